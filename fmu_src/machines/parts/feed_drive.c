/* How does a ball-screw axis follow its reference? Motor, screw and table, under a cascade of position and speed
 * control or a PID.
 *
 *     m_m a_m = F - k (q_m - q_t) - c (v_m - v_t),   m_m = J (2 pi/p)^2,   m_t a_t = k (q_m - q_t) + c (v_m - v_t) -
 * F_friction - F_load cascade: F = K (w - v) + K_i integral of (w - v),   w = K_v (r - q) + s dr/dt pid:     F = k_p (r
 * - q) + k_i integral of (r - q) + k_d (s dr/dt - v)
 *
 * q, v are what is fed back. Where rigid is on, motor and table move as one mass.
 */
#include "../rows.h"

enum {
    POSITION_REFERENCE = INPUT_FIRST,
    VELOCITY_REFERENCE,
    FRICTION_FORCE,
    LOAD_FORCE,
    RIGID,
    PID,
    SCALE, /* switches: some importers know no enumerations */
    MOTOR_INERTIA,
    PITCH,
    TABLE_MASS,
    STIFFNESS,
    DAMPING,
    POSITION_GAIN,
    VELOCITY_GAIN,
    VELOCITY_INTEGRAL_GAIN,
    FEED_FORWARD,
    PID_P,
    PID_I,
    PID_D,
    MOTOR_POSITION,
    MOTOR_VELOCITY,
    TABLE_POSITION,
    TABLE_VELOCITY,
    POSITION_DEVIATION,
    VELOCITY_DEVIATION,
    MOTOR_FORCE,
    MOTOR_TORQUE,
    FOLLOWING_ERROR,
    STORED_ENERGY,
    RATES,
    COUNT = RATES + 6
};

#define ANYWHERE .min = -1e3, .max = 1e3
#define MOVED .unit = "m", .display_unit = "mm", .nominal = 1e-3
#define MOVING .unit = "m/s", .display_unit = "mm/s", .nominal = 1e-2
#define FORCE .unit = "N", .nominal = 100
#define LOOP "guess: a loop of some 50 Hz for the start masses"

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [VAR_TIME] = CLOCK,
    [POSITION_REFERENCE] = {.name = "position_reference", MOVED, ANYWHERE, GIVEN, .meaning = "position asked for",
        .source = "the path"},
    [VELOCITY_REFERENCE] = {.name = "velocity_reference", MOVING, ANYWHERE, GIVEN,
        .meaning = "velocity asked for, fed forward", .source = "the path"},
    [FRICTION_FORCE] = {.name = "friction_force", FORCE, .min = -1e7, .max = 1e7, GIVEN,
        .meaning = "friction of the guideway, against the motion of the table", .source = "the contact"},
    [LOAD_FORCE] = {.name = "load_force", FORCE, .min = -1e7, .max = 1e7, GIVEN,
        .meaning = "any other force against the motion of the table", .source = "cutting, gravity"},
    [RIGID] = {.name = "rigid", SWITCH, .meaning = "motor and table move as one mass; else the screw lies between them",
        .source = DEFINITION},
    [PID] = {.name = "pid", SWITCH,
        .meaning = "a PID on the position controls; else a cascade, proportional in position, proportional and "
            "integral in velocity", .source = DEFINITION},
    [SCALE] = {.name = "linear_scale", SWITCH,
        .meaning = "position and velocity are measured at the table; else at the motor", .source = DEFINITION},
    [MOTOR_INERTIA] = {.name = "motor_inertia", .unit = "kg.m^2", .start = 2e-3, .min = 0, .max = 1e3, .nominal = 1e-3,
        TUNED, .meaning = "inertia of motor, coupling and screw; above 0 unless rigid", .source = "guess: servo motor of 10 N.m"},
    [PITCH] = {.name = "screw_pitch", MOVED, .start = 1e-2, .min = 1e-5, .max = 10, TUNED,
        .meaning = "travel of the table per turn of the screw", .source = "guess: common ball screw"},
    [TABLE_MASS] = {.name = "table_mass", .unit = "kg", .start = 100, .min = 1e-6, .max = 1e6, .nominal = 100, TUNED,
        .meaning = "mass of the table with what it carries", .source = "guess: table of a small machining centre"},
    [STIFFNESS] = {.name = "screw_stiffness", .unit = "N/m", .display_unit = "N/um", .start = 1e8, .min = 1,
        .max = 1e13, .nominal = 1e8, TUNED, .meaning = "axial stiffness of screw, nut and bearings",
        .source = "guess: 100 N/um, ordinary for ball screws of 25 to 32 mm"},
    [DAMPING] = {.name = "screw_damping_ratio", .unit = "1", .start = 0.03, .min = 0, .max = 2, .nominal = 1e-2, TUNED,
        .meaning = "damping ratio of the table on a held screw", .source = "guess"},
    [POSITION_GAIN] = {.name = "position_gain", .unit = "1/s", .start = 50, .min = 0, .max = 1e5, .nominal = 10, TUNED,
        .meaning = "K_v of the cascade", .source = LOOP},
    [VELOCITY_GAIN] = {.name = "velocity_gain", .unit = "N.s/m", .start = 2.5e5, .min = 0, .max = 1e10, .nominal = 1e5,
        TUNED, .meaning = "K of the cascade, as a force at the table", .source = LOOP},
    [VELOCITY_INTEGRAL_GAIN] = {.name = "velocity_integral_gain", .unit = "N/m", .start = 2e7, .min = 0, .max = 1e12,
        .nominal = 1e7, TUNED, .meaning = "K_i of the cascade", .source = LOOP},
    [FEED_FORWARD] = {.name = "feed_forward", .unit = "1", .start = 1, .min = 0, .max = 2, TUNED,
        .meaning = "share s of velocity_reference that is fed forward", .source = DEFINITION},
    [PID_P] = {.name = "pid_gain", .unit = "N/m", .start = 1e7, .min = 0, .max = 1e12, .nominal = 1e6, TUNED,
        .meaning = "k_p of the PID", .source = "guess"},
    [PID_I] = {.name = "pid_integral_gain", .unit = "N/(m.s)", .start = 1e8, .min = 0, .max = 1e14, .nominal = 1e7,
        TUNED, .meaning = "k_i of the PID", .source = "guess"},
    [PID_D] = {.name = "pid_velocity_gain", .unit = "N.s/m", .start = 1e5, .min = 0, .max = 1e10, .nominal = 1e4, TUNED,
        .meaning = "k_d of the PID", .source = "guess"},
    [MOTOR_POSITION] = {.name = "motor_position", MOVED, RESULT, .meaning = "position that the motor asks of the table",
        .source = NEWTON},
    [MOTOR_VELOCITY] = {.name = "motor_velocity", MOVING, RESULT,
        .meaning = "velocity that the motor asks of the table", .source = NEWTON},
    [TABLE_POSITION] = {.name = "table_position", MOVED, RESULT, .meaning = "position of the table", .source = NEWTON},
    [TABLE_VELOCITY] = {.name = "table_velocity", MOVING, RESULT, .meaning = "velocity of the table", .source = NEWTON},
    [POSITION_DEVIATION] = {.name = "position_error_integral", .unit = "m.s", RESULT, .nominal = 1e-3,
        .meaning = "memory of the PID", .source = DEFINITION},
    [VELOCITY_DEVIATION] = {.name = "velocity_error_integral", MOVED, RESULT, .meaning = "memory of the speed control",
        .source = DEFINITION},
    [MOTOR_FORCE] = {.name = "motor_force", FORCE, RESULT, .meaning = "force of the motor, at the table",
        .source = DEFINITION},
    [MOTOR_TORQUE] = {.name = "motor_torque", .unit = "N.m", RESULT, .meaning = "torque of the motor",
        .source = DEFINITION},
    [FOLLOWING_ERROR] = {.name = "following_error", .unit = "m", .display_unit = "um", .nominal = 1e-6, RESULT,
        .meaning = "position_reference less table_position", .source = DEFINITION},
    [STORED_ENERGY] = {.name = "stored_energy", .unit = "J", RESULT,
        .meaning = "kinetic energy and that of the screw's spring", .source = DEFINITION},
    [RATES] = {.name = "rate_of_motor_position", .unit = "m/s", INNER, .derivative_of = MOTOR_POSITION,
        .meaning = "rate of motor_position", .source = NEWTON},
    [RATES + 1] = {.name = "motor_acceleration", .unit = "m/s^2", INNER, .derivative_of = MOTOR_VELOCITY,
        .meaning = "rate of motor_velocity", .source = NEWTON},
    [RATES + 2] = {.name = "rate_of_table_position", .unit = "m/s", INNER, .derivative_of = TABLE_POSITION,
        .meaning = "rate of table_position", .source = NEWTON},
    [RATES + 3] = {.name = "table_acceleration", .unit = "m/s^2", INNER, .derivative_of = TABLE_VELOCITY,
        .meaning = "rate of table_velocity", .source = NEWTON},
    [RATES + 4] = {.name = "position_error", .unit = "m", INNER, .derivative_of = POSITION_DEVIATION,
        .meaning = "rate of position_error_integral", .source = DEFINITION},
    [RATES + 5] = {.name = "velocity_error", .unit = "m/s", INNER, .derivative_of = VELOCITY_DEVIATION,
        .meaning = "rate of velocity_error_integral", .source = DEFINITION},
};
/* clang-format on */

static void evaluate(double *value)
{
    const double turns = 2 * PI / value[PITCH], m_m = value[MOTOR_INERTIA] * turns * turns, m_t = value[TABLE_MASS];
    const double k = value[STIFFNESS], c = 2 * value[DAMPING] * sqrt(k * m_t);
    const double q_m = value[MOTOR_POSITION], v_m = value[MOTOR_VELOCITY], q_t = value[TABLE_POSITION],
                 v_t = value[TABLE_VELOCITY];
    const int rigid = value[RIGID] != 0, scale = rigid || value[SCALE] != 0;
    const double q = scale ? q_t : q_m, v = scale ? v_t : v_m;
    const double off = value[POSITION_REFERENCE] - q, forward = value[FEED_FORWARD] * value[VELOCITY_REFERENCE];
    const double slow = value[POSITION_GAIN] * off + forward - v;
    const double F = value[PID] != 0
                         ? value[PID_P] * off + value[PID_I] * value[POSITION_DEVIATION] + value[PID_D] * (forward - v)
                         : value[VELOCITY_GAIN] * slow + value[VELOCITY_INTEGRAL_GAIN] * value[VELOCITY_DEVIATION];
    const double against = value[FRICTION_FORCE] + value[LOAD_FORCE];
    const double screw = rigid ? 0 : k * (q_m - q_t) + c * (v_m - v_t), together = (F - against) / (m_m + m_t);
    value[MOTOR_FORCE] = F;
    value[MOTOR_TORQUE] = F / turns;
    value[FOLLOWING_ERROR] = value[POSITION_REFERENCE] - q_t;
    value[STORED_ENERGY] = rigid ? 0.5 * (m_m + m_t) * v_t * v_t
                                 : 0.5 * (m_m * v_m * v_m + m_t * v_t * v_t + k * (q_m - q_t) * (q_m - q_t));
    value[RATES] = rigid ? v_t : v_m;
    value[RATES + 1] = rigid     ? together
                       : m_m > 0 ? (F - screw) / m_m
                                 : NAN; /* an elastic screw needs a motor with inertia */
    value[RATES + 2] = v_t;
    value[RATES + 3] = rigid ? together : (screw - against) / m_t;
    value[RATES + 4] = off;
    value[RATES + 5] = slow;
}

const struct Part part = {
    .equations = "m_m a_m = F - k (q_m - q_t) - c (v_m - v_t),   m_m = J (2 pi/p)^2\n"
                 "m_t a_t = k (q_m - q_t) + c (v_m - v_t) - F_friction - F_load\n"
                 "cascade: F = K (w - v) + K_i integral of (w - v),   w = K_v (r - q) + s dr/dt\n"
                 "pid: F = k_p (r - q) + k_i integral of (r - q) + k_d (s dr/dt - v)",
    .variables = variables,
    .count = COUNT,
    .evaluate = evaluate,
};
