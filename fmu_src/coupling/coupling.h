/* How do the components of a system go through time together? Communication steps of FMUs of FMI 2 and 3, inputs
 * continued or interpolated, power watched.
 *
 * In each step the components move one after the other (Gauss-Seidel) or all from the same values (Jacobi). The input
 * of a component whose source has moved already is interpolated over the step; any other is continued, as a constant or
 * along its last slope. At the end of the step all inputs are set to what their sources show, and outputs that follow
 * them at once are read anew, until none moves: outputs may follow inputs through many members, or in a loop.
 *
 * The caller loads the FMUs, owns all memory here, and lends the addresses of their functions. C99, no allocation, no
 * writable static. What the components show and what a record gives stand in one array, the signals: those shown first.
 */
#ifndef COUPLING_H
#define COUPLING_H

#include <stdint.h>

/* A function of FMI in an FMU, and the name by which a failure tells of it. */
struct Function {
    void (*address)(void);
    const char *name;
};

/* Beside the statuses of FMI: an FMU of FMI 3 has made a step, and asks that the simulation ends; outputs that follow
 * inputs at once form a loop in which they do not settle. */
enum { ASKS_TO_END = -1, NOT_SETTLED = -2 };

/* How an FMU keeps the numbers that it shows. */
enum Form { FLOAT64, FLOAT32, INT8, UINT8, INT16, UINT16, INT32, UINT32, INT64, UINT64, BOOLEAN };

/* Outputs that one call reads. */
struct Outputs {
    struct Function get;
    int form, count;
    const uint32_t *references;
    const int *places; /* among the signals */
};

struct Member {
    int fmi;    /* 2 or 3 */
    int slopes; /* it takes the rate of its inputs over a step; else they stand at their mean */
    void *instance;
    struct Function set_inputs, set_slopes, do_step;
    int input_count, call_count;
    const uint32_t *inputs;
    const int *orders;   /* of the derivatives of inputs: 1 for each */
    const int *sources;  /* of the inputs, among the signals */
    double *held, *ahead; /* the inputs as they were last set, and as they are at the end of the step */
    double *told;         /* over the step: their rates or their mean */
    double *largest;      /* that each has been while outputs that follow at once settle */
    const struct Outputs *outputs;
};

/* A force and a velocity that go opposite ways between two members: their product is a power. Sadjina et al. 2017,
 * Energy conservation and power bonds in co-simulations. */
struct Bond {
    int force, velocity;           /* among the signals */
    int force_side, velocity_side; /* members that show them */
    int against; /* the force acts against the motion: the side of the velocity gives the power */
    int velocity_input, force_input; /* where these see the other's, among their inputs; -1: nowhere */
    double velocity_received, force_received, force_sent, velocity_sent; /* at the end of the step */
    double passed, made, moved; /* energy that passed, that the coupling made, and what each step made or lost [J] */
};

struct Coupling {
    int member_count, bond_count, signal_count, shown_count;
    int jacobi, continued;
    struct Member *members;
    struct Bond *bonds;
    double *signals, *rates;               /* at the end of the last step, and over it */
    double *guess, *then;                  /* what they are taken to be at the end of the step, and are */
    uint64_t *buffer;                      /* for as many outputs as one call reads */
    int64_t done, count, every; /* steps; every how many are kept, and the last one */
    int64_t kept, rows;         /* in the table, which holds one signal behind the other */
    double *table;
    double averaged_from, averaged; /* integrals are over the steps that end behind this time [s]; their length */
    double *integrals;              /* of what is shown, straight from the start of a step to its end */
    /* Where a function here has answered 0: the member, its function, what that answered; or, where that answered well,
     * which signal is no finite number, and what it is; or which one does not settle. */
    int failed, status, place;
    const char *function;
    double shown;
};

/* All of these answer 1, or 0 where a member failed. */
int coupling_set(struct Coupling *c, int member); /* inputs from the signals */
int coupling_show(struct Coupling *c, int member); /* outputs to the signals */
int coupling_settle(struct Coupling *c); /* both, until no input moves */
/* So many steps on: times[0], where all stand, to times[count]. given: what a record gives at the end of each, a row
 * for each step. */
int coupling_steps(struct Coupling *c, int64_t count, const double *times, const double *given);

#endif
