/* Sensor delay: forces are sampled later than the motion. */
#include "effect.h"

enum { ON, TIME_LATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "sensor_delay", SWITCH, .meaning = "switch: the measured forces come late", .source = "definition"},
    [TIME_LATE] = {.name = "sensor_delay.time", .unit = "s", .start = 5e-6, .min = 0, .max = 10, .display_unit = "us",
        .nominal = 1e-5, TUNED, .source = "guess",
        .meaning = "delay tau; 0, or less than 1e-12 s: none; the forces of that time must fit into 256 pieces, vibration "
            "cycles that are alike counted once, or the run is refused"},
};
/* clang-format on */

/* First in the chain: all that follows is linear and does not mind. */
static void wait(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    for (int i = 0; i < LANES; ++i) {
        double late[CHANNELS];
        if (!(p[TIME_LATE][i] >= NO_TIME))
            continue;
        recall(x->past, x, i, x->t[i] - p[TIME_LATE][i], late);
        for (int k = 0; k < CHANNELS; ++k)
            x->measured[k][i] += late[k] - x->measured[k][i];
    }
}

static double looks_back(const lanes *p, int i) { return or_none(p[TIME_LATE][i], NO_TIME); }

/* clang-format off */
const struct Effect effect_sensor_delay = {
    .equation = "F(t - tau)",
    .signature = "force over velocity opens into a loop that grows with frequency; the wave's form is kept",
    .rivals = "input_delay",
    .family = "lag", .keeps_mean = 1,
    .stage = STAGE_MEASUREMENT, .act = wait, .looks_back = looks_back,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
