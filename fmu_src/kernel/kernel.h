/* What is the contact made of, and what can be asked of it?
 *
 * All physics lives in this folder: C99 and math.h, no allocation, no writable static, no file, no clock.
 * One `struct Contact` is a block of LANES contacts that run side by side with their own values; the caller owns it, it holds no
 * pointer, and copying its bytes copies the contact. Every quantity is in SI. Names, units, starts, bounds and sources stand in tables
 * (`struct Variable`); the FMI shells, Python, the documentation and the systems learn them by asking (kernel_variable).
 *
 * Stages of one time point: path -> engagement -> load -> friction -> forces. A friction law or an effect opens fields of
 * `struct Point`, never the contact, keeps no state of its own, and does the same arithmetic in every lane.
 */
#ifndef KERNEL_H
#define KERNEL_H

#include <stddef.h>
#include <stdint.h>

#ifndef LANES
#define LANES 1
#endif

/* One number for each lane. */
typedef double lanes[LANES];

/* ---- tables: the one declaration of every quantity ---- */

enum Type { REAL, INTEGER, BOOLEAN, CHOICE };
enum Causality { INDEPENDENT, PARAMETER, CALCULATED, INPUT, OUTPUT, LOCAL };
enum Variability { FIXED, TUNABLE, DISCRETE, CONTINUOUS };

struct Variable {
    const char *name, *unit, *display_unit; /* unit "1": dimensionless; display_unit may be NULL */
    double start, min, max, nominal;        /* in `unit`; nominal 0 stands for 1 */
    const char *meaning, *source;           /* source "guess" where nothing better is known */
    enum Type type;
    enum Causality causality;
    enum Variability variability;
    const char *const *choices; /* CHOICE: the names, ended by NULL; the value is the place in the list */
    int derivative_of;          /* index of the state whose rate this is; 0: none */
};

enum Stage { STAGE_PATH, STAGE_ENGAGEMENT, STAGE_LOAD, STAGE_FRICTION, STAGE_FORCES };

/* The indices of the base table. Tables of laws and effects follow it in the order of registry.c. */
enum Base {
    TIME,
    /* inputs */
    SLIP_VELOCITY, PROXY_SPEED, CONTACT_TEMPERATURE, UNCUT_THICKNESS, CUTTING_SPEED, APPLIED_FORCE,
    TOOL_DISPLACEMENT_X, TOOL_DISPLACEMENT_Y, TOOL_VELOCITY_X, TOOL_VELOCITY_Y,
    /* choices, fixed */
    KINEMATICS, FRICTION_LAW, SHEAR_ANGLE_PRINCIPLE, CHIP_FLOW_ANGLE, PROXY_SOURCE, DAMPING_MODE, RATE_STIFFNESS, INITIAL_STATE,
    /* numbers, fixed */
    VIBRATION_FREQUENCY, PHASE_X, PHASE_Y, AVERAGING_WINDOW, RELATIVE_TOLERANCE,
    /* the process, tunable */
    AMPLITUDE_X, AMPLITUDE_Y, FEED, WIDTH, RAKE_ANGLE, SHEAR_STRESS, CONSTANT_SHEAR_ANGLE,
    /* friction, tunable */
    SIGMA0, SIGMA1, SIGMA2, F_C, F_S, V_S, DAMPING_MARGIN, STIFFNESS_FLOOR, RELEASE_TIME,
    /* the temperature proxy, tunable */
    THETA_REF, ALPHA_T, AMBIENT_TEMPERATURE, REFERENCE_TEMPERATURE,
    /* outputs */
    FRICTION_FORCE, PRINCIPAL_FORCE, FEED_FORCE, NORMAL_FORCE, TOOL_FORCE_X, TOOL_FORCE_Y,
    MEAN_FRICTION_FORCE, MEAN_PRINCIPAL_FORCE, MEAN_FEED_FORCE, MEAN_NORMAL_FORCE, MEAN_CONTACT_RATIO,
    SLIP_VELOCITY_USED, UNCUT_THICKNESS_USED, THETA_USED, SHEAR_ANGLE, SPEED_RATIO, IN_CONTACT,
    BRISTLE_DEFLECTION, DISSIPATED_POWER, DISSIPATED_ENERGY, CLAMPED_COUNT, STEP_COUNT,
    /* locals: the rate of the bristle and the running integrals behind the cycle means */
    BRISTLE_RATE, FRICTION_IMPULSE, PRINCIPAL_IMPULSE, FEED_IMPULSE, NORMAL_IMPULSE, CONTACT_TIME, CONTACT_RATE,
    /* locals: the event indicators, in the order of enum Indicator */
    CONTACT_INDICATOR, SURFACE_INDICATOR, SLIP_INDICATOR, LAW_INDICATOR,
    BASE_COUNT
};

enum Kinematics { KINEMATICS_INTERNAL, KINEMATICS_EXTERNAL, KINEMATICS_COMBINED };
enum ShearAnglePrinciple { MAXIMUM_SHEAR_STRESS, MINIMUM_ENERGY };
enum ChipFlowAngle { CONSTANT_ANGLE, CURRENT_ANGLE };
enum ProxySource { PROXY_IS_SLIP_SPEED, PROXY_IS_INPUT, PROXY_IS_CUTTING_SPEED, PROXY_IS_TEMPERATURE };
enum DampingMode { DISSIPATIVE, AS_PUBLISHED };
enum RateStiffness { REFERENCE_STIFFNESS, THERMAL_STIFFNESS };
enum InitialState { AT_REST, PERIODIC };

enum Limits {
    CAPACITY = 160,      /* values of one contact: base, laws and effects together (a test holds the tables to it) */
    MEMORY = 24,         /* what a law remembers between events, beside its bristle deflection */
    STATES = 7,          /* continuous states, in the order of kernel_state */
    INDICATORS = 4,      /* zero crossings that are events: see enum Indicator */
    INPUT_FIRST = SLIP_VELOCITY,
    INPUT_END = TOOL_VELOCITY_Y + 1
};

/* Each is a number whose change of sign is an event. */
enum Indicator {
    AT_CONTACT, /* > 0 while the tool is in the material and moving into it */
    AT_SURFACE, /* > 0 where an earlier cycle has left the surface, < 0 where the nominal surface still stands */
    AT_SLIP,    /* the slip velocity: friction reverses */
    AT_LAW      /* the friction law's own, > 0 on its sticking side: break-away of a bristle, Karnopp's band */
};

enum Status { KERNEL_OK, KERNEL_NO_SUCH_VARIABLE, KERNEL_NOT_FINITE, KERNEL_OUT_OF_BOUNDS, KERNEL_BAD_STEP, KERNEL_TOO_MANY_STEPS,
              KERNEL_DIVERGED, KERNEL_TEMPERATURES, KERNEL_STATUS_COUNT };

/* Things that are legal but worth one line in the log; bits of kernel_warnings. */
enum Warning { WARN_STIFFNESS_FLOOR = 1, WARN_FORCE_DOMAIN = 2, WARN_TEMPERATURE = 4, WARN_UNUSED_SLIP = 8,
               WARN_NOT_PERIODIC = 16, WARNING_COUNT = 5 };

/* ---- one block of contacts; plain bytes ---- */

struct Contact {
    lanes value[CAPACITY];                   /* every variable, by index */
    lanes slope[INPUT_END - INPUT_FIRST];    /* rate of each input within a communication step, per second; 0 = held */
    lanes memory[MEMORY];                    /* of the friction law */
    lanes sign[INDICATORS];                  /* +1 or -1: on which side of each event the contact is */
    lanes next_step;                         /* internal step that the tolerance asks for [s] */
    lanes largest_difference;                /* what relative_tolerance allows a lower order to change in one step */
    lanes window_start[5];                   /* the impulses (STATES order, from FRICTION_IMPULSE) when the averaging window opened */
    lanes window;                            /* averaging windows closed so far */
    double window_origin;                    /* time at which the first window opened [s] */
    uint32_t warnings;
    uint32_t started;
};

/* ---- asking ---- */

int kernel_variable_count(void);
const struct Variable *kernel_variable(int index);
int kernel_state(int place);                       /* index of the place-th continuous state */
int kernel_indicator(int place);                   /* index of the place-th event indicator */
int kernel_law_count(void);
const struct FrictionLaw *kernel_law(int place);   /* the order is that of the choice friction_law */
int kernel_effect_count(void);
const struct Effect *kernel_effect(int place);
int kernel_effect_switch(int place);               /* index of the effect's Boolean; its parameters follow it */
const char *kernel_status_text(enum Status status);
const char *kernel_warning_text(int bit);          /* bit 0 .. WARNING_COUNT-1 */
size_t kernel_size(void);                          /* bytes of a struct Contact */
void kernel_token(char token[39]);                 /* "{8-4-4-4-12}": a hash over all tables; binds an XML file to its binary */
int kernel_lanes(void);

/* ---- doing ---- */

/* Every value at its start, time 0, nothing running. */
void kernel_reset(struct Contact *contact);
/* One value of one lane, checked: the index exists, the number is finite and within the table's bounds. */
enum Status kernel_set(struct Contact *contact, int index, int lane, double value);
/* The same check without the setting. */
enum Status kernel_check(int index, double value);
/* Begin at `time` [s]: sides of the events, bristles at rest or in the periodic steady state. */
enum Status kernel_start(struct Contact *contact, double time);
/* Outputs and derivatives from value[TIME], the states and the inputs as they stand. */
enum Status kernel_evaluate(struct Contact *contact);
/* Event indicators at value[TIME]; 1 for an event that does not matter at present. kernel_evaluate shows the same as variables. */
void kernel_indicators(const struct Contact *contact, lanes indicator[INDICATORS]);
/* An event has happened at value[TIME]: take sides anew, let separated bristles go, close an averaging window that has ended. */
enum Status kernel_event(struct Contact *contact);
/* Time of the next averaging-window end, of lane 0; infinity where no means are formed. */
double kernel_next_event(const struct Contact *contact);
/* Advance by `step` [s] in internal steps. With stop_at_events nonzero, return at the first contact event before it is acted upon
 * (kernel_event does that), *taken telling how far it went. */
enum Status kernel_advance(struct Contact *contact, double step, int stop_at_events, double *taken);
/* Follow `count` samples: inputs[sample * input_count + j] is the value at times[sample] of the variable input_index[j], linear in
 * between. After each sample (the first is the state as it stands) the variables output_index are written to outputs in the same
 * layout. *done tells how many rows of outputs are valid, also on failure. */
enum Status kernel_run(struct Contact *contact, int64_t count, const double *times, int input_count, const int *input_index,
                       const double *inputs, int output_count, const int *output_index, double *outputs, int64_t *done);
/* d unknown / d known at the current point, by central differences on a copy. known: inputs and states. */
enum Status kernel_derivative(const struct Contact *contact, int unknown, int known, double *derivative);

/* ---- what a law and an effect are ---- */

/* One time point of one block: every stage reads what earlier stages wrote. */
struct Point {
    /* path and engagement */
    lanes u_x, u_y;        /* tool velocity relative to the work [m/s] */
    lanes h;               /* uncut thickness [m] */
    lanes approach;        /* tool velocity into the chip, normal to the rake [m/s] */
    lanes surface;         /* indicator AT_SURFACE */
    lanes contact;         /* indicator AT_CONTACT */
    lanes cutting;         /* 1 in contact, else 0 */
    lanes speed_ratio;     /* HSR = v_c / (a w); infinity without vibration */
    /* load */
    lanes k;               /* shear load tau_s w h [N] */
    /* friction */
    lanes v;               /* slip velocity of the chip along the rake [m/s] */
    lanes direction;       /* +1 or -1: which way it slips */
    lanes speed;           /* |v| [m/s] */
    lanes theta;           /* temperature proxy [m/s] */
    lanes theta_ratio;     /* theta / theta_ref */
    lanes z;               /* mean bristle deflection [m] */
    lanes F_C, F_S, v_s;   /* [N], [N], [m/s] */
    lanes P;               /* stiffness in the rate equation [N/m] */
    lanes s0, s1, sigma2;  /* stiffness [N/m], damping and viscous coefficient [N s/m] in the force equation */
    lanes applied;         /* external tangential force on the contact, for laws that stick [N] */
    lanes sticking, F_stick; /* 1 where the slip was solved to lie in a jump of the law, and the force within the jump that holds it there [N] */
    lanes margin;          /* c in the limit of the damping; infinity: no limit */
    lanes stuck;           /* 1 on the sticking side of the law's own event, else 0 */
    lanes rate;            /* a in dz/dt = drive - a z [1/s] */
    lanes drive;           /* [m/s] */
    lanes target;          /* drive / a, also where a = 0 [m] */
    lanes dz;              /* dz/dt [m/s] */
    lanes F;               /* friction force on the tool along the chip flow [N] */
    lanes law;             /* indicator AT_LAW */
    lanes clamped;         /* how many values had to be clamped */
    uint32_t warnings;
    /* forces */
    lanes N, F_p, F_f;
    lanes outside;         /* 1 where the force lies outside the domain of the shear-angle principle */
};

/* A friction law: dz/dt = drive - rate z and F(z, dz/dt). p: the values of its own table. */
struct FrictionLaw {
    const char *meaning, *equation, *source; /* its name is its place in the choice friction_law */
    const struct Variable *variables; /* may be NULL */
    int count;
    int relaxes;                                             /* z strives for target at rate; else it integrates drive */
    void (*rates)(const lanes *p, struct Point *x);          /* rate, drive, target from v, direction, speed, stuck */
    void (*force)(const lanes *p, struct Point *x);          /* F from z, dz and the same */
    /* The law's own event, all NULL where it has none: its indicator (> 0 is the sticking side), what happens at it, and the memory
     * of an unloaded contact. */
    void (*indicator)(const lanes *p, const lanes *memory, struct Point *x);
    void (*event)(const lanes *p, const struct Point *x, lanes z, lanes *memory);
    void (*rest)(const lanes *p, const struct Point *x, lanes *memory);
};

/* A switchable effect: variables[0] is its Boolean switch and says name, meaning and source; its own parameters follow, named
 * "<effect>.<parameter>". `act` adds to or scales fields of its stage. */
struct Effect {
    const char *equation, *rivals; /* rivals: names, comma-separated, of which at most one may be on; may be NULL */
    enum Stage stage;
    const struct Variable *variables;
    int count;
    void (*act)(const lanes *p, struct Point *x);
};

#endif
