/* What is a partner of the contact made of, and what can be asked of it?
 *
 * A partner is the machine around the contact: tool holder, spindle, feed drive, heat. Each is one file in parts/: a
 * table and one function. What they share: outputs and rates are linear in states and inputs, whatever the parameters,
 * so that machine.c can step them exactly. The FMI shells find here the words that they find in kernel.h for the
 * contact; C99 and math.h, no allocation, no writable static, the caller owns the memory. What the shells call a
 * contact is here the machine.
 */
#ifndef MACHINE_H
#define MACHINE_H

#include "../kernel/tables.h"

#include <stddef.h>
#include <stdint.h>

typedef double lanes[1];

/* A partner's table: time, then its inputs, then what it likes. */
enum Limits { VAR_TIME = 0, INPUT_FIRST = 1, INPUT_END = INPUT_FIRST + 8, CAPACITY = 64, STATES = 8, INDICATORS = 0 };

enum { TOLERANCE_ARGUMENT = CAPACITY }; /* FMI's `tolerance` of the experiment: no variable, the step is exact */

enum Status {
    KERNEL_OK,
    KERNEL_NO_SUCH_VARIABLE,
    KERNEL_NOT_FINITE,
    KERNEL_OUT_OF_BOUNDS,
    KERNEL_BAD_STEP,
    KERNEL_DIVERGED,
    KERNEL_STATUS_COUNT
};
enum Warning { WARNING_COUNT = 0 };

struct Contact {
    lanes value[CAPACITY];                /* every variable, by index */
    lanes slope[INPUT_END - INPUT_FIRST]; /* rate of each input within a communication step, per second; 0 = held */
    uint32_t warnings, started;
    double step;                          /* for which the integrals below hold [s]; 0: none */
    double once[STATES * STATES];         /* of the response to a rate that is held over the step, */
    double twice[STATES * STATES];        /* and to one that grows from 0 */
};

/* Asking and doing: as in kernel.h, where each is told. */
int kernel_variable_count(void);
const struct Variable *kernel_variable(int index);
int kernel_state_count(void);
int kernel_state(int place);
int kernel_derivative_of(int index);
int kernel_indicator(int place);
const char *kernel_status_text(enum Status status);
void kernel_explain(const struct Contact *contact, enum Status status, char *text, size_t size);
const char *kernel_warning_text(int bit);
const char *kernel_equations(void); /* for the documentation */
size_t kernel_size(void);
void kernel_token(char token[39]);

void kernel_reset(struct Contact *contact);
enum Status kernel_set(struct Contact *contact, int index, int lane, double value);
enum Status kernel_check(int index, double value);
const char *kernel_flaw(const struct Contact *contact);
enum Status kernel_start(struct Contact *contact, double time);
enum Status kernel_evaluate(struct Contact *contact);
void kernel_indicators(const struct Contact *contact, lanes *indicator);
enum Status kernel_step_completed(struct Contact *contact);
enum Status kernel_event(struct Contact *contact);
double kernel_next_event(const struct Contact *contact);
int kernel_averages(const struct Contact *contact);
enum Status kernel_advance(struct Contact *contact, double step, int stop_at_events, double *taken);
enum Status kernel_derivative(const struct Contact *contact, int unknown, int known, double *derivative);

/* What a file in parts/ defines. */
struct Part {
    const char *equations;
    const struct Variable *variables;
    int count;
    void (*evaluate)(lanes *value); /* outputs and rates from time, inputs, parameters and states, all in value */
};
extern const struct Part part;

#endif
