/* Sticking limit: no more friction than the normal force of the chip and its own strength allow. Zorev 1963.
 *
 * Over the contact length l_c = c h the normal stress rises from the end of the contact to the edge as a power n of the
 * place u, sigma = (n + 1) N/(w l_c) u^n. Where mu sigma is less than the chip's shear flow stress tau_s the chip
 * slides, nearer to the edge it sticks, sheared at tau_s. The integral over both zones, with q = (n + 1) mu N/(tau_s w
 * l_c): q <= 1: F = mu N;   q > 1: F = tau_s w l_c (1 - n/(n + 1) q^(-1/n)), below both mu N and tau_s w l_c. N is that
 * of the shear plane under this same F, and with k = tau_s w h in proportion to k all is: the limit is k times a
 * number, which this file finds. N = 0 allows no friction.
 */
#include "effect.h"

enum { ON, SEVERITY, MU, CONTACT_LENGTH, EXPONENT, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "sticking_limit", SWITCH,
        .meaning = "switch: friction on the rake face is bounded by mu N and by the chip's shear flow stress",
        .source = "Zorev 1963; Childs, Maekawa, Obikawa and Yamane 2000 (neither read; derived from their two zones)"},
    [SEVERITY] = {.name = "sticking_limit.severity", .unit = "1", .start = 1, .min = 0, .max = 1, TUNED,
        .meaning = "by which the limit is divided; 1: that of mu and contact_length; 0: no limit",
        .source = "definition"},
    [MU] = {.name = "sticking_limit.mu", .unit = "1", .start = 1, .min = 0.01, .max = 10, SHAPE, TUNED,
        .meaning = "friction stress over normal stress where the chip slides", .source = "guess"},
    [CONTACT_LENGTH] = {.name = "sticking_limit.contact_length", .unit = "1", .start = 2, .min = 0.01, .max = 100, SHAPE,
        TUNED, .meaning = "length of the contact between chip and tool over the uncut thickness", .source = "guess"},
    [EXPONENT] = {.name = "sticking_limit.exponent", .unit = "1", .start = 3, .min = 0, .max = 10, SHAPE, TUNED,
        .meaning = "exponent of the normal stress over the contact length; 0: even stress, the lesser of both bounds",
        .source = "guess; Zorev 1963 (not read) has a power"},
};
/* clang-format on */

#define LEAST_EXCESS 1e-15 /* of the limit */
#define NO_BOUND 1e30 /* of the shear load: a severity of 0 or next to it */

/* Largest friction force over the shear load, along the chip's flow (side 1) or against it (-1): the root of
 * X - Z(N(side X)), which is convex and above 0 where the search begins, so that Newton's steps fall onto it. */
static double most(const lanes *p, const struct Configuration *w, int i, double side)
{
    const double mu = p[MU][i], length = p[CONTACT_LENGTH][i], n = p[EXPONENT][i];
    const double slides = friction_of(w, mu, side, i);
    double X = smaller(slides, length);
    for (int count = 0; count < 60; ++count) {
        double slope;
        const double N = larger(normal_of(w, side * X, i, &slope), 0), q = (n + 1) * mu * N / length;
        if (q <= 1)
            return smaller(X, slides); /* it slides over the whole length: closed form */
        const double slid = pow(q, -1 / n); /* share of the length; 0 where n is 0 */
        const double excess = X - length * (1 - n / (n + 1) * slid), rise = 1 - side * slope * mu * slid / q;
        if (!(excess > LEAST_EXCESS * X))
            return X;
        X -= excess / rise;
    }
    return X;
}

static void prepare(const lanes *p, struct Configuration *w)
{
    for (int i = 0; i < LANES; ++i) {
        const double severity = p[SEVERITY][i];
        w->bound_along[i] = severity > 0 ? smaller(most(p, w, i, 1) / severity, NO_BOUND) : NO_BOUND;
        w->bound_against[i] = severity > 0 ? smaller(most(p, w, i, -1) / severity, NO_BOUND) : NO_BOUND;
    }
}

static void bound(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    const struct Configuration *const w = x->configuration;
    EACH_LANE {
        if (p[SEVERITY][i] == 0)
            continue;
        x->most_along[i] = smaller(x->most_along[i], x->k[i] * w->bound_along[i]);
        x->most_against[i] = smaller(x->most_against[i], x->k[i] * w->bound_against[i]);
    }
}

/* clang-format off */
const struct Effect effect_sticking_limit = {
    .equation = "|F|, F_C, F_S <= Z(N)/severity; Z = mu N up to q = (n + 1) mu N/(tau_s w c h) = 1, above it "
        "tau_s w c h (1 - n/(n + 1) q^(-1/n)), c = contact_length, n = exponent, N the normal force under that friction",
    .signature = "friction rises with the thickness from nothing at entry, and at thick chips is what it is without",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "load",
    .stage = STAGE_FRICTION, .prepare = prepare, .act = bound,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
