/* Viscous friction, beside what the nominal model has. */
#include "effect.h"

enum { ON, C, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "viscous_friction", SWITCH, .meaning = "switch: friction grows in proportion to the slip velocity",
        .source = "Canudas de Wit et al. 1995, eq. 5: sigma2 v"},
    [C] = {.name = "viscous_friction.coefficient", .unit = "N.s/m", .start = 1, .min = 0, .max = 1e6, TUNED,
        .meaning = "viscous coefficient added to sigma2; 0: none", .source = "guess"},
};
/* clang-format on */

static void thicken(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->sigma2[i] += p[C][i];
}

/* clang-format off */
const struct Effect effect_viscous_friction = {
    .equation = "friction_force + c v (laws with viscous friction)",
    .signature = "friction over slip velocity gains a straight slope",
    .family = "speed",
    .stage = STAGE_FRICTION, .act = thicken,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
