/* Sensor low-pass: the amplifier filters, first order. */
#include "effect.h"

enum { ON, TIME_CONSTANT, FIRST, RATES = FIRST + CHANNELS, COUNT = RATES + CHANNELS };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "sensor_lowpass", SWITCH,
        .meaning = "switch: the measured forces pass through a first-order low-pass", .source = "definition"},
    [TIME_CONSTANT] = {.name = "sensor_lowpass.time_constant", .unit = "s", .start = 1e-5, .min = 0, .max = 1e3,
        .display_unit = "us", .nominal = 1e-5, TUNED,
        .meaning = "time constant, 1/(2 pi cut-off frequency); 0, or less than 1e-12 s: none", .source = "guess"},
    [FIRST + 0] = {.name = "sensor_lowpass.friction_force", .unit = "N", .nominal = 10, STATE,
        .meaning = "friction_force behind the filter", .source = "definition"},
    [FIRST + 1] = {.name = "sensor_lowpass.principal_force", .unit = "N", .nominal = 10, STATE,
        .meaning = "principal_force behind the filter", .source = "definition"},
    [FIRST + 2] = {.name = "sensor_lowpass.feed_force", .unit = "N", .nominal = 10, STATE,
        .meaning = "feed_force behind the filter", .source = "definition"},
    [RATES + 0] = {.name = "sensor_lowpass.friction_force_rate", .unit = "N/s", STATE,
        .meaning = "rate of friction_force", .source = "definition"},
    [RATES + 1] = {.name = "sensor_lowpass.principal_force_rate", .unit = "N/s", STATE,
        .meaning = "rate of principal_force", .source = "definition"},
    [RATES + 2] = {.name = "sensor_lowpass.feed_force_rate", .unit = "N/s", STATE, .meaning = "rate of feed_force",
        .source = "definition"},
};
/* clang-format on */

static void smooth(const lanes *p, const lanes *state, struct Point *x)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            x->measured[k][i] += p[TIME_CONSTANT][i] >= NO_TIME ? state[k][i] - x->measured[k][i] : 0;
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    for (int k = 0; k < CHANNELS; ++k)
        first_order_response_in_mean(h, p[TIME_CONSTANT], a->measured[k], m->measured[k], b->measured[k], from[k],
                                     half[k], whole[k]);
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            rate[k][i] = p[TIME_CONSTANT][i] >= NO_TIME ? (x->measured[k][i] - state[k][i]) / p[TIME_CONSTANT][i] : 0;
}

static int remembers(const lanes *p, int i) { return p[TIME_CONSTANT][i] >= NO_TIME; }

/* clang-format off */
const struct Effect effect_sensor_lowpass = {
    .equation = "T dy/dt = F - y",
    .signature = "steps of the force become exponentials; gain falls and phase lags with frequency",
    .family = "lag", .keeps_mean = 1,
    .stage = STAGE_MEASUREMENT, .driver = DRIVEN_BY_SENSOR, .states = CHANNELS, .act = smooth, .move = move,
    .rate = rate,
    .remembers = remembers,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
