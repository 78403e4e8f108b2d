/* What does the contact show, whatever law and effects it runs? The base table: one line of seven facts for each
 * quantity.
 *
 * Symbols and decisions: Nosouhi et al., Development of a New Dynamic Friction Model for Analytical Modeling of
 * Elliptical Vibration Assisted Turning Process ("the paper"); Canudas de Wit et al. 1995, A New Model for Control of
 * Systems with Friction ("LuGre 1995").
 */
#include "elementary.h"
#include "kernel.h"
#include "registry.h"

#include <math.h>

static const char *const kinematics[] = {"internal", "external", "combined", NULL};
static const char *const principles[] = {"maximum_shear_stress", "minimum_energy", NULL};
static const char *const chip_flow_angles[] = {"constant", "current_shear_angle", NULL};
static const char *const proxy_sources[] = {"slip_speed", "proxy_speed", "cutting_speed", "contact_temperature", NULL};
static const char *const damping_modes[] = {"dissipative", "as_published", NULL};
static const char *const rate_stiffnesses[] = {"reference", "thermal", NULL};
static const char *const initial_states[] = {"at_rest", "periodic", "steady", NULL};
static const char *const averagings[] = {"resolved", "cycle", NULL};

#define UNBOUNDED (-INFINITY), INFINITY
#define GIVEN .causality = INPUT, .variability = CONTINUOUS
#define FIXED_CHOICE(names) .unit = "1", .type = CHOICE, .causality = PARAMETER, .variability = FIXED, .choices = names
#define FIXED_NUMBER .causality = PARAMETER, .variability = FIXED
#define RESULT .causality = OUTPUT, .variability = CONTINUOUS, .min = -INFINITY, .max = INFINITY
#define COUNTED .causality = OUTPUT, .variability = DISCRETE, .min = -INFINITY, .max = INFINITY
#define INNER .causality = LOCAL, .variability = CONTINUOUS, .min = -INFINITY, .max = INFINITY
#define FORCE .unit = "N", .nominal = 10
/* What is said of an input that some kinematics alone read, and that then has to be given. */
#define USED_WITH(kinematics, what) .meaning = what "; used where kinematics = " kinematics, .required_with = kinematics
#define MACHINE "the machine model that drives the contact"
#define DEFINITION "definition"
/* An integral since the last event. A solver weighs the whole of a state: one that is counted anew at each event stays
 * as exact as a single cut; a thirtieth of what a cycle brings keeps means within 1e-5 at a tolerance of 1e-6. */
#define RECENT 3e-7
#define RECENTLY(what) what " since the last event that was acted upon from outside: the state behind it"

/* clang-format off */
const struct Variable base_variables[BASE_COUNT] = {
    [VAR_TIME] = {.name = "time", .unit = "s", .min = -INFINITY, .max = INFINITY, .causality = INDEPENDENT,
        .variability = CONTINUOUS, .meaning = "simulation time", .source = DEFINITION},

    [VAR_SLIP_VELOCITY] = {.name = "slip_velocity", .unit = "m/s", .display_unit = "m/min", .min = -1e3, .max = 1e3, GIVEN,
        USED_WITH("external", "velocity of the chip along the rake face relative to the tool, positive in ordinary "
            "chip flow"), .source = MACHINE},
    [VAR_PROXY_SPEED] = {.name = "proxy_speed", .unit = "m/s", .display_unit = "m/min", .min = 0, .max = 1e3, GIVEN,
        .meaning = "temperature proxy theta given as a speed; used where proxy_source = proxy_speed",
        .source = "the paper, eq. 3: T ~ v^alpha"},
    [VAR_CONTACT_TEMPERATURE] = {.name = "contact_temperature", .unit = "K", .display_unit = "degC", .start = 293.15,
        .min = 0, .max = 5e3, .nominal = 500, GIVEN,
        .meaning = "chip-tool contact temperature; used where proxy_source = contact_temperature", .source = MACHINE},
    [VAR_UNCUT_THICKNESS] = {.name = "uncut_thickness", .unit = "m", .display_unit = "um", .start = 1e-4, .min = -1e-1,
        .max = 1e-1, .nominal = 1e-4, GIVEN,
        USED_WITH("external", "uncut chip thickness, no contact where it is 0 or less"), .source = MACHINE},
    [VAR_NORMAL_LOAD] = {.name = "normal_load", .unit = "N", .start = 10, .min = 0, .max = 1e6, .nominal = 10, GIVEN,
        .meaning = "normal load on the contact; used by the effect load_dependence and by friction_law = amontons where "
            "kinematics = external",
        .required_with = "external", .source = MACHINE},
    [VAR_CUTTING_SPEED] = {.name = "cutting_speed", .unit = "m/s", .display_unit = "m/min", .start = 10.0 / 60, .min = 0,
        .max = 1e2, GIVEN, .meaning = "speed of the work past the mean tool position", .required_with = "external",
        .source = "guess: 10 m/min, the paper states none"},
    [VAR_APPLIED_FORCE] = {.name = "applied_force", .unit = "N", .min = -1e6, .max = 1e6, .nominal = 10, GIVEN,
        .meaning = "external tangential force on the contact that static friction balances; used by friction_law = "
            "karnopp", .source = "Karnopp 1985 (not read)"},
    [VAR_TOOL_DISPLACEMENT_X] = {.name = "tool_displacement_x", .unit = "m", .display_unit = "um", .min = -10, .max = 10,
        .nominal = 1e-6, GIVEN,
        .meaning = "displacement of the vibration's centre along the cutting direction; has no effect: the work is the "
            "same all along the cut, and every earlier cycle is taken to have had the same centre", .source = MACHINE},
    [VAR_TOOL_DISPLACEMENT_Y] = {.name = "tool_displacement_y", .unit = "m", .display_unit = "um", .min = -10, .max = 10,
        .nominal = 1e-6, GIVEN,
        USED_WITH("combined", "displacement of the vibration's centre away from the machined surface"),
        .source = MACHINE},
    [VAR_TOOL_VELOCITY_X] = {.name = "tool_velocity_x", .unit = "m/s", .display_unit = "m/min", .min = -1e3, .max = 1e3,
        GIVEN, USED_WITH("combined", "velocity of the vibration's centre along the cutting direction"),
        .source = MACHINE},
    [VAR_TOOL_VELOCITY_Y] = {.name = "tool_velocity_y", .unit = "m/s", .display_unit = "m/min", .min = -1e3, .max = 1e3,
        GIVEN, USED_WITH("combined", "velocity of the vibration's centre away from the machined surface"),
        .source = MACHINE},

    [VAR_KINEMATICS] = {.name = "kinematics", .start = KINEMATICS_INTERNAL, .max = 2, FIXED_CHOICE(kinematics),
        .meaning = "where motion and thickness come from: internal: the ellipse, from parameters; external: "
            "slip_velocity and uncut_thickness; combined: the ellipse carried by tool_displacement_y, tool_velocity_x and "
            "tool_velocity_y",
        .source = DEFINITION},
    [VAR_FRICTION_LAW] = {.name = "friction_law", .start = 1, .max = LAW_COUNT - 1, FIXED_CHOICE(law_names),
        .meaning = "friction law of the chip-tool contact", .source = "the paper, section 1"},
    [VAR_SHEAR_ANGLE_PRINCIPLE] = {.name = "shear_angle_principle", .start = MAXIMUM_SHEAR_STRESS, .max = 1,
        FIXED_CHOICE(principles),
        .meaning = "maximum_shear_stress: phi = pi/4 - beta + alpha; minimum_energy: phi = pi/4 - (beta - alpha)/2",
        .source = "the paper, table 2; Lee and Shaffer 1951 (not read); Merchant 1945 (not read)"},
    [VAR_CHIP_FLOW_ANGLE] = {.name = "chip_flow_angle", .start = CONSTANT_ANGLE, .max = 1, FIXED_CHOICE(chip_flow_angles),
        .meaning = "shear angle that turns tool velocity into slip: the parameter chip_flow_shear_angle, or the "
            "current shear_angle", .source = DEFINITION},
    [VAR_PROXY_SOURCE] = {.name = "proxy_source", .start = PROXY_IS_SLIP_SPEED, .max = 3, FIXED_CHOICE(proxy_sources),
        .meaning = "what the temperature proxy theta is taken from", .source = "the paper, eqs. 3 to 5: slip speed"},
    [VAR_DAMPING_MODE] = {.name = "damping_mode", .start = DISSIPATIVE, .max = 1, FIXED_CHOICE(damping_modes),
        .meaning = "dissipative: s1 limited to 4 damping_margin g/|v| (times s0 over the rate stiffness); "
            "as_published: s1 as it stands", .source = "Canudas de Wit et al. 1995, passivity; Olsson 1996 (not read)"},
    [VAR_RATE_STIFFNESS] = {.name = "rate_stiffness", .start = REFERENCE_STIFFNESS, .max = 1,
        FIXED_CHOICE(rate_stiffnesses),
        .meaning = "stiffness in the rate equation of the bristle: reference: sigma0; thermal: s0(theta)",
        .source = "the paper, eq. 8, changes the force equation only"},
    [VAR_INITIAL_STATE] = {.name = "initial_state", .start = AT_REST, .max = 2, FIXED_CHOICE(initial_states),
        .meaning = "at_rest: bristle_deflection as set, and all that lags or remembers at 0; periodic: the steady state of the "
            "vibration cycle, or at_rest with a warning where none is found; steady: bristle_deflection as set, and "
            "proxy_lag, rate_and_state, backlash and the sensors where they would be had all been for long as it is at the "
            "start, other states of effects (ages, loads, swings, elements) at 0",
        .source = DEFINITION},
    [VAR_AVERAGING] = {.name = "averaging", .start = RESOLVED, .max = 1, FIXED_CHOICE(averagings),
        .meaning = "what a step of co-simulation does. resolved: it follows every vibration cycle. cycle: one cycle "
            "with the inputs of the step's middle stands for all: forces, powers and sliding_speed are then its means, "
            "held until the next step, in_contact says whether it cuts at all, states advance by them; other outputs "
            "show the instant at which the tool stands highest. Not with kinematics = external",
        .source = "Kryloff and Bogoliuboff 1947 (not read), averaging; Petzold 1981 (not read), multirevolution methods"},

    [VAR_VIBRATION_FREQUENCY] = {.name = "vibration_frequency", .unit = "Hz", .display_unit = "kHz", .start = 20e3,
        .min = 1e-3, .max = 1e6, .nominal = 2e4, FIXED_NUMBER, .meaning = "frequency of the elliptical vibration",
        .source = "guess: common ultrasonic tool, the paper states none"},
    [VAR_PHASE_X] = {.name = "phase_x", .unit = "rad", .display_unit = "deg", .start = -PI / 2, .min = -2 * PI,
        .max = 2 * PI, FIXED_NUMBER,
        .meaning = "phase of the vibration along the cutting direction, x = amplitude_x cos(2 pi f t + phase_x)",
        .source = "the paper, section 5: pi/2 between the axes; the origin puts the bottom of the path at t = 0"},
    [VAR_PHASE_Y] = {.name = "phase_y", .unit = "rad", .display_unit = "deg", .start = PI, .min = -2 * PI, .max = 2 * PI,
        FIXED_NUMBER,
        .meaning = "phase of the vibration away from the surface, y = amplitude_y cos(2 pi f t + phase_y)",
        .source = "the paper, section 5: pi/2 between the axes; the origin puts the bottom of the path at t = 0"},
    [VAR_AVERAGING_WINDOW] = {.name = "averaging_window", .unit = "s", .display_unit = "us", .min = 0, .max = 1e6,
        .nominal = 1e-4, FIXED_NUMBER,
        .meaning = "length of the window of the mean forces; 0, or less than 1e-9 s: one vibration period, or with "
            "kinematics = external no window (the means are the instantaneous forces)", .source = DEFINITION},
    [VAR_RELATIVE_TOLERANCE] = {.name = "relative_tolerance", .unit = "1", .start = 1e-4, .min = 1e-12, .max = 1e-1,
        .nominal = 1e-4, FIXED_NUMBER,
        .meaning = "relative error that the internal steps of co-simulation are chosen for", .source = DEFINITION},

    [VAR_AMPLITUDE_X] = {.name = "amplitude_x", .unit = "m", .display_unit = "um", .start = 5e-6, .min = 0, .max = 1e-3,
        .nominal = 1e-6, TUNED,
        .meaning = "vibration amplitude along the cutting direction; 0, or less than 1e-12 m: none",
        .source = "guess: the paper states none"},
    [VAR_AMPLITUDE_Y] = {.name = "amplitude_y", .unit = "m", .display_unit = "um", .start = 5e-6, .min = 0, .max = 1e-3,
        .nominal = 1e-6, TUNED, .meaning = "vibration amplitude away from the surface",
        .source = "guess: the paper states none"},
    [VAR_FEED] = {.name = "feed", .unit = "m", .display_unit = "mm", .start = 1e-4, .min = 0, .max = 1e-2, .nominal = 1e-4,
        TUNED, .meaning = "nominal uncut thickness: height of the nominal surface above the lowest point of the path",
        .source = "guess: the paper states none"},
    [VAR_WIDTH] = {.name = "width", .unit = "m", .display_unit = "mm", .start = 1e-3, .min = 0, .max = 1, .nominal = 1e-3,
        TUNED, .meaning = "width of cut", .source = "guess: the paper states none"},
    [VAR_RAKE_ANGLE] = {.name = "rake_angle", .unit = "rad", .display_unit = "deg", .start = 0, .min = -0.7, .max = 0.7,
        TUNED, .meaning = "rake angle of the tool", .source = "the paper, section 4.1: 0 in the identification tests"},
    [VAR_CLEARANCE_ANGLE] = {.name = "clearance_angle", .unit = "rad", .display_unit = "deg", .start = 0, .min = 0,
        .max = 0.7, TUNED,
        .meaning = "angle between the tool's clearance face and the cutting direction; 0: not stated. Where it is, a warning "
            "says how deep the face stands in the surface that is left, and process_damping acts beyond it",
        .source = DEFINITION},
    [VAR_SHEAR_STRESS] = {.name = "shear_stress", .unit = "Pa", .display_unit = "MPa", .start = 4e8, .min = 0, .max = 1e10,
        .nominal = 1e8, TUNED, .meaning = "shear flow stress on the shear plane",
        .source = "guess: the paper states none"},
    [VAR_CONSTANT_SHEAR_ANGLE] = {.name = "chip_flow_shear_angle", .unit = "rad", .display_unit = "deg", .start = PI / 6,
        .min = 0.05, .max = 1.4, TUNED, .meaning = "shear angle of the chip flow where chip_flow_angle = constant",
        .source = "guess: 30 deg, ordinary for metals"},

    [VAR_SIGMA0] = {.name = "sigma0", .unit = "N/m", .display_unit = "N/um", .start = 1e6, .min = 1, .max = 1e10,
        .nominal = 1e6, TUNED, .meaning = "bristle stiffness; P of the thermally modified law",
        .source = "guess: order of the paper's table 1"},
    [VAR_SIGMA1] = {.name = "sigma1", .unit = "N.s/m", .start = 10, .min = 0, .max = 1e9, .nominal = 1e2, TUNED,
        .meaning = "bristle damping; alpha1 of the thermally modified law", .source = "guess"},
    [VAR_SIGMA2] = {.name = "sigma2", .unit = "N.s/m", .start = 1, .min = 0, .max = 1e6, TUNED,
        .meaning = "viscous friction coefficient", .source = "guess: order of the paper's table 1"},
    [VAR_F_C] = {.name = "F_C", .unit = "N", .start = 9, .min = 1e-6, .max = 1e6, .nominal = 10, TUNED,
        .meaning = "Coulomb friction force", .source = "guess: order of the paper's table 1"},
    [VAR_F_S] = {.name = "F_S", .unit = "N", .start = 10, .min = 1e-6, .max = 1e6, .nominal = 10, TUNED,
        .meaning = "static friction force; may lie below F_C", .source = "guess: order of the paper's table 1"},
    [VAR_V_S] = {.name = "v_s", .unit = "m/s", .display_unit = "m/min", .start = 1e-2, .min = 1e-7, .max = 1e2,
        .nominal = 1e-3, TUNED, .meaning = "Stribeck velocity", .source = "guess: order of the paper's table 1"},
    [VAR_DAMPING_MARGIN] = {.name = "damping_margin", .unit = "1", .start = 0.1, .min = 1e-3, .max = 0.999, TUNED,
        .meaning = "c in the limit |v| s1 <= 4 c g of damping_mode = dissipative; at 1/4 the limited force is the "
            "static curve", .source = "guess"},
    [VAR_STIFFNESS_FLOOR] = {.name = "stiffness_floor", .unit = "1", .start = 1e-3, .min = 1e-9, .max = 1, TUNED,
        .meaning = "s0(theta) is kept at or above this share of sigma0",
        .source = "guess; the paper, eq. 7, asks P > v^Q"},
    [VAR_RELEASE_TIME] = {.name = "release_time", .unit = "s", .display_unit = "us", .min = 0, .max = 1e3, .nominal = 1e-5,
        TUNED,
        .meaning = "time constant with which bristles relax out of contact; 0, or less than 1e-12 s: let go at "
            "separation", .source = "guess"},

    [VAR_THETA_REF] = {.name = "theta_ref", .unit = "m/s", .display_unit = "m/min", .start = 1.0 / 60, .min = 1e-9,
        .max = 1e3, .nominal = 1e-2, TUNED,
        .meaning = "reference of the temperature proxy: the speed unit that the paper's coefficients are stated in",
        .source = "inferred: 1 m/min makes the paper's eq. 7 and table 1 consistent"},
    [VAR_ALPHA_T] = {.name = "alpha_T", .unit = "1", .start = 0.4, .min = 0.1, .max = 5, TUNED,
        .meaning = "exponent of temperature over speed, T ~ v^alpha_T",
        .source = "guess; the paper, eq. 3, leaves it open"},
    [VAR_AMBIENT_TEMPERATURE] = {.name = "ambient_temperature", .unit = "K", .display_unit = "degC", .start = 293.15,
        .min = 0, .max = 5e3, .nominal = 300, TUNED, .meaning = "temperature at which the proxy is 0",
        .source = DEFINITION},
    [VAR_REFERENCE_TEMPERATURE] = {.name = "reference_temperature", .unit = "K", .display_unit = "degC", .start = 393.15,
        .min = 0, .max = 5e3, .nominal = 300, TUNED,
        .meaning = "temperature at which the proxy is theta_ref; above ambient_temperature, by 0.001 K or more",
        .source = "guess"},

    [VAR_FRICTION_FORCE] = {.name = "friction_force", FORCE, RESULT, .derivative_of = VAR_RECENT_FRICTION_IMPULSE,
        .meaning = "friction force of the chip on the tool along the rake face", .source = "the paper, eq. 8"},
    [VAR_PRINCIPAL_FORCE] = {.name = "principal_force", FORCE, RESULT, .derivative_of = VAR_RECENT_PRINCIPAL_IMPULSE,
        .meaning = "force on the tool against the cutting direction, N cos(alpha) + F sin(alpha)",
        .source = "Merchant 1945 (not read)"},
    [VAR_FEED_FORCE] = {.name = "feed_force", FORCE, RESULT, .derivative_of = VAR_RECENT_FEED_IMPULSE,
        .meaning = "force on the tool away from the machined surface (thrust), F cos(alpha) - N sin(alpha)",
        .source = "Merchant 1945 (not read)"},
    [VAR_NORMAL_FORCE] = {.name = "normal_force", FORCE, RESULT, .derivative_of = VAR_RECENT_NORMAL_IMPULSE,
        .meaning = "force on the rake face normal to it", .source = "Merchant 1945 (not read)"},
    [VAR_TOOL_FORCE_X] = {.name = "tool_force_x", FORCE, RESULT,
        .meaning = "force on the tool along +x, the cutting direction: -principal_force", .source = DEFINITION},
    [VAR_TOOL_FORCE_Y] = {.name = "tool_force_y", FORCE, RESULT,
        .meaning = "force on the tool along +y, away from the surface: +feed_force", .source = DEFINITION},
    [VAR_MEAN_FRICTION_FORCE] = {.name = "mean_friction_force", FORCE, RESULT,
        .meaning = "friction_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_PRINCIPAL_FORCE] = {.name = "mean_principal_force", FORCE, RESULT,
        .meaning = "principal_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_FEED_FORCE] = {.name = "mean_feed_force", FORCE, RESULT,
        .meaning = "feed_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_NORMAL_FORCE] = {.name = "mean_normal_force", FORCE, RESULT,
        .meaning = "normal_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_CONTACT_RATIO] = {.name = "mean_contact_ratio", .unit = "1", RESULT,
        .meaning = "share of the last full averaging window spent in contact (duty)", .source = DEFINITION},
    [VAR_MEAN_DISSIPATED_POWER] = {.name = "mean_dissipated_power", .unit = "W", RESULT,
        .meaning = "dissipated_power, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_SHEAR_POWER] = {.name = "mean_shear_power", .unit = "W", RESULT,
        .meaning = "shear_power, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEASURED_FRICTION_FORCE] = {.name = "measured_friction_force", FORCE, RESULT,
        .derivative_of = VAR_RECENT_MEASURED_FRICTION_IMPULSE,
        .meaning = "friction_force as the sensor shows it: with the effects of measurement that are on",
        .source = DEFINITION},
    [VAR_MEASURED_PRINCIPAL_FORCE] = {.name = "measured_principal_force", FORCE, RESULT,
        .derivative_of = VAR_RECENT_MEASURED_PRINCIPAL_IMPULSE,
        .meaning = "principal_force as the sensor shows it: with the effects of measurement that are on",
        .source = DEFINITION},
    [VAR_MEASURED_FEED_FORCE] = {.name = "measured_feed_force", FORCE, RESULT,
        .derivative_of = VAR_RECENT_MEASURED_FEED_IMPULSE,
        .meaning = "feed_force as the sensor shows it: with the effects of measurement that are on",
        .source = DEFINITION},
    [VAR_MEAN_MEASURED_FRICTION_FORCE] = {.name = "mean_measured_friction_force", FORCE, RESULT,
        .meaning = "measured_friction_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_MEASURED_PRINCIPAL_FORCE] = {.name = "mean_measured_principal_force", FORCE, RESULT,
        .meaning = "measured_principal_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_MEAN_MEASURED_FEED_FORCE] = {.name = "mean_measured_feed_force", FORCE, RESULT,
        .meaning = "measured_feed_force, mean over the last full averaging window", .source = DEFINITION},
    [VAR_SLIP_VELOCITY_USED] = {.name = "slip_velocity_used", .unit = "m/s", .display_unit = "m/min", RESULT,
        .meaning = "slip velocity that the friction law sees",
        .source = "rigid chip on one shear plane; Merchant 1945 (not read)"},
    [VAR_UNCUT_THICKNESS_USED] = {.name = "uncut_thickness_used", .unit = "m", .display_unit = "um", .nominal = 1e-4,
        RESULT, .meaning = "uncut thickness that the shear load sees, 0 out of contact",
        .source = "Shamoto and Moriwaki 1999 (not read)"},
    [VAR_THETA_USED] = {.name = "theta_used", .unit = "m/s", .display_unit = "m/min", RESULT,
        .meaning = "temperature proxy that the friction law sees", .source = "the paper, eq. 3"},
    [VAR_SHEAR_ANGLE] = {.name = "shear_angle", .unit = "rad", .display_unit = "deg", RESULT,
        .meaning = "current shear angle phi", .source = "the paper, table 2: both principles"},
    [VAR_SPEED_RATIO] = {.name = "speed_ratio", .unit = "1", RESULT,
        .meaning = "HSR = cutting_speed / (2 pi vibration_frequency amplitude_x); separation needs less than 1; 0 "
            "without vibration", .source = "Shamoto and Moriwaki 1999 (not read)"},
    [VAR_CUSP_HEIGHT] = {.name = "cusp_height", .unit = "m", .display_unit = "um", .nominal = 1e-6, RESULT,
        .meaning = "height of the cusps that the vibration leaves along the cut, from their tops to the lowest places between "
            "them: theoretical roughness if the clearance face is clear of them; kinematics = external: 0",
        .source = "Shamoto and Moriwaki 1994 (not read); envelope of all earlier strokes, as uncut_thickness_used"},
    [VAR_IN_CONTACT] = {.name = "in_contact", .unit = "1", .max = 1, .type = BOOLEAN, .causality = OUTPUT,
        .variability = DISCRETE, .meaning = "the tool is in the material and moving into it", .source = DEFINITION},
    [VAR_BRISTLE_DEFLECTION] = {.name = "bristle_deflection", .unit = "m", .display_unit = "um", .nominal = 1e-6,
        .causality = OUTPUT, .variability = CONTINUOUS, .min = -1, .max = 1,
        .meaning = "mean bristle deflection z; its start is the state that initial_state = at_rest begins from",
        .source = "Canudas de Wit et al. 1995, eq. 2"},
    [VAR_DISSIPATED_POWER] = {.name = "dissipated_power", .unit = "W", RESULT,
        .derivative_of = VAR_RECENT_DISSIPATED_ENERGY,
        .meaning = "friction_force times slip velocity: power that the friction takes up; below 0 while bristles "
            "spring back", .source = DEFINITION},
    [VAR_DISSIPATED_ENERGY] = {.name = "dissipated_energy", .unit = "J", .nominal = 1e-5, RESULT,
        .meaning = "dissipated_power, integrated from the start", .source = DEFINITION},
    [VAR_SHEAR_POWER] = {.name = "shear_power", .unit = "W", RESULT, .derivative_of = VAR_RECENT_SHEAR_ENERGY,
        .meaning = "power that shears the chip, shear force times shear velocity on the plane that gives the slip: what "
            "chip and tool exchange less dissipated_power. kinematics = external: of the steady chip at that slip and "
            "chip_flow_shear_angle", .source = "Merchant 1945 (not read); balance of power"},
    [VAR_SHEAR_ENERGY] = {.name = "shear_energy", .unit = "J", .nominal = 1e-5, RESULT,
        .meaning = "shear_power, integrated from the start", .source = DEFINITION},
    [VAR_SLIDING_SPEED] = {.name = "sliding_speed", .unit = "m/s", .display_unit = "m/min", RESULT,
        .derivative_of = VAR_SLIDING_DISTANCE, .meaning = "magnitude of the slip velocity in contact, 0 out of it",
        .source = DEFINITION},
    [VAR_SLIDING_DISTANCE] = {.name = "sliding_distance", .unit = "m", .nominal = 1e-5, RESULT,
        .meaning = "sliding_speed, integrated from the start", .source = DEFINITION},
    [VAR_CLAMPED_COUNT] = {.name = "clamped_count", .unit = "1", .type = INTEGER, COUNTED,
        .meaning = "internal steps in which a value had to be clamped: s0 at its floor, a force outside the closed "
            "form's domain, a temperature below ambient, an input that was given a hair outside its bounds", .source = DEFINITION},
    [VAR_STEP_COUNT] = {.name = "step_count", .unit = "1", .type = INTEGER, COUNTED,
        .meaning = "internal steps taken by co-simulation", .source = DEFINITION},
    [VAR_AVERAGING_ERROR] = {.name = "averaging_error", FORCE, RESULT,
        .meaning = "averaging = cycle: how far the mean forces of the last step may be from those of the resolved run, "
            "from the change between the cycles that were run and between the last three steps, and from a broken number of "
            "cycles in a step; else 0",
        .source = "remainder of the midpoint rule; tests/laws/test_averaging.py"},

    [VAR_BRISTLE_RATE] = {.name = "bristle_rate", .unit = "m/s", INNER, .derivative_of = VAR_BRISTLE_DEFLECTION,
        .meaning = "rate of the mean bristle deflection, dz/dt", .source = "Canudas de Wit et al. 1995, eq. 2"},
    [VAR_FRICTION_IMPULSE] = {.name = "friction_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "friction_force, integrated from the start", .source = DEFINITION},
    [VAR_PRINCIPAL_IMPULSE] = {.name = "principal_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "principal_force, integrated from the start", .source = DEFINITION},
    [VAR_FEED_IMPULSE] = {.name = "feed_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "feed_force, integrated from the start", .source = DEFINITION},
    [VAR_NORMAL_IMPULSE] = {.name = "normal_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "normal_force, integrated from the start", .source = DEFINITION},
    [VAR_CONTACT_TIME] = {.name = "contact_time", .unit = "s", .nominal = 1e-5, INNER,
        .meaning = "time spent in contact from the start", .source = DEFINITION},
    [VAR_MEASURED_FRICTION_IMPULSE] = {.name = "measured_friction_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "measured_friction_force, integrated from the start", .source = DEFINITION},
    [VAR_MEASURED_PRINCIPAL_IMPULSE] = {.name = "measured_principal_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "measured_principal_force, integrated from the start", .source = DEFINITION},
    [VAR_MEASURED_FEED_IMPULSE] = {.name = "measured_feed_impulse", .unit = "N.s", .nominal = 1e-5, INNER,
        .meaning = "measured_feed_force, integrated from the start", .source = DEFINITION},
    [VAR_CONTACT_RATE] = {.name = "contact_rate", .unit = "1", INNER, .derivative_of = VAR_RECENT_CONTACT_TIME,
        .meaning = "1 in contact, 0 out of it", .source = DEFINITION},
    [VAR_RECENT_DISSIPATED_ENERGY] = {.name = "recent_dissipated_energy", .unit = "J", .nominal = RECENT, INNER,
        .meaning = RECENTLY("dissipated_energy"), .source = DEFINITION},
    [VAR_RECENT_SHEAR_ENERGY] = {.name = "recent_shear_energy", .unit = "J", .nominal = RECENT, INNER,
        .meaning = RECENTLY("shear_energy"), .source = DEFINITION},
    [VAR_RECENT_FRICTION_IMPULSE] = {.name = "recent_friction_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("friction_impulse"), .source = DEFINITION},
    [VAR_RECENT_PRINCIPAL_IMPULSE] = {.name = "recent_principal_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("principal_impulse"), .source = DEFINITION},
    [VAR_RECENT_FEED_IMPULSE] = {.name = "recent_feed_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("feed_impulse"), .source = DEFINITION},
    [VAR_RECENT_NORMAL_IMPULSE] = {.name = "recent_normal_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("normal_impulse"), .source = DEFINITION},
    [VAR_RECENT_CONTACT_TIME] = {.name = "recent_contact_time", .unit = "s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("contact_time"), .source = DEFINITION},
    [VAR_RECENT_MEASURED_FRICTION_IMPULSE] = {.name = "recent_measured_friction_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("measured_friction_impulse"), .source = DEFINITION},
    [VAR_RECENT_MEASURED_PRINCIPAL_IMPULSE] = {.name = "recent_measured_principal_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("measured_principal_impulse"), .source = DEFINITION},
    [VAR_RECENT_MEASURED_FEED_IMPULSE] = {.name = "recent_measured_feed_impulse", .unit = "N.s", .nominal = RECENT, INNER,
        .meaning = RECENTLY("measured_feed_impulse"), .source = DEFINITION},
    [VAR_CONTACT_INDICATOR] = {.name = "contact_indicator", .unit = "1", INNER,
        .meaning = "event indicator: above 0 while the tool is in the material and moving into it; the smaller of the "
            "uncut thickness in um and the approach velocity in m/s. Like all event indicators it changes its sign 1e-9 "
            "behind the event, so that it is not 0 there", .source = DEFINITION},
    [VAR_SURFACE_INDICATOR] = {.name = "surface_indicator", .unit = "1", INNER,
        .meaning = "event indicator: above 0 where the previous cycle has left the surface, below 0 where the nominal "
            "surface stands; a length in units of amplitude_x. Where older strokes count, the distance to the nearest "
            "end of one, whose sign changes at each", .source = DEFINITION},
    [VAR_SLIP_INDICATOR] = {.name = "slip_indicator", .unit = "1", INNER,
        .meaning = "event indicator: the slip velocity in mm/s, whose sign change reverses friction",
        .source = DEFINITION},
    [VAR_LAW_INDICATOR] = {.name = "law_indicator", .unit = "1", INNER,
        .meaning = "event indicator of the friction law: above 0 while it sticks, a deflection over F_C/sigma0 or a "
            "speed in mm/s; 1 for laws without such an event",
        .source = DEFINITION},
};
/* clang-format on */
