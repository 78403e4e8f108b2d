/* What can the fuzz do with an instance? Each function draws its numbers, makes a call or a few, and has them judged.
 */
#ifndef ACTS_H
#define ACTS_H

#include "host.h"

enum { MOST_STATES = 3, SETTING = INSTANTIATED | INITIALIZING | RUNNING, READING = SHOWING | INSTANTIATED };
enum Sort { REALS, INTEGERS, BOOLEANS, CHOICES }; /* as enum Type */

/* ---- fuzz.c: the tables, read once ---- */

extern int variables, states;
extern int is_start[CAPACITY]; /* a continuous state, which may be set before the start */
extern struct One *stepped;    /* whose callback is called */

#define NAME(two, three) (one->version == 2 ? "fmi2" two : "fmi3" three)
#define EITHER(two, three) (one->version == 2 ? (int)(two) : (int)(three))

static inline enum Sort sort_of(int index) { return (enum Sort)model_variable(index)->type; }
static inline unsigned reading(const struct One *one)
{
    return READING | (one->version == 3 ? INTERMEDIATE | ASKING : 0);
}
extern const char *const get_names[2][4];

/* ---- numbers.c ---- */

/* The value references of variables by their indices; the array is the caller's. */
const unsigned *references_of(const unsigned *index, size_t count, unsigned *reference);
/* Variables by their indices. */
int get_numbers(struct One *one, enum Sort form, const unsigned *index, size_t count, double *value);
int get_all(struct One *one);
int is_allowed(const struct Variable *v, double x);
void get_some(struct One *one);
void set_one(struct One *one, int index, double value);
void set_some(struct One *one);
double time_of(struct One *one);
void ramp_inputs(struct One *one);

/* ---- life.c ---- */

void forget_given(struct One *one);
void initialise(struct One *one);
void enter_unprepared(struct One *one);
void exit_initialisation(struct One *one);
void terminate(struct One *one);
void reset(struct One *one);
void set_logging_of(struct One *one);
void configure(struct One *one);
void enter_event_mode(struct One *one);
void update(struct One *one);
void leave_event_mode(struct One *one);

/* ---- solver.c ---- */

void completed(struct One *one);
void look_as_solver(struct One *one);
void set_time_of(struct One *one, double time);
void set_strange_states(struct One *one);
void integrate(struct One *one);
double span_of_step(void);
void differentiate(struct One *one);
void ask_what_is_not_there(struct One *one);

/* ---- cosimulation.c ---- */

void last_time(struct One *one);
void step(struct One *one);
void step_and_back(struct One *one);
void update_within(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean asks, fmi3Boolean reads,
                   fmi3Boolean finished, fmi3Boolean may_return, fmi3Boolean *wants_return, fmi3Float64 *until);
void ask_status(struct One *one);

/* ---- saved.c ---- */

/* States that the sequence keeps. */
extern struct Saved {
    void *state;
    unsigned mode;
    int set_up, pending, ramped;
    double start, stop;
} saved[MOST_STATES];
void save_at(struct One *one, struct Saved *at);
void restore_from(struct One *one, const struct Saved *at);
void save(struct One *one);
void restore(struct One *one);
void drop(struct One *one, void **state);
void serialise(struct One *one);

#endif
