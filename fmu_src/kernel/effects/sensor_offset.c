/* Sensor offset: the zero of a channel is off. */
#include "effect.h"

enum { ON, FIRST, COUNT = FIRST + CHANNELS };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "sensor_offset", SWITCH, .meaning = "switch: the measured forces have an offset",
        .source = "definition"},
    [FIRST] = {.name = "sensor_offset.friction_force", .unit = "N", .start = 0.5, .min = -1e6, .max = 1e6, .nominal = 1,
        TUNED, .meaning = "added to measured_friction_force; 0: right", .source = "guess"},
    [FIRST + 1] = {.name = "sensor_offset.principal_force", .unit = "N", .start = 0.5, .min = -1e6, .max = 1e6,
        .nominal = 1, TUNED, .meaning = "added to measured_principal_force; 0: right", .source = "guess"},
    [FIRST + 2] = {.name = "sensor_offset.feed_force", .unit = "N", .start = 0.5, .min = -1e6, .max = 1e6, .nominal = 1,
        TUNED, .meaning = "added to measured_feed_force; 0: right", .source = "guess"},
};
/* clang-format on */

static void show(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            x->measured[k][i] += p[FIRST + k][i];
}

/* clang-format off */
const struct Effect effect_sensor_offset = {
    .equation = "F + offset",
    .signature = "a constant difference, also where nothing touches",
    .family = "zero",
    .stage = STAGE_MEASUREMENT, .act = show,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
