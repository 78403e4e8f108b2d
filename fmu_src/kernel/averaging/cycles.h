/* What do some cycles tell of all? Shared by the files that run them and that make a step of them. */
#ifndef CYCLES_H
#define CYCLES_H

#include "../stages.h"

enum { FIRST_FORCE = 3, DUTY = 7, FIRST_MEASURED = 8, FIRST_MEAN = FIRST_MEAN_INTEGRAL };

/* What the cycles that were run have shown: gains of the integrals, all together and of the last two; departures of the
 * bristle. */
struct CycleSums {
    lanes gain[INTEGRALS], last[INTEGRALS], before[INTEGRALS], departure, departure_before;
    lanes left,
        next[INTEGRALS]; /* share of a departure that outlives a cycle; what the next cycle will gain beyond the last */
    lanes state[EFFECT_STATES]; /* slow states after the cycle */
    lanes drift; /* how far the last cycle has moved the states that a separation resets, as a share of themselves */
    int cycles[LANES], done[LANES], periodic[LANES], drifts[LANES];
};

/* Rows of a contact that its lanes step with: values, slopes, memory, sides; all but what looks back and what windows
 * have in common. */
enum { OWN_ROWS = offsetof(struct Contact, window_origin) / sizeof(lanes) };

enum { MOST_SERVED = 30 }; /* steps that go by what an earlier one has found of the bristle */

static inline double period_of(const struct Contact *contact) { return 1 / contact->value[VAR_VIBRATION_FREQUENCY][0]; }

/* periodic.c: the n-th state that cycles bring back, -1 behind the last; what is much of it; does nothing go by the
 * time itself, so that cycles are alike? */
int unknown_index(const struct Configuration *w, int n);
double scale_of(const struct Contact *contact, int index, int i);
int is_steady(const struct Configuration *w);

/* cycles.c: cycles from `begin`, again and again from the same slow states, until each lane knows how so many would go
 * on. A lane that does stays as it is, to the last bit. Effects that are on: all but sensors. */
enum Status run_cycles(struct Contact *contact, struct Configuration *w, const lanes begin, double cycles,
                       struct CycleSums *seen);
/* Do the cycles that the lane has run tell of so many? They are so many, or the others are known from them. */
int stand_for(const struct CycleSums *seen, double cycles, int i);
/* Mean rates over so many cycles, of which those that were run are the first; and the bristle after them. */
void go_on(struct Contact *contact, const struct CycleSums *seen, double cycles, lanes mean[INTEGRALS]);

#endif
