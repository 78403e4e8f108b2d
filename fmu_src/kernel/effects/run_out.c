/* Run-out: the work is not round, or not clamped in its middle. */
#include "effect.h"

enum { ON, AMPLITUDE, FREQUENCY, PHASE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "run_out", SWITCH, .meaning = "switch: the nominal surface rises and falls once in a spindle turn",
        .source = "definition"},
    [AMPLITUDE] = {.name = "run_out.amplitude", .unit = "m", .start = 5e-6, .min = 0, .max = 1e-3, .display_unit = "um",
        .nominal = 1e-6, TUNED, .meaning = "amplitude e of the rise of the surface; 0: none", .source = "guess"},
    [FREQUENCY] = {.name = "run_out.spindle_frequency", .unit = "Hz", .start = 10, .min = 1e-3, .max = 1e4,
        .nominal = 10, SHAPE, TUNED, .meaning = "turns of the spindle per time, Omega/(2 pi)",
        .source = "guess: 600 1/min"},
    [PHASE] = {.name = "run_out.phase", .unit = "rad", .start = 0, .min = -6.2832, .max = 6.2832, .display_unit = "deg",
        SHAPE, TUNED, .meaning = "phase psi of the rise at time 0", .source = "guess"},
};
/* clang-format on */

static void raise(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->raised[i] += p[AMPLITUDE][i] * sin(2 * PI * p[FREQUENCY][i] * x->t[i] + p[PHASE][i]);
}

static double longest_step(const lanes *p, int i)
{
    return p[AMPLITUDE][i] > 0 ? 1 / (20 * p[FREQUENCY][i]) : INFINITY;
}

/* clang-format off */
const struct Effect effect_run_out = {
    .equation = "nominal surface + e sin(Omega t + psi)",
    .signature = "a line at the spindle frequency whose amplitude does not depend on the feed",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "path", .unsteady = 1,
    .stage = STAGE_PATH, .act = raise, .longest_step = longest_step,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
