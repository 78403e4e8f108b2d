/* How does a contact begin, and what are its derivatives? Life of one contact around advance.c. */
#include "shared.h"
#include "stages.h"

#include <math.h>

enum Status kernel_check(int index, double value) { return check_value(kernel_variable(index), value); }
double kernel_bound_slack(int index)
{
    const struct Variable *variable = kernel_variable(index);
    return variable ? bound_slack(variable) : 0;
}

void note_bound(struct Contact *contact, int index, int lane, int outside)
{
    const uint64_t bit = (uint64_t)1 << (index - INPUT_FIRST);
    contact->at_bound[lane] = outside ? contact->at_bound[lane] | bit : contact->at_bound[lane] & ~bit;
    contact->warnings |= outside ? WARN_AT_BOUND : 0u;
}

enum Status kernel_set(struct Contact *contact, int index, int lane, double value)
{
    const enum Status status = kernel_check(index, value);
    if (status != STATUS_OK)
        return status;
    const double kept = within_bounds(kernel_variable(index), value);
    contact->value[index][lane] = kept;
    follow_recent(contact, index, lane);
    if (index >= INPUT_FIRST && index < INPUT_END)
        note_bound(contact, index, lane, kept != value);
    if (index == VAR_SLIP_VELOCITY && value != 0 && contact->started &&
        chosen(contact->value, VAR_KINEMATICS, 0) == KINEMATICS_INTERNAL)
        contact->warnings |= WARN_UNUSED_SLIP;
    return STATUS_OK;
}

void kernel_lead(struct Contact *contact, int index, double value)
{
    contact->value[index][0] = value;
    follow_recent(contact, index, 0);
}

void kernel_reset(struct Contact *contact)
{
    static const struct Contact blank;
    const int count = kernel_variable_count();
    *contact = blank;
    for (int n = 0; n < count; ++n)
        EACH_LANE
            contact->value[n][i] = kernel_variable(n)->start;
    EACH_LANE {
        for (int k = 0; k < INDICATORS; ++k)
            contact->sign[k][i] = 1;
        contact->next_step[i] = INFINITY;
    }
}

double largest_difference(const struct Contact *contact, int i)
{
    return pow(10 * contact->value[VAR_RELATIVE_TOLERANCE][i], 0.6); /* see badness in tolerance.c */
}

/* Bristles unloaded, sides as the point at value[VAR_TIME] says. */
static enum Status begin(struct Contact *contact)
{
    const struct Configuration w = wire(contact);
    if (w.delays)
        feel_slip_now(contact, &w); /* nothing is known but what is given now */
    EACH_LANE {
        contact->next_step[i] = 1 / (200 * contact->value[VAR_VIBRATION_FREQUENCY][i]);
        contact->largest_difference[i] = largest_difference(contact, i);
        begin_breakpoints(contact, &w, i);
    }
    if (w.law->rest)
        rest_law(&w, contact->memory);
    return kernel_event(contact);
}

/* Of a bristle that is bent at the start, what stands in its place, or beside it, is loaded alike. */
static enum Status load_alike(struct Contact *contact, const struct Configuration *w)
{
    static const lanes now;
    struct Point x;
    int begins = 0, bent = 0;
    for (int n = 0; n < w->on_count; ++n)
        begins |= w->on[n]->begin != NULL;
    EACH_LANE
        bent |= contact->value[VAR_BRISTLE_DEFLECTION][i] != 0;
    if (!begins || !bent)
        return STATUS_OK;
    point_at(contact, w, now, &x);
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->begin)
            w->on[n]->begin(w->on_p[n], &x, x.state + w->on_state[n]);
    store_states(contact, w, &x);
    for (int i = 0; i < LANES; ++i)
        forget_past(contact, i); /* of bristles that nothing bent */
    return kernel_event(contact);
}

enum Status kernel_start(struct Contact *contact, double time)
{
    contact->effects_on = effects_switched_on(contact);
    const struct Configuration w = wire(contact);
    int rivals[2];
    if (!isfinite(time))
        return STATUS_NOT_FINITE;
    if (rivals_among(contact->effects_on, rivals))
        return STATUS_RIVALS;
    if (kernel_averages(contact) && w.kinematics == KINEMATICS_EXTERNAL)
        return STATUS_NO_CYCLE;
    EACH_LANE
        contact->value[VAR_TIME][i] = contact->window_origin = time;
    EACH_LANE
        contact->slip_count[i] = contact->slip_first[i] = contact->slip_settled[i] = contact->follows[i] =
            contact->followed_slip[i] = 0;
    contact->started = 1;
    enum Status status = begin(contact);
    if (status == STATUS_OK)
        status = load_alike(contact, &w);
    if (status == STATUS_OK && chosen(contact->value, VAR_INITIAL_STATE, 0) == STEADY)
        status = settle_states(contact);
    if (status == STATUS_OK && kernel_averages(contact))
        return average_start(contact);
    if (chosen(contact->value, VAR_INITIAL_STATE, 0) == PERIODIC && status == STATUS_OK) {
        const int cyclic = chosen(contact->value, VAR_KINEMATICS, 0) != KINEMATICS_EXTERNAL;
        contact->warnings |= cyclic ? 0u : WARN_NOT_PERIODIC;
        status = cyclic ? find_periodic(contact) : STATUS_OK;
        if (status == STATUS_OK)
            status = kernel_event(contact);
    }
    EACH_LANE
        open_window(contact, i);
    if (contact->value[VAR_SLIP_VELOCITY][0] != 0 && chosen(contact->value, VAR_KINEMATICS, 0) == KINEMATICS_INTERNAL)
        contact->warnings |= WARN_UNUSED_SLIP;
    return status;
}

enum Status kernel_derivatives(const struct Contact *contact, int known, int count, const int *unknown,
                               double *derivatives)
{
    struct Contact probe = *contact;
    const struct Variable *variable = kernel_variable(known);
    for (int j = 0; j < count; ++j) {
        if (!variable || !kernel_variable(unknown[j]))
            return STATUS_NO_SUCH_VARIABLE;
        derivatives[j] = 0;
    }
    if (count == 0)
        return STATUS_OK;
    /* Central differences, of second order from within where a bound is near (a magnitude at 0 has no other side). The
     * step balances rounding and truncation, both near 1e-10 of the nominal. */
    const double value = contact->value[known][0], scale = variable->nominal > 0 ? variable->nominal : 1;
    const int averages = kernel_averages(contact); /* a mean over a cycle is good to the tolerance of its steps only */
    const double h = (averages ? 1e-3 : cbrt(2.3e-16)) * larger(fabs(value), 1e-2 * scale);
    static const double place[3][3] = {{-1, 0, 1}, {0, 1, 2}, {-2, -1, 0}},
                        weight[3][3] = {{-0.5, 0, 0.5}, {-1.5, 2, -0.5}, {0.5, -2, 1.5}};
    const int kind = value - h < variable->min ? 1 : value + h > variable->max ? 2 : 0;
    for (int n = 0; n < 3; ++n) {
        if (weight[kind][n] == 0)
            continue;
        EACH_LANE {
            probe.value[known][i] = contact->value[known][i] + place[kind][n] * h;
            follow_recent(&probe, known, i);
        }
        const enum Status status = averages ? average_here(&probe) : kernel_evaluate(&probe);
        if (status != STATUS_OK)
            return status;
        for (int j = 0; j < count; ++j)
            derivatives[j] += weight[kind][n] * probe.value[unknown[j]][0];
    }
    for (int j = 0; j < count; ++j)
        derivatives[j] /= h;
    return STATUS_OK;
}
