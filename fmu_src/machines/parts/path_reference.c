/* Where should the axes be? A ramp at constant speed, or a circle, entered smoothly.
 *
 *     ramp:   x = v t, y = 0
 *     circle: x = R sin(a), y = R (1 - cos(a)),   a = v/R (t - T (1 - exp(-t/T)))
 */
#include "../rows.h"

enum { CIRCLE = INPUT_FIRST, SPEED, RADIUS, RUN_UP_TIME, POSITION_X, VELOCITY_X, POSITION_Y, VELOCITY_Y, COUNT };

#define MOVED RESULT, .unit = "m", .display_unit = "mm", .nominal = 1e-2, .source = DEFINITION
#define MOVING RESULT, .unit = "m/s", .display_unit = "mm/s", .nominal = 1e-2, .source = DEFINITION

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [VAR_TIME] = CLOCK,
    [CIRCLE] = {.name = "circle", .start = 1, SWITCH,
        .meaning = "both axes along a circle; else the first one along a ramp at constant speed", .source = DEFINITION},
    [SPEED] = {.name = "speed", .unit = "m/s", .display_unit = "mm/s", .start = 0.02, .min = 0, .max = 1e3,
        .nominal = 1e-2, .causality = PARAMETER, .variability = FIXED, .meaning = "speed along the path",
        .source = "guess: a feed of 1.2 m/min"},
    [RADIUS] = {.name = "radius", .unit = "m", .display_unit = "mm", .start = 0.02, .min = 1e-6, .max = 1e3,
        .nominal = 1e-2, .causality = PARAMETER, .variability = FIXED, .meaning = "radius of the circle",
        .source = "guess: an ordinary circular test"},
    [RUN_UP_TIME] = {.name = "run_up_time", .unit = "s", .start = 0.1, .min = 1e-6, .max = 1e3, .causality = PARAMETER,
        .variability = FIXED, .meaning = "time constant with which the circle is entered", .source = "guess"},
    [POSITION_X] = {.name = "position_x", MOVED, .meaning = "position asked of the first axis"},
    [VELOCITY_X] = {.name = "velocity_x", MOVING, .meaning = "velocity asked of the first axis"},
    [POSITION_Y] = {.name = "position_y", MOVED, .meaning = "position asked of the second axis"},
    [VELOCITY_Y] = {.name = "velocity_y", MOVING, .meaning = "velocity asked of the second axis"},
};
/* clang-format on */

static void evaluate(double *value)
{
    const double t = value[VAR_TIME], v = value[SPEED], R = value[RADIUS], T = value[RUN_UP_TIME];
    const double late = t > 0 ? exp(-t / T) : 1, a = v / R * (t > 0 ? t - T * (1 - late) : 0), speed = v * (1 - late);
    const int ramp = value[CIRCLE] == 0;
    value[POSITION_X] = ramp ? v * t : R * sin(a);
    value[VELOCITY_X] = ramp ? v : speed * cos(a);
    value[POSITION_Y] = ramp ? 0 : R * (1 - cos(a));
    value[VELOCITY_Y] = ramp ? 0 : speed * sin(a);
}

static double time_scale(const double *value)
{
    return fmin(value[RUN_UP_TIME], value[RADIUS] / fmax(value[SPEED], 1e-9));
}

const struct Part part = {
    .equations = "ramp: x = v t, y = 0\ncircle: x = R sin(a), y = R (1 - cos(a)),   a = v/R (t - T (1 - exp(-t/T)))",
    .variables = variables,
    .count = COUNT,
    .time_scale = time_scale,
    .evaluate = evaluate,
};
