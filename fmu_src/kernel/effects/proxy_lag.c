/* Proxy lag: a contact heats up and cools down with a delay. */
#include "effect.h"

enum { ON, TIME_CONSTANT, THETA, RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "proxy_lag", SWITCH,
        .meaning = "switch: the temperature proxy follows its source through a first-order lag",
        .source = "guess: one heat capacity"},
    [TIME_CONSTANT] = {.name = "proxy_lag.time_constant", .unit = "s", .start = 1e-3, .min = 0, .max = 1e4,
        .display_unit = "ms", .nominal = 1e-3, TUNED,
        .meaning = "time constant of the lag; 0, or less than 1e-12 s: none", .source = "guess"},
    [THETA] = {.name = "proxy_lag.theta", .unit = "m/s", .display_unit = "m/min", .nominal = 1e-1, STATE,
        .meaning = "temperature proxy behind the lag", .source = "definition"},
    [RATE] = {.name = "proxy_lag.theta_rate", .unit = "m/s^2", STATE, .meaning = "rate of theta",
        .source = "definition"},
};
/* clang-format on */

static void lag(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE
        x->theta[i] += p[TIME_CONSTANT][i] >= NO_TIME ? larger(state[0][i], 0) - x->theta[i] : 0;
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    first_order_response(h, p[TIME_CONSTANT], a->theta_given, m->theta_given, b->theta_given, from[0], half[0],
                         whole[0]);
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    EACH_LANE
        rate[0][i] = p[TIME_CONSTANT][i] >= NO_TIME ? (x->theta_given[i] - state[0][i]) / p[TIME_CONSTANT][i] : 0;
}

/* clang-format off */
const struct Effect effect_proxy_lag = {
    .equation = "T d theta/dt = theta_source - theta",
    .signature = "thermal changes of friction come late: force over temperature proxy opens into a loop",
    .needs = "proxy_speed",
    .family = "thermal",
    .stage = STAGE_TEMPERATURE, .driver = DRIVEN_BY_MOTION, .states = 1, .settles = 1, .act = lag, .move = move, .rate = rate,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
