/* Size effect: thin chips are harder to shear. A power, as Kienzle's of the cutting force, here of the shear stress:
 * with friction that does not follow the load the specific cutting force has a lesser exponent; see kienzle_force.c. */
#include "effect.h"

enum { ON, EXPONENT, H_REF, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "size_effect", SWITCH, .meaning = "switch: the shear stress rises as the chip gets thinner",
        .source = "guess: the power of Kienzle 1952 (not read) for the shear stress alone"},
    [EXPONENT] = {.name = "size_effect.exponent", .unit = "1", .start = 0.2, .min = 0, .max = 0.9, TUNED,
        .meaning = "exponent m of the shear stress; 0: none", .source = "guess: ordinary for steel"},
    [H_REF] = {.name = "size_effect.h_ref", .unit = "m", .start = 1e-4, .min = 1e-7, .max = 1e-2, .display_unit = "um",
        .nominal = 1e-4, SHAPE, TUNED, .meaning = "thickness at which shear_stress holds", .source = "guess"},
};
/* clang-format on */

/* A thousandth of h_ref is thinner than any chip that forms: there the law, which has no limit at 0, is held. */
static void harden(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double ratio = x->h[i] / p[H_REF][i];
        x->tau_s[i] *= power_of(larger(ratio, 1e-3), -p[EXPONENT][i]);
        mark_side(x, i, (p[EXPONENT][i] != 0) & (ratio < 1e-3));
    }
}

/* clang-format off */
const struct Effect effect_size_effect = {
    .equation = "tau_s (h/h_ref)^-m",
    .signature = "force over thickness is a power below 1: steep at thin chips, no intercept",
    .rivals = "edge_force, kienzle_force",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "load",
    .stage = STAGE_SHEAR, .act = harden,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
