/* How does a partner live and move on? Exactly: its rates are linear in states and inputs, and inputs are linear within
 * a step.
 *
 * x(h) = x + once f + twice df/dt, once = integral of exp(A s) from 0 to h, twice = integral of that: f the rates as
 * they stand, df/dt their change by the slopes of the inputs. No step size is too long, and what has no damping keeps
 * its energy but for rounding.
 */
#include "machine.h"
#include "response.h"

#include <math.h>
#include <string.h>

#define LONGEST_STEP 1e9 /* [s]: 30 years */

int kernel_variable_count(void) { return part.count; }
const struct Variable *kernel_variable(int index)
{
    return index >= 0 && index < part.count ? &part.variables[index] : NULL;
}
const char *kernel_equations(void) { return part.equations; }
size_t kernel_size(void) { return sizeof(struct Contact); }
int kernel_derivative_of(int index)
{
    return index > 0 && index < part.count ? part.variables[index].derivative_of : 0;
}

/* The states in the order of their rates in the table. */
static int rate_of(int place)
{
    for (int i = 0; i < part.count; ++i)
        if (part.variables[i].derivative_of && place-- == 0)
            return i;
    return -1;
}

int kernel_state_count(void)
{
    int count = 0;
    for (int i = 0; i < part.count; ++i)
        count += part.variables[i].derivative_of != 0;
    return count;
}

int kernel_state(int place)
{
    const int rate = place < 0 ? -1 : rate_of(place);
    return rate < 0 ? -1 : part.variables[rate].derivative_of;
}

/* Nothing happens to a partner: no events, no warnings. */
int kernel_indicator(int place) { return (void)place, -1; }
void kernel_indicators(const struct Contact *contact, lanes *indicator) { (void)contact, (void)indicator; }
double kernel_next_event(const struct Contact *contact) { return (void)contact, INFINITY; }
int kernel_averages(const struct Contact *contact) { return (void)contact, 0; }
enum Status kernel_event(struct Contact *contact) { return kernel_evaluate(contact); }
enum Status kernel_step_completed(struct Contact *contact) { return kernel_evaluate(contact); }
const char *kernel_warning_text(int bit) { return (void)bit, "unknown warning"; }

static const char *const status_texts[KERNEL_STATUS_COUNT] = {
    [KERNEL_OK] = "done",
    [KERNEL_NO_SUCH_VARIABLE] = "there is no such variable",
    [KERNEL_NOT_FINITE] = "the value is not a finite number",
    [KERNEL_OUT_OF_BOUNDS] = "the value lies outside its bounds",
    [KERNEL_BAD_STEP] = "the step is not a number above 0 and up to 1e9 s",
    [KERNEL_DIVERGED] = "a state or an output is no longer a finite number",
};
const char *kernel_status_text(enum Status status)
{
    return status < KERNEL_STATUS_COUNT ? status_texts[status] : "unknown status";
}

void kernel_explain(const struct Contact *contact, enum Status status, char *text, size_t size)
{
    (void)contact;
    if (size == 0)
        return;
    strncpy(text, kernel_status_text(status), size - 1);
    text[size - 1] = '\0';
}

enum Status kernel_check(int index, double value)
{
    const struct Variable *variable = kernel_variable(index);
    if (!variable)
        return KERNEL_NO_SUCH_VARIABLE;
    if (!isfinite(value))
        return KERNEL_NOT_FINITE;
    if (value < variable->min || value > variable->max)
        return KERNEL_OUT_OF_BOUNDS;
    return variable->type != REAL && value != floor(value) ? KERNEL_OUT_OF_BOUNDS : KERNEL_OK;
}

enum Status kernel_set(struct Contact *contact, int index, int lane, double value)
{
    const enum Status status = kernel_check(index, value);
    if (status != KERNEL_OK)
        return status;
    contact->value[index][lane] = value;
    if (part.variables[index].causality == PARAMETER)
        contact->step = 0;
    return KERNEL_OK;
}

void kernel_reset(struct Contact *contact)
{
    memset(contact, 0, sizeof *contact);
    for (int i = 0; i < part.count; ++i)
        contact->value[i][0] = part.variables[i].start;
}

enum Status kernel_start(struct Contact *contact, double time)
{
    if (!isfinite(time))
        return KERNEL_NOT_FINITE;
    contact->value[VAR_TIME][0] = time;
    contact->started = 1;
    contact->step = 0;
    return kernel_evaluate(contact);
}

enum Status kernel_evaluate(struct Contact *contact)
{
    part.evaluate(contact->value);
    for (int i = 0; i < part.count; ++i)
        if (!isfinite(contact->value[i][0]))
            return KERNEL_DIVERGED;
    return KERNEL_OK;
}

static double nominal(int index) { return part.variables[index].nominal > 0 ? part.variables[index].nominal : 1; }

static void rates(lanes *value, const int *rate, int count, double *f)
{
    part.evaluate(value);
    for (int n = 0; n < count; ++n)
        f[n] = value[rate[n]][0];
}

/* The integrals of the response for a step of h, from rates with one state after the other moved from 0 by its nominal
 * value. */
static void prepare(struct Contact *contact, const int *state, const int *rate, int count, double h)
{
    double matrix[STATES * STATES], rest[STATES], moved[STATES];
    struct Contact probe = *contact;
    for (int n = 0; n < count; ++n)
        probe.value[state[n]][0] = 0;
    for (int i = 0; i < part.count; ++i)
        if (part.variables[i].causality == INPUT)
            probe.value[i][0] = 0;
    rates(probe.value, rate, count, rest);
    for (int k = 0; k < count; ++k) {
        probe.value[state[k]][0] = nominal(state[k]);
        rates(probe.value, rate, count, moved);
        probe.value[state[k]][0] = 0;
        for (int n = 0; n < count; ++n)
            matrix[n * count + k] = (moved[n] - rest[n]) / nominal(state[k]);
    }
    respond(count, matrix, h, contact->once, contact->twice);
    contact->step = h;
}

enum Status kernel_advance(struct Contact *contact, double step, int stop_at_events, double *taken)
{
    int state[STATES], rate[STATES];
    double now[STATES], end[STATES];
    const int count = kernel_state_count();
    (void)stop_at_events; /* there are none */
    *taken = 0;
    if (!(step > 0 && step <= LONGEST_STEP))
        return KERNEL_BAD_STEP;
    for (int n = 0; n < count; ++n) {
        rate[n] = rate_of(n);
        state[n] = part.variables[rate[n]].derivative_of;
    }
    /* Communication steps differ by the rounding of time: the integrals serve for all of them, the rest is a step of
     * first order. */
    if (!(fabs(step - contact->step) <= 1e-9 * step))
        prepare(contact, state, rate, count, step);
    const double rest = step - contact->step;
    rates(contact->value, rate, count, now);
    for (int i = INPUT_FIRST; i < INPUT_END; ++i)
        contact->value[i][0] += step * contact->slope[i - INPUT_FIRST][0]; /* of what is no input it is 0 */
    rates(contact->value, rate, count, end);
    for (int n = 0; n < count; ++n) {
        double by = rest * now[n];
        for (int k = 0; k < count; ++k)
            by += contact->once[n * count + k] * now[k] + contact->twice[n * count + k] * ((end[k] - now[k]) / step);
        contact->value[state[n]][0] += by;
    }
    contact->value[VAR_TIME][0] += step;
    *taken = step;
    return kernel_evaluate(contact);
}

/* The integrals of the response belong to the step and the parameters: a state from outside cannot bring others. */
static int belongs(const struct Contact *contact)
{
    int state[STATES], rate[STATES];
    const int count = kernel_state_count();
    struct Contact own = *contact;
    for (int n = 0; n < count; ++n) {
        rate[n] = rate_of(n);
        state[n] = part.variables[rate[n]].derivative_of;
    }
    prepare(&own, state, rate, count, contact->step);
    for (int n = 0; n < count * count; ++n)
        if (!(fabs(own.once[n] - contact->once[n]) <= 1e-9 * fabs(own.once[n]) &&
              fabs(own.twice[n] - contact->twice[n]) <= 1e-9 * fabs(own.twice[n])))
            return 0;
    return 1;
}

const char *kernel_flaw(const struct Contact *contact)
{
    if (contact->started > 1 || contact->warnings)
        return "a flag is not there";
    if (!isfinite(contact->value[VAR_TIME][0]))
        return "the time is no finite number";
    for (int i = 0; i < part.count; ++i) { /* outputs are found anew from these */
        const enum Causality role = part.variables[i].causality;
        if ((role == PARAMETER || role == INPUT) && kernel_check(i, contact->value[i][0]) != KERNEL_OK)
            return "a parameter or an input lies outside its bounds";
        if (part.variables[i].derivative_of && !isfinite(contact->value[part.variables[i].derivative_of][0]))
            return "a continuous state is no finite number";
    }
    for (int k = 0; k < INPUT_END - INPUT_FIRST; ++k)
        if (!isfinite(contact->slope[k][0]))
            return "a derivative of an input is no finite number";
    if (!(contact->step >= 0 && contact->step < INFINITY))
        return "the step is no finite number from 0 on";
    return contact->step > 0 && !belongs(contact) ? "the response over a step is not that of the parameters" : NULL;
}

enum Status kernel_derivative(const struct Contact *contact, int unknown, int known, double *derivative)
{
    struct Contact probe = *contact;
    if (!kernel_variable(unknown) || !kernel_variable(known))
        return KERNEL_NO_SUCH_VARIABLE;
    /* Central differences: exact but for rounding where the unknown is linear or quadratic in the known, as all here
     * are. */
    const double value = contact->value[known][0], h = fmax(1e-3 * fabs(value), 1e-2 * nominal(known));
    probe.value[known][0] = value + h;
    part.evaluate(probe.value);
    const double above = probe.value[unknown][0];
    probe.value[known][0] = value - h;
    part.evaluate(probe.value);
    *derivative = (above - probe.value[unknown][0]) / (2 * h);
    return KERNEL_OK;
}
