/* Elasto-plastic presliding: below a break-away deflection bristles spring back whole. Dupont, Hayward, Armstrong and
 * Altpeter 2002. */
#include "effect.h"

enum { ON, SHARE, BREAK_AWAY, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "elasto_plastic", SWITCH, .meaning = "switch: no plastic slip below a break-away deflection",
        .source = "Dupont, Hayward, Armstrong and Altpeter 2002 (not read; alpha(z) as in FrictionModels.jl)"},
    [SHARE] = {.name = "elasto_plastic.share", .unit = "1", .start = 1, .min = 0, .max = 1, TUNED,
        .meaning = "share of the bristles that behave so; 0: none, all as in LuGre",
        .source = "definition: a blend of both laws"},
    [BREAK_AWAY] = {.name = "elasto_plastic.break_away", .unit = "1", .start = 0.7, .min = 0.01, .max = 0.99, SHAPE,
        TUNED, .meaning = "deflection where plastic slip begins, as a share of the steady one", .source = "guess"},
};
/* clang-format on */

/* alpha(z) of Dupont et al. and its slope over the deflection s along the slip, steady at `most`. */
IN_LOOPS double plastic(double s, double break_away, double most, double *slope)
{
    const double from = break_away * most, width = most - from;
    const int between = (s > from) & (width > 0) & (s < most);
    double cosine, sine;
    cos_sin(0.5 * (s - from) / width - 0.25, &cosine, &sine);
    *slope = chosen_of(between, 0.5 * cosine * PI / width, 0);
    return chosen_of(between, 0.5 * (1 + sine), s > from);
}

/* dz/dt = v - alpha(z) a z, linearised at this z: rate a (alpha + alpha' s), but at least a. The step's parabola runs
 * over the integral of the rate, and a rate that fell to next to nothing would throw the target out of its reach. */
static void yield(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        double slope;
        const double s = x->direction[i] * x->z[i], alpha = plastic(s, p[BREAK_AWAY][i], fabs(x->target[i]), &slope);
        mark_side(x, i, (p[SHARE][i] > 0) & (alpha > 0));
        mark_side(x, i, (p[SHARE][i] > 0) & (alpha >= 1));
        const double share = p[SHARE][i], part = 1 - share * (1 - alpha), steep = larger(part + share * slope * s, 1);
        x->target[i] = (x->target[i] + (steep - part) * x->z[i]) / steep;
        x->drive[i] += (steep - part) * x->rate[i] * x->z[i];
        x->rate[i] *= steep;
    }
}

/* clang-format off */
const struct Effect effect_elasto_plastic = {
    .equation = "dz/dt = v - alpha(z) P |v| z / g; alpha = 0 below the break-away deflection or where z and v differ "
        "in sign, 1 at steady slip, a half sine between",
    .signature = "small loads to and fro are held without drift; after a reversal the slope is that of the bristles, "
        "where LuGre has twice it",
    .rivals = "maxwell_slip",
    .family = "presliding", .form_of_law = 1,
    .stage = STAGE_BRISTLE, .bends = 1, .act = yield,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
