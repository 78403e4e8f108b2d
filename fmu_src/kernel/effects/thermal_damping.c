/* Thermal damping: the sensitivity to strain rate changes with temperature. The paper, eq. 5, with sigma1 as its
 * alpha1. */
#include "effect.h"

enum { ON, ALPHA2, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "thermal_damping", SWITCH, .meaning = "switch: bristle damping changes with the temperature proxy",
        .source = "the paper, eq. 5"},
    [ALPHA2] = {.name = "thermal_damping.alpha2", .unit = "1", .start = 0.02245, .min = 0, .max = 5, TUNED,
        .meaning = "exponent of the damping; 0: none of it changes", .source = "the paper, table 1, Al 6061"},
};
/* clang-format on */

static void damp(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->s1[i] *= power_of(x->theta_ratio[i], p[ALPHA2][i]);
}

/* clang-format off */
const struct Effect effect_thermal_damping = {
    .equation = "s1(theta) = sigma1 (theta/theta_ref)^alpha2",
    .signature = "presliding damping changes with the temperature proxy; steady sliding does not",
    .needs = "proxy_speed",
    .family = "thermal",
    .stage = STAGE_FRICTION, .variables = variables, .count = COUNT, .act = damp,
};
/* clang-format on */
