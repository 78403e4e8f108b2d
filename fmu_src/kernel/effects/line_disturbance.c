/* Line disturbance: a sine of one frequency is added to the signal, as mains hum is. Morrison 2007, Grounding and
 * Shielding. */
#include "effect.h"

enum { ON, FIRST, FREQUENCY = FIRST + CHANNELS, PHASE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "line_disturbance", SWITCH, .meaning = "switch: a line at one frequency is added to the measured forces",
        .source = "definition: one harmonic; where it comes from: Morrison 2007 (not read), Grounding and Shielding"},
    [FIRST] = {.name = "line_disturbance.friction_force", .unit = "N", .start = 0.2, .min = 0, .max = 1e6,
        .nominal = 1, TUNED, .meaning = "amplitude A of the line in measured_friction_force; 0: none",
        .source = "guess"},
    [FIRST + 1] = {.name = "line_disturbance.principal_force", .unit = "N", .start = 0.2, .min = 0, .max = 1e6,
        .nominal = 1, TUNED, .meaning = "amplitude A of the line in measured_principal_force; 0: none",
        .source = "guess"},
    [FIRST + 2] = {.name = "line_disturbance.feed_force", .unit = "N", .start = 0.2, .min = 0, .max = 1e6,
        .nominal = 1, TUNED, .meaning = "amplitude A of the line in measured_feed_force; 0: none", .source = "guess"},
    [FREQUENCY] = {.name = "line_disturbance.frequency", .unit = "Hz", .start = 50, .min = 1e-3, .max = 1e5,
        .nominal = 50, SHAPE, TUNED, .meaning = "frequency f of the line", .source = "IEC 60038: mains of 50 or 60 Hz"},
    [PHASE] = {.name = "line_disturbance.phase", .unit = "rad", .start = 0, .min = -6.2832, .max = 6.2832,
        .display_unit = "deg", SHAPE, TUNED, .meaning = "phase psi of the line at time 0", .source = "guess"},
};
/* clang-format on */

static void hum(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    lanes wave;
    EACH_LANE {
        double cosine;
        cos_sin(p[FREQUENCY][i] * x->t[i] + p[PHASE][i] / (2 * PI), &cosine, &wave[i]);
    }
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            x->measured[k][i] += p[FIRST + k][i] * wave[i];
}

/* The forces themselves are right at any step; what is summed of them wants to see the wave. */
static double longest_step(const lanes *p, int i)
{
    double largest = 0;
    for (int k = 0; k < CHANNELS; ++k)
        largest = larger(largest, p[FIRST + k][i]);
    return largest > 0 ? 1 / (20 * p[FREQUENCY][i]) : INFINITY;
}

/* clang-format off */
const struct Effect effect_line_disturbance = {
    .equation = "F + A sin(2 pi f t + psi)",
    .signature = "a sharp line at one frequency, also where nothing touches or moves, whatever the motion does",
    .family = "line", .unsteady = 1,
    .stage = STAGE_MEASUREMENT, .act = hum, .longest_step = longest_step,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
