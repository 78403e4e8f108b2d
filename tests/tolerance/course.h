/* What does the reference know while it leads a contact through a motion? Shared by the files that do so: course.c
 * looks at the contact, surface.c remembers what the tool left, notes.c what is shown, walk.c goes from stop to stop,
 * reference.c through it all. */
#ifndef COURSE_H
#define COURSE_H

#include "radau.h"
#include "reference.h"

/* What the tool has left behind, for a revolution that meets it again: heights at the start and the nodes of each
 * step. */
struct Left {
    double start, length, height[1 + STAGES_OF_RADAU];
};

struct Course {
    struct Contact *contact;
    const struct Motion *motion;
    const struct Care *care;
    struct Outcome *outcome;
    struct Radau radau;
    int segment;
    int state[MOST_STATES], rate[MOST_STATES], of_sensor[MOST_STATES];
    int integral[MOST_INTEGRALS], integrand[MOST_INTEGRALS];
    double t, y[MOST_STATES], f[MOST_STATES], g[MOST_INTEGRALS], sums[MOST_INTEGRALS];
    double next;     /* length of the next step by the last one's error */
    double slow;     /* slip that changes by so little changes no law of friction much */
    int moved;       /* forces, or a solution for the slip, move the tool: the times of all events hang on states */
    int frozen;      /* nothing but the sensors moves */
    int late_row;    /* a delay of the sensors: the next row whose late outputs are due */
    double window;   /* length of the averaging windows, 0: none */
    int64_t windows; /* that have ended; means of the last one; the integrals when the present one began */
    double mean[MOST_INTEGRALS], opened[MOST_INTEGRALS];
    double turn;     /* time of a revolution that meets its own surface, 0: none does; how many are completed */
    int turns;
    struct Left *left;
    int64_t left_count, left_room;
    int64_t counted_events; /* and when they were counted: does it slide along an event without end? */
    double counted_at;
};

static inline double parameter(const struct Course *c, int index) { return c->contact->value[index][0]; }

/* branches.c: how many slips go with the state of a contact that moves by the shear angle of the moment? */
int branches_at(const struct Contact *contact);

/* course.c: a value by its name; the contact at a time with these states; the same with rates; the course's own
 * present, which it leaves in the contact, 0 where there are no rates. */
double course_named(const struct Course *c, const char *name);
void course_put(struct Course *c, double t, const double *y);
int course_rates(void *course, double t, const double *y, double *f, double *g);
int course_look(struct Course *c);
void course_take_states(struct Course *c);
void course_sort_states(struct Course *c);

/* surface.c: set what the tool meets at t; keep what it leaves over a step; turns end. */
void surface_meet(struct Course *c, double t);
void surface_leave(struct Course *c, double h, const struct Step *step);
double surface_next_turn(const struct Course *c);

/* notes.c: rows, late outputs and means; what jumps. */
void notes_row(struct Course *c, int row, int late);
double notes_next_late(const struct Course *c);
void notes_late(struct Course *c);
double notes_window_end(const struct Course *c);
void notes_close_window(struct Course *c);
void notes_both_sides(struct Course *c);
/* An event at the present time: sides anew, and a note of what jumps where the time of it hangs on a state. 0: there
 * are no rates. */
int notes_event(struct Course *c, int hangs_on_state);

/* walk.c */
enum Verdict walk_to(struct Course *c, double stop);
enum Verdict walk_sensors(struct Course *c);

#endif
