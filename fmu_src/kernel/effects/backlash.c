/* Backlash: after a reversal the motion first crosses a gap, and then takes the contact along. Play operator: Tao and
 * Kokotovic 1996; in drives: Nordin and Gutman 2002.
 *
 * The motion is what is given; what of it does not reach the contact moves within the gap. What moves there is a stop
 * operator, with its round corner for the ends of the gap.
 */
#include "effect.h"
#include "stop_operator.h"

enum { ON, GAP, PLACE, RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "backlash", SWITCH,
        .meaning = "switch: after a reversal the motion crosses a gap before it moves the contact",
        .source = "Tao and Kokotovic 1996; Nordin and Gutman 2002 (neither read)"},
    [GAP] = {.name = "backlash.gap", .unit = "m", .start = 2e-5, .min = 0, .max = 1, .display_unit = "um",
        .nominal = 1e-5, TUNED, .meaning = "width of the gap, from end to end; 0, or less than 1e-12 m: none",
        .source = "guess"},
    [PLACE] = {.name = "backlash.place", .unit = "1", STATE,
        .meaning = "place in the gap, -1 and 1 at its ends; 0 at the start, and after a separation without a release_time",
        .source = "definition"},
    [RATE] = {.name = "backlash.place_rate", .unit = "1/s", STATE, .meaning = "rate of place", .source = "definition"},
};
/* clang-format on */

/* Of a motion in the gap so much reaches the contact all the same: it says which way the slip turns, and moves nothing.
 */
#define LEAK 1e-6

static void cross(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE {
        const double s = x->v[i] < 0 ? -1 : 1, free = s * stop_rate(state[0][i], s);
        x->passed[i] *= p[GAP][i] >= NO_AMPLITUDE ? 1 - (1 - LEAK) * larger(free, 0) : 1;
        mark_side(x, i, p[GAP][i] >= NO_AMPLITUDE && gives_way(state[0][i], x->direction[i]));
    }
}

static double motion(const struct Point *x, int i) { return x->v[i] / x->passed[i]; }

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    EACH_LANE {
        const double s = a->direction[i], y = from[0][i];
        const int crosses = (a->cutting[i] != 0) & (p[GAP][i] >= NO_AMPLITUDE);
        double to_half, to_end;
        ways_of(s, h[i], motion(a, i), motion(m, i), motion(b, i), &to_half, &to_end);
        half[0][i] = crosses ? stop_after(y, s, 2 * to_half / p[GAP][i]) : y;
        whole[0][i] = crosses ? stop_after(y, s, 2 * to_end / p[GAP][i]) : y;
    }
    for (int i = 0; i < LANES; ++i) {
        if (a->cutting[i] == 0 || isnan(a->solved_slip[i]) || !(p[GAP][i] >= NO_AMPLITUDE))
            continue;
        struct Ways to_half, to_end;
        ways_that_turn(a->direction[i], h[i], motion(a, i), motion(m, i), motion(b, i), &to_half, &to_end);
        half[0][i] = stop_along_and_back(from[0][i], a->direction[i], 0.5 * p[GAP][i], to_half);
        whole[0][i] = stop_along_and_back(from[0][i], a->direction[i], 0.5 * p[GAP][i], to_end);
    }
}

#define ROUNDINGS 1e-14 /* of two places, as a share of the gap */

/* A motion that turns just within a round corner slips there, and neither before nor after. */
static double slip_way(const lanes *p, double h, const struct Point *a, const struct Point *m, const struct Point *b,
                       const lanes *from, const lanes *to, double seen, int i)
{
    if (!(p[GAP][i] >= NO_AMPLITUDE))
        return seen;
    struct Ways half, whole;
    ways_that_turn(a->direction[i], h, motion(a, i), motion(m, i), motion(b, i), &half, &whole);
    const double side = (1 - LEAK) * 0.5 * p[GAP][i], across = side * (to[0][i] - from[0][i]);
    const double way = a->direction[i] * (whole.along - whole.back) - across;
    return fabs(way - seen) > ROUNDINGS * side ? way : seen;
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    EACH_LANE {
        const double s = x->direction[i], v = larger(s * motion(x, i), 0);
        const int crosses = (x->cutting[i] != 0) & (p[GAP][i] >= NO_AMPLITUDE);
        rate[0][i] = crosses ? 2 * v / p[GAP][i] * stop_rate(state[0][i], s) : 0;
    }
}

/* clang-format off */
const struct Effect effect_backlash = {
    .equation = "slip velocity v (1 - min(1, (1 - s y)/0.1)), s = sgn(v); gap/2 dy/dt = v min(1, (1 - s y)/0.1)",
    .signature = "after each reversal the force stands still over a way that is the same at any speed, and then turns",
    .applies_to = "external",
    .family = "lag",
    .stage = STAGE_ENGAGEMENT, .driver = DRIVEN_BY_APPROACH, .states = 1, .forgets = 1, .settles = 1,
    .act = cross, .move = move, .rate = rate, .slip_way = slip_way,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
