/* What is the contact made of, and what can be asked of it?
 *
 * All physics lives in this folder: C99 and math.h, no allocation, no writable static, no file, no clock.
 * One `struct Contact` is a block of LANES contacts that run side by side with their own values; the caller owns it, it
 * holds no pointer, and copying its bytes copies the contact. Every quantity is in SI. Names, units, starts, bounds and
 * sources stand in tables
 * (`struct Variable`); the FMI shells, Python, the documentation and the systems learn them by asking
 * (kernel_variable).
 *
 * Stages of one time point: path -> engagement -> temperature -> shear -> load -> friction -> bristle -> forces ->
 * measurement; the states that forces drive (structure) are moved last. A friction law or an effect changes fields of
 * `struct Point`, never the contact, keeps nothing beside its states in the table, and does the same arithmetic in
 * every lane.
 */
#ifndef KERNEL_H
#define KERNEL_H

#include "tables.h"

#include <stddef.h>
#include <stdint.h>

#ifndef LANES
#define LANES 1
#endif

/* One number for each lane. What is fixed, and whether the tool vibrates at all, is the same in all of a block. */
typedef double lanes[LANES];

enum Stage {
    STAGE_PATH,
    STAGE_ENGAGEMENT,
    STAGE_TEMPERATURE,
    STAGE_SHEAR,
    STAGE_LOAD,
    STAGE_FRICTION,
    STAGE_BRISTLE,
    STAGE_FORCES,
    STAGE_MEASUREMENT,
    STAGE_COUNT
};

/* The indices of the base table. Tables of laws and effects follow it in the order of registry.c; their own indices
 * stand without VAR_, so that one of them may be TIME. */
enum Base {
    VAR_TIME,
    /* inputs */
    VAR_SLIP_VELOCITY,
    VAR_PROXY_SPEED,
    VAR_CONTACT_TEMPERATURE,
    VAR_UNCUT_THICKNESS,
    VAR_NORMAL_LOAD,
    VAR_CUTTING_SPEED,
    VAR_APPLIED_FORCE,
    VAR_TOOL_DISPLACEMENT_X,
    VAR_TOOL_DISPLACEMENT_Y,
    VAR_TOOL_VELOCITY_X,
    VAR_TOOL_VELOCITY_Y,
    /* choices, fixed */
    VAR_KINEMATICS,
    VAR_FRICTION_LAW,
    VAR_SHEAR_ANGLE_PRINCIPLE,
    VAR_CHIP_FLOW_ANGLE,
    VAR_PROXY_SOURCE,
    VAR_DAMPING_MODE,
    VAR_RATE_STIFFNESS,
    VAR_INITIAL_STATE,
    VAR_AVERAGING,
    /* numbers, fixed */
    VAR_VIBRATION_FREQUENCY,
    VAR_PHASE_X,
    VAR_PHASE_Y,
    VAR_AVERAGING_WINDOW,
    VAR_RELATIVE_TOLERANCE,
    /* the process, tunable */
    VAR_AMPLITUDE_X,
    VAR_AMPLITUDE_Y,
    VAR_FEED,
    VAR_WIDTH,
    VAR_RAKE_ANGLE,
    VAR_CLEARANCE_ANGLE,
    VAR_SHEAR_STRESS,
    VAR_CONSTANT_SHEAR_ANGLE,
    /* friction, tunable */
    VAR_SIGMA0,
    VAR_SIGMA1,
    VAR_SIGMA2,
    VAR_F_C,
    VAR_F_S,
    VAR_V_S,
    VAR_DAMPING_MARGIN,
    VAR_STIFFNESS_FLOOR,
    VAR_RELEASE_TIME,
    /* the temperature proxy, tunable */
    VAR_THETA_REF,
    VAR_ALPHA_T,
    VAR_AMBIENT_TEMPERATURE,
    VAR_REFERENCE_TEMPERATURE,
    /* outputs */
    VAR_FRICTION_FORCE,
    VAR_PRINCIPAL_FORCE,
    VAR_FEED_FORCE,
    VAR_NORMAL_FORCE,
    VAR_TOOL_FORCE_X,
    VAR_TOOL_FORCE_Y,
    VAR_MEAN_FRICTION_FORCE,
    VAR_MEAN_PRINCIPAL_FORCE,
    VAR_MEAN_FEED_FORCE,
    VAR_MEAN_NORMAL_FORCE,
    VAR_MEAN_CONTACT_RATIO,
    VAR_MEAN_DISSIPATED_POWER,
    VAR_MEAN_SHEAR_POWER,
    VAR_MEASURED_FRICTION_FORCE,
    VAR_MEASURED_PRINCIPAL_FORCE,
    VAR_MEASURED_FEED_FORCE,
    VAR_MEAN_MEASURED_FRICTION_FORCE,
    VAR_MEAN_MEASURED_PRINCIPAL_FORCE,
    VAR_MEAN_MEASURED_FEED_FORCE,
    VAR_SLIP_VELOCITY_USED,
    VAR_UNCUT_THICKNESS_USED,
    VAR_THETA_USED,
    VAR_SHEAR_ANGLE,
    VAR_SPEED_RATIO,
    VAR_CUSP_HEIGHT,
    VAR_IN_CONTACT,
    VAR_BRISTLE_DEFLECTION,
    VAR_DISSIPATED_POWER,
    VAR_DISSIPATED_ENERGY,
    VAR_SHEAR_POWER,
    VAR_SHEAR_ENERGY,
    VAR_SLIDING_SPEED,
    VAR_SLIDING_DISTANCE,
    VAR_CLAMPED_COUNT,
    VAR_STEP_COUNT,
    VAR_AVERAGING_ERROR,
    /* locals: the rate of the bristle and the running integrals behind the cycle means */
    VAR_BRISTLE_RATE,
    VAR_FRICTION_IMPULSE,
    VAR_PRINCIPAL_IMPULSE,
    VAR_FEED_IMPULSE,
    VAR_NORMAL_IMPULSE,
    VAR_CONTACT_TIME,
    VAR_MEASURED_FRICTION_IMPULSE,
    VAR_MEASURED_PRINCIPAL_IMPULSE,
    VAR_MEASURED_FEED_IMPULSE,
    VAR_CONTACT_RATE,
    /* locals: the same integrals since the last event, in the same order: states, since they do not grow */
    VAR_RECENT_DISSIPATED_ENERGY,
    VAR_RECENT_SHEAR_ENERGY,
    VAR_RECENT_FRICTION_IMPULSE,
    VAR_RECENT_PRINCIPAL_IMPULSE,
    VAR_RECENT_FEED_IMPULSE,
    VAR_RECENT_NORMAL_IMPULSE,
    VAR_RECENT_CONTACT_TIME,
    VAR_RECENT_MEASURED_FRICTION_IMPULSE,
    VAR_RECENT_MEASURED_PRINCIPAL_IMPULSE,
    VAR_RECENT_MEASURED_FEED_IMPULSE,
    /* locals: the event indicators, in the order of enum Indicator */
    VAR_CONTACT_INDICATOR,
    VAR_SURFACE_INDICATOR,
    VAR_SLIP_INDICATOR,
    VAR_LAW_INDICATOR,
    BASE_COUNT
};

enum Kinematics { KINEMATICS_INTERNAL, KINEMATICS_EXTERNAL, KINEMATICS_COMBINED };
enum ShearAnglePrinciple { MAXIMUM_SHEAR_STRESS, MINIMUM_ENERGY };
enum ChipFlowAngle { CONSTANT_ANGLE, CURRENT_ANGLE };
enum ProxySource { PROXY_IS_SLIP_SPEED, PROXY_IS_INPUT, PROXY_IS_CUTTING_SPEED, PROXY_IS_TEMPERATURE };
enum DampingMode { DISSIPATIVE, AS_PUBLISHED };
enum RateStiffness { REFERENCE_STIFFNESS, THERMAL_STIFFNESS };
enum InitialState { AT_REST, PERIODIC, STEADY };
enum Averaging { RESOLVED, CYCLE };

enum Limits {
    CAPACITY = 320,      /* values of one contact: base, laws and effects together (a test holds the tables to it) */
    MEMORY = 24,         /* what a law remembers between events, beside its bristle deflection */
    BASE_STATES = 12,    /* continuous states of the base table, the first of kernel_state */
    EFFECT_STATES = 24,  /* at most so many states of all effects together follow them */
    STATES = BASE_STATES + EFFECT_STATES,
    HISTORY = 256, /* pieces of the past that are kept, of forces and of the surface, and corners of an input; each only
                      while an effect asks for it */
    NODES = 5, /* values of a piece: at its start, quarters and end */
    CHANNELS = 3, /* forces that are measured: friction, principal, feed */
    INTEGRALS = 11, /* running integrals of the base table: the distance, and those behind the means */
    MEANS = 10, /* quantities with a mean over the averaging window: two powers, four forces, contact, three measured
                   forces */
    INDICATORS = 4, /* zero crossings that are events: see enum Indicator */
    BREAKPOINTS =
        64, /* ends of steps that are kept, one bit each in breakpoint_of_event: a cycle has a dozen, 40 at 1e-6 */
    FLANK_FACTS = 6, /* what of an ellipse decides how deep the clearance face stands in the surface */
    INPUT_FIRST = VAR_SLIP_VELOCITY,
    INPUT_END = VAR_TOOL_VELOCITY_Y + 1
};

/* Each is a number whose change of sign is an event. */
enum Indicator {
    AT_CONTACT, /* > 0 while the tool is in the material and moving into it */
    AT_SURFACE, /* > 0 where an earlier cycle has left the surface, < 0 where the nominal surface still stands; where
                   more than the cycle before has left it, the ends of all their loops change the sign in turn */
    AT_SLIP, /* the slip velocity: friction reverses */
    AT_LAW /* the friction law's own, > 0 on its sticking side: break-away of a bristle, Karnopp's band */
};

/* Things that are legal but worth one line in the log; bits of struct Contact's warnings, behind WARN_AT_BOUND. */
enum Warning {
    WARN_STIFFNESS_FLOOR = 2,
    WARN_FORCE_DOMAIN = 4,
    WARN_TEMPERATURE = 8,
    WARN_UNUSED_SLIP = 16,
    WARN_NOT_PERIODIC = 32,
    WARN_FLANK = 64,
    WARN_ALWAYS_INTO = 128,
    WARN_CLEARANCE = 256,
    WARN_SHEAR_FLOOR = 512,
    WARNING_COUNT = 10
};

/* ---- one block of contacts; plain bytes ---- */

/* Pieces of the past, a ring. What is kept of each is a polynomial of fourth order. Where no piece lies between two,
 * what was there is what was whole vibration cycles before, in the one that ends where the gap begins; where cycles
 * drift, what lies on a straight line from there to the same phase of the cycle that begins where the gap ends. */
struct Ring {
    lanes count, first; /* pieces written, and the first that is still there */
    lanes settled, joined; /* the first that nobody has tried to join yet, as far as allowed, and to a share of it */
    lanes end[HISTORY], length[HISTORY]; /* [s] */
    lanes drift[HISTORY]; /* > 0: cycles drift in the gap before it, and how far off this is, of what may be lost */
};

struct Contact {
    lanes value[CAPACITY]; /* every variable, by index */
    lanes slope[INPUT_END - INPUT_FIRST]; /* rate of each input within a communication step, per second; 0 = held */
    lanes memory[MEMORY]; /* of the friction law */
    lanes sign[INDICATORS]; /* +1 or -1: on which side of each event the contact is */
    lanes next_step; /* internal step that the tolerance asks for [s] */
    /* Ends of the last steps [s], a ring, and a bit of each whether an event was there; the first of them that lies
     * less than a cycle back, when a step of this cycle may end there (infinity: none), and since when steps have kept
     * these places [s]. See averaging/breakpoints.c. Empty where an effect looks back. */
    lanes breakpoint_count, breakpoint_next, breakpoint_due, breakpoints_from, breakpoint[BREAKPOINTS];
    uint64_t breakpoint_of_event[LANES];
    /* Where slip and shear angle are solved for, the slip that was last, of the answers that they may have [m/s]; and
     * whether there is one. */
    lanes followed_slip, follows;
    lanes largest_difference; /* what relative_tolerance allows a lower order to change in one step */
    lanes window_start[MEANS]; /* the integrals behind the means when the averaging window opened */
    lanes event_start[MEANS]; /* the same at the last event */
    lanes window; /* averaging windows closed so far */
    double window_origin; /* time at which the first window opened [s] */
    /* How deep the clearance face stood in the surface when WARN_CLEARANCE was set [m]; for which ellipse that was
     * looked at last (see clearance.c). */
    double flank_depth;
    lanes flank_of[FLANK_FACTS];
    lanes cusp,
        cusp_of[2]; /* height of cusps [amplitudes b], and the ellipse it is of: speed ratio, phase (see cusp.c) */
    uint32_t warnings;
    uint32_t started;
    uint64_t effects_on; /* bit n: effect n, since the start */
    uint64_t at_bound[LANES]; /* bit n: input n was given a hair outside its bounds, and is held on them */
    /* averaging = cycle: where the effects' slow states strive to, and the mean forces of the two steps before, at
     * their middles [s] */
    lanes steady_state[EFFECT_STATES];
    lanes earlier_time[2], earlier_force[2][CHANNELS];
    /* and what a bristle does that is bent otherwise at the start of a cycle: share that outlives it, change of each
     * integral over the change of the bristle; for how many steps that has served */
    lanes outlives, changes[INTEGRALS], served;
    /* The forces, one piece for each internal step or for some of them. Empty unless an effect looks back. */
    struct Ring past;
    lanes past_force[HISTORY][CHANNELS][NODES];
    /* The height of the surface that is left [m], likewise, and the largest thickness so far [m]. Empty unless an
     * effect meets it again. */
    struct Ring surface;
    lanes surface_height[HISTORY][NODES], surface_thickest;
    /* Corners of slip_velocity [s], [m/s], a ring, straight in between; and the slip that is felt late or early: at
     * value[VAR_TIME], its slope, and how long that holds [s]. Empty unless an effect delays it. */
    lanes slip_count, slip_first, slip_settled; /* as in struct Ring */
    lanes slip_time[HISTORY], slip_given[HISTORY];
    lanes late_slip, late_slope, late_until;
};

/* What to follow. Inputs are linear between the samples: inputs[sample * input_count + j], or with per_lane nonzero a
 * value for each lane there. keep[sample] nonzero: outputs are wanted at it; keep NULL: at all. */
struct Record {
    int64_t count;
    const double *times;
    int input_count;
    const int *input_index;
    const double *inputs;
    int per_lane;
    const unsigned char *keep;
    double
        most_steps; /* internal steps of a lane over the whole record, beyond which it fails; 0: as many as it takes */
};

/* What to bring back, each may be NULL: rows[(row * output_count + j) * LANES + lane] of the kept samples; their sums,
 * and their squared distances from data[row * output_count + j] (NAN: none there), [j * LANES + lane], added to what
 * stands there. */
struct Yield {
    int output_count;
    const int *output_index;
    double *rows, *sums, *squares;
    const double *data;
    int64_t samples_done, rows_done;
};

/* ---- asking ---- */

int kernel_variable_count(void);
const struct Variable *kernel_variable(int index);
int kernel_state_count(void);
int kernel_state(int place); /* index of the place-th continuous state */
int kernel_derivative_of(int index); /* index of the state whose rate variable `index` is; 0: none */
int kernel_indicator(int place); /* index of the place-th event indicator */
int kernel_law_count(void);
const struct FrictionLaw *kernel_law(int place); /* the order is that of the choice friction_law */
int kernel_effect_count(void);
const struct Effect *kernel_effect(int place);
const char *kernel_stage_name(enum Stage stage);
int kernel_effect_switch(int place); /* index of the effect's Boolean; its parameters follow it */
const char *kernel_status_text(enum Status status);
/* What a status means for this contact: where a combination is at fault, its law, choices and effects, too. */
void kernel_explain(const struct Contact *contact, enum Status status, char *text, size_t size);
/* What a bit of this contact's warnings means, 0 .. WARNING_COUNT-1. */
void kernel_explain_warning(const struct Contact *contact, int bit, char *text, size_t size);
int kernel_averages(const struct Contact *contact); /* averaging = cycle: it shows cycle means, and there is nothing to
                                                       see within a step */
size_t kernel_size(void); /* bytes of a struct Contact */
void kernel_token(char token[39]); /* "{8-4-4-4-12}": a hash over all tables; binds an XML file to its binary */
int kernel_lanes(void);

/* ---- doing ---- */

/* Every value at its start, time 0, nothing running. */
void kernel_reset(struct Contact *contact);
/* One value of one lane, checked: the index exists, the number is finite and within the table's bounds. An input that
 * is a hair outside them is held on them: a warning, and clamped_count counts the steps. */
enum Status kernel_set(struct Contact *contact, int index, int lane, double value);
/* Unchecked, of lane 0: the time, a continuous state that a solver outside leads, an input at the end of its ramp. */
void kernel_lead(struct Contact *contact, int index, double value);
/* The check of kernel_set without the setting; and the hair, in the unit of the variable. */
enum Status kernel_check(int index, double value);
double kernel_bound_slack(int index);
/* What keeps a contact whose bytes come from outside from going on, in words; NULL: nothing. */
const char *kernel_flaw(const struct Contact *contact);
/* Begin at `time` [s]: sides of the events, bristles at rest or in the periodic steady state. */
enum Status kernel_start(struct Contact *contact, double time);
/* Outputs and derivatives from value[VAR_TIME], the states and the inputs as they stand. With averaging = cycle outputs
 * hold the means of the last step. */
enum Status kernel_evaluate(struct Contact *contact);
/* Event indicators at value[VAR_TIME], of order 1 and with a hysteresis; 1 for an event that does not matter at
 * present. kernel_evaluate shows the same as variables. */
void kernel_indicators(const struct Contact *contact, lanes indicator[INDICATORS]);
/* Of which size is a continuous state, as the parameters of lane 0 are? Stiff bristles bend by less than others. */
double kernel_nominal(const struct Contact *contact, int index);
/* Model exchange: the host's integrator has completed a step that ends at value[VAR_TIME]; effects that look back
 * keep it. */
enum Status kernel_step_completed(struct Contact *contact);
/* An event has happened at value[VAR_TIME]: take sides anew, let separated bristles go, close an averaging window that
 * has ended. */
enum Status kernel_event(struct Contact *contact);
/* Has an event turned anything that rates depend on: a side, a memory of the law, a state? A solver then begins anew.
 */
int kernel_turned(const struct Contact *before, const struct Contact *after);
/* Time of the next averaging-window end, of lane 0; infinity where no means are formed. */
double kernel_next_event(const struct Contact *contact);
/* Advance by `step` [s] in internal steps. With stop_at_events nonzero, return at the first contact event before it is
 * acted upon (kernel_event does that), *taken telling how far it went. With averaging = cycle it goes all the way: one
 * cycle stands for the step. */
enum Status kernel_advance(struct Contact *contact, double step, int stop_at_events, double *taken);
/* The same by what kernel_wire has found for this very contact, none of whose parameters has changed since, and from
 * the point that the last such step has reached where time, sides, inputs and deflection still are as they were. To the
 * bit the same. */
struct Wiring;
size_t kernel_wiring_size(void);
void kernel_wire(const struct Contact *contact, struct Wiring *wired);
enum Status kernel_advance_wired(struct Contact *contact, struct Wiring *wired, double step, int stop_at_events,
                                 double *taken);
/* Follow a record from its first sample, where the contact stands, to its last; see struct Record and struct Yield. A
 * nonzero *stop (may be NULL) breaks off after the sample that is being followed. */
enum Status kernel_run_record(struct Contact *contact, const struct Record *record, struct Yield *yield,
                              const volatile int *stop);
/* d unknown / d known of `count` unknowns at the current point, by central differences on a copy. known: inputs and
 * states. */
enum Status kernel_derivatives(const struct Contact *contact, int known, int count, const int *unknown,
                               double *derivatives);
/* d output / dt of `count` outputs of lane 0, at most DERIVATIVES_AT_ONCE, at the present point, as the inputs go on by
 * their slopes. room: where to look around in. */
enum Status kernel_time_derivatives(const struct Contact *contact, struct Contact *room, int count, const int *index,
                                    double *derivatives);

/* ---- what a law and an effect are ---- */

/* One time point of one block: every stage reads what earlier stages wrote. */
struct Point {
    lanes t; /* [s] */
    lanes state[EFFECT_STATES]; /* of the effects, by place */
    /* path: what the ellipse runs with, and the motion of its centre beside the cutting speed */
    lanes a, b; /* amplitudes [m] */
    lanes phase_y; /* [rad] */
    lanes centre_u_x, centre_u_y; /* [m/s] */
    lanes centre_y; /* [m] */
    lanes cos_x; /* x of the vibration over its amplitude */
    lanes raised; /* nominal surface above its mean height [m] */
    lanes left; /* height of the surface that the last revolution left here [m] */
    /* engagement */
    lanes u_x, u_y; /* tool velocity relative to the work [m/s] */
    lanes h; /* uncut thickness [m] */
    lanes approach; /* tool velocity into the chip, normal to the rake [m/s] */
    lanes shear_speed; /* that sets the strain rate: approach, or where only the slip is given the slip speed [m/s] */
    lanes surface; /* indicator AT_SURFACE */
    lanes flank, always; /* 1 where the tool moves back below what stands, and where it never leaves the material */
    lanes contact; /* indicator AT_CONTACT */
    lanes cutting; /* 1 in contact, else 0 */
    lanes speed_ratio; /* HSR = v_c / (a w); infinity without vibration */
    lanes v; /* slip velocity of the chip along the rake [m/s] */
    lanes tan_clearance; /* of clearance_angle; 0: not stated */
    lanes passed; /* share of it that the motion passes on to the contact */
    lanes direction; /* +1 or -1: which way it slips */
    lanes speed; /* |v| [m/s] */
    /* temperature */
    lanes theta_given; /* temperature proxy as its source gives it [m/s] */
    lanes theta; /* temperature proxy [m/s] */
    lanes theta_ratio; /* theta / theta_ref, after the stage */
    /* shear and load */
    lanes tau_s; /* shear stress [Pa] */
    lanes w; /* width of cut [m] */
    lanes k; /* shear load tau_s w h [N] */
    /* of what has kinks, which side is on: of the surface that is met, and of what the effects do, a binary digit each
     * in their order: of those on the path, of those before the bristle, of all; opened where an effect is on */
    lanes surface_piece, path_piece, open_piece, piece;
    lanes edge_p, edge_f; /* forces of the edge and the flank on the tool, beside those of the chip [N] */
    lanes load; /* normal load on the contact: given, or that of a chip without friction [N] */
    lanes distance; /* slid so far [m] */
    /* friction */
    lanes z; /* mean bristle deflection [m] */
    lanes F_C, F_S, v_s; /* [N], [N], [m/s] */
    lanes P; /* stiffness in the rate equation [N/m] */
    lanes s0, s1, sigma2; /* stiffness [N/m], damping and viscous coefficient [N s/m] in the force equation */
    lanes applied; /* external tangential force on the contact, for laws that stick [N] */
    lanes sticking, F_stick; /* 1 where the slip was solved to lie in a jump of the law, and the force within the jump
                                that holds it there [N] */
    lanes solved_slip,
        solved_slope; /* the slip that was solved for last, and how the excess falls with it; NAN: none yet */
    lanes limited; /* 1 where the damping is at its limit, or what is applied to a law that sticks beyond its own */
    lanes margin; /* c in the limit of the damping; infinity: no limit */
    lanes stuck; /* 1 on the sticking side of the law's own event, else 0 */
    lanes law_side; /* the side of it that the contact holds, > 0: sticking */
    lanes rate; /* a in dz/dt = drive - a z [1/s] */
    lanes drive; /* [m/s] */
    lanes target; /* drive / a, also where a = 0 [m] */
    lanes flat_from; /* slip speed from which on the target does not depend on it, as far as the law knows [m/s] */
    lanes dz; /* dz/dt [m/s] */
    lanes beside; /* force along the chip flow beside that of the law [N]; opened where an effect acts on friction */
    lanes most_along, most_against; /* largest force along and against the chip flow that the contact bears [N]; opened
                                       where an effect acts on friction */
    lanes unbounded; /* friction force before these bound it [N]; set with them */
    lanes kept, instead; /* share of the bristle's force that stands, and what stands instead of the rest [N]; opened
                            where an effect acts on the bristle, as is */
    lanes steady; /* the target of the law's own rates, however it or an effect bends them: its deflection in steady
                     sliding; 0: a law without one, or out of contact [m] */
    lanes law; /* indicator AT_LAW */
    lanes clamped; /* how many values had to be clamped */
    lanes F; /* friction force on the tool along the chip flow [N] */
    /* forces: in the order of their impulses in the base table, so that sums of them are taken side by side */
    lanes F_p, F_f, N;
    lanes P_f, P_s; /* power that friction takes up on the rake face, and that shears the chip [W] */
    lanes beside_N; /* normal force beside that of the shear plane [N] */
    lanes outside; /* 1 where the force lies outside the domain of the shear-angle principle */
    /* measurement */
    lanes measured[CHANNELS]; /* friction, principal and feed force as a dynamometer shows them [N] */
    const struct Past *past; /* where an effect that looks back finds earlier forces; the first that is no lane */
    const struct Configuration *configuration; /* what points have in common, for who asks forces.c; while it opens */
    uint32_t warnings;
};

/* A friction law: dz/dt = drive - rate z and F(z, dz/dt). p: the values of its own table. */
struct FrictionLaw {
    const char *meaning, *equation, *source; /* its name is its place in the choice friction_law */
    const char *reads; /* parameters and inputs of the base table in its equation, comma-separated, beside the slip */
    const struct Variable *variables; /* may be NULL */
    int count;
    int has_static; /* it reads F_S, which else is F_C wherever the size of its friction is asked for */
    /* F_C and F_S in place of those of the base table, from the load, before the effects act, and again where these
     * have raised friction, by so much; may be NULL */
    void (*level)(const lanes *p, const lanes raised, struct Point *x);
    /* Is its target, in this lane, as smooth in the slip speed as e^-(v/v_s)^2? NULL: nobody says so. */
    int (*smooth)(const lanes *p, int lane);
    void (*prepare)(const lanes *p, struct Configuration *w); /* what follows from parameters alone; may be NULL */
    int relaxes; /* z strives for target at rate; else it integrates drive */
    void (*rates)(const lanes *p, struct Point *x); /* rate, drive, target from v, direction, speed, stuck */
    /* Does the rate depend on the deflection, in this lane? And how: rate, drive, target linearised at z. Solved by
     * iteration; both NULL where it does not. An effect that bends the rate itself takes their place in lanes where it
     * is not at its neutral values (Configuration.yielding). */
    int (*yields)(const lanes *p, int lane);
    void (*yield)(const lanes *p, struct Point *x);
    void (*force)(const lanes *p, struct Point *x); /* F from z, dz and the same */
    /* The law's own event, all NULL where it has none: its indicator (> 0 is the sticking side), what happens at it,
     * and the memory of an unloaded contact. */
    void (*indicator)(const lanes *p, const lanes *memory, struct Point *x);
    void (*event)(const lanes *p, const struct Point *x, lanes z, lanes *memory);
    void (*rest)(const lanes *p, const struct Point *x, lanes *memory);
};

/* What moves an effect's states: nothing (it has none), the motion (path, slip, temperature), the motion before the
 * states say how much of it reaches the contact, the forces, which feed back within the step, or what is measured. */
enum Driver { NO_STATES, DRIVEN_BY_MOTION, DRIVEN_BY_APPROACH, DRIVEN_BY_FORCE, DRIVEN_BY_SENSOR };

/* A switchable effect. variables[0] is its Boolean switch and says name, meaning and source; then come its parameters,
 * named
 * "<effect>.<parameter>", then its states, then their rates in the same order. p: the values of its table; state, rate:
 * its states. */
struct Effect {
    const char *equation, *signature; /* the law, and what it does to a record */
    const char *family; /* of effects that a record can hardly tell apart: one word, as in a textbook's index */
    const char *rivals; /* names, comma-separated, of which at most one may be on; may be NULL */
    const char *special_cases; /* names of effects that it comes to where its own part is out of sight; may be NULL */
    const char *needs; /* inputs without which it says nothing, comma-separated; may be NULL */
    const char *applies_to; /* the kinematics in which it happens, comma-separated, and inputs whoever gives which has
                               it in every kinematics; NULL: it may happen anywhere */
    int unsteady; /* it goes by the time or the way itself: no mean under it is one of a steady state */
    int irreversible; /* what it has changed stays so: the next recording of a specimen begins where this one ends */
    int keeps_mean; /* a filter or a delay, which a mean over a steady state passes as it is */
    int form_of_law; /* friction laws differ in it among themselves, so a little of it is no effect */
    enum Stage stage;
    const struct Variable *variables;
    int count, states;
    enum Driver driver;
    int bends; /* it makes the rate of the bristle depend on the deflection: solved by iteration */
    int forgets; /* states are 0 again after separation */
    int settles; /* initial_state = steady: they begin where a motion as at the start leads in the end */
    /* What follows from parameters alone: worked out once for a call, into the configuration; may be NULL. */
    void (*prepare)(const lanes *p, struct Configuration *w);
    /* What its states are where the bristle is bent at the start, and nothing says what they are; may be NULL. */
    void (*begin)(const lanes *p, const struct Point *x, lanes *state);
    /* Add to or scale fields of its stage. */
    void (*act)(const lanes *p, const lanes *state, struct Point *x);
    /* States from the start of a step of h to its middle and end; and their rates at a point. For a given drive affine
     * in the states, and right for any h, but where it forgets: averaging leads them over many cycles by it. */
    void (*move)(const lanes *p, const lanes h, const struct Point *start, const struct Point *middle,
                 const struct Point *end, const lanes *from, lanes *half, lanes *whole);
    void (*rate)(const lanes *p, const struct Point *x, const lanes *state, lanes *rate);
    /* Longest internal step that resolves what it does, and how far back it recalls forces [s]; may be NULL. */
    double (*longest_step)(const lanes *p, int lane);
    /* Of what comes back with a state: how many periods lie between two states? A step does not pass a part of one
     * that its three points could not tell from another; may be NULL. */
    double (*periods)(const lanes *p, const lanes *from, const lanes *to, int lane);
    double (*looks_back)(const lanes *p, int lane);
    /* Which way the contact slips over a step between two states [m], of an effect that passes the motion on in a part
     * of the way that the points of the step may not show; `seen` [m] is the way by those points, and the answer where
     * there is no such part; may be NULL. */
    double (*slip_way)(const lanes *p, double h, const struct Point *start, const struct Point *middle,
                       const struct Point *end, const lanes *from, const lanes *to, double seen, int lane);
    /* By how much the slip comes later than its input [s], below 0: earlier; may be NULL. */
    double (*delays)(const lanes *p, int lane);
    /* Of a sensor: do its states follow the forces late? NULL: it has none. */
    int (*remembers)(const lanes *p, int lane);
    /* After which time it meets the surface that is left now [s]; may be NULL. */
    double (*meets_again)(const lanes *p, int lane);
};

#endif
