/* How fast does the work pass the tool? A spindle under speed control that runs up, and gives way to the cutting force.
 *
 *     J dw/dt = M - F_p r - d w,   M = K (w_ref - w) + K_i integral of (w_ref - w),   T dw_ref/dt = w_set - w_ref, v_c
 * = w r
 */
#include "../rows.h"

enum {
    PRINCIPAL_FORCE = INPUT_FIRST,
    SPEED_SET,
    RUN_UP_TIME,
    RADIUS,
    INERTIA,
    DRAG,
    GAIN,
    INTEGRAL_GAIN,
    REFERENCE,
    SPEED,
    DEVIATION,
    CUTTING_SPEED,
    TORQUE,
    POWER,
    RATES,
    COUNT = RATES + 3
};

#define TURNS .unit = "rad/s", .display_unit = "rpm", .nominal = 10

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [VAR_TIME] = CLOCK,
    [PRINCIPAL_FORCE] = {.name = "principal_force", .unit = "N", .min = -1e6, .max = 1e6, .nominal = 100, GIVEN,
        .meaning = "cutting force that brakes the work", .source = "the contact"},
    [SPEED_SET] = {.name = "speed_set", TURNS, .start = 25.0 / 3, .min = 0, .max = 1e4, TUNED,
        .meaning = "spindle speed asked for", .source = "guess: 10 m/min at the start radius"},
    [RUN_UP_TIME] = {.name = "run_up_time", .unit = "s", .start = 0.2, .min = 1e-6, .max = 1e3, TUNED,
        .meaning = "time constant with which the reference approaches speed_set", .source = "guess"},
    [RADIUS] = {.name = "workpiece_radius", .unit = "m", .display_unit = "mm", .start = 0.02, .min = 1e-6, .max = 10,
        .nominal = 1e-2, TUNED, .meaning = "radius at which the tool cuts", .source = "guess: bar of 40 mm"},
    [INERTIA] = {.name = "inertia", .unit = "kg.m^2", .start = 0.05, .min = 1e-9, .max = 1e4, .nominal = 1e-2, TUNED,
        .meaning = "inertia of spindle, chuck and work", .source = "guess: spindle of a small lathe"},
    [DRAG] = {.name = "drag", .unit = "N.m.s/rad", .start = 0.01, .min = 0, .max = 1e3, .nominal = 1e-2, TUNED,
        .meaning = "viscous drag of the bearings", .source = "guess"},
    [GAIN] = {.name = "speed_gain", .unit = "N.m.s/rad", .start = 3, .min = 0, .max = 1e6, TUNED,
        .meaning = "proportional gain of the speed control", .source = "guess: a loop of 10 Hz"},
    [INTEGRAL_GAIN] = {.name = "speed_integral_gain", .unit = "N.m/rad", .start = 50, .min = 0, .max = 1e8, TUNED,
        .meaning = "integral gain of the speed control", .source = "guess: reset time 60 ms"},
    [REFERENCE] = {.name = "speed_reference", TURNS, RESULT, .start = 25.0 / 3,
        .meaning = "speed that the control follows", .source = DEFINITION},
    [SPEED] = {.name = "spindle_speed", TURNS, RESULT, .start = 25.0 / 3, .meaning = "spindle speed", .source = NEWTON},
    [DEVIATION] = {.name = "speed_error_integral", .unit = "rad", RESULT, .nominal = 1e-2,
        .meaning = "memory of the integral part", .source = DEFINITION},
    [CUTTING_SPEED] = {.name = "cutting_speed", .unit = "m/s", .display_unit = "m/min", RESULT,
        .meaning = "speed of the work past the tool", .source = DEFINITION},
    [TORQUE] = {.name = "motor_torque", .unit = "N.m", RESULT, .meaning = "torque of the motor on the spindle",
        .source = DEFINITION},
    [POWER] = {.name = "motor_power", .unit = "W", RESULT, .nominal = 100,
        .meaning = "power of the motor on the spindle", .source = DEFINITION},
    [RATES] = {.name = "reference_acceleration", .unit = "rad/s^2", INNER, .derivative_of = REFERENCE,
        .meaning = "rate of speed_reference", .source = DEFINITION},
    [RATES + 1] = {.name = "spindle_acceleration", .unit = "rad/s^2", INNER, .derivative_of = SPEED,
        .meaning = "rate of spindle_speed", .source = NEWTON},
    [RATES + 2] = {.name = "speed_error", .unit = "rad/s", INNER, .derivative_of = DEVIATION,
        .meaning = "rate of speed_error_integral", .source = DEFINITION},
};
/* clang-format on */

static void evaluate(double *value)
{
    const double r = value[RADIUS], w = value[SPEED], w_ref = value[REFERENCE];
    const double M = value[GAIN] * (w_ref - w) + value[INTEGRAL_GAIN] * value[DEVIATION];
    value[CUTTING_SPEED] = w * r;
    value[TORQUE] = M;
    value[POWER] = M * w;
    value[RATES] = (value[SPEED_SET] - w_ref) / value[RUN_UP_TIME];
    value[RATES + 1] = (M - value[PRINCIPAL_FORCE] * r - value[DRAG] * w) / value[INERTIA];
    value[RATES + 2] = w_ref - w;
}

const struct Part part = {
    .equations = "J dw/dt = M - F_p r - d w,   M = K (w_ref - w) + K_i integral of (w_ref - w)\nT dw_ref/dt = w_set - "
                 "w_ref,   v_c = w r",
    .variables = variables,
    .count = COUNT,
    .evaluate = evaluate,
};
