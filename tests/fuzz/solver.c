/* What does the fuzz ask as a solver of model exchange would? Times, states, rates, derivatives; and what no instance
 * has. */
#include "acts.h"

#include <math.h>

void completed(struct One *one)
{
    int status;
    if (one->version == 2) {
        fmi2Boolean event, terminates;
        status = CALL(one, "fmi2CompletedIntegratorStep", INTEGRATING, MAY_FAIL,
                      fmi2CompletedIntegratorStep(one->c, 1, &event, &terminates));
    } else {
        fmi3Boolean event, terminates;
        status = CALL(one, "fmi3CompletedIntegratorStep", INTEGRATING, MAY_FAIL,
                      fmi3CompletedIntegratorStep(one->c, true, &event, &terminates));
    }
    (void)status;
}

static unsigned solving(const struct One *one)
{
    return one->version == 2 ? SHOWING & ~(unsigned)(STEPPING | STEP_FAILED)
                             : INITIALIZING | EVENT | INTEGRATING | TERMINATED | FAILED;
}

/* FMI 3 refuses what belongs to the other interface. */
static enum Verdict for_solvers(const struct One *one)
{
    return one->version == 3 && one->interface == CO_SIMULATION ? MUST_FAIL : MAY_FAIL;
}

void look_as_solver(struct One *one)
{
    double x[STATES + 1];
    const int odd = chance(0.02);
    const size_t count = (size_t)states + (odd ? 1 : 0), signs = (size_t)model_indicator_count() + (odd ? 1 : 0);
    const enum Verdict verdict = odd ? MUST_FAIL : for_solvers(one);
    int status;
    switch (below(4)) {
    case 0:
        status =
            CALL(one, NAME("GetDerivatives", "GetContinuousStateDerivatives"), solving(one), verdict,
                 EITHER(fmi2GetDerivatives(one->c, x, count), fmi3GetContinuousStateDerivatives(one->c, x, count)));
        judge(one, status, "rate", x, odd ? 0 : count);
        break;
    case 1:
        status = CALL(one, NAME("GetEventIndicators", "GetEventIndicators"), solving(one), verdict,
                      EITHER(fmi2GetEventIndicators(one->c, x, signs), fmi3GetEventIndicators(one->c, x, signs)));
        judge(one, status, "indicator", x, odd ? 0 : signs);
        break;
    case 2:
        status = CALL(one, NAME("GetContinuousStates", "GetContinuousStates"), solving(one), verdict,
                      EITHER(fmi2GetContinuousStates(one->c, x, count), fmi3GetContinuousStates(one->c, x, count)));
        judge(one, status, "state", x, odd ? 0 : count);
        break;
    default:
        status = CALL(one, NAME("GetNominalsOfContinuousStates", "GetNominalsOfContinuousStates"),
                      one->version == 2 ? ANY_MODE & ~(unsigned)(STEPPING | STEP_FAILED) : solving(one) | INSTANTIATED,
                      verdict,
                      EITHER(fmi2GetNominalsOfContinuousStates(one->c, x, count),
                             fmi3GetNominalsOfContinuousStates(one->c, x, count)));
        judge(one, status, "nominal", x, odd ? 0 : count);
    }
}

void set_time_of(struct One *one, double time)
{
    CALL(one, NAME("SetTime", "SetTime"), one->version == 2 ? EVENT | INTEGRATING : INTEGRATING,
         isfinite(time) ? MUST_PASS : MUST_FAIL, EITHER(fmi2SetTime(one->c, time), fmi3SetTime(one->c, time)));
}

static void set_states_of(struct One *one, const double *x)
{
    int all = 1;
    for (int i = 0; i < states; ++i)
        all &= isfinite(x[i]) != 0;
    CALL(
        one, NAME("SetContinuousStates", "SetContinuousStates"), INTEGRATING, all ? MUST_PASS : MUST_FAIL,
        EITHER(fmi2SetContinuousStates(one->c, x, (size_t)states), fmi3SetContinuousStates(one->c, x, (size_t)states)));
}

void set_strange_states(struct One *one)
{
    double x[STATES];
    for (int i = 0; i < states; ++i) {
        const double nominal = model_variable(model_state(i))->nominal;
        x[i] = (nominal > 0 ? nominal : 1) * between(-2, 2);
    }
    if (states && chance(0.3))
        x[below(states)] = strange();
    set_states_of(one, x);
}

double span_of_step(void)
{
    if (chance(0.02))
        return strange();
    return chance(0.02) ? spread(1e-30, 1e-9) : spread(1e-9, 2e-4);
}

/* Euler's rule, as a solver would. */
void integrate(struct One *one)
{
    double x[STATES], rate[STATES];
    const double time = time_of(one), h = span_of_step();
    if (one->mode != INTEGRATING || one->interface != MODEL_EXCHANGE || isnan(time)) {
        look_as_solver(one);
        return;
    }
    int status = CALL(
        one, NAME("GetContinuousStates", "GetContinuousStates"), INTEGRATING, MUST_PASS,
        EITHER(fmi2GetContinuousStates(one->c, x, (size_t)states), fmi3GetContinuousStates(one->c, x, (size_t)states)));
    judge(one, status, "state", x, (size_t)states);
    if (status > WARNING)
        return;
    status = CALL(one, NAME("GetDerivatives", "GetContinuousStateDerivatives"), INTEGRATING, MAY_FAIL,
                  EITHER(fmi2GetDerivatives(one->c, rate, (size_t)states),
                         fmi3GetContinuousStateDerivatives(one->c, rate, (size_t)states)));
    judge(one, status, "rate", rate, (size_t)states);
    if (status > WARNING)
        return;
    set_time_of(one, time + h);
    for (int i = 0; i < states; ++i)
        x[i] += h * rate[i];
    if (one->mode == INTEGRATING)
        set_states_of(one, x);
    if (one->mode == INTEGRATING)
        completed(one);
}

/* Time derivatives of outputs, as a master that extrapolates would. */
static void differentiate_outputs(struct One *one)
{
    unsigned index[3], reference[3];
    int order[3], legal = one->interface == CO_SIMULATION;
    double slope[3] = {0, 0, 0};
    const size_t count = (size_t)below(4);
    for (int i = 0; i < 3; ++i) {
        do
            index[i] = (unsigned)below(variables);
        while (chance(0.99) && (sort_of((int)index[i]) != REALS || model_variable((int)index[i])->causality != OUTPUT));
        order[i] = chance(0.99) ? 1 : below(3);
        legal &= (size_t)i >= count || (order[i] == 1 && sort_of((int)index[i]) == REALS &&
                                        model_variable((int)index[i])->causality == OUTPUT);
    }
    const unsigned *const of = references_of(index, 3, reference);
    const int status =
        CALL(one, NAME("GetRealOutputDerivatives", "GetOutputDerivatives"),
             STEPPING | STEP_FAILED | TERMINATED | FAILED | INTERMEDIATE | ASKING, legal ? MAY_FAIL : MUST_FAIL,
             EITHER(fmi2GetRealOutputDerivatives(one->c, of, count, order, slope),
                    fmi3GetOutputDerivatives(one->c, of, count, order, slope, count)));
    judge(one, status, "time derivative", slope, count);
}

void differentiate(struct One *one)
{
    if (chance(0.5)) {
        differentiate_outputs(one);
        return;
    }
    unsigned unknown[3], known[3], unknown_reference[3], known_reference[3];
    double seed[3], result[3] = {0, 0, 0};
    const size_t unknowns = (size_t)below(4), knowns = (size_t)below(4);
    const int adjoint = one->version == 3 && chance(0.5);
    for (int i = 0; i < 3; ++i) {
        do
            unknown[i] = (unsigned)below(variables);
        while (chance(0.99) &&
               (sort_of((int)unknown[i]) != REALS || (model_variable((int)unknown[i])->causality != OUTPUT &&
                                                      model_variable((int)unknown[i])->causality != LOCAL)));
        do
            known[i] = (unsigned)below(variables);
        while (chance(0.99) && !is_start[known[i]] && model_variable((int)known[i])->causality != INPUT);
        seed[i] = chance(0.9) ? between(-1, 1) : strange();
    }
    const size_t seeds = adjoint ? unknowns : knowns, results = adjoint ? knowns : unknowns;
    const unsigned *const of = references_of(unknown, 3, unknown_reference), *const by = references_of(known, 3,
                                                                                                       known_reference);
    int status;
    if (one->version == 2)
        status = CALL(one, "fmi2GetDirectionalDerivative", SHOWING, MAY_FAIL,
                      fmi2GetDirectionalDerivative(one->c, of, unknowns, by, knowns, seed, result));
    else if (adjoint)
        status = CALL(one, "fmi3GetAdjointDerivative", SHOWING, MAY_FAIL,
                      fmi3GetAdjointDerivative(one->c, of, unknowns, by, knowns, seed, seeds, result, results));
    else
        status = CALL(one, "fmi3GetDirectionalDerivative", SHOWING, MAY_FAIL,
                      fmi3GetDirectionalDerivative(one->c, of, unknowns, by, knowns, seed, seeds, result, results));
    judge(one, status, "derivative", result, results);
}

void ask_what_is_not_there(struct One *one)
{
    const unsigned reference[1] = {(unsigned)below(variables)};
    const size_t count = (size_t)below(2);
    const enum Verdict verdict = count ? MUST_FAIL : MUST_PASS;
    if (one->version == 2) {
        fmi2String text[1] = {"x"};
        if (chance(0.5))
            CALL(one, "fmi2GetString", READING, verdict, fmi2GetString(one->c, reference, count, text));
        else
            CALL(one, "fmi2SetString", SETTING, verdict, fmi2SetString(one->c, reference, count, text));
        return;
    }
    fmi3Float32 narrow[1] = {0};
    fmi3String text[1] = {"x"};
    fmi3Binary bytes[1];
    fmi3Clock clocks[1] = {false};
    size_t size[1];
    switch (below(7)) {
    case 0:
        CALL(one, "fmi3GetFloat32", reading(one), verdict, fmi3GetFloat32(one->c, reference, count, narrow, count));
        break;
    case 1:
        CALL(one, "fmi3SetFloat32", SETTING | ASKING, verdict, fmi3SetFloat32(one->c, reference, count, narrow, count));
        break;
    case 2:
        CALL(one, "fmi3GetString", reading(one), verdict, fmi3GetString(one->c, reference, count, text, count));
        break;
    case 3:
        CALL(one, "fmi3GetBinary", reading(one), verdict, fmi3GetBinary(one->c, reference, count, size, bytes, count));
        break;
    case 4:
        CALL(one, "fmi3SetClock", SETTING | ASKING, verdict, fmi3SetClock(one->c, reference, count, clocks));
        break;
    case 5:
        CALL(one, "fmi3GetNumberOfVariableDependencies", ANY_MODE, MUST_FAIL,
             fmi3GetNumberOfVariableDependencies(one->c, 0, size));
        break;
    default:
        CALL(one, "fmi3ActivateModelPartition", ANY_MODE, MUST_FAIL, fmi3ActivateModelPartition(one->c, 0, 0));
    }
}
