/* Thermal viscosity: the film between chip and tool thins as it gets hotter. Reynolds 1886. */
#include "effect.h"

enum { ON, BETA, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "thermal_viscosity", SWITCH, .meaning = "switch: viscous friction falls with the temperature proxy",
        .source = "Reynolds 1886 (not read): eta = eta_0 exp(-beta T)"},
    [BETA] = {.name = "thermal_viscosity.beta", .unit = "1", .start = 0.05, .min = 0, .max = 10, TUNED,
        .meaning = "loss of the viscous coefficient per theta_ref, as an exponent; 0: none", .source = "guess"},
};
/* clang-format on */

static void thin(const lanes *p, const lanes *state, struct Point *x)
{
    (void)state;
    EACH_LANE
        x->sigma2[i] *= exponential(-p[BETA][i] * x->theta_ratio[i]);
}

/* clang-format off */
const struct Effect effect_thermal_viscosity = {
    .equation = "sigma2 exp(-beta theta/theta_ref)",
    .signature = "friction over slip velocity bends down at speed, the more the hotter",
    .needs = "proxy_speed",
    .family = "thermal",
    .stage = STAGE_FRICTION, .act = thin,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
