/* Maxwell slip: presliding by four elements in parallel, which give way one after the other. Iwan 1966; generalised:
 * Lampaert, Al-Bender and Swevers 2003.
 *
 * Each carries a quarter of the force that the friction law's bristle has in steady sliding, which its deflection g/P
 * and the stiffness s0 make: g(v), or less of it where heat softens s0 alone. It gives way after a stroke of its own:
 * the longest and what a ratio makes of it, three times. So where a slip turned round within the stroke is remembered
 * until it is passed again, which one bristle does not do. Unlike Lampaert et al. an element that gives way has the
 * force of the limit at once, and one that sticks follows it, too.
 */
#include "effect.h"
#include "stop_operator.h"

enum { ELEMENTS = 4 };
enum { ON, SHARE, STROKE, RATIO, FIRST, RATES = FIRST + ELEMENTS, COUNT = RATES + ELEMENTS };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "maxwell_slip", SWITCH,
        .meaning = "switch: presliding by four elements that give way one after the other, in place of one bristle",
        .source = "Lampaert, Al-Bender and Swevers 2003 (not read; compared with FrictionModels.jl)"},
    [SHARE] = {.name = "maxwell_slip.share", .unit = "1", .start = 1, .min = 0, .max = 1, TUNED,
        .meaning = "share of the friction limit that they carry; 0: none, all is the law's own bristle",
        .source = "definition: a blend of both laws"},
    [STROKE] = {.name = "maxwell_slip.stroke", .unit = "m", .start = 2e-5, .min = 1e-9, .max = 1, .display_unit = "um",
        .nominal = 1e-5, SHAPE, TUNED, .meaning = "slip after which the last of them gives way",
        .source = "guess: Al-Bender, Lampaert and Swevers 2005 (not read) have tens of um"},
    [RATIO] = {.name = "maxwell_slip.ratio", .unit = "1", .start = 3, .min = 1, .max = 20, SHAPE, TUNED,
        .meaning = "stroke of each over that of the one before; 1: all give way at once", .source = "guess"},
    [FIRST + 0] = {.name = "maxwell_slip.load_1", .unit = "1", STATE,
        .meaning = "force of the first to give way over its limit", .source = "definition"},
    [FIRST + 1] = {.name = "maxwell_slip.load_2", .unit = "1", STATE, .meaning = "force of the second over its limit",
        .source = "definition"},
    [FIRST + 2] = {.name = "maxwell_slip.load_3", .unit = "1", STATE, .meaning = "force of the third over its limit",
        .source = "definition"},
    [FIRST + 3] = {.name = "maxwell_slip.load_4", .unit = "1", STATE,
        .meaning = "force of the last to give way over its limit", .source = "definition"},
    [RATES + 0] = {.name = "maxwell_slip.load_1_rate", .unit = "1/s", STATE, .meaning = "rate of load_1",
        .source = "definition"},
    [RATES + 1] = {.name = "maxwell_slip.load_2_rate", .unit = "1/s", STATE, .meaning = "rate of load_2",
        .source = "definition"},
    [RATES + 2] = {.name = "maxwell_slip.load_3_rate", .unit = "1/s", STATE, .meaning = "rate of load_3",
        .source = "definition"},
    [RATES + 3] = {.name = "maxwell_slip.load_4_rate", .unit = "1/s", STATE, .meaning = "rate of load_4",
        .source = "definition"},
};
/* clang-format on */

/* Force of all over their limit, after a way from where none was loaded; and of each. */
static double loaded(const lanes *p, int i, double way, double *load)
{
    double stroke = p[STROKE][i], sum = 0;
    for (int k = ELEMENTS - 1; k >= 0; --k) {
        load[k] = stop_after(0, 1, way / stroke);
        sum += load[k];
        stroke /= p[RATIO][i];
    }
    return sum / (double)ELEMENTS;
}

/* A bristle that is bent stands for elements which one way has loaded until they had its share of the limit. */
static void begin(const lanes *p, const struct Point *x, lanes *state)
{
    EACH_LANE {
        const double bent = x->steady[i] != 0 ? smaller(fabs(x->z[i] / x->steady[i]), 1) : 0;
        double load[ELEMENTS] = {0}, low = 0, high = 4 * p[STROKE][i]; /* where the last has given way */
        int stated = 0;
        for (int k = 0; k < ELEMENTS; ++k)
            stated |= state[k][i] != 0;
        if (bent == 0 || stated)
            continue;
        for (int n = 0; n < 60; ++n) { /* halvings: of a double they leave nothing */
            const double way = (low + high) / 2;
            *(loaded(p, i, way, load) < bent ? &low : &high) = way;
        }
        for (int k = 0; k < ELEMENTS; ++k)
            state[k][i] = copysign(load[k], x->z[i]);
    }
}

/* Of a law whose bristle strives for a steady deflection, s0 times that is the limit, whatever way leads there; one
 * without has nothing to replace. */
static void replace(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE {
        const double share = x->steady[i] != 0 ? p[SHARE][i] : 0;
        const double load = (state[0][i] + state[1][i] + state[2][i] + state[3][i]) / (double)ELEMENTS;
        x->instead[i] += share * x->s0[i] * fabs(x->steady[i]) * load;
        x->kept[i] *= 1 - share;
        for (int k = 0; k < ELEMENTS; ++k)
            mark_side(x, i, share != 0 && gives_way(state[k][i], x->direction[i]));
    }
}

/* Out of contact they relax as the bristle does. */
static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    lanes stroke, left, half_along, half_back, along, back;
    int turns = 0, apart = 0;
    EACH_LANE {
        stroke[i] = p[STROKE][i];
        ways_of(a->direction[i], h[i], a->v[i], m->v[i], b->v[i], &half_along[i], &along[i]);
        half_back[i] = back[i] = 0;
        turns |= (a->direction[i] * a->v[i] > 0) & (a->direction[i] * b->v[i] < 0);
        apart |= a->cutting[i] == 0;
    }
    for (int i = 0; turns && i < LANES; ++i) {
        struct Ways to_half, to_end;
        ways_that_turn(a->direction[i], h[i], a->v[i], m->v[i], b->v[i], &to_half, &to_end);
        half_along[i] = to_half.along;
        half_back[i] = to_half.back;
        along[i] = to_end.along;
        back[i] = to_end.back;
    }
    if (apart)
        EACH_LANE
            left[i] = exponential(-0.5 * h[i] * a->rate[i]);
    for (int k = ELEMENTS - 1; k >= 0; --k) {
        EACH_LANE {
            half[k][i] = stop_after(from[k][i], a->direction[i], half_along[i] / stroke[i]);
            whole[k][i] = stop_after(from[k][i], a->direction[i], along[i] / stroke[i]);
        }
        if (turns)
            EACH_LANE {
                half[k][i] = stop_after(half[k][i], -a->direction[i], half_back[i] / stroke[i]);
                whole[k][i] = stop_after(whole[k][i], -a->direction[i], back[i] / stroke[i]);
            }
        if (apart)
            EACH_LANE {
                half[k][i] = a->cutting[i] != 0 ? half[k][i] : from[k][i] * left[i];
                whole[k][i] = a->cutting[i] != 0 ? whole[k][i] : from[k][i] * left[i] * left[i];
            }
        EACH_LANE
            stroke[i] /= p[RATIO][i];
    }
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    lanes stroke;
    EACH_LANE
        stroke[i] = p[STROKE][i];
    for (int k = ELEMENTS - 1; k >= 0; --k)
        EACH_LANE {
            const double slides = stop_rate(state[k][i], x->direction[i]) * x->speed[i] / stroke[i];
            rate[k][i] = x->cutting[i] != 0 ? slides : -x->rate[i] * state[k][i];
            stroke[i] /= p[RATIO][i];
        }
}

/* clang-format off */
const struct Effect effect_maxwell_slip = {
    .equation = "F = (1 - share) (s0 z + s1 dz/dt) + share s0/P g(v) sum(y_k)/4 + sigma2 v; dy_k/dt = v/d_k up to "
        "|y_k| = 1, d_k = stroke/ratio^(4 - k), k = 1..4 (laws whose bristle relaxes)",
    .signature = "force over position after a reversal bends in steps; a small loop within a large one closes, and goes "
        "on as if it had not been",
    .rivals = "elasto_plastic",
    .family = "presliding", .form_of_law = 1,
    .stage = STAGE_BRISTLE, .driver = DRIVEN_BY_MOTION, .states = ELEMENTS, .forgets = 1,
    .begin = begin, .act = replace, .move = move, .rate = rate,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
