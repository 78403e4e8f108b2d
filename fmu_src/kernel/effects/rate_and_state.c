/* Rate and state: friction answers to a change of speed at once, and settles over a distance slid. Dieterich 1979;
 * Ruina 1983.
 *
 * mu = mu_0 + a ln(v/v_0) + b ln(v_0 theta/d_c) with Ruina's slip law, d theta/dt = -(v theta/d_c) ln(v theta/d_c). In
 * memory = -ln(v_0 theta/d_c), the logarithm of the speed that the contact remembers, it is linear: memory strives for
 * ln(v/v_0) over d_c of slip. Both logarithms are Dieterich's ln(1 + v/v_0), which have a limit at rest. What a rest
 * adds by itself, the ageing law's part, is the effect dwell_strengthening.
 */
#include "effect.h"

enum { ON, A, B, V_0, D_C, MEMORY_OF_SPEED, RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "rate_and_state", SWITCH,
        .meaning = "switch: friction follows the logarithm of the slip speed, in part at once and in part over a distance",
        .source = "Dieterich 1979; slip law: Ruina 1983 (neither read; as in rsfmodel)"},
    [A] = {.name = "rate_and_state.a", .unit = "1", .start = 0.02, .min = 0, .max = 1, TUNED,
        .prior_sd = 0.1, .meaning = "direct effect: rise of F_C and F_S per natural logarithm of the speed, as a share; 0: none",
        .source = "Marone 1998 (not read): 0.005 to 0.015 of mu = 0.6; beyond rock a guess: four times that"},
    [B] = {.name = "rate_and_state.b", .unit = "1", .start = 0.04, .min = 0, .max = 1, TUNED,
        .prior_sd = 0.1, .meaning = "evolution effect: loss of them per natural logarithm of the remembered speed; 0: "
            "none; steady friction falls with speed where it is above a", .source = "Marone 1998 (not read): of the order of a"},
    [V_0] = {.name = "rate_and_state.v_0", .unit = "m/s", .display_unit = "m/min", .start = 1e-4, .min = 1e-9, .max = 10,
        .nominal = 1e-4, SHAPE, TUNED, .meaning = "slip speed from which the logarithms grow; far below it F_C and F_S hold",
        .source = "guess; Dieterich 1979 (not read) has such a bound at small speeds"},
    [D_C] = {.name = "rate_and_state.d_c", .unit = "m", .display_unit = "um", .start = 1e-5, .min = 1e-9, .max = 1,
        .nominal = 1e-5, SHAPE, TUNED, .meaning = "slip over which friction settles after a change of speed",
        .source = "Dieterich 1979 (not read): 1 um to 50 um"},
    [MEMORY_OF_SPEED] = {.name = "rate_and_state.memory", .unit = "1", .nominal = 10, STATE,
        .meaning = "logarithm of 1 plus the remembered slip speed over v_0; 0: a fresh contact", .source = "definition"},
    [RATE] = {.name = "rate_and_state.memory_rate", .unit = "1/s", STATE, .meaning = "rate of memory",
        .source = "definition"},
};
/* clang-format on */

/* A contact does not lose more than this of its friction, whatever the parameters. */
#define LEAST_SHARE 0.01

static INLINED double logarithm(const lanes *p, const struct Point *x, int i)
{
    return log_1p(x->speed[i] / p[V_0][i]);
}

static INLINED double renewal(const lanes *p, const struct Point *x, int i)
{
    return x->cutting[i] * x->speed[i] / p[D_C][i];
}

static void follow_speed(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE {
        const double told = 1 + p[A][i] * logarithm(p, x, i) - p[B][i] * state[0][i], share = larger(told, LEAST_SHARE);
        mark_side(x, i, told < LEAST_SHARE);
        x->F_C[i] *= share;
        x->F_S[i] *= share;
    }
}

/* d memory/dD = logarithm - memory over the renewals D = integral of |v|/d_c, with the logarithm as the parabola in D
 * through start, middle and end: exact whatever D is where the speed stays. */
static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    lanes M, D, to_M[3], to_D[3];
    EACH_LANE {
        const double r_0 = renewal(p, a, i), r_m = renewal(p, m, i), r_1 = renewal(p, b, i);
        D[i] = h[i] / 6 * (r_0 + 4 * r_m + r_1);
        M[i] = smaller(larger(h[i] / 24 * (5 * r_0 + 8 * r_m - r_1), 0), D[i]);
    }
    moments_in_lanes(M, D, to_M, to_D);
    EACH_LANE {
        const double u_0 = logarithm(p, a, i), u_m = logarithm(p, m, i), u_1 = logarithm(p, b, i), y = from[0][i];
        const int to_middle = M[i] > NO_PATH, on_from_there = D[i] - M[i] > NO_PATH, at_all = D[i] > NO_PATH;
        const double first = to_middle ? (u_m - u_0) / (to_middle ? M[i] : 1) : 0,
                     last = on_from_there ? (u_1 - u_m) / (on_from_there ? D[i] - M[i] : 1) : first;
        const double bend = at_all ? (last - first) / (at_all ? D[i] : 1) : 0, slope = first - bend * M[i];
        half[0][i] = y + (u_0 - y) * to_M[0][i] + slope * to_M[1][i] + bend * to_M[2][i];
        whole[0][i] = y + (u_0 - y) * to_D[0][i] + slope * to_D[1][i] + bend * to_D[2][i];
    }
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    EACH_LANE
        rate[0][i] = renewal(p, x, i) * (logarithm(p, x, i) - state[0][i]);
}

/* clang-format off */
const struct Effect effect_rate_and_state = {
    .equation = "F_C, F_S scaled by 1 + a ln(1 + |v|/v_0) - b memory, d memory/dt = |v|/d_c (ln(1 + |v|/v_0) - memory)",
    .signature = "a step of the slip speed shows as a peak that decays over a distance, not over a time; steady friction "
        "changes by equal steps per decade of speed",
    .special_cases = "viscous_friction", /* of a power below 1, where nothing is seen to evolve */
    .family = "state",
    .stage = STAGE_FRICTION, .driver = DRIVEN_BY_MOTION, .states = 1, .forgets = 1, .settles = 1,
    .act = follow_speed, .move = move, .rate = rate,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
