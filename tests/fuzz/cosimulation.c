/* How does the fuzz step an instance? Forward mostly, and with other calls in the middle of a step. */
#include "acts.h"

#include <math.h>

void last_time(struct One *one)
{
    double time = NAN;
    const int status =
        CALL(one, "fmi2GetRealStatus", ANY_MODE, MUST_PASS, fmi2GetRealStatus(one->c, fmi2LastSuccessfulTime, &time));
    judge(one, status, "last time", &time, 1);
}

/* Over so many vibration cycles that some of them need not be run. */
static double span_of_cycles(void) { return spread(1e-4, 1e-2); }
static double span_of_any_step(void) { return chance(0.03) ? span_of_cycles() : span_of_step(); }

void step(struct One *one)
{
    const double now = time_of(one);
    if (isnan(now) && one->mode != STEPPING)
        return;
    double time = now, h = span_of_any_step();
    if (chance(0.02))
        time = chance(0.5) ? strange() : now + h;
    else if (chance(0.05))
        time = nextafter(now, now + 1);
    const double slack = 1e-6 * h + 1e-15 * fabs(now);
    const int fine =
        h > 0 && h < INFINITY && fabs(time - now) <= 2 * slack && !(time + h > one->stop + 2 * slack) && !one->pending;
    double last = NAN;
    fmi3Boolean event = false, terminates = false, early = false;
    int status;
    tally.steps += 1;
    if (one->version == 2)
        status =
            CALL(one, "fmi2DoStep", STEPPING, fine ? MAY_FAIL : MUST_FAIL, fmi2DoStep(one->c, time, h, chance(0.5)));
    else
        status = CALL(one, "fmi3DoStep", STEPPING, fine ? MAY_FAIL : MUST_FAIL,
                      fmi3DoStep(one->c, time, h, chance(0.5), &event, &terminates, &early, &last));
    tally.steps_done += status <= WARNING;
    for (int place = 0; one->ramped && place < model_input_count(); ++place)
        one->given[model_input(place)] = NAN;
    if (status == DISCARD)
        one->mode = one->version == 2 ? STEP_FAILED : one->mode;
    if (status <= WARNING && one->version == 3)
        judge(one, status, "last time", &last, 1);
    if (status <= DISCARD && one->version == 2)
        last_time(one);
    if (event)
        one->pending = 1;
    if (event && !(one->event_mode && one->early_return))
        finding("asks for event handling that was not agreed upon");
    if (status <= WARNING && !early) {
        const double reached = time_of(one);
        if (one->mode == STEPPING && !(fabs(reached - (time + h)) <= 2 * slack + 1e-15 * fabs(time + h)))
            finding("the step to %.17g s ended at %.17g s", time + h, reached);
    }
    if (chance(0.3))
        get_all(one);
}

/* A step, taken back and taken again: to the last bit the same. */
void step_and_back(struct One *one)
{
    struct Saved *const at = &saved[0];
    unsigned reference[CAPACITY];
    double value[2][CAPACITY];
    size_t count = 0;
    const double h = chance(0.9) ? spread(1e-9, 1e-5) : span_of_cycles();
    for (int i = 0; i < variables; ++i)
        if (sort_of(i) == REALS)
            reference[count++] = (unsigned)i;
    save_at(one, at);
    for (int n = 0; n < 2 && one->mode == STEPPING && !one->pending; ++n) {
        const double now = time_of(one);
        double last;
        fmi3Boolean flag[3];
        if (one->mode != STEPPING || now + h > one->stop || one->early_return)
            return;
        const int status = CALL(one, NAME("DoStep", "DoStep"), STEPPING, MAY_FAIL,
                                EITHER(fmi2DoStep(one->c, now, h, 0),
                                       fmi3DoStep(one->c, now, h, false, &flag[0], &flag[1], &flag[2], &last)));
        if (status > WARNING || CALL(one, get_names[one->version - 2][REALS], reading(one), MAY_FAIL,
                                     get_numbers(one, REALS, reference, count, value[n])) > WARNING) {
            one->mode = status == DISCARD && one->version == 2 ? STEP_FAILED : one->mode;
            return;
        }
        judge(one, status, "value", value[n], count);
        if (n == 0)
            restore_from(one, at);
        else
            for (size_t i = 0; i < count; ++i)
                if (value[0][i] != value[1][i] && !one->watched) {
                    finding("%s is %.17g, and %.17g after the same step again", model_variable((int)reference[i])->name,
                            value[0][i], value[1][i]);
                    return;
                }
    }
}

void update_within(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean asks, fmi3Boolean reads,
                   fmi3Boolean finished, fmi3Boolean may_return, fmi3Boolean *wants_return, fmi3Float64 *until)
{
    struct One *one = stepped;
    (void)environment;
    if (!isfinite(time))
        finding("shows the time %g", time);
    if (!reads || !finished || may_return != (one->early_return != 0))
        finding("tells a wrong flag within a step");
    if (one->mode == FAILED)
        finding("goes on with a step in which a call has failed");
    const struct Outer outer = aside(one);
    one->mode = asks ? ASKING : INTERMEDIATE;
    one->updates += 1;
    if (one->updates % 8 == 0)
        get_some(one);
    if (asks && one->mode != FAILED && chance(0.05))
        set_some(one);
    if (one->mode != FAILED && chance(0.002)) {
        double last;
        fmi3Boolean flag[3];
        CALL(one, "fmi3DoStep", STEPPING, MUST_FAIL,
             fmi3DoStep(one->c, time, 1e-6, true, &flag[0], &flag[1], &flag[2], &last));
    }
    resume(one, &outer);
    *wants_return = may_return && chance(0.02);
    *until = chance(0.9) ? time + spread(1e-9, 1e-5) : chance(0.5) ? time : strange();
}

void ask_status(struct One *one)
{
    fmi2Boolean truth;
    fmi2Integer whole;
    fmi2Status status;
    fmi2String text;
    switch (below(6)) {
    case 0:
        CALL(one, "fmi2CancelStep", ANY_MODE, MUST_FAIL, fmi2CancelStep(one->c));
        break;
    case 1:
        CALL(one, "fmi2GetStatus", ANY_MODE, MUST_FAIL, fmi2GetStatus(one->c, fmi2DoStepStatus, &status));
        break;
    case 2:
        CALL(one, "fmi2GetIntegerStatus", ANY_MODE, MUST_FAIL,
             fmi2GetIntegerStatus(one->c, (fmi2StatusKind)below(5), &whole));
        break;
    case 3:
        CALL(one, "fmi2GetStringStatus", ANY_MODE, MUST_FAIL, fmi2GetStringStatus(one->c, fmi2PendingStatus, &text));
        break;
    case 4:
        CALL(one, "fmi2GetBooleanStatus", ANY_MODE, MUST_PASS, fmi2GetBooleanStatus(one->c, fmi2Terminated, &truth));
        break;
    default:
        last_time(one);
    }
}
