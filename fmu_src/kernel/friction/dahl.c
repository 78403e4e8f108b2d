/* Dahl: a bristle whose force saturates at F_C. Dahl 1968, with exponent 1. */
#include "../stages.h"

static void rates(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE {
        x->drive[i] = x->v[i];
        x->rate[i] = x->P[i] * x->speed[i] / x->F_C[i];
        x->target[i] = x->direction[i] * x->F_C[i] / x->P[i];
        x->flat_from[i] = 0;
    }
}

static void force(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE
        x->F[i] = x->s0[i] * x->z[i];
}

/* clang-format off */
const struct FrictionLaw friction_dahl = {
    .meaning = "elastic presliding that saturates at the Coulomb force",
    .equation = "dz/dt = v - sigma0 |v| z / F_C;  F = s0 z",
    .source = "Dahl 1968 (not read); Canudas de Wit et al. 1995, section II",
    .reads = "sigma0, F_C",
    .relaxes = 1, .rates = rates, .force = force,
};
/* clang-format on */
