/* Flow stress: harder when sheared faster, softer when hotter. The factors of strain rate and of temperature of Johnson
 * and Cook 1983, with ln(1 + rate) to have a limit at rest. Their factor of strain, A + B eps^n, is not in it: on a
 * shear plane at one angle the strain cot(phi) + tan(phi - alpha) is one and the same, and stands in shear_stress. */
#include "effect.h"

enum { ON, C, V_REF, SOFTENING, EXPONENT, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "flow_stress_softening", SWITCH,
        .meaning = "switch: the shear stress depends on strain rate and temperature proxy; not on strain, which is that of "
            "the shear angle",
        .source = "Johnson and Cook 1983 (not read; as in the manual of OSUPDocs), factors of rate and temperature"},
    [C] = {.name = "flow_stress_softening.C", .unit = "1", .start = 0.02, .min = 0, .max = 1, TUNED,
        .meaning = "rise of the shear stress with the logarithm of the shearing speed; 0: none",
        .source = "Johnson and Cook 1983 (not read); value: ordinary for steel"},
    [V_REF] = {.name = "flow_stress_softening.v_ref", .unit = "m/s", .start = 1e-3, .min = 1e-9, .max = 1e3,
        .display_unit = "m/min", .nominal = 1e-3, SHAPE, TUNED, .meaning = "shearing speed that counts as slow",
        .source = "guess"},
    [SOFTENING] = {.name = "flow_stress_softening.softening", .unit = "1", .start = 0.01, .min = 0, .max = 1, TUNED,
        .meaning = "share of the shear stress lost at theta = theta_ref; 0: none",
        .source = "guess: half of it at 49 m/min, the fastest slip at the start values"},
    [EXPONENT] = {.name = "flow_stress_softening.exponent", .unit = "1", .start = 1, .min = 0.05, .max = 5, SHAPE,
        TUNED, .meaning = "exponent m of the softening", .source = "Johnson and Cook 1983 (not read)"},
};
/* clang-format on */

#define FLOOR 0.01 /* share of the shear stress */

static void soften(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    int floors = 0;
    EACH_LANE {
        const double rate = 1 + p[C][i] * log_1p(x->shear_speed[i] / p[V_REF][i]);
        const double left = 1 - p[SOFTENING][i] * power_of(x->theta_ratio[i], p[EXPONENT][i]);
        const int at_floor = (x->cutting[i] != 0) & (left < FLOOR);
        x->tau_s[i] *= rate * larger(left, FLOOR);
        x->clamped[i] += at_floor;
        floors |= at_floor;
        mark_side(x, i, left < FLOOR);
    }
    x->warnings |= floors ? WARN_SHEAR_FLOOR : 0u;
}

/* clang-format off */
const struct Effect effect_flow_stress_softening = {
    .equation = "tau_s (1 + C ln(1 + u/v_ref)) max(0.01, 1 - s (theta/theta_ref)^m), u the speed into the chip, or |v| where "
        "only the slip is given",
    .signature = "principal force falls with the temperature proxy and rises with the logarithm of speed; friction "
        "keeps its share",
    .needs = "proxy_speed",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "thermal",
    .stage = STAGE_SHEAR, .act = soften,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
