/* How does an instance move on? Steps of co-simulation, events of both interfaces, and what there is to warn of.
 *
 * Time: the host's communication points and the model's own time may differ by rounding only. The step taken runs
 * from the own time to the host's next point, so that rounding never adds up.
 */
#include "component.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum Answer component_warn(struct Component *c)
{
    const uint32_t fresh = model_warnings(c->model) & ~c->told;
    if (!fresh)
        return ANSWER_OK;
    c->told |= fresh;
    for (int bit = 0; bit < model_warning_count(); ++bit)
        if (fresh >> bit & 1u) {
            char text[512];
            model_explain_warning(c->model, bit, text, sizeof text);
            report(c, ANSWER_WARNING, "at time %g s: %s.", present_time(c), text);
        }
    return c->host.warned;
}

static enum Answer bad_step(struct Component *c, double time, double step, double slack)
{
    const double now = present_time(c);
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

/* Would an input that is ramped by its derivative leave its bounds before the end of the step? One that misses them by
 * a hair is led onto them. */
static int ramps_stay(struct Component *c, double step)
{
    for (int place = 0; place < model_input_count() && c->life.slope_set; ++place) {
        const int i = model_input(place);
        const double now = model_get(c->model, i), end = now + model_slope(c->model, i) * step;
        const struct Variable *v = model_variable(i);
        if (model_check(i, end) == STATUS_OK) {
            const double held = within_bounds(v, end);
            if (held != end)
                model_set_slope(c->model, i, (held - now) / step);
            if (fabs(held - end) > 4 * DBL_EPSILON * fabs(now)) /* no rounding of a ramp that means to end there */
                held_on_bound(c, i, end);
            continue;
        }
        report(c, ANSWER_ERROR,
               "the derivative of %s would lead it to %g %s at the end of the step; allowed is %g to %g.", v->name, end,
               v->unit, v->min, v->max);
        return 0;
    }
    return 1;
}

/* Show the present point to the host. Returns whether it wants the step to end before `target`, which then says where.
 */
static int stopped_after_showing(struct Component *c, double *target)
{
    const double now = present_time(c);
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
    double target = present_time(c) + whole, left = whole, taken;
    for (int stop = hand_over || watched;;) {
        if (!c->wired)
            model_wire(c->model, c->wiring);
        c->wired = 1;
        enum Status status = model_step_wired(c->model, c->wiring, left, stop, &taken);
        const int at_event = taken < left;
        if (status != STATUS_OK)
            return status;
        end->event = at_event && hand_over;
        end->early |= end->event;
        if (at_event && !hand_over)
            status = model_event(c->model);
        if (status != STATUS_OK)
            return status;
        end->early |= watched && stopped_after_showing(c, &target);
        left = at_event ? target - present_time(c) : 0;
        if (end->event || !(left > 0) || c->life.mode != STEPPING)
            return STATUS_OK;
        stop = stop && taken > 0;
    }
}

enum Answer component_step(struct Component *c, double time, double step, struct StepEnd *end)
{
    const double now = present_time(c);
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

    drop_kept_slopes(c);
    const enum Status status = advance(c, whole, end);
    c->life.last_time = end->last_time = present_time(c);
    c->life.stale = 1;
    c->life.event_pending = (uint32_t)end->event;
    for (int place = 0; place < model_input_count() && c->life.slope_set; ++place) {
        const int i = model_input(place);
        model_lead(c->model, i, within_bounds(model_variable(i), model_get(c->model, i))); /* rounding misses them */
    }
    c->life.slope_kept = c->life.slope_set;
    c->life.slope_set = 0;
    if (status != STATUS_OK) {
        c->life.mode = STEP_FAILED;
        char why[512];
        model_explain(c->model, status, why, sizeof why);
        return report(c, end->last_time > now ? c->host.partial_step : ANSWER_ERROR,
                      "the step from %.17g s by %g s ended at %.17g s: %s.", now, step, end->last_time, why);
    }
    return c->life.mode == STEPPING ? component_warn(c) : ANSWER_ERROR;
}

enum Answer component_event(struct Component *c, struct News *news)
{
    memcpy(c->preview, c->model, model_size()); /* it has no use of its own but in initialization mode */
    const enum Status status = model_event(c->model);
    if (status != STATUS_OK)
        return report_status(c, ANSWER_ERROR, status);
    c->life.stale = 1;
    c->life.event_pending = 0;
    /* Also where the states are as they were and their rates jump, as on entry: many hosts restart on this flag only.
     */
    *news =
        (struct News){.next_event = model_next_event(c->model), .states_changed = model_turned(c->preview, c->model)};
    news->nominals_changed = c->life.interface == MODEL_EXCHANGE && c->tuned;
    c->tuned = 0;
    /* Within a step of co-simulation the model acts on its events itself: the host need not stop there. */
    news->next_event_defined = c->life.interface == MODEL_EXCHANGE && isfinite(news->next_event);
    report(c, ANSWER_OK, "event at time %.17g s%s.", present_time(c),
           news->states_changed ? ", states or rates changed" : "");
    return component_warn(c);
}
