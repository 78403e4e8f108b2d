/* Edge force: the rounded edge ploughs besides the chip. Albrecht 1960. */
#include "effect.h"

enum { ON, K_EP, K_EF, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "edge_force", SWITCH,
        .meaning = "switch: constant forces per width while cutting, beside those of the chip",
        .source = "Albrecht 1960 (not read); linear edge forces: Altintas 2012 (not read), Manufacturing Automation, "
            "chapter 2"},
    [K_EP] = {.name = "edge_force.K_ep", .unit = "N/m", .start = 5e3, .min = 0, .max = 1e7, .display_unit = "N/mm",
        .nominal = 1e3, TUNED, .meaning = "edge force per width against the cutting direction; 0: none",
        .source = "guess"},
    [K_EF] = {.name = "edge_force.K_ef", .unit = "N/m", .start = 5e3, .min = 0, .max = 1e7, .display_unit = "N/mm",
        .nominal = 1e3, TUNED, .meaning = "edge force per width away from the surface; 0: none", .source = "guess"},
};
/* clang-format on */

static void plough(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        x->edge_p[i] += p[K_EP][i] * x->w[i];
        x->edge_f[i] += p[K_EF][i] * x->w[i];
    }
}

/* clang-format off */
const struct Effect effect_edge_force = {
    .equation = "principal_force + K_ep w, feed_force + K_ef w while cutting",
    .signature = "force over thickness keeps its slope and gains an intercept",
    .rivals = "size_effect, kienzle_force",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "load",
    .stage = STAGE_LOAD, .act = plough,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
