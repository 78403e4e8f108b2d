/* Direction asymmetry: friction differs between the two ways. */
#include "effect.h"

enum { ON, A, A_VISCOUS, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "direction_asymmetry", SWITCH,
        .meaning = "switch: friction differs between slip forward and backward",
        .source = "Armstrong-Helouvry, Dupont and Canudas de Wit 1994; on a drive: Janot, Gautier and Brunot 2019 "
            "(neither read)"},
    [A] = {.name = "direction_asymmetry.a", .unit = "1", .start = 0.1, .min = -0.9, .max = 0.9, TUNED,
        .meaning = "share by which F_C and F_S are larger at v > 0 and smaller at v < 0; 0: none", .source = "guess"},
    [A_VISCOUS] = {.name = "direction_asymmetry.a_viscous", .unit = "1", .start = 0, .min = -0.9, .max = 0.9, TUNED,
        .meaning = "the same for sigma2; 0: none", .source = "guess"},
};
/* clang-format on */

static void lean(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        x->F_C[i] *= 1 + p[A][i] * x->direction[i];
        x->F_S[i] *= 1 + p[A][i] * x->direction[i];
        x->sigma2[i] *= 1 + p[A_VISCOUS][i] * x->direction[i];
    }
}

/* clang-format off */
const struct Effect effect_direction_asymmetry = {
    .equation = "F_C, F_S scaled by 1 + a sgn(v), sigma2 by 1 + a_viscous sgn(v)",
    .signature = "the loop of friction over slip is shifted: an even part under reversal",
    .family = "direction",
    .stage = STAGE_FRICTION, .act = lean,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
