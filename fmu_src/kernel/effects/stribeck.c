/* Stribeck effect, beside what the nominal model has: more friction at the slowest slip. Stribeck 1902. */
#include "effect.h"

enum { ON, RISE, V_S_RATIO, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "stribeck", SWITCH, .meaning = "switch: friction is higher near zero slip",
        .source = "Stribeck 1902 (not read); exponential form: Bo and Pavelescu 1982 (not read)"},
    [RISE] = {.name = "stribeck.rise", .unit = "N", .start = 2, .min = 0, .max = 1e6, .nominal = 1, TUNED,
        .meaning = "added to F_S; 0: none", .source = "guess"},
    [V_S_RATIO] = {.name = "stribeck.v_s_ratio", .unit = "1", .start = 1, .min = 1e-3, .max = 1e4, .neutral = 1, TUNED,
        .meaning = "scale of the Stribeck velocity v_s; 1: as it stands", .source = "guess"},
};
/* clang-format on */

static void raise(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE {
        x->F_S[i] += p[RISE][i];
        x->v_s[i] *= p[V_S_RATIO][i];
    }
}

/* clang-format off */
const struct Effect effect_stribeck = {
    .equation = "F_S + rise, v_s scaled by v_s_ratio",
    .signature = "peaks of friction where the slip starts or nearly stops; none at speed",
    .family = "speed",
    .stage = STAGE_FRICTION, .act = raise,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
