/* Process damping: the flank is pressed into the surface while the tool moves into it. Altintas, Eynian and Onozuka
 * 2008. */
#include "effect.h"

enum { ON, C, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "process_damping", SWITCH, .meaning = "switch: a feed force against the motion into the surface",
        .source = "Altintas, Eynian and Onozuka 2008"},
    [C] = {.name = "process_damping.C", .unit = "Pa.s", .start = 5e3, .min = 0, .max = 1e8, .nominal = 1e3, TUNED,
        .meaning = "force per width and speed into the surface; 0: none", .source = "guess"},
};
/* clang-format on */

static void press(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->edge_f[i] += p[C][i] * x->w[i] * larger(-x->u_y[i], 0);
}

/* clang-format off */
const struct Effect effect_process_damping = {
    .equation = "feed_force - C w u_y while u_y < 0",
    .signature = "feed force rises early in the contact, while the tool still moves into the surface, and not later",
    .applies_to = "internal, combined",
    .family = "load",
    .stage = STAGE_LOAD, .act = press,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
