/* How does a contact begin, follow a record, and what are its derivatives? Life of one contact around advance.c. */
#include "stages.h"

#include <math.h>

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
    if (index == SLIP_VELOCITY && value != 0 && contact->started && chosen(contact->value, KINEMATICS, 0) == KINEMATICS_INTERNAL)
        contact->warnings |= WARN_UNUSED_SLIP;
    return KERNEL_OK;
}

void kernel_reset(struct Contact *contact)
{
    static const struct Contact blank;
    const int count = kernel_variable_count();
    *contact = blank;
    for (int n = 0; n < count; ++n)
        EACH_LANE contact->value[n][i] = kernel_variable(n)->start;
    EACH_LANE {
        for (int k = 0; k < INDICATORS; ++k)
            contact->sign[k][i] = 1;
        contact->next_step[i] = INFINITY;
    }
}

/* Bristles unloaded, sides as the point at value[TIME] says. */
static enum Status begin(struct Contact *contact)
{
    const struct Wiring w = wire(contact);
    struct Point x;
    const lanes now = {0};
    EACH_LANE {
        contact->next_step[i] = 1 / (200 * contact->value[VIBRATION_FREQUENCY][i]);
        contact->largest_difference[i] = pow(10 * contact->value[RELATIVE_TOLERANCE][i], 0.6); /* see badness in advance.c */
    }
    if (w.law->rest) {
        path_at(contact, &w, now, &x);
        EACH_LANE x.direction[i] = x.cutting[i] = 1;
        friction_open(contact, &w, now, &x);
        w.law->rest(w.law_p, &x, contact->memory);
    }
    return kernel_event(contact);
}

/* The bristle deflection that one vibration cycle brings back. For a law that is linear in z one cycle maps z to c + E z, and two
 * cycles give z_0 = c / (1 - E); otherwise the same secant is repeated. */
static enum Status find_periodic(struct Contact *contact)
{
    const double start = contact->value[TIME][0], period = 1 / contact->value[VIBRATION_FREQUENCY][0];
    struct Contact trial = *contact;
    lanes z = {0}, miss = {0}, z_before, miss_before;
    int found = 0;
    for (int n = 0; n < 20 && !found; ++n) {
        double taken;
        EACH_LANE {
            trial.value[BRISTLE_DEFLECTION][i] = z[i];
            trial.value[TIME][i] = start;
            z_before[i] = n == 0 ? 0 : z_before[i];
            miss_before[i] = n == 0 ? 0 : miss_before[i];
        }
        const enum Status begun = kernel_event(&trial);
        const enum Status status = begun == KERNEL_OK ? kernel_advance(&trial, period, 0, &taken) : begun;
        if (status != KERNEL_OK)
            return status;
        found = 1;
        EACH_LANE {
            const double reach = larger(trial.value[F_C][i], trial.value[F_S][i]) / trial.value[SIGMA0][i];
            miss[i] = trial.value[BRISTLE_DEFLECTION][i] - z[i];
            found &= fabs(miss[i]) <= 1e-2 * trial.value[RELATIVE_TOLERANCE][i] * reach;
            const double slope = n > 0 && z[i] != z_before[i] ? (miss[i] - miss_before[i]) / (z[i] - z_before[i]) : -1;
            z_before[i] = z[i];
            miss_before[i] = miss[i];
            z[i] -= found ? 0 : slope < 0 ? miss[i] / slope : -miss[i];
        }
    }
    EACH_LANE contact->value[BRISTLE_DEFLECTION][i] = z[i];
    for (int n = 0; n < MEMORY; ++n)
        EACH_LANE contact->memory[n][i] = trial.memory[n][i];
    contact->warnings |= found ? 0u : WARN_NOT_PERIODIC;
    return KERNEL_OK;
}

enum Status kernel_start(struct Contact *contact, double time)
{
    if (!isfinite(time))
        return KERNEL_NOT_FINITE;
    EACH_LANE contact->value[TIME][i] = contact->window_origin = time;
    contact->started = 1;
    enum Status status = begin(contact);
    if (chosen(contact->value, INITIAL_STATE, 0) == PERIODIC && status == KERNEL_OK) {
        const int cyclic = chosen(contact->value, KINEMATICS, 0) != KINEMATICS_EXTERNAL;
        contact->warnings |= cyclic ? 0u : WARN_NOT_PERIODIC;
        status = cyclic ? find_periodic(contact) : KERNEL_OK;
        if (status == KERNEL_OK)
            status = kernel_event(contact);
    }
    for (int n = 0; n < MEANS; ++n)
        EACH_LANE contact->window_start[n][i] = contact->value[kernel_state(n + 2)][i];
    if (contact->value[SLIP_VELOCITY][0] != 0 && chosen(contact->value, KINEMATICS, 0) == KINEMATICS_INTERNAL)
        contact->warnings |= WARN_UNUSED_SLIP;
    return status;
}

enum Status kernel_run(struct Contact *contact, int64_t count, const double *times, int input_count, const int *input_index,
                       const double *inputs, int output_count, const int *output_index, double *outputs, int64_t *done)
{
    *done = 0;
    for (int64_t n = 0; n < count; ++n) {
        const double step = n > 0 ? times[n] - times[n - 1] : 0;
        enum Status status = KERNEL_OK;
        double taken;
        for (int j = 0; j < input_count; ++j) {
            const double *column = inputs + j, now = column[n * input_count], before = column[(n > 0 ? n - 1 : 0) * input_count];
            const int at = input_index[j] - INPUT_FIRST;
            status = status == KERNEL_OK ? kernel_check(input_index[j], now) : status;
            EACH_LANE contact->slope[at][i] = n > 0 ? (now - before) / step : 0;
        }
        if (status == KERNEL_OK && n > 0)
            status = kernel_advance(contact, step, 0, &taken);
        for (int j = 0; j < input_count && status == KERNEL_OK; ++j) {
            status = kernel_set(contact, input_index[j], 0, inputs[n * input_count + j]);
            EACH_LANE {
                contact->slope[input_index[j] - INPUT_FIRST][i] = 0;
                contact->value[input_index[j]][i] = inputs[n * input_count + j];
            }
        }
        if (status == KERNEL_OK)
            status = kernel_evaluate(contact);
        if (status != KERNEL_OK)
            return status;
        for (int j = 0; j < output_count; ++j)
            outputs[n * output_count + j] = contact->value[output_index[j]][0];
        *done = n + 1;
    }
    return KERNEL_OK;
}

enum Status kernel_derivative(const struct Contact *contact, int unknown, int known, double *derivative)
{
    struct Contact probe = *contact;
    const struct Variable *variable = kernel_variable(known);
    if (!variable || !kernel_variable(unknown))
        return KERNEL_NO_SUCH_VARIABLE;
    /* Central differences, of second order from within where a bound is near (a magnitude at 0 has no other side). The step balances
     * rounding and truncation, both near 1e-10 of the nominal. */
    const double value = contact->value[known][0], scale = variable->nominal > 0 ? variable->nominal : 1;
    const double h = cbrt(2.3e-16) * larger(fabs(value), 1e-2 * scale);
    static const double place[3][3] = {{-1, 0, 1}, {0, 1, 2}, {-2, -1, 0}}, weight[3][3] = {{-0.5, 0, 0.5}, {-1.5, 2, -0.5}, {0.5, -2, 1.5}};
    const int kind = value - h < variable->min ? 1 : value + h > variable->max ? 2 : 0;
    double sum = 0;
    for (int n = 0; n < 3; ++n) {
        if (weight[kind][n] == 0)
            continue;
        EACH_LANE probe.value[known][i] = contact->value[known][i] + place[kind][n] * h;
        const enum Status status = kernel_evaluate(&probe);
        if (status != KERNEL_OK)
            return status;
        sum += weight[kind][n] * probe.value[unknown][0];
    }
    *derivative = sum / h;
    return KERNEL_OK;
}
