/* Which steps lead from a time to the forces? The stages of one time point, in their order, and the wiring they share. */
#ifndef STAGES_H
#define STAGES_H

#include "kernel.h"
#include "registry.h"

#define EACH_LANE for (int i = 0; i < LANES; ++i)

/* Where in its cycle the tool stops moving forward: last = acos(-r), and bend = sin(last), of the speed ratio r < 1; else 0. */
struct Turn {
    double r, last, bend;
};

/* What a run of points has in common: which law and effects are on, found once per call. */
struct Wiring {
    const lanes *p;                 /* the base table's values */
    const struct FrictionLaw *law;
    const lanes *law_p;
    const struct Effect *on[EFFECT_COUNT];    /* effects that are on, and their parameters */
    const lanes *on_p[EFFECT_COUNT];
    int on_count;
    int held;                       /* external kinematics and no input changes: nothing but the bristle moves */
    enum Kinematics kinematics;
    int current_angle;              /* chip_flow_angle = current_shear_angle: slip and force are solved together */
    lanes cycle;                    /* place in the vibration cycle at value[TIME], 0..1 */
    lanes cos_rake, sin_rake;
    lanes cos_x, sin_x, cos_y, sin_y; /* of the phases */
    struct Turn turn[LANES];        /* at the speed ratio that holds at value[TIME] */
    lanes tan_flow;                 /* of chip_flow_shear_angle - rake_angle */
};

/* wiring.c */
struct Wiring wire(const struct Contact *contact);
void act(const struct Wiring *w, enum Stage stage, struct Point *x);

/* path.c: r = v_c / (a w). */
struct Turn turn_at(double r);
/* path.c: u, h, approach, the path's indicators, at `tau` [s] after value[TIME]. */
void path_at(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x);
/* path.c: chip slip along the rake; tan_flow: of the shear angle less the rake angle. */
double slip_along_rake(const struct Wiring *w, const struct Point *x, int lane, double tan_flow);

/* forces.c: the shear load. */
void load_at(const struct Wiring *w, struct Point *x);

/* friction.c: open the law's fields (theta, F_C, ...), and what follows from z. */
void friction_open(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x);
void friction_rates(const struct Wiring *w, struct Point *x);
void friction_force(const struct Wiring *w, struct Point *x);
/* friction.c: open and rates together, with the slip solved from its own shear angle. */
void friction_solved(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x);

/* forces.c: normal, principal and feed force from F and k; and the shear angle that goes with them. */
void forces_at(const struct Wiring *w, struct Point *x);
double shear_angle(const struct Wiring *w, const struct Point *x, int lane);

/* point.c: all stages at tau; z given in x for open and close, taken from the contact by point_at. passing: a point within a step, whose
 * outputs nobody looks at. */
void open_point(const struct Contact *contact, const struct Wiring *w, const lanes tau, int passing, struct Point *x);
void close_point(const struct Contact *contact, const struct Wiring *w, int passing, struct Point *x);
void point_at(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x);
/* point.c: sides of the events. */
void indicators(const struct Wiring *w, const struct Point *x, lanes indicator[INDICATORS]);
int watched(const struct Contact *contact, int k, int i);
void let_go(struct Contact *contact, const struct Wiring *w, const struct Point *x);
void settle_sides(struct Contact *contact, const struct Wiring *w, const lanes tau, double ahead, struct Point *x);
void act_on_event(struct Contact *contact, const struct Wiring *w, const lanes tau, double ahead, struct Point *x);

/* window.c: length and end [s] of the present averaging window, 0 and infinity where no means are formed. */
enum { MEANS = 5 };
extern const int mean_of[MEANS];
double window_length(const struct Contact *contact, int i);
double window_end(const struct Contact *contact, int i);
void close_window(struct Contact *contact, int i);

/* evaluate.c: reference above ambient, where the proxy is a temperature. */
int ordered_temperatures(const struct Contact *contact);

/* integrate.c: bristle deflection after half and after the whole of h, from the rates at start, middle and end; and the change that a
 * lower order would have made of the end (for the choice of step). relaxes: by exponentials, else by Simpson's rule; clip: |z| is
 * bounded by the largest target. */
void bristle_step(int relaxes, int clip, const lanes h, const struct Point *start, const struct Point *middle,
                  const struct Point *end, lanes z_middle, lanes z_end, lanes difference);

/* fmin and fmax without their care for NaN: one instruction each. */
static inline double smaller(double a, double b) { return a < b ? a : b; }
static inline double larger(double a, double b) { return a > b ? a : b; }

/* The place of a choice in its list. */
static inline int chosen(const lanes *value, int index, int lane) { return (int)value[index][lane]; }

/* An input at `tau` after value[TIME]. */
static inline double input_at(const struct Contact *contact, int index, int lane, double tau)
{
    return contact->value[index][lane] + contact->slope[index - INPUT_FIRST][lane] * tau;
}

#endif
