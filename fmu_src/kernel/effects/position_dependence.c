/* Position dependence: friction and force come back with the position, as a motor cogs and balls pass. Cogging: Jahns
 * and Soong 1996; friction of a ball screw over position: Otsuka 1992; harmonics of position: Popovic and Goldenberg
 * 1998.
 */
#include "effect.h"

enum { ON, FRICTION, COGGING, PERIOD, PHASE, POSITION, RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "position_dependence", SWITCH,
        .meaning = "switch: the friction level and a force go up and down with the position",
        .source = "Jahns and Soong 1996 (cogging, not read); "
            "Popovic and Goldenberg 1998 (friction as harmonics of position, not read)"},
    [FRICTION] = {.name = "position_dependence.friction", .unit = "1", .start = 0.1, .min = 0, .max = 0.9, TUNED,
        .meaning = "amplitude r of the share by which F_C and F_S rise and fall; 0: none", .source = "guess"},
    [COGGING] = {.name = "position_dependence.cogging", .unit = "N", .start = 0.5, .min = 0, .max = 1e6, .nominal = 1, TUNED,
        .meaning = "amplitude A of a force that goes by the position alone and takes no energy over a period; 0: none",
        .source = "guess"},
    [PERIOD] = {.name = "position_dependence.period", .unit = "m", .start = 1e-2, .min = 1e-6, .max = 100,
        .display_unit = "mm", .nominal = 1e-2, SHAPE, TUNED, .meaning = "period of both over the position",
        .source = "guess: the lead of a ball screw"},
    [PHASE] = {.name = "position_dependence.phase", .unit = "rad", .start = 0, .min = -6.2832, .max = 6.2832,
        .display_unit = "deg", SHAPE, TUNED, .meaning = "phase psi of both where the position is 0",
        .source = "guess"},
    [POSITION] = {.name = "position_dependence.position", .unit = "m", .display_unit = "mm", .nominal = 1e-2, STATE,
        .meaning = "position: the way slid forward less that backward, since the start, or the last separation "
            "without a release_time",
        .source = "definition"},
    [RATE] = {.name = "position_dependence.position_rate", .unit = "m/s", STATE, .meaning = "rate of position",
        .source = "definition"},
};
/* clang-format on */

static double wave(const lanes *p, double position, int i)
{
    double cosine, sine;
    cos_sin(position / p[PERIOD][i] + p[PHASE][i] / (2 * PI), &cosine, &sine);
    return sine;
}

static void rise_and_fall(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE {
        const double sine = wave(p, state[0][i], i), share = 1 + p[FRICTION][i] * sine;
        x->F_C[i] *= share;
        x->F_S[i] *= share;
        x->beside[i] += p[COGGING][i] * sine;
    }
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    (void)p;
    EACH_LANE {
        const double v_0 = a->v[i], v_m = m->v[i], v_1 = b->v[i], on = a->cutting[i];
        half[0][i] = from[0][i] + on * h[i] / 24 * (5 * v_0 + 8 * v_m - v_1);
        whole[0][i] = from[0][i] + on * h[i] / 6 * (v_0 + 4 * v_m + v_1);
    }
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    (void)p, (void)state;
    EACH_LANE
        rate[0][i] = x->cutting[i] * x->v[i];
}

static double periods(const lanes *p, const lanes *from, const lanes *to, int i)
{
    return p[FRICTION][i] + p[COGGING][i] > 0 ? fabs(to[0][i] - from[0][i]) / p[PERIOD][i] : 0;
}

/* clang-format off */
const struct Effect effect_position_dependence = {
    .equation = "F_C, F_S scaled by 1 + r sin(2 pi x/period + psi), friction_force + A sin(2 pi x/period + psi), dx/dt = v",
    .signature = "a ripple that stands still over the position: its frequency grows with the speed, its size does not",
    .applies_to = "external",
    .family = "position",
    .stage = STAGE_FRICTION, .driver = DRIVEN_BY_MOTION, .states = 1, .forgets = 1,
    .act = rise_and_fall, .move = move, .rate = rate, .periods = periods,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
