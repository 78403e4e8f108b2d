/* Sensor drift: the zero of a channel wanders, as of a charge amplifier. */
#include "effect.h"

enum { ON, FIRST, COUNT = FIRST + CHANNELS };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "sensor_drift", SWITCH, .meaning = "switch: the measured forces drift with time",
        .source = "definition"},
    [FIRST] = {.name = "sensor_drift.friction_force", .unit = "N/s", .start = 0.01, .min = -1e6, .max = 1e6,
        .nominal = 1e-2, TUNED, .meaning = "growth of measured_friction_force from time 0; 0: none", .source = "guess"},
    [FIRST + 1] = {.name = "sensor_drift.principal_force", .unit = "N/s", .start = 0.01, .min = -1e6, .max = 1e6,
        .nominal = 1e-2, TUNED, .meaning = "growth of measured_principal_force from time 0; 0: none",
        .source = "guess"},
    [FIRST + 2] = {.name = "sensor_drift.feed_force", .unit = "N/s", .start = 0.01, .min = -1e6, .max = 1e6,
        .nominal = 1e-2, TUNED, .meaning = "growth of measured_feed_force from time 0; 0: none", .source = "guess"},
};
/* clang-format on */

static void show(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            x->measured[k][i] += p[FIRST + k][i] * x->t[i];
}

/* clang-format off */
const struct Effect effect_sensor_drift = {
    .equation = "F + rate t",
    .signature = "a difference that grows with time, also where nothing touches or moves",
    .family = "zero", .unsteady = 1,
    .stage = STAGE_MEASUREMENT, .act = show,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
