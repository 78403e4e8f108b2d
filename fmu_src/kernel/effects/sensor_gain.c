/* Sensor gain: the scale of a channel is off. */
#include "effect.h"

enum { ON, FIRST, COUNT = FIRST + CHANNELS };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "sensor_gain", SWITCH, .meaning = "switch: the measured forces are scaled", .source = "definition"},
    [FIRST] = {.name = "sensor_gain.friction_force", .unit = "1", .start = 1.05, .min = 0.1, .max = 10, .neutral = 1,
        TUNED, .meaning = "scale of measured_friction_force; 1: right", .source = "guess"},
    [FIRST + 1] = {.name = "sensor_gain.principal_force", .unit = "1", .start = 1.05, .min = 0.1, .max = 10,
        .neutral = 1, TUNED, .meaning = "scale of measured_principal_force; 1: right", .source = "guess"},
    [FIRST + 2] = {.name = "sensor_gain.feed_force", .unit = "1", .start = 1.05, .min = 0.1, .max = 10, .neutral = 1,
        TUNED, .meaning = "scale of measured_feed_force; 1: right", .source = "guess"},
};
/* clang-format on */

static void show(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            x->measured[k][i] *= p[FIRST + k][i];
}

/* clang-format off */
const struct Effect effect_sensor_gain = {
    .equation = "gain F",
    .signature = "the measured force is larger or smaller by one factor, at all times and conditions alike",
    .family = "gain",
    .stage = STAGE_MEASUREMENT, .act = show,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
