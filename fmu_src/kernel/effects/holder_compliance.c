/* Holder compliance: the tool holder gives way to the cutting force, one mode along the cut and one across. */
#include "effect.h"

enum { ON, COMPLIANCE_X, COMPLIANCE_Y, FREQUENCY, DAMPING_RATIO, X, U_X, Y, U_Y, RATES, COUNT = RATES + 4 };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [ON] = {.name = "holder_compliance", SWITCH,
        .meaning = "switch: the tool holder is a mass on spring and damper, and its motion changes path, slip and "
            "thickness", .source = "Altintas 2012 (not read), Manufacturing Automation, chapter 3"},
    [COMPLIANCE_X] = {.name = "holder_compliance.compliance_x", .unit = "m/N", .start = 2e-8, .min = 0, .max = 2e-7,
        .display_unit = "um/N", .nominal = 1e-8, TUNED,
        .meaning = "static deflection per force along the cutting direction; 0: rigid", .source = "guess: 50 N/um"},
    [COMPLIANCE_Y] = {.name = "holder_compliance.compliance_y", .unit = "m/N", .start = 2e-8, .min = 0, .max = 2e-7,
        .display_unit = "um/N", .nominal = 1e-8, TUNED,
        .meaning = "static deflection per force away from the surface; 0: rigid", .source = "guess: 50 N/um"},
    [FREQUENCY] = {.name = "holder_compliance.natural_frequency", .unit = "Hz", .start = 2e3, .min = 1, .max = 5e3,
        .display_unit = "kHz", .nominal = 1e3, SHAPE, TUNED, .meaning = "undamped natural frequency of both modes",
        .source = "guess"},
    [DAMPING_RATIO] = {.name = "holder_compliance.damping_ratio", .unit = "1", .start = 0.03, .min = 0, .max = 2, SHAPE,
        TUNED, .meaning = "damping ratio of both modes", .source = "guess"},
    [X] = {.name = "holder_compliance.displacement_x", .unit = "m", .display_unit = "um", .nominal = 1e-6, STATE,
        .meaning = "displacement of the tool along the cutting direction", .source = "definition"},
    [U_X] = {.name = "holder_compliance.velocity_x", .unit = "m/s", .nominal = 1e-2, STATE,
        .meaning = "velocity of the tool along the cutting direction", .source = "definition"},
    [Y] = {.name = "holder_compliance.displacement_y", .unit = "m", .display_unit = "um", .nominal = 1e-6, STATE,
        .meaning = "displacement of the tool away from the surface", .source = "definition"},
    [U_Y] = {.name = "holder_compliance.velocity_y", .unit = "m/s", .nominal = 1e-2, STATE,
        .meaning = "velocity of the tool away from the surface", .source = "definition"},
    [RATES] = {.name = "holder_compliance.rate_x", .unit = "m/s", STATE, .meaning = "rate of displacement_x",
        .source = "definition"},
    [RATES + 1] = {.name = "holder_compliance.acceleration_x", .unit = "m/s^2", STATE, .meaning = "rate of velocity_x",
        .source = "definition"},
    [RATES + 2] = {.name = "holder_compliance.rate_y", .unit = "m/s", STATE, .meaning = "rate of displacement_y",
        .source = "definition"},
    [RATES + 3] = {.name = "holder_compliance.acceleration_y", .unit = "m/s^2", STATE, .meaning = "rate of velocity_y",
        .source = "definition"},
};
/* clang-format on */

enum { DX, DU_X, DY, DU_Y, STATE_COUNT };

static double omega(const lanes *p, int i) { return 2 * PI * p[FREQUENCY][i]; }

static void carry(const lanes *p, const lanes *state, struct Point *x)
{
    (void)p;
    EACH_LANE {
        x->centre_u_x[i] += state[DU_X][i];
        x->centre_y[i] += state[DY][i];
        x->centre_u_y[i] += state[DU_Y][i];
    }
}

static void move(const lanes *p, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b,
                 const lanes *from, lanes *half, lanes *whole)
{
    struct Oscillators modes;
    lanes w, later[2][2][2];
    EACH_LANE {
        const double c_x = -p[COMPLIANCE_X][i], c_y = p[COMPLIANCE_Y][i];
        w[i] = omega(p, i);
        modes.start[0][i] = c_x * a->F_p[i];
        modes.start[1][i] = c_y * a->F_f[i];
        modes.middle[0][i] = c_x * m->F_p[i];
        modes.middle[1][i] = c_y * m->F_f[i];
        modes.end[0][i] = c_x * b->F_p[i];
        modes.end[1][i] = c_y * b->F_f[i];
        modes.at[OF_PLACE][0][i] = from[DX][i];
        modes.at[OF_PLACE][1][i] = from[DY][i];
        modes.at[OF_SPEED][0][i] = from[DU_X][i];
        modes.at[OF_SPEED][1][i] = from[DU_Y][i];
    }
    second_order_responses(h, w, p[DAMPING_RATIO], &modes, later[0], later[1]);
    for (int k = 0; k < 2; ++k) {
        lanes *const to = k ? whole : half;
        EACH_LANE {
            to[DX][i] = later[k][OF_PLACE][0][i];
            to[DU_X][i] = later[k][OF_SPEED][0][i];
            to[DY][i] = later[k][OF_PLACE][1][i];
            to[DU_Y][i] = later[k][OF_SPEED][1][i];
        }
    }
}

static void rate(const lanes *p, const struct Point *x, const lanes *state, lanes *rate)
{
    EACH_LANE {
        const double w = omega(p, i), zeta = p[DAMPING_RATIO][i];
        rate[DX][i] = state[DU_X][i];
        rate[DU_X][i] = w * w * (-p[COMPLIANCE_X][i] * x->F_p[i] - state[DX][i]) - 2 * zeta * w * state[DU_X][i];
        rate[DY][i] = state[DU_Y][i];
        rate[DU_Y][i] = w * w * (p[COMPLIANCE_Y][i] * x->F_f[i] - state[DY][i]) - 2 * zeta * w * state[DU_Y][i];
    }
}

static double longest_step(const lanes *p, int i)
{
    return p[COMPLIANCE_X][i] + p[COMPLIANCE_Y][i] > 0 ? 1 / (20 * p[FREQUENCY][i]) : INFINITY;
}

/* clang-format off */
const struct Effect effect_holder_compliance = {
    .equation = "q'' + 2 zeta w q' + w^2 q = w^2 c F in x (F = -principal_force) and y (F = feed_force); u += q', "
        "centre += q",
    .signature = "a line at the natural frequency that rings down after each entry and exit; the thickness follows the "
        "force",
    .family = "lag",
    .stage = STAGE_PATH, .driver = DRIVEN_BY_FORCE, .states = STATE_COUNT,
    .act = carry, .move = move, .rate = rate, .longest_step = longest_step,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
