/* Friction wear: surfaces run in, and friction drifts with the distance slid. */
#include "effect.h"

enum { ON, DELTA, S_0, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "friction_wear", SWITCH, .meaning = "switch: the friction level drifts with the distance slid",
        .source = "guess: running-in as an exponential"},
    [DELTA] = {.name = "friction_wear.delta", .unit = "1", .start = 0.2, .min = -0.9, .max = 10, TUNED,
        .meaning = "share by which friction has changed in the end; 0: none", .source = "guess"},
    [S_0] = {.name = "friction_wear.s_0", .unit = "m", .start = 10, .min = 1e-6, .max = 1e6, .nominal = 1, SHAPE, TUNED,
        .meaning = "distance of the change", .source = "guess"},
};
/* clang-format on */

static void drift(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double share = 1 + p[DELTA][i] * (1 - exponential(-x->distance[i] / p[S_0][i]));
        x->F_C[i] *= share;
        x->F_S[i] *= share;
    }
}

/* clang-format off */
const struct Effect effect_friction_wear = {
    .equation = "F_C, F_S scaled by 1 + delta (1 - exp(-s/s_0)), s the sliding distance since the start",
    .signature = "the friction level drifts through the record at the same motion, in both directions alike",
    .family = "wear", .unsteady = 1, .irreversible = 1,
    .stage = STAGE_FRICTION, .act = drift,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
