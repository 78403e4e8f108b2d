/* What is the right answer of a contact to a motion, and what does the kernel's own stepping make of it? */
#ifndef REFERENCE_H
#define REFERENCE_H

#include "kernel.h"

#include <stdint.h>

enum Verdict { DONE, NO_RATES, NO_STEP, TOO_MANY_EVENTS, TOO_MANY_STEPS };

/* Inputs that run straight from `begin` to `end` of each segment, and may jump between segments. */
struct Motion {
    int segments, inputs, outputs;
    const double *times;      /* segments + 1 */
    const int *input_index;
    const double *begin, *end; /* [segment * inputs + j] */
    const int *output_index;
    int rounds;               /* a host adds up slopes: an input that should end at 0 does so but for rounding */
    double late;              /* the reference: sensors show what was so long ago, with the kernel's own delay off */
    const unsigned char *lags; /* outputs that do */
};

/* How tightly. */
struct Care {
    double tolerance; /* of one step of the reference */
    double span;      /* of its longest step: 1 as designed, 0.5 twice as many */
    int64_t most_steps, most_events;
    int branches;     /* look at each step for a slip that is not the only answer: costs far more than the step */
};

/* A jump of the outputs. */
struct Jump {
    double time, patience; /* patience: the time in which the motion changes a force by about itself */
    int first;             /* of its outputs in Outcome.sides: before, then after */
};

struct Outcome {
    double *rows;  /* [(segments + 1) * outputs], at the ends of the segments */
    struct Jump *jumps;
    double *sides; /* two rows of outputs for each jump */
    int jump_room, jump_count;
    int64_t steps, events, evaluations;
    double failed_at;
    int branches; /* the most slips that go with any state, where asked */
};

/* The contact has its values and is not started; it is led through the motion from times[0] by the model-exchange side
 * alone. */
enum Verdict reference_run(struct Contact *contact, const struct Motion *motion, const struct Care *care,
                           struct Outcome *outcome);

/* The kernel's answer as a host steps it: inputs and their slopes set at each communication point, kernel_advance,
 * kernel_evaluate. */
enum Status stepped_run(struct Contact *contact, const struct Motion *motion, double *rows);

#endif
