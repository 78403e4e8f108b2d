/* Which steps lead from a time to the forces? The stages of one time point, in their order, and the wiring they share.
 */
#ifndef STAGES_H
#define STAGES_H

#include "elementary.h"
#include "kernel.h"
#include "registry.h"

#include <math.h>

/* Lanes do not touch each other: a compiler may take them side by side. */
#if LANES > 1 && defined(__clang__)
#define EACH_LANE                                                                                                      \
    _Pragma(                                                                                                           \
        "clang loop vectorize(assume_safety) vectorize_width(LANES) interleave_count(1) unroll(disable)") for (int i = \
                                                                                                                   0;  \
                                                                                                               i <     \
                                                                                                               LANES;  \
                                                                                                               ++i)
#else
#define EACH_LANE for (int i = 0; i < LANES; ++i)
#endif

/* On a line of the cache of its own: wide vectors that lie across two cost twice. */
#if LANES > 1 && defined(__GNUC__)
#define ON_LINES __attribute__((aligned(64)))
#else
#define ON_LINES
#endif

/* Part of each caller, in other files, too: what is called at each point costs a twentieth of a step in calls. */
#if defined(__GNUC__)
#define INLINED inline __attribute__((always_inline))
#else
#define INLINED
#endif

/* What an ellipse leaves that does not change from cycle to cycle; see path.c. Heights in amplitudes b. */
struct Turn {
    lanes r, lead, aspect; /* of the ellipse: speed ratio, phase of y where the tool is fastest, b / a */
    lanes cos_lead, sin_lead;
    lanes last, bend; /* where it stops moving forward: last = acos(-r), and bend = sin(last), of r < 1; else 0 */
    lanes shape[4];   /* of the way to there, see from_the_end() */
    lanes alone; /* 1 where only the stroke of the cycle before may have left what is cut, else 0 */
    lanes begins, fastest; /* angles at which it begins to move into the material, and does so fastest */
    lanes valley_forward, valley_backward; /* places of the lowest points of both strokes; NAN: none within it */
    lanes dips; /* lowest height at which the backward stroke may go below what stands; infinity: it does not */
    lanes always; /* 1 where it moves into the material throughout, though it turns back */
};

/* What a run of points has in common: which law and effects are on, found once per call. */
struct Configuration {
    const lanes *p;                 /* the base table's values */
    const struct FrictionLaw *law;
    const lanes *law_p;
    const struct Effect *on[EFFECT_COUNT];    /* effects that are on, */
    const lanes *on_p[EFFECT_COUNT];          /* their parameters, */
    int on_state[EFFECT_COUNT];               /* the place of their first state in struct Point, */
    int on_value[EFFECT_COUNT];               /* and its index in the table */
    int on_count;
    int stages;                     /* bit n: an effect acts in stage n */
    int drivers;                    /* bit n: states of an effect are driven by enum Driver n; */
    int acting[LANES];              /* the same, of effects that are not at their neutral values in a lane; */
    int levelled[LANES], bent[LANES]; /* does such an effect act on friction, and one, or the law, bend the rate? */
    int keeps_past[LANES];          /* does such an effect look back, or meet the surface again? */
    int sensors;                    /* effects with states of a sensor */
    int looks_back, bends, meets_again; /* whether an effect does; */
    int yields;                     /* and the law, */
    int yielding[LANES];            /* in lanes where no effect acts that bends it in its own way */
    int comes_back;                 /* whether one has periods */
    int delays;                     /* the slip is given, and one delays it */
    const struct Record *record;    /* that is being followed and gives the slip, by its column; else NULL */
    int slip_column;
    int feedback;                   /* forces move the path within a step */
    int iterates;                   /* one pass over a step does not do, */
    int iterated[LANES];            /* in these lanes */
    int rises; /* an input has a slope */
    int held; /* external kinematics, no input changes, no effect moves: nothing but the bristle does */
    enum Kinematics kinematics; /* the choices are fixed, and the same in all lanes of a block: */
    enum ProxySource proxy_source;
    int by_energy;
    char dissipative, thermal_rate;
    char current_angle; /* chip_flow_angle = current_shear_angle: slip and force are solved together */
    lanes longest; /* internal step that resolves vibration and effects [s] */
    lanes
        finer; /* times as many steps as at the usual tolerance: its fourth root over relative_tolerance, 1 at least */
    lanes tighter; /* relative_tolerance over the usual one, 1 at most */
    lanes flat_share, damping_room; /* of lugre.c: slip without static friction over v_s; how much damping dissipates */
    lanes decayed, root_decayed; /* x from which on e^-x is less than the tolerance asks for, and its root */
    lanes cycle; /* place in the vibration cycle at value[VAR_TIME], 0..1 */
    double ends; /* of the communication step [s]; NAN: points there need not stand as the next one begins */
    lanes cycle_then; /* place in the cycle at its end, to the bit as the next one begins there */
    lanes cos_rake, sin_rake;
    lanes tan_clearance;
    lanes cos_x, sin_x, cos_y, sin_y; /* of the phases */
    struct Turn turn; /* at the speed ratio that holds at value[VAR_TIME] */
    int turns_alike; /* no input and no effect changes the ellipse: turn is that of all points */
    lanes tan_flow; /* of chip_flow_shear_angle - rake_angle */
    lanes cot_flow; /* of chip_flow_shear_angle, where the slip is given */
    lanes bound_along, bound_against; /* of friction on the rake face over the shear load, where an effect has one; */
    lanes tan_flattest, tan_steepest; /* of the bounds of the current shear angle, less rake_angle */
};

/* configuration.c */
/* Effects whose switch is on: bit n for effect n. They are fixed at the start. */
uint64_t effects_switched_on(const struct Contact *contact);
struct Configuration wire(const struct Contact *contact);
void wire_time(const struct Contact *contact, struct Configuration *w);
void wire_step(double step, struct Configuration *w);

/* effects.c: let the effects of a stage act; move the states of one driver over a step; show states and their rates;
 * the longest step that resolves what is on. */
void act(const struct Configuration *w, enum Stage stage, struct Point *x);
enum Driver driver_of(const struct Configuration *w, const struct Effect *effect);
void move_states(const struct Configuration *w, enum Driver driver, const lanes h, const struct Point *start,
                 struct Point *middle, struct Point *end);
/* Does an effect act on what is measured? Else that is the forces, as open_measured() has it. */
static inline int measures(const struct Configuration *w) { return w->stages >> STAGE_MEASUREMENT & 1; }
void open_measured(struct Point *x);
void measure(const struct Contact *contact, const struct Configuration *w, struct Point *x);
void measure_step(const struct Contact *contact, const struct Configuration *w, const lanes h,
                  const struct Point *start, struct Point *middle, struct Point *end);
void load_states(const struct Contact *contact, const struct Configuration *w, struct Point *x);
void store_states(struct Contact *contact, const struct Configuration *w, const struct Point *x);
void store_state_of(struct Contact *contact, const struct Configuration *w, const struct Point *x, int lane);
void show_rates(struct Contact *contact, const struct Configuration *w, const struct Point *x);
void forget_states(struct Contact *contact, const struct Configuration *w, int lane);
void lead_states(const struct Configuration *w, enum Driver driver, const lanes ahead, struct Point *x);
void resolving_step(const struct Configuration *w, lanes longest);
double look_back(const struct Configuration *w, int lane);
/* The most periods of an effect that lie between two points. */
double periods_between(const struct Configuration *w, int lane, const struct Point *from, const struct Point *to);
int sensors_that_remember(const struct Configuration *w, int lane);
double meeting_time(const struct Configuration *w, int lane);
/* A step of h from t, shortened to where a jump of the past is recalled; and how much a step's recalled forces bend. */
double until_late_jump(const struct Contact *contact, const struct Configuration *w, int lane, double t, double h,
                       const struct Point *start);
double late_bend(const struct Contact *contact, const struct Configuration *w, int lane, const struct Point *a,
                 const struct Point *m, const struct Point *b);
/* Are two of the effects of these bits rivals of each other? The first such pair, by place. */
int rivals_among(uint64_t on, int pair[2]);

/* history.c: where the forces before a point are found: in the contact's ring, and in the step that is being taken
 * (NULL: none). */
struct Past {
    const struct Contact *contact;
    const struct Configuration *w;
    const struct Point *start, *middle, *end;
};
void remember(struct Contact *contact, const struct Configuration *w, int lane, double h, const struct Point *start,
              const struct Point *middle, const struct Point *end);
void remember_host_step(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *x);
/* Nothing is known of the forces before: what is felt first has been so for ever. */
void forget_past(struct Contact *contact, int lane);
/* The chip's forces, as channels are measured, at time t <= x->t; before all that is known, the first that is known. */
void recall(const struct Past *past, const struct Point *x, int lane, double t, double force[CHANNELS]);
/* The first time in (from, to) at which the forces of the past have jumped, up to the step that begins with start; else
 * infinity. */
double recall_jump(const struct Contact *contact, const struct Configuration *w, int lane, const struct Point *start,
                   double from, double to);
/* The height that the tool leaves over a step, or a host's step that ends at x; what was left at t; the first time in
 * (from, to) at which that jumps, or begins. */
void leave_surface(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *start,
                   const struct Point *middle, const struct Point *end);
void leave_surface_here(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *x);
double surface_left(const struct Contact *contact, const struct Configuration *w, int lane, double t);
double surface_jump(const struct Contact *contact, const struct Configuration *w, int lane, double from, double to);
/* Is all still there that effects look back to at t? */
int past_reaches(const struct Contact *contact, const struct Configuration *w, int lane, double t);

/* ring.c: a count in bytes that may come from outside; and the first of the places low..high of a ring whose time
 * lies after t, or with `at` set at t or after, high where none does. */
int64_t whole_count(double count);
int64_t first_later(const lanes *times, int lane, int64_t low, int64_t high, double t, int at);

/* late_slip.c: a corner of slip_velocity; the one that stands in the contact; the part of it that a lane feels at s
 * after value[VAR_TIME], in late_slip, late_slope and late_until; that of all lanes at value[VAR_TIME]; how far ahead
 * any of them feels it [s]. */
void note_slip(struct Contact *contact, const struct Configuration *w, int lane, double t, double v);
void note_slip_now(struct Contact *contact, const struct Configuration *w);
enum Status feel_slip(struct Contact *contact, const struct Configuration *w, int lane, double s);
enum Status feel_slip_now(struct Contact *contact, const struct Configuration *w);
double slip_lead(const struct Configuration *w, int lane);

/* linear_response.c: exact answers of linear states to a drive that is a parabola over the step, through u at start,
 * middle and end. first_order_response: dy/dt = (u - y)/T after half and whole of h; second_order_responses: d2y/dt2 =
 * w^2 (u - y) - 2 zeta w dy/dt for y and its rate. */
void first_order_response(const lanes h, const lanes T, const lanes u_0, const lanes u_m, const lanes u_1,
                          const lanes y, lanes half, lanes whole);
enum { OF_PLACE, OF_SPEED };
struct Oscillators { /* two of one frequency and damping */
    lanes start[2], middle[2], end[2]; /* u of each, */
    lanes at[2][2]; /* and its place and speed at the start */
};
void second_order_responses(const lanes h, const lanes w, const lanes zeta, const struct Oscillators *oscillators,
                            lanes half[2][2], lanes whole[2][2]);
/* The same of a sensor: what stands for the middle gives the mean by Simpson's rule. */
void first_order_response_in_mean(const lanes h, const lanes T, const lanes u_0, const lanes u_m, const lanes u_1,
                                  const lanes y, lanes half, lanes whole);
void second_order_responses_in_mean(const lanes h, const lanes w, const lanes zeta, const struct Oscillators *o,
                                    lanes half[2][2], lanes whole[2][2]);

/* path.c: r = v_c / (a w), the phase of y where the tool is fastest, b / a; and beyond that where angles are sought
 * from, of an ellipse that is asked for many. */
void turn_at(const struct Configuration *w, double r, double lead, double aspect, struct Turn *turn, int lane);
void shape_at(struct Turn *turn, int lane);
/* path.c: places of the lowest points of both strokes; and the lowest height that any stroke has left at a place. */
void valleys_at(struct Turn *turn, int lane);
double lowest_left(const struct Turn *turn, int lane, double begun, double place, double ends);
/* path.c: u, h, approach, slip, the path's indicators, at `tau` [s] after value[VAR_TIME]; uses the states in x. */
void path_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);
/* path.c: which part of the slip reaches the contact. */
void pass_on(const struct Configuration *w, struct Point *x);
/* path.c: chip slip along the rake; tan_flow: of the shear angle less the rake angle. */
double slip_along_rake(const struct Configuration *w, const struct Point *x, int lane, double tan_flow);

/* clearance.c: where a clearance angle is stated, warn if the clearance face stands in the surface that the ellipse
 * leaves with which x runs. That takes up to half a millisecond, and is done where the ellipse is another one than last
 * time. */
void look_at_flank(struct Contact *contact, const struct Configuration *w, const struct Point *x);

/* cusp.c: the height of the cusps that the ellipse leaves with which x runs. Up to a quarter of a millisecond where
 * that is another one than last time and not upright. */
void show_cusps(struct Contact *contact, const struct Configuration *w, const struct Point *x);

/* friction.c: theta as its source gives it. */
void proxy_open(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);

/* forces.c: the shear load, once theta is known. */
void load_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);

/* friction.c: open the law's fields (theta, F_C, ...), and what follows from z. */
void friction_open(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);
void friction_rates(const struct Configuration *w, struct Point *x);
void friction_force(const struct Configuration *w, struct Point *x);
/* friction.c: open and rates together, with the slip solved from its own shear angle; the search begins anew after
 * a separation, else goes on with the slip that was solved for last. */
void recall_slip(const struct Contact *contact, struct Point *x);
void friction_solved(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);

/* forces.c: the normal force over the shear load, F being friction over it, and how it rises with F; and the friction
 * over the shear load that is mu times its own normal force, along the chip flow (side 1) or against it (-1). */
double normal_of(const struct Configuration *w, double F, int lane, double *slope);
double friction_of(const struct Configuration *w, double mu, double side, int lane);
/* forces.c: normal, principal and feed force from F and k; and the shear angle that goes with them. */
void forces_at(const struct Configuration *w, struct Point *x);
double shear_angle(const struct Configuration *w, const struct Point *x, int lane);

/* point.c: all stages at tau; z and states given in x for the first three, taken from the contact by point_at. engage:
 * motion and theta; open: up to the rates; bend: the rates anew, of all that was opened what goes by z within a step;
 * close: the rest. passing: a point within a step, whose outputs nobody looks at. */
void engage_point(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);
void engage_step(const struct Contact *contact, const struct Configuration *w, const lanes h, const lanes half,
                 const lanes whole, const struct Point *start, struct Point *middle, struct Point *end);
void open_point(const struct Contact *contact, const struct Configuration *w, const lanes tau, int passing,
                struct Point *x);
void bend_point(const struct Configuration *w, struct Point *x);
void close_point(const struct Contact *contact, const struct Configuration *w, int passing, struct Point *x);
void point_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x);
/* point.c: sides of the events. */
void indicators(const struct Configuration *w, const struct Point *x, lanes indicator[INDICATORS]);
int watched(const struct Contact *contact, int k, int i);
/* point.c: what a law remembers where each contact begins, alike and by no level of the moment: it must not hang on
 * when this is asked. */
void rest_law(const struct Configuration *w, lanes *memory);
void let_go(struct Contact *contact, const struct Configuration *w);
void settle_sides(struct Contact *contact, const struct Configuration *w, const lanes tau, const lanes ahead,
                  const int chased[LANES], struct Point *x);
void act_on_event(struct Contact *contact, const struct Configuration *w, const lanes tau, const lanes ahead,
                  const int chased[LANES], struct Point *x);

/* step.c: one trial step of h[i] from s[i]: fills middle and end from start; `difference` is what a lower order would
 * have changed. Where forces move the tool, passes begin with what is known of their feedback, and leave there what
 * they have found; NULL: nothing is, and nobody asks. try_alike: where slip is held, and middle and end are the start's
 * already but for what goes by the bristle. */
struct Feedback;
void try_step(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
              const struct Point *start, struct Feedback *known, struct Point *middle, struct Point *end,
              lanes difference);
void try_alike(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
               const struct Point *start, struct Feedback *known, struct Point *middle, struct Point *end,
               lanes difference);

/* step.c: the same way in two halves of step[i], beside the step that middle and end are of. Where a time alone says
 * what the rates are there, they are those that stand in middle and end, and only the quarters are new. */
void try_halves(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes step,
                const struct Feedback *known, const struct Point *start, const struct Point *middle,
                const struct Point *end, struct Point *early, struct Point *half, struct Point *late,
                struct Point *whole);

/* anderson.c: passes over a step, by the forces (friction, principal, feed; at middle and end) that each begins with
 * and misses. begin_passes: middle and end where the predicted forces would move them, or those of the start;
 * note_pass: what a pass has led to, which is as good as it has to be where it misses no more than will_do [N];
 * begin_pass: where the next one begins. */
enum { PASSED_FORCES = 2 * CHANNELS, DIFFERENCES = 3 };
/* What is known before the passes over a step: the forces, and what came back of which differences between forces in
 * another step. */
struct Feedback {
    lanes force[PASSED_FORCES];
    lanes predicted; /* 1 where the forces are */
    lanes begun[DIFFERENCES][PASSED_FORCES], returned[DIFFERENCES][PASSED_FORCES]; /* [N], and by that step [N/s] */
    lanes count; /* of differences */
    int first_may_do; /* a first pass is enough where little of what it misses comes back */
};
enum { FEEDBACK_LANES = offsetof(struct Feedback, first_may_do) / sizeof(lanes) };
/* At start, middle and end of a step of some length; and predicted from them, at these shares of it. */
struct StepForces {
    lanes length, at[3][CHANNELS];
};
void note_forces(double length, const struct Point *a, const struct Point *m, const struct Point *b, int lane,
                 struct StepForces *forces);
void predict_forces(const struct StepForces *forces, double at_middle, double at_end, int lane, struct Feedback *known);
struct Passes {
    lanes begun[PASSED_FORCES];
    lanes from[PASSED_FORCES], missed[PASSED_FORCES], miss; /* of the pass that stands, and the most that it misses */
    lanes by_from[DIFFERENCES][PASSED_FORCES], by_missed[DIFFERENCES][PASSED_FORCES]; /* between passes */
    int mixes; /* friction has bristles, and does not jump */
    lanes share; /* of what is missed that the next one follows */
    int count[LANES]; /* of differences */
    int first[LANES]; /* none has been made yet */
    int astray[LANES]; /* the last one does not stand */
};
void begin_passes(const struct Configuration *w, const lanes h, const struct Point *start, const struct Feedback *known,
                  struct Point *middle, struct Point *end, struct Passes *p);
void note_pass(const lanes will_do, struct Point *middle, struct Point *end, struct Passes *p);
void begin_pass(const struct Configuration *w, const lanes h, const struct Point *start, struct Point *middle,
                struct Point *end, struct Passes *p);
/* What comes back of a force in a step of h, by the newest difference; infinity where none is known. */
double loop_gain(const struct Feedback *known, double h, int lane);
void note_feedback(const struct Passes *p, double h, int lane, struct Feedback *known);

/* tolerance.c: is the step within the tolerance? Chooses each lane's next step; where it is not, fits says in which
 * lanes it is, and the others' next step is the shorter one to try again with; a step of `shortest` is taken as it is.
 */
int accurate(const struct Contact *contact, const struct Configuration *w, double shortest, const lanes h,
             const struct Point *start, const struct Point *middle, const struct Point *end, const lanes difference,
             lanes next, int fits[LANES]);

/* relative_tolerance at its start: what is said in steps or shares of a cycle is said of it. */
#define USUAL_TOLERANCE 1e-4

/* shown_curve.c: in which of the lanes that are asked do they show all that the law's own curve does between them?
 * There the next step may be as long as they would show it, too. */
void show_curve(const struct Configuration *w, const lanes h, const struct Point *a, const struct Point *m,
                const struct Point *b, const int asked[LANES], lanes next, int shown[LANES]);
/* step_doubling.c: in which lanes may start, middle and end not show what lies between them? And there, how far the end
 * of the step is from that of its two halves, in units of the tolerance; 0 elsewhere. tolerance.c: are these steps,
 * too, within the tolerance? As accurate(). */
int in_doubt(const struct Contact *contact, const struct Configuration *w, const lanes h, const struct Point *a,
             const struct Point *m, const struct Point *b, lanes next, int doubtful[LANES]);
void step_doubling_error(const struct Contact *contact, const struct Configuration *w, double shortest,
                         const int doubtful[LANES], const struct Feedback *known, const lanes s, const lanes h,
                         const struct Point *a, const struct Point *m, const struct Point *b, lanes error);
int accurate_in_halves(const struct Contact *contact, const struct Configuration *w, double shortest,
                       const struct Feedback *known, const lanes s, const lanes h, const struct Point *start,
                       const struct Point *middle, const struct Point *end, const int doubtful[LANES], lanes next,
                       int fits[LANES]);

/* event_search.c: does a lane see an event, by the signs at middle and end? And does any, or may it have touched the
 * work in between? Most steps see none, and need not ask each lane. */
int sees_event(const struct Contact *contact, const struct Configuration *w, int lane, const struct Point *start,
               const struct Point *middle, const struct Point *end);
int shows_slip_event(const struct Contact *contact, const struct Configuration *w, int lane, const struct Point *early,
                     const struct Point *late);
int any_event(const struct Contact *contact, const struct Configuration *w, const struct Point *start,
              const struct Point *middle, const struct Point *end);
/* event_search.c: does an event fall into the step? In the lanes that are asked, and say NO_EVENT before: if so h is
 * shortened to it and `cut` says which; JUMP: it has happened already, before the start; `acted`: which has been acted
 * on and has changed nothing; `wait`: after how long a contact that was passed over so is looked at again [s]. The
 * event `known` to lie at the end is passed over. cut_at_touch: the same of one lane
 * for a contact that start, middle and end do not show. */
enum Cut { NO_EVENT = -1, JUMP = -2 };
void cut_at_events(const struct Contact *contact, const struct Configuration *w, const int asked[LANES],
                   const int known[LANES], const int acted[LANES], const lanes wait, const lanes s, lanes h,
                   const struct Point *start, const struct Point *middle, const struct Point *end, int cut[LANES]);
void cut_at_touch(const struct Contact *contact, const struct Configuration *w, int lane, const lanes s, lanes h,
                  const struct Point *start, const struct Point *middle, const struct Point *end, int cut[LANES]);

/* events.c: act_on_event in the lanes where `event` is set. act_at_step_end: with a slip that is solved for, the law's
 * own events are acted upon at the end of each step, in the lanes that have stepped and have no event of their own. */
void act_in_lanes(struct Contact *contact, const struct Configuration *w, const lanes s, const lanes ahead,
                  const int chased[LANES], const int event[LANES], struct Point *x);
void act_at_step_end(struct Contact *contact, const struct Configuration *w, const lanes h, const int event[LANES],
                     const struct Point *end);
void take_law_side(struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                   const int event[LANES], struct Point *x);

/* breakpoints.c: how far ahead of s does the end of a step of the cycle before
 * lie, a cycle on, at which this one may aim (infinity: none)? Is it of an event? The step of h that has ended at t as
 * one for the next cycle. BY_TOLERANCE: after a longer one was tried. */
enum Ended { ENDED_ELSEWHERE, BY_TOLERANCE, AT_NEW_EVENT, AT_EVENT_AS_BEFORE };
void begin_breakpoints(struct Contact *contact, const struct Configuration *w, int lane);
void look_for_breakpoints(const struct Contact *contact, const struct Configuration *w, const lanes s,
                          lanes breakpoint);
int aims_at_event(const struct Contact *contact, int lane);
void note_breakpoint(struct Contact *contact, const struct Configuration *w, int lane, double t, double h,
                     enum Ended ended);
/* A cycle begins at value[VAR_TIME] that is like the one which was run last, wherever that lay: steps of this one may
 * end where those did. What is known of cycles, to another contact. */
void repeat_breakpoints(struct Contact *contact, const struct Configuration *w, int lane);
void copy_breakpoints(struct Contact *to, const struct Contact *from, int lane);

/* advance.c: from value[VAR_TIME] on by `step`, s telling how far it went; the point reached is room[now],
 * where known. */
struct ZenoGuard {
    double length, begun; /* of a stretch of time [s], and when it began; length 0: none has */
    double taken, most; /* steps in it */
    double events, most_events; /* a cycle has a dozen; forces that chase one another have no end of them */
    double breaks, most_breaks; /* events of the law alone, which break bonds */
};
/* zeno_guard.c: begin or go on with a stretch; is the step that begins at s, the n-th of this communication step, one
 * too many? */
void guard_stretch(const struct Contact *contact, const struct Configuration *w, struct ZenoGuard *p);
int is_without_end(const struct Contact *contact, struct ZenoGuard *p, double step, const lanes s, double n);
struct Course {
    struct Room {
        ON_LINES struct Point point;
    } room[3];
    lanes window_end; /* as window_end(), where known */
    int now, known;
    int arrived; /* the point reached stands at the end of the communication step, to the bit */
    int alike; /* where one is known: all of room is alike but for what goes by the bristle */
    double most_steps; /* internal steps that may still be taken, 0: as many as it takes */
    struct ZenoGuard guard;
};
enum Status advance_internal(struct Contact *contact, const struct Configuration *w, double step, int stop_at_events,
                             lanes s, struct Course *course);
/* cycle_jump.c: the same, but for cycles that would be the last one over again. */
enum Status advance_cycles(struct Contact *contact, const struct Configuration *w, double step, int stop_at_events,
                           lanes s, struct Course *course);
/* communication_step.c: time and inputs, s later. */
void move_on(struct Contact *contact, const lanes s);
/* event_search.c: the motion at tau, and where the forces move the path or `forces` asks for them all of the point,
 * reached from s by a step on the held sides. */
void point_within(const struct Contact *contact, const struct Configuration *w, int forces, const lanes s,
                  const lanes tau, const struct Point *start, struct Point *x);

/* contact_search.c: does a lane that is out of contact touch the work within its step of h from s, where start, middle
 * and end do not show it? If so then not yet at tau[0] but at tau[1], as the indicators there say. A contact may be
 * missed below 1e-4 of a cycle. */
int touches_within(const struct Contact *contact, const struct Configuration *w, int lane, double s, double h,
                   const struct Point *start, const struct Point *middle, const struct Point *end, double tau[2],
                   double indicator[2]);

/* evaluate.c: the point x as outputs, derivatives and indicators; shear angle and cusps, which are dear, only with
 * `angles`. */
void show_outputs(struct Contact *contact, const struct Configuration *w, const struct Point *x, int angles);
/* evaluate.c: are these outputs fields of a point? show_some: then only these of them, and warnings. */
int shows_plainly(int count, const int *index);
void show_some(struct Contact *contact, const struct Point *x, int count, const int *index);
/* evaluate.c: is every output and every rate that the contact shows a finite number? Else it has diverged. */
enum Status shows_finite(const struct Contact *contact, const struct Configuration *w);
/* evaluate.c: the contact's warnings at x. */
void warn(struct Contact *contact, const struct Point *x);
/* evaluate.c: show the point at value[VAR_TIME], with sides as the inputs say; but the point `passed`, where not NULL,
 * in the lanes in which it is whole. */
enum Status show_here(struct Contact *contact, const struct Configuration *w, const struct Point *passed,
                      const int whole[LANES], int angles);

/* mean_window.c: length and end [s] of the present averaging window, 0 and infinity where no means are formed. */
/* registry.c: the running integrals, those behind the means last and in their order; mean_window.c: the means. */
enum { FIRST_MEAN_INTEGRAL = INTEGRALS - MEANS };
extern const int integral_of[INTEGRALS];
extern const int mean_of[MEANS];
double window_length(const struct Contact *contact, int i);
/* mean_window.c: the windows that end while all means stand at the rates `mean` from `begin` to value[VAR_TIME]. */
void pass_windows(struct Contact *contact, int i, double begin, const double mean[MEANS]);
/* A host's time lies beside the end of a window by roundings, which add up over many steps. That window ends with its
 * step: its mean is of so much less than is asked for. */
#define BESIDE_WINDOW 1e-6 /* of it, and of the step */
double window_end(const struct Contact *contact, int i);
void forms_means(const struct Contact *contact, int forms[LANES]); /* is there a window? */
void open_window(struct Contact *contact, int i);
void close_window(struct Contact *contact, int i);
void skip_windows(struct Contact *contact, const struct Configuration *w, double step);
void return_to_window(struct Contact *contact);
/* mean_window.c: the integrals since the last event, which a solver outside leads. They are shown as the integrals say;
 * where one of them, the variable `index`, has been led, the integral follows it; at an event they begin anew. */
void show_recent(struct Contact *contact);
void follow_recent(struct Contact *contact, int index, int lane);
void begin_recent(struct Contact *contact);
int recent_of(int index); /* the state behind an integral; of another variable the variable itself */

/* lifecycle.c: whether an input is given a hair outside its bounds, in one lane. */
void note_bound(struct Contact *contact, int index, int lane, int outside);

/* lifecycle.c: what relative_tolerance allows a lower order to change in one step. */
double largest_difference(const struct Contact *contact, int lane);

/* evaluate.c: reference above ambient, where the proxy is a temperature. */
int ordered_temperatures(const struct Contact *contact);

/* average.c: averaging = cycle: begin at value[VAR_TIME]; go on by `step` at the cost of a cycle or two; show the means
 * of the present inputs. */
enum Status average_start(struct Contact *contact);
enum Status average_step(struct Contact *contact, double step);
enum Status average_here(struct Contact *contact);
/* slow_states.c: states of effects that outlive a cycle, by place as in struct Point. Where they strive to
 * (contact->steady_state), from what a cycle makes of them; what they are after h, striving there; get_slow_states says
 * how many there are. The sensors are left out: they hear mean forces, over a step or since ever, and show means. */
uint64_t sensors_on(const struct Contact *contact);
int get_slow_states(const struct Contact *contact, const struct Configuration *w, lanes *state);
void set_slow_states(struct Contact *contact, const struct Configuration *w, const lanes *state);
void find_steady_states(struct Contact *contact, const struct Configuration *w, double period, const lanes *from,
                        const lanes *after);
void slow_states_after(const struct Contact *contact, const struct Configuration *w, double h, const lanes *from,
                       lanes *to);
void settle_sensors(struct Contact *contact, double period, const lanes *force);
/* What the states of the n-th effect that is on make of each other within h, moved by nothing else: M[after][before].
 */
void own_slopes(const struct Configuration *w, int n, double h, lanes M[EFFECT_STATES][EFFECT_STATES]);
/* initial_state = steady: what lags or remembers stands where a motion and a force as those at the start lead to. */
enum Status settle_states(struct Contact *contact);
void measured_now(struct Contact *contact, const lanes *force, lanes *measured);
enum Status measure_means(struct Contact *contact, double step, const lanes *force, lanes *measured);
/* periodic.c: sets the states from which one vibration cycle comes back to itself; and A x = b of `count` unknowns, in
 * place, by elimination with pivots: a column without a pivot leaves its unknown at 0. */
enum Status find_periodic(struct Contact *contact);
double most_steps_of_cycles(const struct Contact *contact);
enum { UNKNOWNS = 1 + EFFECT_STATES };
void solve_linear(int count, double A[UNKNOWNS][UNKNOWNS], double x[UNKNOWNS]);

/* integrate.c: I[k] = integral from 0 to D of e^-(D - A) A^k dA, D >= 0. */
void moments(double D, double I[3]);
/* The same of all lanes at M and D, M <= D. */
void moments_in_lanes(const lanes M, const lanes D, lanes to_M[3], lanes to_D[3]);
/* integrate.c: bristle deflection after half and after the whole of h, from the rates at start, middle and end; and the
 * change that a lower order would have made of the end (for the choice of step). relaxes: by exponentials, else by
 * Simpson's rule; clip: |z| is bounded by the largest target. */
void bristle_step(int relaxes, int clip, const lanes h, const struct Point *start, const struct Point *middle,
                  const struct Point *end, lanes z_middle, lanes z_end, lanes difference);

/* integrate.c: how far the end of a step of 2h may be off because its target is not the parabola through start a,
 * middle m and end b: by the targets seen at a quarter and three quarters, early and late, and what a rest may hide
 * between the last of them. */
void hidden_in_target(const lanes h, const struct Point *a, const struct Point *early, const struct Point *m,
                      const struct Point *late, const struct Point *b, lanes hidden);

/* fmin and fmax without their care for NaN: one instruction each. */
static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

/* Below this part of a cycle a step is brief; below far less of it at a tighter tolerance than usual, which asks for
 * what happens there, too. */
#define BRIEF 3e-3

/* Which share of what the forces are off within a step of h counts? At its end they follow from slip and
 * deflection, and have no error but theirs; between the ends they make impulses only, to which a step adds by its
 * length. All of it counts where forces are recalled as they were, where the slip is solved for from them, and where no
 * cycle says how long a step is. */
static inline void force_shares(const struct Configuration *w, const lanes h, lanes share)
{
    EACH_LANE
        share[i] = 1;
    if (w->kinematics == KINEMATICS_EXTERNAL || w->current_angle || w->looks_back)
        return;
    EACH_LANE
        share[i] = smaller(h[i] * w->p[VAR_VIBRATION_FREQUENCY][i] / (BRIEF * w->tighter[i] * w->tighter[i]), 1);
}

/* What counts as the size of a small friction force: of static friction what its parameter says, since what effects add
 * to that may be felt at no speed of the run. */
static inline double level_of(const struct Configuration *w, const struct Point *x, int lane)
{
    return larger(x->F_C[lane], smaller(x->F_S[lane], w->p[VAR_F_S][lane]));
}

/* The same as parameters state it, before load and effects have their say. */
static inline double stated_level(const lanes *p, int lane)
{
    const int has_static = kernel_law((int)p[VAR_FRICTION_LAW][lane])->has_static;
    return has_static ? larger(p[VAR_F_C][lane], p[VAR_F_S][lane]) : p[VAR_F_C][lane];
}

/* The furthest that sliding bends a bristle. */
static inline double reach_of(const struct Point *x, int lane)
{
    return larger(x->F_C[lane], x->F_S[lane]) / x->P[lane];
}

/* Lane i of `count` rows; the lanes of a point come first in it. */
enum {
    POINT_LANES = offsetof(struct Point, past) / sizeof(lanes),
    BESIDE_STATES = offsetof(struct Point, a) / sizeof(lanes) /* behind time and states */
};
static inline void copy_lane(lanes *to, const lanes *from, int count, int i)
{
    for (int k = 0; k < count; ++k)
        to[k][i] = from[k][i];
}

/* The same of all lanes that are chosen, row by row. */
static inline void copy_lanes(lanes *to, const lanes *from, int count, const int which[LANES])
{
    for (int k = 0; k < count; ++k)
        EACH_LANE
            to[k][i] = chosen_of(which[i], from[k][i], to[k][i]);
}

static inline void copy_points(struct Point *to, const struct Point *from, const int which[LANES])
{
    copy_lanes((lanes *)to, (const lanes *)from, POINT_LANES, which);
}

/* Where numbers are too small to mean anything they count as 0, which is off: 1/T and what is made of it stay finite.
 */
#define NO_TIME 1e-12 /* time constant or delay [s]: a tenth of a millionth of the shortest cycle */
#define NO_WINDOW 1e-9 /* averaging window [s]: a hundredth of it */
#define NO_AMPLITUDE 1e-12 /* [m]: a hundredth of an atom */
#define NO_PATH 1e-150 /* of a bristle, in relaxations: a slip of less than 1e-150 m/s */
#define NO_STEP 1e-30 /* [s]: only the time moves on */
#define LONGEST_STEP 1e9 /* [s]: 30 years */
static inline double or_none(double x, double none) { return x < none ? 0 : x; }
static inline int is_step(double step) { return step > 0 && step <= LONGEST_STEP; }

/* Through start, middle and end of a step, at a share of it. */
static inline double parabola(double share, double u_0, double u_m, double u_1)
{
    return u_0 + share * (4 * u_m - 3 * u_0 - u_1 + 2 * share * (u_0 - 2 * u_m + u_1));
}

/* Where the chip flows by the angle of the moment and friction falls with speed, slip and shear angle have more than
 * one answer, and the one that is followed ends in a fold: the slip jumps there. No step is short enough for a jump; it
 * is known to the part of a cycle to which events are. */
static inline double jump_time(const struct Configuration *w, int lane)
{
    return 1e-9 / w->p[VAR_VIBRATION_FREQUENCY][lane];
}

/* How far apart may the same place of two cycles seem to be, near the time t [s]? */
static inline double rounding_of(double t) { return 2e-15 * fabs(t); }

/* Do steps of a lane remember the vibration cycle before? See breakpoints.c. */
static inline int keeps_breakpoints(const struct Configuration *w, int lane)
{
    return w->kinematics != KINEMATICS_EXTERNAL && !w->keeps_past[lane];
}

/* To which width is an event within a step of h known, near the time t [s]? To a thousandth of the tolerance; where
 * it is looked for again a cycle on, to roundings of the time, too. */
static inline double event_width(const struct Configuration *w, int lane, double h, double t)
{
    const double rounding = keeps_breakpoints(w, lane) ? smaller(rounding_of(t), jump_time(w, lane)) : 0;
    return 1e-3 * w->p[VAR_RELATIVE_TOLERANCE][lane] * h + rounding;
}

/* Turns of the vibration at `tau` after value[VAR_TIME], but for whole ones. */
static inline double turns_at(const struct Configuration *w, int lane, double tau)
{
    return tau == w->ends ? w->cycle_then[lane] : w->cycle[lane] + w->p[VAR_VIBRATION_FREQUENCY][lane] * tau;
}

/* The place of a choice in its list. */
static inline int chosen(const lanes *value, int index, int lane) { return (int)value[index][lane]; }

/* An input that has changed so much since it was u. One that is given as straight to 0 gets there but for roundings of
 * its slope and of the time: a slip is at rest, and has not turned round; a chip has ended. */
static inline double given_then(double u, double change)
{
    const double now = u + change;
    return fabs(now) > 1e-15 * fabs(change) ? now : 0;
}

/* Has an input a slope? By bits, in few instructions. */
static inline int any_rises(const struct Contact *contact)
{
    uint64_t bits = 0;
    for (int k = 0; k < INPUT_END - INPUT_FIRST; ++k)
        EACH_LANE
            bits |= (uint64_t)bits_of(contact->slope[k][i]);
    return bits << 1 != 0; /* but for the sign of 0 */
}

/* An input at `tau` after value[VAR_TIME]. */
static inline double input_at(const struct Contact *contact, int index, int lane, double tau)
{
    return contact->value[index][lane] + contact->slope[index - INPUT_FIRST][lane] * tau;
}

#endif
