/* Bristle: many elastic bonds that break one by one and form again at random. Haessig and Friedland 1991.
 *
 * All bonds follow the slip, so their mean z is the only continuous state; memory holds each bond's offset from it. A
 * new bond forms anywhere within the break-away deflection d of the tool: in steady sliding the mean deflection is then
 * d/3, hence d = 3 F_C/sigma0.
 */
#include "../stages.h"

#include <math.h>

enum { BONDS = 20, BROKEN = BONDS };
enum { SEED, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [SEED] = {.name = "bristle.seed", .unit = "1", .start = 1, .min = 0, .max = 1e6, .type = INTEGER,
        .causality = PARAMETER, .variability = FIXED, .meaning = "seed of the places where new bonds form",
        .source = "guess"},
};
/* clang-format on */

/* Uniform in (-1, 1), from a counter: no state beside the count. Integer finalizer of splitmix (Steele et al. 2014), 32
 * bits. */
static double scatter(double seed, double count)
{
    uint32_t n = (uint32_t)seed * 0x9e3779b9u + (uint32_t)fmod(fabs(count), 4294967296.0);
    n = (n ^ n >> 16) * 0x7feb352du;
    n = (n ^ n >> 15) * 0x846ca68bu;
    n ^= n >> 16;
    return (n + 0.5) / 2147483648.0 - 1;
}

static double break_away(const struct Point *x, int i) { return 3 * x->F_C[i] / x->P[i]; }

static void rest(const lanes *p, const struct Point *x, lanes *memory)
{
    (void)p;
    for (int n = 0; n < BONDS; ++n)
        EACH_LANE
            memory[n][i] = break_away(x, i) * ((n + 0.5) / (double)BONDS - 0.5);
    EACH_LANE
        memory[BROKEN][i] = 0; /* every contact begins alike */
}

static void indicator(const lanes *p, const lanes *memory, struct Point *x)
{
    (void)p;
    EACH_LANE {
        double furthest = -INFINITY;
        for (int n = 0; n < BONDS; ++n)
            furthest = larger(furthest, fabs(x->z[i] + memory[n][i]));
        x->law[i] = break_away(x, i) - furthest;
    }
}

static void rates(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE {
        x->rate[i] = x->target[i] = 0;
        x->drive[i] = x->v[i];
    }
}

static void force(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE
        x->F[i] = x->s0[i] * x->z[i];
}

static void event(const lanes *p, const struct Point *x, lanes z, lanes *memory)
{
    for (int i = 0; i < LANES; ++i) {
        const double limit = break_away(x, i);
        double mean = 0;
        if (x->cutting[i] == 0) /* what relaxes breaks no bond; what is too long when the tool comes back breaks then */
            continue;
        for (int n = 0; n < BONDS; ++n) {
            double deflection = z[i] + memory[n][i];
            const int breaks = fabs(x->z[i] + memory[n][i]) >= limit; /* where the side of the event is taken, too */
            if (breaks || fabs(deflection) >= limit * (1 - 1e-9)) { /* hosts stop at the event to some roundings */
                deflection = limit * scatter(p[SEED][i], memory[BROKEN][i]);
                memory[BROKEN][i] += 1;
            }
            memory[n][i] = deflection;
            mean += deflection / (double)BONDS;
        }
        for (int n = 0; n < BONDS; ++n)
            memory[n][i] -= mean;
        z[i] = mean;
    }
}

/* clang-format off */
const struct FrictionLaw friction_bristle = {
    .meaning = "20 elastic bonds that break at 3 F_C/sigma0 and form again at random places",
    .equation = "dz_i/dt = v;  |z_i| >= d: z_i = d u, u uniform in (-1, 1), d = 3 F_C/sigma0;  F = s0 mean(z_i)",
    .source = "Haessig and Friedland 1991 (not read)",
    .reads = "sigma0, F_C",
    .variables = variables, .count = COUNT,
    .rates = rates, .force = force, .indicator = indicator, .event = event, .rest = rest,
};
/* clang-format on */
