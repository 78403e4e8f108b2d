/* Dynamometer resonance: the platform on its quartzes is a mass on a spring. */
#include "effect.h"

enum { ON, PERIOD, DAMPING_RATIO, FIRST, RATES = FIRST + 2 * CHANNELS, COUNT = RATES + 2 * CHANNELS };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "dynamometer_resonance", SWITCH, .meaning = "switch: the measured forces pass through a resonance",
        .source = "definition: a linear oscillator, gain 1 at rest"},
    [PERIOD] = {.name = "dynamometer_resonance.natural_period", .unit = "s", .start = 2.5e-4, .min = 0, .max = 1,
        .display_unit = "us", .nominal = 1e-4, TUNED,
        .meaning = "period of the undamped natural vibration, 1/f_n; 0, or less than 1e-12 s: infinitely stiff",
        .source = "guess: 4 kHz, ordinary for a mounted dynamometer"},
    [DAMPING_RATIO] = {.name = "dynamometer_resonance.damping_ratio", .unit = "1", .start = 0.05, .min = 0, .max = 2,
        SHAPE, TUNED, .meaning = "damping ratio", .source = "guess"},
    [FIRST + 0] = {.name = "dynamometer_resonance.friction_force", .unit = "N", .nominal = 10, STATE,
        .meaning = "friction_force that the platform passes on", .source = "definition"},
    [FIRST + 1] = {.name = "dynamometer_resonance.friction_force_speed", .unit = "N/s", .nominal = 1e5, STATE,
        .meaning = "rate of change of the friction_force that the platform passes on", .source = "definition"},
    [FIRST + 2] = {.name = "dynamometer_resonance.principal_force", .unit = "N", .nominal = 10, STATE,
        .meaning = "principal_force that the platform passes on", .source = "definition"},
    [FIRST + 3] = {.name = "dynamometer_resonance.principal_force_speed", .unit = "N/s", .nominal = 1e5, STATE,
        .meaning = "rate of change of the principal_force that the platform passes on", .source = "definition"},
    [FIRST + 4] = {.name = "dynamometer_resonance.feed_force", .unit = "N", .nominal = 10, STATE,
        .meaning = "feed_force that the platform passes on", .source = "definition"},
    [FIRST + 5] = {.name = "dynamometer_resonance.feed_force_speed", .unit = "N/s", .nominal = 1e5, STATE,
        .meaning = "rate of change of the feed_force that the platform passes on", .source = "definition"},
    [RATES + 0] = {.name = "dynamometer_resonance.friction_force_rate", .unit = "N/s", STATE,
        .meaning = "rate of friction_force", .source = "definition"},
    [RATES + 1] = {.name = "dynamometer_resonance.friction_force_acceleration", .unit = "N/s^2", STATE,
        .meaning = "rate of friction_force_speed", .source = "definition"},
    [RATES + 2] = {.name = "dynamometer_resonance.principal_force_rate", .unit = "N/s", STATE,
        .meaning = "rate of principal_force", .source = "definition"},
    [RATES + 3] = {.name = "dynamometer_resonance.principal_force_acceleration", .unit = "N/s^2", STATE,
        .meaning = "rate of principal_force_speed", .source = "definition"},
    [RATES + 4] = {.name = "dynamometer_resonance.feed_force_rate", .unit = "N/s", STATE,
        .meaning = "rate of feed_force", .source = "definition"},
    [RATES + 5] = {.name = "dynamometer_resonance.feed_force_acceleration", .unit = "N/s^2", STATE,
        .meaning = "rate of feed_force_speed", .source = "definition"},
};
/* clang-format on */

static double omega(const lanes *p, int i) { return 2 * PI / p[PERIOD][i]; }

static void ring(const lanes *p, const lanes *state, struct Point *x)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE
            x->measured[k][i] += p[PERIOD][i] >= NO_TIME ? state[2 * k][i] - x->measured[k][i] : 0;
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    for (int k = 0; k < CHANNELS; k += 2) { /* two channels at a time; the last is alone, and done twice */
        const int l = k + 1 < CHANNELS ? k + 1 : k;
        struct Oscillators channels;
        lanes w, later[2][2][2];
        EACH_LANE {
            w[i] = p[PERIOD][i] >= NO_TIME ? omega(p, i) : 1;
            channels.start[0][i] = a->measured[k][i];
            channels.start[1][i] = a->measured[l][i];
            channels.middle[0][i] = m->measured[k][i];
            channels.middle[1][i] = m->measured[l][i];
            channels.end[0][i] = b->measured[k][i];
            channels.end[1][i] = b->measured[l][i];
            for (int n = 0; n < 2; ++n) {
                channels.at[n][0][i] = from[2 * k + n][i];
                channels.at[n][1][i] = from[2 * l + n][i];
            }
        }
        second_order_responses_in_mean(h, w, p[DAMPING_RATIO], &channels, later[0], later[1]);
        EACH_LANE {
            const int rings = p[PERIOD][i] >= NO_TIME;
            for (int n = 0; n < 2; ++n) {
                half[2 * k + n][i] = rings ? later[0][n][0][i] : n ? 0 : channels.middle[0][i];
                half[2 * l + n][i] = rings ? later[0][n][1][i] : n ? 0 : channels.middle[1][i];
                whole[2 * k + n][i] = rings ? later[1][n][0][i] : n ? 0 : channels.end[0][i];
                whole[2 * l + n][i] = rings ? later[1][n][1][i] : n ? 0 : channels.end[1][i];
            }
        }
    }
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE {
            const double w = p[PERIOD][i] >= NO_TIME ? omega(p, i) : 0, y = state[2 * k][i], s = state[2 * k + 1][i];
            rate[2 * k][i] = p[PERIOD][i] >= NO_TIME ? s : 0;
            rate[2 * k + 1][i] = w * w * (x->measured[k][i] - y) - 2 * p[DAMPING_RATIO][i] * w * s;
        }
}

static int remembers(const lanes *p, int i) { return p[PERIOD][i] >= NO_TIME; }

/* clang-format off */
const struct Effect effect_dynamometer_resonance = {
    .equation = "y'' + 2 zeta w y' + w^2 y = w^2 F, w = 2 pi/natural_period",
    .signature = "entries and exits ring at the natural frequency; harmonics near it are raised, those above it cut "
        "off",
    .family = "lag", .keeps_mean = 1,
    .stage = STAGE_MEASUREMENT, .driver = DRIVEN_BY_SENSOR, .states = 2 * CHANNELS, .act = ring, .move = move,
    .rate = rate,
    .remembers = remembers,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
