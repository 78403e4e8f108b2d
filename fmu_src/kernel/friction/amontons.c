/* Amontons: friction in proportion to the normal force. Coulomb's law as mu N, where coulomb holds one force for all
 * loads. */
#include "../stages.h"

enum { MU, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [MU] = {.name = "amontons.mu", .unit = "1", .start = 0.5, .min = 1e-3, .max = 10, .causality = PARAMETER,
        .variability = TUNABLE, .meaning = "friction force over normal force", .source = "guess"},
};
/* clang-format on */

/* On the rake face the normal force answers to friction, too, which is what friction_of has solved: effects that raise
 * friction raise mu. */
static void level(const lanes *p, const lanes raised, struct Point *x)
{
    const struct Configuration *w = x->configuration;
    const int given = w->kinematics == KINEMATICS_EXTERNAL;
    for (int i = 0; i < LANES; ++i) {
        const double mu = p[MU][i] * raised[i];
        const double force = given ? mu * x->load[i] : x->k[i] * friction_of(w, mu, x->direction[i], i);
        x->F_C[i] = x->F_S[i] = force;
    }
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
    EACH_LANE
        x->F[i] = x->v[i] == 0 ? 0 : x->direction[i] * x->F_C[i];
}

/* clang-format off */
const struct FrictionLaw friction_amontons = {
    .meaning = "a force along the slip in proportion to the normal force, none at rest",
    .equation = "F = mu N sgn(v), N the input normal_load, or that of the shear plane under this friction",
    .source = "Amontons 1699; Coulomb 1785 (neither read)",
    .reads = "normal_load",
    .level = level, .rates = rates, .force = force,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
