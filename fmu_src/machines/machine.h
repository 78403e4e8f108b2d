/* What is a partner of the contact made of?
 *
 * A partner is the machine around the contact: tool holder, spindle, feed drive, heat. Each is one file in parts/: a
 * table and one function. What they share: rates are linear in states and inputs, whatever the parameters, so that
 * machine.c can step them exactly; or they say that their response to the states varies with the inputs. What can be
 * asked of one is the interface of all models, fmi/model.h; C99 and math.h, no allocation, no writable static, the
 * caller owns the memory.
 */
#ifndef MACHINE_H
#define MACHINE_H

#include "../fmi/model.h"

/* A partner's table: time, then its inputs, then what it likes. */
enum Limits { VAR_TIME = 0, INPUT_FIRST = 1, INPUTS = 8, CAPACITY = 64, STATES = 8 };

struct Model {
    double value[CAPACITY];       /* every variable, by index */
    double slope[INPUTS];         /* rate of each input within a communication step, per second; 0 = held */
    uint32_t warnings, started; /* WARN_AT_BOUND or 0 */
    double step;                  /* for which the integrals below hold [s]; 0: none */
    double once[STATES * STATES]; /* of the response to a rate that is held over the step, */
    double twice[STATES * STATES]; /* and to one that grows from 0 */
};

const char *machine_equations(void); /* for the documentation */

/* What a file in parts/ defines. */
struct Part {
    const char *equations;
    const struct Variable *variables;
    int count;
    int varies; /* the rates are linear in the states alone: inputs change the response to them */
    double (*time_scale)(const double *value); /* in which outputs change by the time alone [s]; NULL: they do not */
    void (*evaluate)(double *value); /* outputs and rates from time, inputs, parameters and states, all in value */
};
extern const struct Part part;

#endif
