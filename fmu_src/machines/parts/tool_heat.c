/* How warm does the contact get? The dissipated power flows through the constriction below the contact into the insert,
 * and on to the holder.
 *
 *     C_c dT_c/dt = s P - (T_c - T_b)/R_c,   R_c = 1/(4 k a),   C_c = 2/3 pi a^3 rho_c
 *     C_b dT_b/dt = (T_c - T_b)/R_c - (T_b - T_a)/R_b
 *
 * R_c is that of a circular spot of radius a on a half space; C_c that of the half ball under it.
 */
#include "../rows.h"

enum {
    DISSIPATED_POWER = INPUT_FIRST,
    SHARE,
    SPOT_RADIUS,
    CONDUCTIVITY,
    HEAT_CAPACITY,
    BODY_CAPACITY,
    BODY_RESISTANCE,
    AMBIENT,
    TEMPERATURE,
    BODY_TEMPERATURE,
    SPOT_RESISTANCE,
    SPOT_TIME,
    HEAT_FLOW,
    RATES,
    COUNT = RATES + 2
};

#define WARM .unit = "K", .display_unit = "degC", .start = 293.15, .nominal = 300

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [VAR_TIME] = CLOCK,
    [DISSIPATED_POWER] = {.name = "dissipated_power", .unit = "W", .min = -1e9, .max = 1e9, GIVEN,
        .meaning = "power that friction turns into heat", .source = "the contact"},
    [SHARE] = {.name = "heat_share", .unit = "1", .start = 0.5, .min = 0, .max = 1, TUNED,
        .meaning = "share of the heat that goes into the tool",
        .source = "guess: the chip takes the rest; Loewen and Shaw 1954 compute it"},
    [SPOT_RADIUS] = {.name = "spot_radius", .unit = "m", .display_unit = "um", .start = 2.5e-4, .min = 1e-6,
        .max = 1e-1, .nominal = 1e-4, TUNED, .meaning = "radius of the circle with the area of the contact",
        .source = "guess: 1 mm by 0.2 mm"},
    [CONDUCTIVITY] = {.name = "conductivity", .unit = "W/(m.K)", .start = 80, .min = 1e-2, .max = 1e4, .nominal = 10,
        TUNED, .meaning = "heat conductivity of the tool", .source = "cemented carbide, common handbook value"},
    [HEAT_CAPACITY] = {.name = "heat_capacity", .unit = "J/(m^3.K)", .start = 3e6, .min = 1e3, .max = 1e8,
        .nominal = 1e6, TUNED, .meaning = "heat capacity of the tool by volume",
        .source = "cemented carbide, common handbook value"},
    [BODY_CAPACITY] = {.name = "insert_capacity", .unit = "J/K", .start = 2, .min = 1e-6, .max = 1e6, TUNED,
        .meaning = "heat capacity of the insert", .source = "guess: 12.7 mm square, 4.8 mm thick"},
    [BODY_RESISTANCE] = {.name = "insert_resistance", .unit = "K/W", .start = 2, .min = 1e-6, .max = 1e6, TUNED,
        .meaning = "thermal resistance between insert and ambient", .source = "guess"},
    [AMBIENT] = {.name = "ambient_temperature", WARM, .min = 0, .max = 2e3, TUNED,
        .meaning = "temperature of the holder", .source = "guess: 20 degC"},
    [TEMPERATURE] = {.name = "contact_temperature", WARM, RESULT, .meaning = "temperature of the contact",
        .source = "balance of heat"},
    [BODY_TEMPERATURE] = {.name = "insert_temperature", WARM, RESULT, .meaning = "temperature of the insert",
        .source = "balance of heat"},
    [SPOT_RESISTANCE] = {.name = "spot_resistance", .unit = "K/W", RESULT,
        .meaning = "resistance R_c of the constriction",
        .source = "Carslaw and Jaeger 1959, circular source on a half space"},
    [SPOT_TIME] = {.name = "spot_time", .unit = "s", .display_unit = "ms", RESULT, .nominal = 1e-3,
        .meaning = "time constant R_c C_c of the contact", .source = DEFINITION},
    [HEAT_FLOW] = {.name = "heat_flow", .unit = "W", RESULT, .meaning = "heat that flows from contact to insert",
        .source = DEFINITION},
    [RATES] = {.name = "contact_heating", .unit = "K/s", INNER, .derivative_of = TEMPERATURE,
        .meaning = "rate of contact_temperature", .source = "balance of heat"},
    [RATES + 1] = {.name = "insert_heating", .unit = "K/s", INNER, .derivative_of = BODY_TEMPERATURE,
        .meaning = "rate of insert_temperature", .source = "balance of heat"},
};
/* clang-format on */

static void evaluate(double *value)
{
    const double a = value[SPOT_RADIUS], R_c = 1 / (4 * value[CONDUCTIVITY] * a),
                 C_c = 2 * PI / 3 * a * a * a * value[HEAT_CAPACITY];
    const double T_b = value[BODY_TEMPERATURE], flow = (value[TEMPERATURE] - T_b) / R_c;
    value[SPOT_RESISTANCE] = R_c;
    value[SPOT_TIME] = R_c * C_c;
    value[HEAT_FLOW] = flow;
    value[RATES] = (value[SHARE] * value[DISSIPATED_POWER] - flow) / C_c;
    value[RATES + 1] = (flow - (T_b - value[AMBIENT]) / value[BODY_RESISTANCE]) / value[BODY_CAPACITY];
}

const struct Part part = {
    .equations = "C_c dT_c/dt = s P - (T_c - T_b)/R_c,   R_c = 1/(4 k a),   C_c = 2/3 pi a^3 rho_c\n"
                 "C_b dT_b/dt = (T_c - T_b)/R_c - (T_b - T_a)/R_b",
    .variables = variables,
    .count = COUNT,
    .evaluate = evaluate,
};
