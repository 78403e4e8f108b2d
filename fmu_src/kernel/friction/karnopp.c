/* Karnopp: Coulomb friction that balances the applied force while the slip stays within a narrow band. Karnopp 1985. */
#include "../stages.h"

#include <math.h>

enum { ZERO_VELOCITY_BAND, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ZERO_VELOCITY_BAND] = {.name = "karnopp.zero_velocity_band", .unit = "m/s", .display_unit = "m/min", .start = 1e-3,
        .min = 1e-9, .max = 1, .nominal = 1e-3, .causality = PARAMETER, .variability = TUNABLE,
        .meaning = "slip speed below which the contact sticks", .source = "Karnopp 1985 (not read); value: guess"},
};
/* clang-format on */

static void indicator(const lanes *p, const lanes *memory, struct Point *x)
{
    (void)memory;
    EACH_LANE
        x->law[i] = p[ZERO_VELOCITY_BAND][i] - fabs(x->v[i]);
}

static void rates(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE
        x->drive[i] = x->rate[i] = x->target[i] = 0;
}

static void force(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE {
        const double held = smaller(larger(x->applied[i], -x->F_S[i]), x->F_S[i]);
        x->limited[i] = (x->stuck[i] != 0) & (held != x->applied[i]);
        x->F[i] = x->stuck[i] != 0 ? held : x->direction[i] * x->F_C[i];
    }
}

/* clang-format off */
const struct FrictionLaw friction_karnopp = {
    .meaning = "sticks within a band of zero velocity and there balances the input applied_force up to F_S; Coulomb "
        "friction outside",
    .equation = "|v| < band: F = min(max(applied_force, -F_S), F_S);  else F = F_C sgn(v)",
    .source = "Karnopp 1985 (not read)",
    .reads = "F_C, F_S, applied_force", .has_static = 1,
    .variables = variables, .count = COUNT,
    .rates = rates, .force = force, .indicator = indicator,
};
/* clang-format on */
