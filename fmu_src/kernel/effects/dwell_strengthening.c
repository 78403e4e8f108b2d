/* Dwell strengthening: contacts that rest grow. Dieterich 1979; age of the contact: Ruina 1983. */
#include "effect.h"

enum { ON, BETA, T_REF, D_C, AGE, RATE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "dwell_strengthening", SWITCH,
        .meaning = "switch: static friction grows with the logarithm of the time at rest",
        .source = "Dieterich 1979; Ruina 1983 (neither read; rate of the age as in rsfmodel)"},
    [BETA] = {.name = "dwell_strengthening.beta", .unit = "1", .start = 0.05, .min = 0, .max = 5, TUNED,
        .meaning = "rise of F_S per natural logarithm of the age, as a share; 0: none",
        .source = "guess: order of Dieterich 1979 (not read)"},
    [T_REF] = {.name = "dwell_strengthening.t_ref", .unit = "s", .start = 1e-3, .min = 1e-9, .max = 1e4,
        .display_unit = "ms", .nominal = 1e-3, SHAPE, TUNED, .meaning = "age from which the logarithm grows",
        .source = "guess"},
    [D_C] = {.name = "dwell_strengthening.D_c", .unit = "m", .start = 1e-6, .min = 1e-10, .max = 1,
        .display_unit = "um", .nominal = 1e-6, SHAPE, TUNED, .meaning = "slip that renews the contact",
        .source = "guess: order of Dieterich 1979 (not read)"},
    [AGE] = {.name = "dwell_strengthening.age", .unit = "s", .nominal = 1e-3, STATE, .meaning = "age of the contact",
        .source = "definition"},
    [RATE] = {.name = "dwell_strengthening.age_rate", .unit = "1", STATE, .meaning = "rate of age",
        .source = "definition"},
};
/* clang-format on */

static void strengthen(const lanes *p, const lanes *state, struct Point *x)
{
    EACH_LANE
        x->F_S[i] *= 1 + p[BETA][i] * log_1p(larger(state[0][i], 0) / p[T_REF][i]);
}

static double renewal(const lanes *p, const struct Point *x, int i) { return x->cutting[i] * x->speed[i] / p[D_C][i]; }

/* age' = 1 - |v| age/D_c over h with the renewals D = integral of |v|/D_c and M at half of h: by Simpson's rule where
 * few, at the mean rate where many. */
static double aged(double age, double h, double M, double D)
{
    if (D < 0.5)
        return age * exp(-D) + h / 6 * (exp(-D) + 4 * exp(M - D) + 1);
    return age * exp(-D) - h / D * expm1(-D);
}

/* Rates of renewal at start, middle and end of a step. */
struct Rates {
    double r_0, r_m, r_1;
};

/* Many renewals at a pace that changes little: the age follows 1/r, a parabola in the renewals through the three
 * points, M and D of them after half and whole of the step; over `to` of them. */
static double followed(double age, const struct Rates *r, double M, double D, double to)
{
    const double q_0 = 1 / r->r_0, first = (1 / r->r_m - q_0) / M, last = (1 / r->r_1 - 1 / r->r_m) / (D - M);
    const double bend = (last - first) / D, slope = first - bend * M;
    double I[3];
    moments(to, I);
    return age + (q_0 - age) * I[0] + slope * I[1] + bend * I[2];
}

#define LEAST_RENEWALS 0.5 /* below, 1/r may be anything and the time counts */
#define MOST_RATE_RATIO 4  /* rates of a step whose 1/r is near a parabola */

static int follows(const struct Rates *r, double D)
{
    const double low = smaller(smaller(r->r_0, r->r_m), r->r_1), high = larger(larger(r->r_0, r->r_m), r->r_1);
    return D >= LEAST_RENEWALS && high < MOST_RATE_RATIO * low;
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    for (int i = 0; i < LANES; ++i) {
        const double r_0 = renewal(p, a, i), r_m = renewal(p, m, i), r_1 = renewal(p, b, i), on = a->cutting[i];
        const double M = h[i] / 24 * larger(5 * r_0 + 8 * r_m - r_1, 0),
                     D = larger(h[i] / 6 * (r_0 + 4 * r_m + r_1), M);
        const double quarter = h[i] / 48 * (8 * r_0 + 5 * r_m - r_1); /* all three of the parabola through the rates */
        const struct Rates r = {r_0, r_m, r_1};
        if (on != 0 && follows(&r, D)) {
            half[0][i] = followed(from[0][i], &r, M, D, M);
            whole[0][i] = followed(from[0][i], &r, M, D, D);
            continue;
        }
        half[0][i] = on != 0 ? aged(from[0][i], 0.5 * h[i], smaller(larger(quarter, 0), M), M) : from[0][i];
        whole[0][i] = on != 0 ? aged(from[0][i], h[i], M, D) : from[0][i];
    }
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    EACH_LANE
        rate[0][i] = x->cutting[i] - renewal(p, x, i) * state[0][i];
}

/* clang-format off */
const struct Effect effect_dwell_strengthening = {
    .equation = "F_S (1 + beta ln(1 + age/t_ref)), d age/dt = 1 - |v| age/D_c in contact",
    .signature = "the first peak after a rest is higher the longer the rest, in equal steps per decade",
    .family = "state",
    .stage = STAGE_FRICTION, .driver = DRIVEN_BY_MOTION, .states = 1, .forgets = 1,
    .act = strengthen, .move = move, .rate = rate,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
