/* Amplitude loss: the ultrasonic tool vibrates less the more it is loaded. */
#include "effect.h"

enum { ON, KAPPA, F_REF, RESPONSE_TIME, LOAD, RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "amplitude_loss", SWITCH,
        .meaning = "switch: the vibration amplitudes fall with the mean principal force",
        .source = "guess: linear, as of a resonant tool without amplitude control"},
    [KAPPA] = {.name = "amplitude_loss.kappa", .unit = "1", .start = 0.1, .min = 0, .max = 1, TUNED,
        .meaning = "share of the amplitudes lost at F_ref; 0: none", .source = "guess"},
    [F_REF] = {.name = "amplitude_loss.F_ref", .unit = "N", .start = 10, .min = 1e-3, .max = 1e6, .nominal = 10, SHAPE,
        .reference = 1, TUNED, .meaning = "mean principal force at which kappa is lost: only the quotient of both counts",
        .source = "guess"},
    [RESPONSE_TIME] = {.name = "amplitude_loss.response_time", .unit = "s", .start = 1e-3, .min = 1e-6, .max = 10,
        .display_unit = "ms", .nominal = 1e-3, SHAPE, TUNED,
        .meaning = "time constant of the mean, and so of the ultrasonic system", .source = "guess"},
    [LOAD] = {.name = "amplitude_loss.mean_load", .unit = "N", .nominal = 10, STATE,
        .meaning = "principal force that the ultrasonic system feels", .source = "definition"},
    [RATE] = {.name = "amplitude_loss.mean_load_rate", .unit = "N/s", STATE, .meaning = "rate of mean_load",
        .source = "definition"},
};
/* clang-format on */

#define LEAST_SHARE 0.01 /* of the amplitudes is left under any load */

static void shrink(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE {
        const double linear = 1 - p[KAPPA][i] * state[0][i] / p[F_REF][i], left = larger(linear, LEAST_SHARE);
        mark_side(x, i, linear < LEAST_SHARE);
        x->a[i] *= left;
        x->b[i] *= left;
    }
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    first_order_response(h, p[RESPONSE_TIME], a->F_p, m->F_p, b->F_p, from[0], half[0], whole[0]);
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    EACH_LANE
        rate[0][i] = (x->F_p[i] - state[0][i]) / p[RESPONSE_TIME][i];
}

/* clang-format off */
const struct Effect effect_amplitude_loss = {
    .equation = "a, b scaled by 1 - kappa F_mean/F_ref, T dF_mean/dt = principal_force - F_mean; the nominal surface stays where the "
                "amplitudes without load put it",
    .signature = "contact ratio and speed ratio change with load: heavier cuts separate later and slip slower",
    .applies_to = "internal, combined",
    .family = "path",
    .stage = STAGE_PATH, .driver = DRIVEN_BY_FORCE, .states = 1, .act = shrink, .move = move, .rate = rate,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
