/* Minimum chip thickness: what lies below the stagnation point on the rounded edge makes no chip, but flows under it.
 * Where the edge is sharp beside the cut, that is little; where the cut is as thin, there is nothing but ploughing. */
#include "effect.h"

enum { ON, H_MIN, STRESS, DRAG, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "minimum_chip_thickness", SWITCH,
        .meaning = "switch: the lowest layer of the cut is ploughed by the rounded edge, not sheared",
        .source = "Albrecht 1960; Vogler, DeVor and Kapoor 2004 (not read): chips form from some thickness on"},
    [H_MIN] = {.name = "minimum_chip_thickness.h_min", .unit = "m", .start = 2e-6, .min = 0, .max = 1e-4, .display_unit = "um",
        .nominal = 1e-6, TUNED, .meaning = "thickness of the layer that is ploughed, 0.2 to 0.4 of the edge's radius; 0: none",
        .source = "guess: an edge of 5 to 10 um"},
    [STRESS] = {.name = "minimum_chip_thickness.stress", .unit = "Pa", .start = 5e8, .min = 1e6, .max = 1e11, .display_unit = "MPa",
        .nominal = 1e8, SHAPE, TUNED, .meaning = "force away from the surface for each area of that layer",
        .source = "guess: of the order of the shear stress"},
    [DRAG] = {.name = "minimum_chip_thickness.drag", .unit = "1", .start = 0.3, .min = 1e-2, .max = 10, SHAPE, TUNED,
        .meaning = "force against the cutting direction over that away from the surface", .source = "guess: a coefficient of friction"},
};
/* clang-format on */

static void pass_under(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double under = smaller(p[H_MIN][i], larger(x->h[i], 0)), push = p[STRESS][i] * x->w[i] * under;
        x->k[i] *= x->h[i] > 0 ? 1 - under / x->h[i] : 1;
        x->edge_p[i] += p[DRAG][i] * push;
        x->edge_f[i] += push;
    }
}

/* clang-format off */
const struct Effect effect_minimum_chip_thickness = {
    .equation = "tau_s w (h - h_m) in place of tau_s w h, principal_force + drag stress w h_m, feed_force + stress w h_m, "
        "h_m = min(h, h_min)",
    .signature = "force over thickness has a bend at h_min: one slope for ploughing below, that of the chip above",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "load",
    .stage = STAGE_LOAD, .act = pass_under,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
