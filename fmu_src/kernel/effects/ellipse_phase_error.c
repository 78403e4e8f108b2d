/* Ellipse phase error: the two vibrations do not run a quarter turn apart. */
#include "effect.h"

enum { ON, DELTA, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "ellipse_phase_error", SWITCH,
        .meaning = "switch: the vibration away from the surface has another phase than it should", .source = "guess"},
    [DELTA] = {.name = "ellipse_phase_error.delta", .unit = "rad", .start = 0.1, .min = -1.5, .max = 1.5,
        .display_unit = "deg", TUNED, .meaning = "phase added to phase_y; 0: as it should be", .source = "guess"},
};
/* clang-format on */

static void tilt(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->phase_y[i] += p[DELTA][i];
}

/* clang-format off */
const struct Effect effect_ellipse_phase_error = {
    .equation = "y = b cos(2 pi f t + phase_y + delta)",
    .signature = "the ellipse is tilted: entry, exit and reversal shift in phase, mean forces change at every speed",
    .applies_to = "internal, combined",
    .family = "path",
    .stage = STAGE_PATH, .act = tilt,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
