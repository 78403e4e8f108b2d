/* Minimum chip thickness: what lies below the stagnation point on the rounded edge makes no chip, but flows under it.
 * The edge is a quarter of a circle of radius r; from its lowest point up to the height h_m it presses on the work with
 * one pressure p and rubs with mu p. Their sum over the arc is that over its projections, h_m upright and
 * c = sqrt(h_m (2 r - h_m)) along the cut. Where the cut is thinner than the stagnation point is high, all of it flows
 * under the edge. Work that springs back behind the edge is flank_wear's and edge_force's. */
#include "effect.h"

enum { ON, RADIUS, SHARE, STRESS, FRICTION, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "minimum_chip_thickness", SWITCH,
        .meaning = "switch: the lowest layer of the cut is ploughed by the rounded edge, not sheared",
        .source = "Albrecht 1960; Vogler, DeVor and Kapoor 2004 (neither read); the sum over the arc is derived"},
    [RADIUS] = {.name = "minimum_chip_thickness.edge_radius", .unit = "m", .start = 8e-6, .min = 0, .max = 2e-4,
        .display_unit = "um", .nominal = 1e-6, TUNED, .meaning = "radius r of the cutting edge; 0: none, it is sharp",
        .source = "guess: an edge of 5 to 10 um"},
    [SHARE] = {.name = "minimum_chip_thickness.share", .unit = "1", .start = 0.3, .min = 0.05, .max = 1, SHAPE, TUNED,
        .meaning = "thickness from which chips form over the radius, h_min/r",
        .source = "guess: commonly quoted as 0.2 to 0.4; Wojciechowski 2022, doi:10.3390/ma15010059 (abstract read), "
            "reviews how it is found"},
    [STRESS] = {.name = "minimum_chip_thickness.stress", .unit = "Pa", .start = 5e8, .min = 1e6, .max = 1e11, .display_unit = "MPa",
        .nominal = 1e8, SHAPE, TUNED, .meaning = "pressure p between the edge and what flows under it",
        .source = "guess: of the order of the shear stress"},
    [FRICTION] = {.name = "minimum_chip_thickness.friction", .unit = "1", .start = 0.3, .min = 1e-2, .max = 1, SHAPE, TUNED,
        .meaning = "coefficient mu of friction there", .source = "guess"},
};
/* clang-format on */

static void pass_under(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double r = p[RADIUS][i], mu = p[FRICTION][i], pressed = p[STRESS][i] * x->w[i],
                     under = smaller(p[SHARE][i] * r, larger(x->h[i], 0)), along = sqrt(under * (2 * r - under));
        mark_side(x, i, x->h[i] < p[SHARE][i] * r);
        x->k[i] *= x->h[i] > 0 ? 1 - under / x->h[i] : 1;
        x->edge_p[i] += pressed * (under + mu * along);
        x->edge_f[i] += pressed * (along - mu * under);
    }
}

/* clang-format off */
const struct Effect effect_minimum_chip_thickness = {
    .equation = "tau_s w (h - h_m) in place of tau_s w h, principal_force + p w (h_m + mu c), feed_force + p w (c - mu h_m), "
        "h_m = min(h, share r), c = sqrt(h_m (2 r - h_m))",
    .signature = "force over thickness has a bend at share r: ploughing below, steep at first, the slope of the chip above",
    .special_cases = "edge_force", /* where the cut is never thinner than share r */
    .applies_to = "internal, combined, uncut_thickness",
    .family = "load",
    .stage = STAGE_LOAD, .act = pass_under,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
