/* Load dependence: friction rises with the normal load. Amontons 1699; with n = 2/3 an elastic round contact, Archard
 * 1957. */
#include "effect.h"

enum { ON, N_EXP, N_REF, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "load_dependence", SWITCH, .meaning = "switch: the friction level follows the normal load",
        .source = "Amontons 1699; Archard 1957 (neither read)"},
    [N_EXP] = {.name = "load_dependence.n", .unit = "1", .start = 0.7, .min = -0.5, .max = 2, TUNED,
        .meaning = "exponent; 1: in proportion; 0: none; below 0 beside amontons, whose friction it makes rise less than in "
            "proportion", .source = "Archard 1957 (not read): 2/3 for an elastic contact, -1/3 beside amontons"},
    [N_REF] = {.name = "load_dependence.N_ref", .unit = "N", .start = 10, .min = 1e-3, .max = 1e6, .nominal = 10, SHAPE,
        TUNED, .meaning = "normal load at which F_C and F_S hold", .source = "guess"},
};
/* clang-format on */

/* A thousandth of N_ref is held: a law without friction force has no bristle. */
static void press(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        const double ratio = x->load[i] / p[N_REF][i], share = power_of(larger(ratio, 1e-3), p[N_EXP][i]);
        mark_side(x, i, (p[N_EXP][i] != 0) & (ratio < 1e-3));
        x->F_C[i] *= share;
        x->F_S[i] *= share;
    }
}

/* clang-format off */
const struct Effect effect_load_dependence = {
    .equation = "F_C, F_S scaled by (N/N_ref)^n, N the input normal_load, or the normal force of a chip without "
        "friction",
    .signature = "friction follows the thickness or load within the cycle and between conditions",
    .needs = "normal_load",
    .family = "load",
    .stage = STAGE_FRICTION, .act = press,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
