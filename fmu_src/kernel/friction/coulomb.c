/* Coulomb: a constant force against the slip. The static rival of the paper. */
#include "../stages.h"

static void rates(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE
        x->drive[i] = x->rate[i] = x->target[i] = 0;
}

static void force(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE
        x->F[i] = x->v[i] == 0 ? 0 : x->direction[i] * x->F_C[i];
}

/* clang-format off */
const struct FrictionLaw friction_coulomb = {
    .meaning = "constant force along the slip, none at rest",
    .equation = "F = F_C sgn(v)",
    .source = "Coulomb 1785 (not read); the paper, section 1",
    .reads = "F_C",
    .rates = rates, .force = force,
};
/* clang-format on */
