/* How does a partner live and move on? Exactly: its rates are linear in states and inputs, and inputs are linear within
 * a step. Where inputs change the response to the states as well, to second order in their change.
 *
 * x(h) = x + once f + twice df/dt, once = integral of exp(A s) from 0 to h, twice = integral of that: f the rates as
 * they stand, df/dt their change by the slopes of the inputs. No step size is too long, and what has no damping keeps
 * its energy but for rounding.
 */
#include "machine.h"
#include "linear_response.h"

#include <math.h>
#include <string.h>

#define LONGEST_STEP 1e9 /* [s]: 30 years */

static uint64_t hash_part(uint64_t hash)
{
    for (int i = 0; i < part.count; ++i)
        hash = hash_row(hash, &part.variables[i], part.variables[i].derivative_of, 0);
    return hash_text(hash, part.equations);
}

const char *machine_equations(void) { return part.equations; }
size_t model_size(void) { return sizeof(struct Model); }
void model_token(char token[39]) { write_token(hash_part, token); }
int model_variable_count(void) { return part.count; }
const struct Variable *model_variable(int index)
{
    return index >= 0 && index < part.count ? &part.variables[index] : NULL;
}
int model_derivative_of(int index) { return index > 0 && index < part.count ? part.variables[index].derivative_of : 0; }

int model_input_count(void)
{
    int count = 0;
    for (int i = 0; i < part.count; ++i)
        count += part.variables[i].causality == INPUT;
    return count;
}
int model_input(int place) { return INPUT_FIRST + place; }

/* The states in the order of their rates in the table. */
static int rate_of(int place)
{
    for (int i = 0; i < part.count; ++i)
        if (part.variables[i].derivative_of && place-- == 0)
            return i;
    return -1;
}

int model_state_count(void)
{
    int count = 0;
    for (int i = 0; i < part.count; ++i)
        count += part.variables[i].derivative_of != 0;
    return count;
}

int model_state(int place)
{
    const int rate = place < 0 ? -1 : rate_of(place);
    return rate < 0 ? -1 : part.variables[rate].derivative_of;
}

/* Nothing happens to a partner: no events; its step is exact, and any solver can follow it. */
int model_tolerance(void) { return -1; }
int model_indicator_count(void) { return 0; }
int model_indicator(int place) { return (void)place, -1; }
void model_indicators(const struct Model *model, double *indicators) { (void)model, (void)indicators; }
double model_next_event(const struct Model *model) { return (void)model, INFINITY; }
int model_turned(const struct Model *before, const struct Model *after) { return (void)before, (void)after, 0; }
enum Status model_event(struct Model *model) { return model_evaluate(model); }
enum Status model_completed_step(struct Model *model) { return model_evaluate(model); }
uint32_t model_warnings(const struct Model *model) { return model->warnings; }
int model_warning_count(void) { return 1; }
const char *model_solver_obstacle(const struct Model *model) { return (void)model, NULL; }

static void say(const char *said, char *text, size_t size)
{
    const size_t length = strlen(said), room = size > 0 ? size - 1 : 0, used = length < room ? length : room;
    if (size == 0)
        return;
    memcpy(text, said, used);
    text[used] = '\0';
}

void model_explain(const struct Model *model, enum Status status, char *text, size_t size)
{
    (void)model;
    say(status_text(status), text, size);
}

void model_explain_warning(const struct Model *model, int bit, char *text, size_t size)
{
    (void)model;
    say(bit == 0 ? AT_BOUND_TEXT : "unknown warning", text, size);
}

enum Status model_check(int index, double value) { return check_value(model_variable(index), value); }
double model_bound_slack(int index) { return model_variable(index) ? bound_slack(model_variable(index)) : 0; }
double model_get(const struct Model *model, int index) { return model->value[index]; }
void model_lead(struct Model *model, int index, double value) { model->value[index] = value; }
double model_slope(const struct Model *model, int input) { return model->slope[input - INPUT_FIRST]; }
void model_set_slope(struct Model *model, int input, double slope) { model->slope[input - INPUT_FIRST] = slope; }

enum Status model_set(struct Model *model, int index, double value)
{
    const enum Status status = model_check(index, value);
    if (status != STATUS_OK)
        return status;
    model->value[index] = within_bounds(&part.variables[index], value);
    model->warnings |= model->value[index] != value ? WARN_AT_BOUND : 0u;
    if (part.variables[index].causality == PARAMETER)
        model->step = 0;
    return STATUS_OK;
}

void model_reset(struct Model *model)
{
    memset(model, 0, sizeof *model);
    for (int i = 0; i < part.count; ++i)
        model->value[i] = part.variables[i].start;
}

int model_started(const struct Model *model) { return model->started != 0; }

enum Status model_start(struct Model *model, double time)
{
    if (!isfinite(time))
        return STATUS_NOT_FINITE;
    model->value[VAR_TIME] = time;
    model->started = 1;
    model->step = 0;
    return model_evaluate(model);
}

enum Status model_evaluate(struct Model *model)
{
    part.evaluate(model->value);
    for (int i = 0; i < part.count; ++i)
        if (!isfinite(model->value[i]))
            return STATUS_DIVERGED;
    return STATUS_OK;
}

static double nominal(int index) { return part.variables[index].nominal > 0 ? part.variables[index].nominal : 1; }

double model_nominal(const struct Model *model, int state)
{
    (void)model;
    return nominal(state);
}

static void rates(double *value, const int *rate, int count, double *f)
{
    part.evaluate(value);
    for (int n = 0; n < count; ++n)
        f[n] = value[rate[n]];
}

/* The integrals of the response for a step of h, from rates with one state after the other moved from 0 by its nominal
 * value. Where inputs change the response, as at the end of the step, where a long one settles: it is of second order.
 */
static void prepare(struct Model *model, const int *state, const int *rate, int count, double h)
{
    double matrix[STATES * STATES], rest[STATES], moved[STATES];
    struct Model probe = *model;
    for (int n = 0; n < count; ++n)
        probe.value[state[n]] = 0;
    for (int i = 0; i < part.count; ++i)
        if (part.variables[i].causality == INPUT)
            probe.value[i] = part.varies ? model->value[i] + h * model->slope[i - INPUT_FIRST] : 0;
    rates(probe.value, rate, count, rest);
    for (int k = 0; k < count; ++k) {
        probe.value[state[k]] = nominal(state[k]);
        rates(probe.value, rate, count, moved);
        probe.value[state[k]] = 0;
        for (int n = 0; n < count; ++n)
            matrix[n * count + k] = (moved[n] - rest[n]) / nominal(state[k]);
    }
    linear_response(count, matrix, h, model->once, model->twice);
    model->step = h;
}

enum Status model_step(struct Model *model, double step, int stop_at_events, double *taken)
{
    int state[STATES], rate[STATES];
    double now[STATES], end[STATES];
    const int count = model_state_count(), inputs = model_input_count();
    (void)stop_at_events; /* there are none */
    *taken = 0;
    if (!(step > 0 && step <= LONGEST_STEP))
        return STATUS_BAD_STEP;
    for (int n = 0; n < count; ++n) {
        rate[n] = rate_of(n);
        state[n] = part.variables[rate[n]].derivative_of;
    }
    /* Communication steps differ by the rounding of time: the integrals serve for all of them, the rest is a step of
     * first order. */
    if (!(fabs(step - model->step) <= 1e-9 * step))
        prepare(model, state, rate, count, step);
    const double rest = step - model->step;
    rates(model->value, rate, count, now);
    for (int i = INPUT_FIRST; i < INPUT_FIRST + inputs; ++i)
        model->value[i] += step * model->slope[i - INPUT_FIRST];
    rates(model->value, rate, count, end);
    for (int n = 0; n < count; ++n) {
        double by = rest * now[n];
        for (int k = 0; k < count; ++k)
            by += model->once[n * count + k] * now[k] + model->twice[n * count + k] * ((end[k] - now[k]) / step);
        model->value[state[n]] += by;
    }
    model->step = part.varies ? 0 : model->step; /* it holds for this step only */
    model->value[VAR_TIME] += step;
    *taken = step;
    return model_evaluate(model);
}

/* What follows from the parameters stands in the model itself. */
size_t model_wiring_size(void) { return 0; }
void model_wire(const struct Model *model, struct Wiring *wiring) { (void)model, (void)wiring; }
enum Status model_step_wired(struct Model *model, struct Wiring *wiring, double step, int stop_at_events, double *taken)
{
    (void)wiring;
    return model_step(model, step, stop_at_events, taken);
}

/* The integrals of the response belong to the step and the parameters: a state from outside cannot bring others. */
static int belongs(const struct Model *model)
{
    int state[STATES] = {0}, rate[STATES] = {0};
    const int count = model_state_count();
    struct Model own = *model;
    for (int n = 0; n < count; ++n) {
        rate[n] = rate_of(n);
        state[n] = part.variables[rate[n]].derivative_of;
    }
    prepare(&own, state, rate, count, model->step);
    for (int n = 0; n < count * count; ++n)
        if (!(fabs(own.once[n] - model->once[n]) <= 1e-9 * fabs(own.once[n]) &&
              fabs(own.twice[n] - model->twice[n]) <= 1e-9 * fabs(own.twice[n])))
            return 0;
    return 1;
}

const char *model_flaw(const struct Model *model)
{
    if (model->started > 1 || model->warnings > WARN_AT_BOUND)
        return "a flag is not there";
    if (!isfinite(model->value[VAR_TIME]))
        return "the time is no finite number";
    for (int i = 0; i < part.count; ++i) { /* outputs are found anew from these */
        const enum Causality role = part.variables[i].causality;
        if ((role == PARAMETER || role == INPUT) && model_check(i, model->value[i]) != STATUS_OK)
            return "a parameter or an input lies outside its bounds";
        if (part.variables[i].derivative_of && !isfinite(model->value[part.variables[i].derivative_of]))
            return "a continuous state is no finite number";
    }
    for (int k = 0; k < INPUTS; ++k)
        if (!isfinite(model->slope[k]))
            return "a derivative of an input is no finite number";
    if (!(model->step >= 0 && model->step < INFINITY))
        return "the step is no finite number from 0 on";
    return model->step > 0 && !belongs(model) ? "the response over a step is not that of the parameters" : NULL;
}

/* In which time anything moves by the size that it has [s]. */
static double time_scale(const struct Model *model)
{
    double scale = part.time_scale ? part.time_scale(model->value) : 1;
    for (int i = 1; i < part.count; ++i) {
        const int input = part.variables[i].causality == INPUT, state = part.variables[i].derivative_of,
                  moved = input ? i : state;
        const double rate = fabs(input ? model->slope[i - INPUT_FIRST] : state ? model->value[i] : 0);
        scale = rate > 0 ? fmin(scale, fmax(fabs(model->value[moved]), nominal(moved)) / rate) : scale;
    }
    return scale;
}

/* `ahead` seconds on, straight along the slopes and the rates as they are at `model`. */
static void move(const struct Model *model, double ahead, struct Model *room)
{
    room->value[VAR_TIME] = model->value[VAR_TIME] + ahead;
    for (int i = 1; i < part.count; ++i) {
        const int state = part.variables[i].derivative_of;
        if (part.variables[i].causality == INPUT)
            room->value[i] = model->value[i] + ahead * model->slope[i - INPUT_FIRST];
        else if (state)
            room->value[state] = model->value[state] + ahead * model->value[i];
    }
    part.evaluate(room->value);
}

enum Status model_time_derivatives(const struct Model *model, struct Model *room, int count, const int *index,
                                   double *derivatives)
{
    /* Differences of second order along that line: what outputs are of states, inputs and time is smooth over their
     * sizes. Ahead, since a path may begin now. */
    struct Model now = *model;
    const enum Status status = model_evaluate(&now);
    const double h = 1e-4 * time_scale(&now);
    *room = now;
    move(&now, 2 * h, room);
    for (int j = 0; j < count; ++j)
        derivatives[j] = room->value[index[j]];
    move(&now, h, room);
    for (int j = 0; j < count; ++j) {
        const double here = now.value[index[j]];
        derivatives[j] = (2 * (room->value[index[j]] - here) - 0.5 * (derivatives[j] - here)) / h;
        for (int i = 1; i < part.count; ++i)
            if (part.variables[i].derivative_of == index[j])
                derivatives[j] = now.value[i];
    }
    return status;
}

enum Status model_derivatives(const struct Model *model, int known, int count, const int *unknown, double *derivatives)
{
    for (int j = 0; j < count; ++j)
        if (!model_variable(unknown[j]) || !model_variable(known))
            return STATUS_NO_SUCH_VARIABLE;
    if (count == 0)
        return STATUS_OK;
    /* Central differences, of two steps: exact but for rounding where the unknown is linear or quadratic in the known,
     * and of fourth order, in a step that is a part of the value, where it goes by a power of it, as heat by a speed
     * (Richardson's extrapolation). */
    const double value = model->value[known], h = fmax(1e-3 * fabs(value), 1e-6 * nominal(known));
    struct Model at[4];
    for (int k = 0; k < 4; ++k) {
        static const double places[4] = {-1, -0.5, 0.5, 1};
        at[k] = *model;
        at[k].value[known] = value + places[k] * h;
        part.evaluate(at[k].value);
    }
    for (int j = 0; j < count; ++j) {
        const double wide = (at[3].value[unknown[j]] - at[0].value[unknown[j]]) / (2 * h),
                     narrow = (at[2].value[unknown[j]] - at[1].value[unknown[j]]) / h;
        derivatives[j] = (4 * narrow - wide) / 3;
    }
    return STATUS_OK;
}
