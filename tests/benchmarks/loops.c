/* What does the same work cost from C, with no Python between? Loops that a host would write, and the least that they
 * could cost.
 *
 * Every loop returns the processor seconds that it took. A host's instance and functions come in as pointers, so this
 * library links to no FMU.
 */
#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <time.h>

#pragma GCC visibility push(default) /* all but the static ones is what Python calls */

static double seconds_since(clock_t begin) { return (double)(clock() - begin) / CLOCKS_PER_SEC; }

/* ---- a master of co-simulation ---- */

typedef int DoStep2(void *instance, double time, double step, int no_set_state);
typedef int DoStep3(void *instance, double time, double step, _Bool no_set_state, _Bool *event, _Bool *terminate,
                    _Bool *early, double *last);
typedef int Values2(void *instance, const unsigned *references, size_t count, double *values);

/* Nothing but the call. */
int nothing_2(void *instance, double time, double step, int no_set_state)
{
    (void)instance, (void)time, (void)step, (void)no_set_state;
    return 0;
}

/* An FMU without work: takes any values, and shows others after each step. */
static double stepped = 0;

int step_2(void *instance, double time, double step, int no_set_state)
{
    (void)instance, (void)time, (void)step, (void)no_set_state;
    stepped += 1;
    return 0;
}

int take_2(void *instance, const unsigned *references, size_t count, const double *values)
{
    (void)instance, (void)references, (void)count, (void)values;
    return 0;
}

int take_slopes_2(void *instance, const unsigned *references, size_t count, const int *orders, const double *values)
{
    (void)instance, (void)references, (void)count, (void)orders, (void)values;
    return 0;
}

int show_2(void *instance, const unsigned *references, size_t count, double *values)
{
    (void)instance, (void)references;
    for (size_t i = 0; i < count; ++i)
        values[i] = stepped + (double)i;
    return 0;
}

/* `count` steps from *time on, which is moved; the first status above 1 (warning) ends the loop with -1. */
double steps_2(DoStep2 *do_step, void *instance, double *time, double step, int64_t count)
{
    const clock_t begin = clock();
    for (int64_t n = 0; n < count; ++n) {
        if (do_step(instance, *time, step, 1) > 1)
            return -1;
        *time += step;
    }
    return seconds_since(begin);
}

double steps_3(DoStep3 *do_step, void *instance, double *time, double step, int64_t count)
{
    const clock_t begin = clock();
    for (int64_t n = 0; n < count; ++n) {
        _Bool event, terminate, early;
        double last;
        if (do_step(instance, *time, step, 1, &event, &terminate, &early, &last) > 1)
            return -1;
        *time += step;
    }
    return seconds_since(begin);
}

/* The same with an input set before each step, which goes to and fro, and an output read after it. */
double exchanges_2(DoStep2 *do_step, Values2 *set, Values2 *get, void *instance, unsigned input, double size,
                   unsigned output, double *time, double step, int64_t count)
{
    const clock_t begin = clock();
    for (int64_t n = 0; n < count; ++n) {
        double in = n & 1 ? 0.9 * size : size, out;
        if (set(instance, &input, 1, &in) > 1 || do_step(instance, *time, step, 1) > 1 ||
            get(instance, &output, 1, &out) > 1)
            return -1;
        *time += step;
    }
    return seconds_since(begin);
}

/* ---- the bare law: slip v = mean + cosine cos(omega t) + sine sin(omega t), a LuGre bristle on it ---- */

struct Law {
    double mean, cosine, sine, omega; /* m/s, 1/s */
    double P, F_C, F_S, v_s;          /* N/m, N, N, m/s */
    double *(*data)(void *vector);    /* where a solver's vector keeps its numbers */
};

static double slip(const struct Law *law, double t)
{
    return law->mean + law->cosine * cos(law->omega * t) + law->sine * sin(law->omega * t);
}

static double stribeck(const struct Law *law, double v)
{
    const double ratio = v / law->v_s;
    return law->F_C + (law->F_S - law->F_C) * exp(-fmin(ratio * ratio, 700));
}

/* dz/dt, as CVode asks for it. */
int rate(double t, void *z, void *dz, void *law_)
{
    const struct Law *law = law_;
    const double v = slip(law, t);
    law->data(dz)[0] = v - law->P * fabs(v) / stribeck(law, v) * law->data(z)[0];
    return 0;
}

/* The least arithmetic of an internal step: the exponential midpoint rule, `count` steps of h from begin_time on.
 * moving = 0: slip held. */
double bare_steps(const struct Law *law, int moving, double begin_time, double h, int64_t count, double *z)
{
    const clock_t begin = clock();
    double v = law->mean;
    for (int64_t n = 0; n < count; ++n) {
        v = moving ? slip(law, begin_time + ((double)n + 0.5) * h)
                   : v * (1 - 1e-15); /* no loop invariant for the compiler */
        const double g = stribeck(law, v), target = (v < 0 ? -g : g) / law->P;
        *z = target + (*z - target) * exp(-law->P * fabs(v) / g * h);
    }
    return seconds_since(begin);
}
