/* How does the tool give way? Holder on slide on machine bed, along the cutting direction x and away from the work y:
 * four masses on springs, in each direction one on the other.
 *
 *     m_h a_h = F - k_h (q_h - q_s) - c_h (v_h - v_s)
 *     m_s a_s = k_h (q_h - q_s) + c_h (v_h - v_s) - k_s q_s - c_s v_s,     c = 2 zeta sqrt(k m)
 */
#include "../rows.h"

enum {
    FORCE_X = INPUT_FIRST,
    FORCE_Y,
    HOLDER_MASS,
    HOLDER_STIFFNESS_X,
    HOLDER_STIFFNESS_Y,
    HOLDER_DAMPING,
    SLIDE_MASS_X,
    SLIDE_MASS_Y,
    SLIDE_STIFFNESS_X,
    SLIDE_STIFFNESS_Y,
    SLIDE_DAMPING,
    DISPLACEMENT_X,
    VELOCITY_X,
    SLIDE_DISPLACEMENT_X,
    SLIDE_VELOCITY_X,
    DISPLACEMENT_Y,
    VELOCITY_Y,
    SLIDE_DISPLACEMENT_Y,
    SLIDE_VELOCITY_Y,
    STORED_ENERGY,
    POWER_IN,
    POWER_LOST,
    RATES, /* of the states, in their order */
    COUNT = RATES + 8
};

#define ON_THE_TOOL GIVEN, .unit = "N", .min = -1e6, .max = 1e6, .nominal = 100, .source = "the contact"
#define MOVED RESULT, .unit = "m", .display_unit = "um", .nominal = 1e-6, .source = NEWTON
#define MOVING RESULT, .unit = "m/s", .display_unit = "mm/s", .nominal = 1e-2, .source = NEWTON
#define RATE(of) INNER, .derivative_of = of, .source = NEWTON
#define STIFF TUNED, .unit = "N/m", .display_unit = "N/um", .min = 1e-3, .max = 1e12, .nominal = 1e8
#define HEAVY TUNED, .unit = "kg", .min = 1e-3, .max = 1e5, .nominal = 1
#define DAMPED TUNED, .unit = "1", .min = 0, .max = 2, .nominal = 1e-2

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [VAR_TIME] = CLOCK,
    [FORCE_X] = {.name = "force_x", ON_THE_TOOL, .meaning = "force on the tool along the cutting direction"},
    [FORCE_Y] = {.name = "force_y", ON_THE_TOOL, .meaning = "force on the tool away from the machined surface"},
    [HOLDER_MASS] = {.name = "holder_mass", .start = 1.5, HEAVY,
        .meaning = "mass of tool and holder that vibrates against the slide",
        .source = "guess: a steel holder of 25 mm section with its ultrasonic unit"},
    [HOLDER_STIFFNESS_X] = {.name = "holder_stiffness_x", .start = 5e7, STIFF,
        .meaning = "stiffness of the holder along the cutting direction",
        .source = "guess: first bending mode near 900 Hz"},
    [HOLDER_STIFFNESS_Y] = {.name = "holder_stiffness_y", .start = 8e7, STIFF,
        .meaning = "stiffness of the holder away from the surface", .source = "guess: mode near 1.2 kHz"},
    [HOLDER_DAMPING] = {.name = "holder_damping_ratio", .start = 0.03, DAMPED,
        .meaning = "damping ratio of the holder's modes on a rigid slide",
        .source = "guess: bolted joints, 0.02 to 0.05"},
    [SLIDE_MASS_X] = {.name = "slide_mass_x", .start = 60, HEAVY,
        .meaning = "mass that moves with the slide along the cutting direction",
        .source = "guess: slide of a small lathe"},
    [SLIDE_MASS_Y] = {.name = "slide_mass_y", .start = 60, HEAVY,
        .meaning = "mass that moves with the slide away from the surface", .source = "guess: slide of a small lathe"},
    [SLIDE_STIFFNESS_X] = {.name = "slide_stiffness_x", .start = 3e8, STIFF,
        .meaning = "stiffness of the slide's guides along the cutting direction", .source = "guess: mode near 350 Hz"},
    [SLIDE_STIFFNESS_Y] = {.name = "slide_stiffness_y", .start = 1.5e8, STIFF,
        .meaning = "stiffness of the feed drive that holds the slide", .source = "guess: mode near 250 Hz"},
    [SLIDE_DAMPING] = {.name = "slide_damping_ratio", .start = 0.05, DAMPED,
        .meaning = "damping ratio of the slide's modes without holder", .source = "guess: lubricated guides"},
    [DISPLACEMENT_X] = {.name = "displacement_x", MOVED,
        .meaning = "displacement of the tool along the cutting direction"},
    [VELOCITY_X] = {.name = "velocity_x", MOVING, .meaning = "velocity of the tool along the cutting direction"},
    [SLIDE_DISPLACEMENT_X] = {.name = "slide_displacement_x", MOVED,
        .meaning = "displacement of the slide along the cutting direction"},
    [SLIDE_VELOCITY_X] = {.name = "slide_velocity_x", MOVING,
        .meaning = "velocity of the slide along the cutting direction"},
    [DISPLACEMENT_Y] = {.name = "displacement_y", MOVED, .meaning = "displacement of the tool away from the surface"},
    [VELOCITY_Y] = {.name = "velocity_y", MOVING, .meaning = "velocity of the tool away from the surface"},
    [SLIDE_DISPLACEMENT_Y] = {.name = "slide_displacement_y", MOVED,
        .meaning = "displacement of the slide away from the surface"},
    [SLIDE_VELOCITY_Y] = {.name = "slide_velocity_y", MOVING, .meaning = "velocity of the slide away from the surface"},
    [STORED_ENERGY] = {.name = "stored_energy", RESULT, .unit = "J", .nominal = 1e-3,
        .meaning = "kinetic energy and that of the springs", .source = DEFINITION},
    [POWER_IN] = {.name = "power_in", RESULT, .unit = "W", .meaning = "work of the forces on the tool per second",
        .source = DEFINITION},
    [POWER_LOST] = {.name = "power_lost", RESULT, .unit = "W", .meaning = "what the dampers take",
        .source = DEFINITION},
    [RATES] = {.name = "rate_of_displacement_x", .unit = "m/s", RATE(DISPLACEMENT_X),
        .meaning = "rate of displacement_x"},
    [RATES + 1] = {.name = "acceleration_x", .unit = "m/s^2", RATE(VELOCITY_X), .meaning = "acceleration of the tool"},
    [RATES + 2] = {.name = "rate_of_slide_displacement_x", .unit = "m/s", RATE(SLIDE_DISPLACEMENT_X),
        .meaning = "rate of slide_displacement_x"},
    [RATES + 3] = {.name = "slide_acceleration_x", .unit = "m/s^2", RATE(SLIDE_VELOCITY_X),
        .meaning = "acceleration of the slide"},
    [RATES + 4] = {.name = "rate_of_displacement_y", .unit = "m/s", RATE(DISPLACEMENT_Y),
        .meaning = "rate of displacement_y"},
    [RATES + 5] = {.name = "acceleration_y", .unit = "m/s^2", RATE(VELOCITY_Y), .meaning = "acceleration of the tool"},
    [RATES + 6] = {.name = "rate_of_slide_displacement_y", .unit = "m/s", RATE(SLIDE_DISPLACEMENT_Y),
        .meaning = "rate of slide_displacement_y"},
    [RATES + 7] = {.name = "slide_acceleration_y", .unit = "m/s^2", RATE(SLIDE_VELOCITY_Y),
        .meaning = "acceleration of the slide"},
};
/* clang-format on */

/* One direction; the states, and so their rates, of a direction stand together. */
static void direction(double *value, double F, double k_h, double m_s, double k_s, int state, int rate)
{
    const double m_h = value[HOLDER_MASS], c_h = 2 * value[HOLDER_DAMPING] * sqrt(k_h * m_h),
                 c_s = 2 * value[SLIDE_DAMPING] * sqrt(k_s * m_s);
    const double q_h = value[state], v_h = value[state + 1], q_s = value[state + 2], v_s = value[state + 3];
    const double spring = k_h * (q_h - q_s), damper = c_h * (v_h - v_s);
    value[rate] = v_h;
    value[rate + 1] = (F - spring - damper) / m_h;
    value[rate + 2] = v_s;
    value[rate + 3] = (spring + damper - k_s * q_s - c_s * v_s) / m_s;
    value[STORED_ENERGY] += 0.5 * (m_h * v_h * v_h + m_s * v_s * v_s + spring * (q_h - q_s) + k_s * q_s * q_s);
    value[POWER_IN] += F * v_h;
    value[POWER_LOST] += damper * (v_h - v_s) + c_s * v_s * v_s;
}

static void evaluate(double *value)
{
    value[STORED_ENERGY] = value[POWER_IN] = value[POWER_LOST] = 0;
    direction(value, value[FORCE_X], value[HOLDER_STIFFNESS_X], value[SLIDE_MASS_X], value[SLIDE_STIFFNESS_X],
              DISPLACEMENT_X, RATES);
    direction(value, value[FORCE_Y], value[HOLDER_STIFFNESS_Y], value[SLIDE_MASS_Y], value[SLIDE_STIFFNESS_Y],
              DISPLACEMENT_Y, RATES + 4);
}

const struct Part part = {
    .equations =
        "m_h a_h = F - k_h (q_h - q_s) - c_h (v_h - v_s)\n"
        "m_s a_s = k_h (q_h - q_s) + c_h (v_h - v_s) - k_s q_s - c_s v_s,   c = 2 zeta sqrt(k m), in each direction",
    .variables = variables,
    .count = COUNT,
    .evaluate = evaluate,
};
