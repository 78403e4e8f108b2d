/* With which forces does the next pass over a step begin, where forces move the tool? With a mean of those that passes
 * have begun with, weighed such that a linear answer would be met, and a share of what it misses: Anderson 1965 (not
 * read).
 *
 * The forces at middle and end move the tool there, and a pass finds others. Where friction is damped stiffly it
 * overshoots as many times over as the step is longer than the tool takes to follow its contact, and repeating it
 * settles nothing. Friction at two points is what is stiff; the chip's load at them follows, so that three differences
 * of passes serve. A pass that has led astray is taken back: its difference counts like any other, and by as many times
 * as it has missed more the next ones follow less of what they miss; or it alone counts, where less has come back of it
 * than was put in. A force without bristles jumps where the slip
 * turns, and has no such mean: there each pass begins with what the one before has led to, and its end alone counts.
 *
 * The longer a step, the further a force moves the tool, and the more comes back of it: what differences of passes say
 * holds, in proportion to its length, of the step that is tried next, too, as long as no event lies between them. A
 * stiff contact that every step had to get to know anew settled in much shorter ones only.
 */
#include "../stages.h"

#include <math.h>

#define ASTRAY 2 /* times what the pass before has missed */
#define LEAST_SHARE 1e-20 /* share of a square: roundings */

static lanes *force_of(struct Point *middle, struct Point *end, int k)
{
    struct Point *const x = k < CHANNELS ? middle : end;
    return k % CHANNELS == 0 ? &x->F : k % CHANNELS == 1 ? &x->F_p : &x->F_f;
}

void note_forces(double length, const struct Point *a, const struct Point *m, const struct Point *b, int i,
                 struct StepForces *forces)
{
    const struct Point *const points[3] = {a, m, b};
    forces->length[i] = length;
    for (int n = 0; n < 3; ++n) {
        forces->at[n][0][i] = points[n]->F[i];
        forces->at[n][1][i] = points[n]->F_p[i];
        forces->at[n][2][i] = points[n]->F_f[i];
    }
}

void predict_forces(const struct StepForces *forces, double at_middle, double at_end, int i, struct Feedback *known)
{
    for (int k = 0; k < PASSED_FORCES; ++k) {
        const int c = k % CHANNELS;
        known->force[k][i] =
            parabola(k < CHANNELS ? at_middle : at_end, forces->at[0][c][i], forces->at[1][c][i], forces->at[2][c][i]);
    }
    known->predicted[i] = 1;
}

/* What is known, as it holds in a step of h. */
static void recall_differences(const struct Feedback *known, double h, int i, struct Passes *p)
{
    p->count[i] = (int)known->count[i];
    for (int n = 0; n < p->count[i]; ++n)
        for (int k = 0; k < PASSED_FORCES; ++k) {
            p->by_from[n][k][i] = known->begun[n][k][i];
            p->by_missed[n][k][i] = h * known->returned[n][k][i] - known->begun[n][k][i];
        }
}

void note_feedback(const struct Passes *p, double h, int i, struct Feedback *known)
{
    known->count[i] = h > 0 ? p->count[i] : 0;
    for (int n = 0; n < known->count[i]; ++n)
        for (int k = 0; k < PASSED_FORCES; ++k) {
            known->begun[n][k][i] = p->by_from[n][k][i];
            known->returned[n][k][i] = (p->by_from[n][k][i] + p->by_missed[n][k][i]) / h;
        }
}

double loop_gain(const struct Feedback *known, double h, int i)
{
    double begun = 0, returned = 0;
    for (int k = 0; known->count[i] > 0 && k < PASSED_FORCES; ++k) {
        begun = larger(begun, fabs(known->begun[0][k][i]));
        returned = larger(returned, fabs(known->returned[0][k][i]));
    }
    return begun > 0 ? h * returned / begun : INFINITY;
}

void begin_passes(const struct Configuration *w, const lanes h, const struct Point *start, const struct Feedback *known,
                  struct Point *middle, struct Point *end, struct Passes *p)
{
    p->mixes = w->law->relaxes || w->law->event != NULL;
    for (int i = 0; i < LANES; ++i) {
        p->count[i] = 0;
        p->first[i] = 1;
        p->share[i] = 1;
        p->miss[i] = INFINITY;
    }
    if (!p->mixes)
        return;
    *middle = *end = *start;
    for (int i = 0; known && i < LANES; ++i)
        recall_differences(known, h[i], i, p);
    for (int k = 0; k < PASSED_FORCES; ++k)
        for (int i = 0; i < LANES; ++i) {
            double *const force = &force_of(middle, end, k)[0][i];
            if (known && known->predicted[i] != 0)
                *force = known->force[k][i];
            p->begun[k][i] = *force;
        }
    move_states(w, DRIVEN_BY_FORCE, h, start, middle, end);
}

/* What lies between the pass that stands and another one is kept, the newest first. */
static void keep_difference(const double from[PASSED_FORCES], const double missed[PASSED_FORCES], struct Passes *p,
                            int i)
{
    p->count[i] = p->count[i] < DIFFERENCES ? p->count[i] + 1 : DIFFERENCES;
    for (int k = 0; k < PASSED_FORCES; ++k) {
        for (int age = DIFFERENCES - 1; age > 0; --age) {
            p->by_from[age][k][i] = p->by_from[age - 1][k][i];
            p->by_missed[age][k][i] = p->by_missed[age - 1][k][i];
        }
        p->by_from[0][k][i] = from[k] - p->from[k][i];
        p->by_missed[0][k][i] = missed[k] - p->missed[k][i];
    }
}

/* Does less come back of the newest difference than was put in? Then what has led a pass astray was the mean of older
 * ones that are nearly one another's multiples, and no overshoot. */
static int contracts(const struct Passes *p, int i)
{
    double begun = 0, returned = 0;
    for (int k = 0; k < PASSED_FORCES; ++k) {
        begun = larger(begun, fabs(p->by_from[0][k][i]));
        returned = larger(returned, fabs(p->by_from[0][k][i] + p->by_missed[0][k][i]));
    }
    return returned < begun;
}

void note_pass(const lanes will_do, struct Point *middle, struct Point *end, struct Passes *p)
{
    for (int i = 0; i < LANES; ++i) {
        double from[PASSED_FORCES], missed[PASSED_FORCES], miss = 0;
        for (int k = 0; k < PASSED_FORCES; ++k) {
            from[k] = p->mixes || p->first[i] == 0 ? p->begun[k][i] : 0;
            missed[k] = force_of(middle, end, k)[0][i] - from[k];
            miss = p->mixes || k >= CHANNELS ? larger(miss, fabs(missed[k])) : miss;
        }
        p->astray[i] = p->mixes && p->first[i] == 0 && !(miss <= larger(ASTRAY * p->miss[i], will_do[i]));
        if (p->mixes && p->first[i] == 0 && miss < INFINITY)
            keep_difference(from, missed, p, i);
        p->first[i] = 0;
        if (p->astray[i]) {
            if (miss < INFINITY && contracts(p, i))
                p->count[i] = 1;
            else
                p->share[i] *= miss < INFINITY ? p->miss[i] / miss : 1e-3;
            continue;
        }
        p->miss[i] = miss;
        for (int k = 0; k < PASSED_FORCES; ++k) {
            p->from[k][i] = from[k];
            p->missed[k][i] = missed[k];
        }
    }
}

static double product(const lanes x[PASSED_FORCES], const lanes y[PASSED_FORCES], int i)
{
    double sum = 0;
    for (int k = 0; k < PASSED_FORCES; ++k)
        sum += x[k][i] * y[k][i];
    return sum;
}

/* Takes from what is missed all that differences between passes span, one after the other, and from where it begins
 * what goes with it. */
static void mix(const struct Passes *p, int i, double from[PASSED_FORCES], double missed[PASSED_FORCES])
{
    lanes by_from[DIFFERENCES][PASSED_FORCES], by_missed[DIFFERENCES][PASSED_FORCES];
    for (int m = 0; m < p->count[i]; ++m) {
        for (int k = 0; k < PASSED_FORCES; ++k) {
            by_from[m][k][i] = p->by_from[m][k][i];
            by_missed[m][k][i] = p->by_missed[m][k][i];
        }
        const double whole = product(by_missed[m], by_missed[m], i);
        for (int n = 0; n < m; ++n) {
            const double square = product(by_missed[n], by_missed[n], i),
                         share = square > 0 ? product(by_missed[m], by_missed[n], i) / square : 0;
            for (int k = 0; k < PASSED_FORCES; ++k) {
                by_from[m][k][i] -= share * by_from[n][k][i];
                by_missed[m][k][i] -= share * by_missed[n][k][i];
            }
        }
        const double square = product(by_missed[m], by_missed[m], i);
        double weight = 0;
        if (!(square > LEAST_SHARE * whole)) { /* no direction of its own */
            for (int k = 0; k < PASSED_FORCES; ++k)
                by_missed[m][k][i] = 0;
            continue;
        }
        for (int k = 0; k < PASSED_FORCES; ++k)
            weight += missed[k] * by_missed[m][k][i] / square;
        for (int k = 0; k < PASSED_FORCES; ++k) {
            from[k] -= weight * by_from[m][k][i];
            missed[k] -= weight * by_missed[m][k][i];
        }
    }
}

void begin_pass(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *middle,
                struct Point *end, struct Passes *p)
{
    if (!p->mixes) { /* the last pass has moved the tool already */
        for (int k = 0; k < PASSED_FORCES; ++k)
            for (int i = 0; i < LANES; ++i)
                p->begun[k][i] = force_of(middle, end, k)[0][i];
        return;
    }
    lanes come_back[PASSED_FORCES]; /* of the pass that stands, which a point out of contact may keep */
    for (int i = 0; i < LANES; ++i) {
        double from[PASSED_FORCES], missed[PASSED_FORCES];
        for (int k = 0; k < PASSED_FORCES; ++k) {
            from[k] = p->from[k][i];
            missed[k] = p->missed[k][i];
        }
        mix(p, i, from, missed);
        for (int k = 0; k < PASSED_FORCES; ++k) {
            p->begun[k][i] = from[k] + p->share[i] * missed[k];
            come_back[k][i] = force_of(middle, end, k)[0][i];
            force_of(middle, end, k)[0][i] = p->begun[k][i];
        }
    }
    move_states(w, DRIVEN_BY_FORCE, h, start, middle, end);
    for (int k = 0; k < PASSED_FORCES; ++k)
        for (int i = 0; i < LANES; ++i)
            force_of(middle, end, k)[0][i] = come_back[k][i];
}
