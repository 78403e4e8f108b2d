/* How is an internal step tried? See trial.c. */
#ifndef TRIAL_H
#define TRIAL_H

#include "../stages.h"

/* What is known of forces that move the tool: by the step before, and as a step was computed last; and the forces of
 * the step before. */
struct LoopMemory {
    struct Feedback known, latest;
    struct StepForces before;
};

/* One internal step while it is tried. */
struct Trial {
    struct Point *start, *middle, *end;
    lanes h, to_window;      /* its length [s]; nonzero where it ends with an averaging window */
    lanes aimed; /* the length with which it was to end where one of the cycle before had ended; 0: none */
    lanes next, difference; /* the step that the tolerance asks for [s], and what a lower order would change */
    lanes beside_window; /* how far a window may end beside the communication step, and ends with it [s] */
    double shortest; /* length at which the tolerance gives way [s] */
    int cut[LANES]; /* the event that h ends at, NO_EVENT or JUMP */
    int first; /* none has been taken yet in this communication step, before which an input may have jumped */
    int acted[LANES]; /* whether a jump at its start has been acted on and has changed no side */
    lanes wait; /* after which a contact that was passed over is looked at again [s] */
    int fits[LANES]; /* whether it is within the tolerance */
    int failed[LANES]; /* whether a longer one was not */
    int alike; /* start, middle and end are, but for what goes by the bristle */
    struct LoopMemory *loop; /* where forces move the tool */
};

/* Is it within the tolerance, by its own points and by those of its halves? */

static inline int trial_is_accurate(const struct Contact *contact, const struct Configuration *w, struct Trial *t)
{
    return accurate(contact, w, t->shortest, t->h, t->start, t->middle, t->end, t->difference, t->next, t->fits);
}

static inline int halves_are_accurate(const struct Contact *contact, const struct Configuration *w, const lanes s,
                                      struct Trial *t)
{
    int doubtful[LANES];
    if (!in_doubt(contact, w, t->h, t->start, t->middle, t->end, t->next, doubtful))
        return 1;
    return accurate_in_halves(contact, w, t->shortest, &t->loop->latest, s, t->h, t->start, t->middle, t->end, doubtful,
                              t->next, t->fits);
}

/* What the tolerance asks for, ended where it must or may end; false where no lane is on its way. */
int choose_step(const struct Contact *contact, const struct Configuration *w, double step, const lanes s,
                const lanes window_ends, struct Trial *t);
void compute_trial(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t);
/* What is known of the feedback in a lane does not hold any more; or is what the step has found that is taken. */
void forget_feedback(struct Trial *t, int lane);
void keep_feedback(struct Trial *t, int lane);
/* Before the first of a communication step. */
void begin_trials(const struct Configuration *w, double step, struct Trial *t);
/* The lanes that are beyond the tolerance ask for a shorter step. */
void ask_again(struct Contact *contact, struct Trial *t);
int trial_repeats(const struct Trial *t);
int cut_short(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t);
int settle_cut(const struct Contact *contact, const struct Configuration *w, const lanes s, struct Trial *t);
enum Ended ended_at(const struct Contact *contact, const struct Trial *t, double step, double s, int lane);

#endif
