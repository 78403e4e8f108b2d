/* Thermal softening: bristles get softer as the contact gets hotter. The paper, eq. 6, with k_Q and theta_ref carrying
 * its units. */
#include "effect.h"

enum { ON, K_Q, Q, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "thermal_softening", SWITCH,
        .meaning = "switch: bristle stiffness falls with the temperature proxy", .source = "the paper, eq. 6"},
    [K_Q] = {.name = "thermal_softening.k_Q", .unit = "N/m", .start = 1, .min = 0, .max = 1e9, TUNED,
        .meaning = "loss of stiffness at theta = theta_ref; 0: none",
        .source = "the paper, eq. 6: 1 with the units left out"},
    [Q] = {.name = "thermal_softening.Q", .unit = "1", .start = 3.49, .min = 0, .max = 10, SHAPE, TUNED,
        .meaning = "exponent of the loss of stiffness", .source = "the paper, table 1, Al 6061"},
};
/* clang-format on */

static void soften(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->s0[i] -= p[K_Q][i] * power_of(x->theta_ratio[i], p[Q][i]);
}

/* clang-format off */
const struct Effect effect_thermal_softening = {
    .equation = "s0(theta) = sigma0 - k_Q (theta/theta_ref)^Q",
    .signature = "friction falls as the temperature proxy rises, also in steady sliding; break-away stiffness falls "
        "with it",
    .needs = "proxy_speed",
    .family = "thermal",
    .stage = STAGE_FRICTION, .variables = variables, .count = COUNT, .act = soften,
};
/* clang-format on */
