/* How does the fuzz lead an instance through its life? From instantiation to termination, and through events. */
#include "acts.h"

#include <math.h>

void forget_given(struct One *one)
{
    for (int i = 0; i < CAPACITY; ++i)
        one->given[i] = NAN;
}

void initialise(struct One *one)
{
    const int with_tolerance = chance(0.2), with_stop = chance(0.2);
    const double tolerance = chance(0.9) ? spread(1e-9, 1e-2) : strange();
    const double start = chance(0.8) ? 0 : chance(0.9) ? between(-1, 10) : strange();
    const double stop = chance(0.95) ? start + spread(1e-6, 1) : strange();
    const int fine = isfinite(start) && !(with_stop && (!isfinite(stop) || stop < start));
    const struct Variable *v = model_variable(model_tolerance());
    const enum Verdict verdict = !fine                                              ? MUST_FAIL
                                 : with_tolerance && v && !is_allowed(v, tolerance) ? MAY_FAIL
                                                                                    : MUST_PASS;
    if (v)
        one->given[model_tolerance()] = NAN;
    const int again = one->version == 3 || !one->set_up || chance(0.1);
    if (again) { /* else it keeps the times that it was set up with, in whatever state was restored */
        one->start = start;
        one->stop = with_stop ? stop : INFINITY;
    }
    if (one->version == 3) {
        if (CALL(one, "fmi3EnterInitializationMode", INSTANTIATED, verdict,
                 fmi3EnterInitializationMode(one->c, with_tolerance, tolerance, start, with_stop, stop)) <= WARNING)
            one->mode = INITIALIZING;
        return;
    }
    if (again && CALL(one, "fmi2SetupExperiment", INSTANTIATED, verdict,
                      fmi2SetupExperiment(one->c, with_tolerance, tolerance, start, with_stop, stop)) <= WARNING)
        one->set_up = 1;
    if (CALL(one, "fmi2EnterInitializationMode", INSTANTIATED, one->set_up ? MUST_PASS : MUST_FAIL,
             fmi2EnterInitializationMode(one->c)) <= WARNING)
        one->mode = INITIALIZING;
}

void enter_unprepared(struct One *one)
{
    if (one->version == 3) {
        initialise(one);
        return;
    }
    if (CALL(one, "fmi2EnterInitializationMode", INSTANTIATED, one->set_up ? MUST_PASS : MUST_FAIL,
             fmi2EnterInitializationMode(one->c)) <= WARNING)
        one->mode = INITIALIZING;
}

void exit_initialisation(struct One *one)
{
    if (CALL(one, NAME("ExitInitializationMode", "ExitInitializationMode"), INITIALIZING, MAY_FAIL,
             EITHER(fmi2ExitInitializationMode(one->c), fmi3ExitInitializationMode(one->c))) <= WARNING)
        one->mode = one->interface == MODEL_EXCHANGE || one->event_mode ? EVENT : STEPPING;
}

void terminate(struct One *one)
{
    if (CALL(one, NAME("Terminate", "Terminate"), RUNNING | STEP_FAILED, MUST_PASS,
             EITHER(fmi2Terminate(one->c), fmi3Terminate(one->c))) <= WARNING)
        one->mode = TERMINATED;
}

void reset(struct One *one)
{
    if (CALL(one, NAME("Reset", "Reset"), ANY_MODE, MUST_PASS, EITHER(fmi2Reset(one->c), fmi3Reset(one->c))) > WARNING)
        return;
    one->mode = INSTANTIATED;
    one->set_up = one->pending = one->ramped = 0;
    forget_given(one);
}

void set_logging_of(struct One *one)
{
    static const char *const names[] = {"logEvents",      "logStatusWarning", "logStatusDiscard", "logStatusError",
                                        "logStatusFatal", "logAll",           "logNonsense",      ""};
    const char *chosen[3];
    enum Verdict verdict = MUST_PASS;
    const size_t count = (size_t)below(4);
    for (size_t i = 0; i < count; ++i) {
        const int n = chance(0.95) ? below(6) : 6 + below(2);
        chosen[i] = names[n];
        verdict = n > 5 ? MUST_FAIL : verdict;
    }
    const int on = below(2);
    if (CALL(one, NAME("SetDebugLogging", "SetDebugLogging"), ANY_MODE, verdict,
             EITHER(fmi2SetDebugLogging(one->c, on, count, chosen), fmi3SetDebugLogging(one->c, on, count, chosen))) >
        WARNING)
        return;
    CALL(one, NAME("SetDebugLogging", "SetDebugLogging"), ANY_MODE, MUST_PASS,
         EITHER(fmi2SetDebugLogging(one->c, 1, 0, NULL), fmi3SetDebugLogging(one->c, 1, 0, NULL)));
    one->logging = 1;
}

void configure(struct One *one)
{
    if (one->version == 2)
        return;
    if (one->mode == CONFIGURING || chance(0.2)) {
        if (CALL(one, "fmi3ExitConfigurationMode", CONFIGURING, MUST_PASS, fmi3ExitConfigurationMode(one->c)) <=
            WARNING)
            one->mode = INSTANTIATED;
    } else if (CALL(one, "fmi3EnterConfigurationMode", INSTANTIATED, MUST_PASS, fmi3EnterConfigurationMode(one->c)) <=
               WARNING)
        one->mode = CONFIGURING;
}

void enter_event_mode(struct One *one)
{
    const unsigned legal = one->version == 2 ? INTEGRATING | EVENT : INTEGRATING | STEPPING;
    const enum Verdict verdict = one->interface == CO_SIMULATION && !one->event_mode ? MUST_FAIL : MUST_PASS;
    if (CALL(one, NAME("EnterEventMode", "EnterEventMode"), legal, verdict,
             EITHER(fmi2EnterEventMode(one->c), fmi3EnterEventMode(one->c))) <= WARNING)
        one->mode = EVENT;
}

void update(struct One *one)
{
    double next = NAN;
    int status, defined = 0;
    if (one->version == 2) {
        fmi2EventInfo info;
        const int none = chance(0.01);
        status = CALL(one, "fmi2NewDiscreteStates", EVENT, none ? MUST_FAIL : MAY_FAIL,
                      fmi2NewDiscreteStates(one->c, none ? NULL : &info));
        if (!none && status <= WARNING) {
            defined = info.nextEventTimeDefined;
            next = info.nextEventTime;
        }
    } else {
        fmi3Boolean flag[5] = {0};
        status = CALL(one, "fmi3UpdateDiscreteStates", EVENT, MAY_FAIL,
                      fmi3UpdateDiscreteStates(one->c, &flag[0], &flag[1], &flag[2], &flag[3], &flag[4], &next));
        defined = flag[4];
    }
    if (defined)
        judge(one, status, "next event", &next, 1);
    if (status <= WARNING)
        one->pending = 0;
}

void leave_event_mode(struct One *one)
{
    const int solver = one->version == 2 || (one->interface == MODEL_EXCHANGE) != chance(0.02);
    if (solver) {
        const enum Verdict verdict = one->interface == MODEL_EXCHANGE ? MUST_PASS : MUST_FAIL;
        if (CALL(one, NAME("EnterContinuousTimeMode", "EnterContinuousTimeMode"), EVENT, verdict,
                 EITHER(fmi2EnterContinuousTimeMode(one->c), fmi3EnterContinuousTimeMode(one->c))) <= WARNING)
            one->mode = INTEGRATING;
    } else if (CALL(one, "fmi3EnterStepMode", EVENT,
                    one->interface == CO_SIMULATION && !one->pending ? MUST_PASS : MUST_FAIL,
                    fmi3EnterStepMode(one->c)) <= WARNING)
        one->mode = STEPPING;
}
