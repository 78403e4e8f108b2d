/* How does an instance move on? Steps of co-simulation, events of both interfaces, and what there is to warn of.
 *
 * Time: the host's communication points and the contact's own time may differ by rounding only. The step taken runs
 * from the own time to the host's next point, so that rounding never adds up.
 */
#include "component.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum Answer component_warn(struct Component *c)
{
    const uint32_t fresh = c->contact.warnings & ~c->told;
    if (!fresh)
        return ANSWER_OK;
    c->told |= fresh;
    for (int bit = 0; bit < WARNING_COUNT; ++bit)
        if (fresh >> bit & 1u)
            report(c, ANSWER_WARNING, "at time %g s: %s.", c->contact.value[VAR_TIME][0], kernel_warning_text(bit));
    return c->host.warned;
}

static enum Answer bad_step(struct Component *c, double time, double step, double slack)
{
    const double now = c->contact.value[VAR_TIME][0];
    if (!(step > 0 && step < INFINITY))
        return report(c, ANSWER_ERROR, "the step size is %g s; a finite number above 0 is needed.", step);
    if (!(fabs(time - now) <= slack))
        return report(c, ANSWER_ERROR,
                      "the communication point is %.17g s, but the instance stands at %.17g s; "
                      "they may differ by %.2g s (1e-6 of the step). To go back, restore an FMU state.",
                      time, now, slack);
    if (!(time + step <= c->life.stop + slack))
        return report(c, ANSWER_ERROR, "the step would end at %.17g s, after the stop time %.17g s.", time + step,
                      c->life.stop);
    return report(c, ANSWER_ERROR, "the step size %g s is too small to move the time %.17g s.", step, now);
}

/* Would an input that is ramped by its derivative leave its bounds before the end of the step? */
static int ramps_stay(struct Component *c, double step)
{
    for (int i = INPUT_FIRST; i < INPUT_END && c->life.slope_set; ++i) {
        const double end = c->contact.value[i][0] + c->contact.slope[i - INPUT_FIRST][0] * step;
        const struct Variable *v = kernel_variable(i);
        if (kernel_check(i, end) == KERNEL_OK)
            continue;
        report(c, ANSWER_ERROR,
               "the derivative of %s would lead it to %g %s at the end of the step; allowed is %g to %g.", v->name, end,
               v->unit, v->min, v->max);
        return 0;
    }
    return 1;
}

/* Show the present point to the host. Returns whether it wants the step to end before `target`, which then says where.
 */
static int shown_and_stopped(struct Component *c, double *target)
{
    const double now = c->contact.value[VAR_TIME][0];
    double until = now;
    const int asks = now < *target;
    c->life.mode = asks ? ASKING : INTERMEDIATE;
    c->life.stale = 1;
    const int stop = c->host.show(&c->host, now, asks, &until) && c->host.early_return;
    if (c->life.mode & (ASKING | INTERMEDIATE)) /* else a call from within has failed */
        c->life.mode = STEPPING;
    if (!stop || until >= *target)
        return 0;
    *target = until > now ? until : now;
    return 1;
}

/* From now to `target`, past events or up to the first one, as the host has agreed to at instantiation. */
static enum Status advance(struct Component *c, double whole, struct StepEnd *end)
{
    const int hand_over = c->host.event_mode && c->host.early_return, watched = c->host.show != NULL;
    double *now = c->contact.value[VAR_TIME], target = *now + whole, left = whole, taken;
    for (int stop = hand_over || watched;;) {
        enum Status status = kernel_advance(&c->contact, left, stop, &taken);
        const int at_event = taken < left;
        if (status != KERNEL_OK)
            return status;
        end->event = at_event && hand_over;
        end->early |= end->event;
        if (at_event && !hand_over)
            status = kernel_event(&c->contact);
        if (status != KERNEL_OK)
            return status;
        end->early |= watched && shown_and_stopped(c, &target);
        left = at_event ? target - *now : 0;
        if (end->event || !(left > 0) || c->life.mode != STEPPING)
            return KERNEL_OK;
        stop = stop && taken > 0;
    }
}

enum Answer component_step(struct Component *c, double time, double step, struct StepEnd *end)
{
    const double now = c->contact.value[VAR_TIME][0];
    const double slack = 1e-6 * step + 4 * DBL_EPSILON * fabs(now);
    const double whole = time - now + step;
    *end = (struct StepEnd){.last_time = now};
    if (!(step > 0 && step < INFINITY && fabs(time - now) <= slack && time + step <= c->life.stop + slack &&
          now + whole > now))
        return bad_step(c, time, step, slack);
    if (c->life.event_pending)
        return report(c, ANSWER_ERROR, "an event waits to be handled at time %.17g s; go through Event Mode first.",
                      now);
    if (!ramps_stay(c, whole))
        return ANSWER_ERROR;

    const enum Status status = advance(c, whole, end);
    c->life.last_time = end->last_time = c->contact.value[VAR_TIME][0];
    c->life.stale = 1;
    c->life.event_pending = (uint32_t)end->event;
    if (c->life.slope_set)
        memset(c->contact.slope, 0, sizeof c->contact.slope);
    c->life.slope_set = 0;
    if (status != KERNEL_OK) {
        c->life.mode = STEP_FAILED;
        char why[512];
        kernel_explain(&c->contact, status, why, sizeof why);
        return report(c, end->last_time > now ? c->host.partial_step : ANSWER_ERROR,
                      "the step from %.17g s by %g s ended at %.17g s: %s.", now, step, end->last_time, why);
    }
    return c->life.mode == STEPPING ? component_warn(c) : ANSWER_ERROR;
}

enum Answer component_event(struct Component *c, struct News *news)
{
    double before[STATES];
    for (int i = 0; i < c->state_count; ++i)
        before[i] = c->contact.value[c->state[i]][0];
    const enum Status status = kernel_event(&c->contact);
    if (status != KERNEL_OK)
        return report_kernel(c, ANSWER_ERROR, status);
    c->life.stale = 1;
    c->life.event_pending = 0;
    *news = (struct News){.next_event = kernel_next_event(&c->contact)};
    /* Within a step of co-simulation the contact closes its averaging windows itself: the host need not stop there. */
    news->next_event_defined = c->life.interface == MODEL_EXCHANGE && isfinite(news->next_event);
    for (int i = 0; i < c->state_count; ++i)
        news->states_changed |= c->contact.value[c->state[i]][0] != before[i];
    report(c, ANSWER_OK, "event at time %.17g s%s.", c->contact.value[VAR_TIME][0],
           news->states_changed ? ", states changed" : "");
    return component_warn(c);
}
