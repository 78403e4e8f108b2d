/* Kienzle's force: the specific cutting force is a power of the thickness, k_c = k_c1 (h/h_ref)^-m. Kienzle 1952.
 *
 * The force on the rake normal to it (at rake 0 the principal force) becomes what it is at h_ref under the same
 * friction, times (h/h_ref)^(1 - m), whatever friction law holds: k_c w h with Kienzle's exponent. Friction stays.
 */
#include "effect.h"

enum { ON, SEVERITY, EXPONENT, H_REF, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "kienzle_force", SWITCH,
        .meaning = "switch: the specific cutting force is a power of the thickness",
        .source = "Kienzle 1952 (not read): k_c = k_c1.1 h^-m"},
    [SEVERITY] = {.name = "kienzle_force.severity", .unit = "1", .start = 1, .min = 0, .max = 1, TUNED,
        .meaning = "share of the way from the shear plane's force to Kienzle's; 0: none", .source = "definition"},
    [EXPONENT] = {.name = "kienzle_force.exponent", .unit = "1", .start = 0.25, .min = 0, .max = 0.9, SHAPE, TUNED,
        .meaning = "exponent m of the specific cutting force", .source = "Kienzle 1952 (not read); value: ordinary for steel"},
    [H_REF] = {.name = "kienzle_force.h_ref", .unit = "m", .start = 1e-4, .min = 1e-7, .max = 1e-2, .display_unit = "um",
        .nominal = 1e-4, SHAPE, TUNED, .meaning = "thickness at which the shear plane's own force holds",
        .source = "guess"},
};
/* clang-format on */

static void cut(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    for (int i = 0; i < LANES; ++i) {
        const double k = x->tau_s[i] * x->w[i] * p[H_REF][i];
        if (x->cutting[i] == 0 || !(k > 0) || !(x->h[i] > 0))
            continue;
        double slope;
        const double there = larger(k * normal_of(x->configuration, x->F[i] / k, i, &slope), 0);
        const double N = there * power_of(x->h[i] / p[H_REF][i], 1 - p[EXPONENT][i]);
        x->beside_N[i] += p[SEVERITY][i] * (N - x->N[i]);
    }
}

/* clang-format off */
const struct Effect effect_kienzle_force = {
    .equation = "N_h + severity (N_ref (h/h_ref)^(1 - m) - N_h), N the shear plane's normal force at h and at h_ref, under "
        "the same friction",
    .signature = "principal force over thickness is a power below 1 that vanishes with the chip, whatever the friction",
    .rivals = "size_effect, edge_force",
    .applies_to = "internal, combined, uncut_thickness",
    .family = "load",
    .stage = STAGE_FORCES, .act = cut,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
