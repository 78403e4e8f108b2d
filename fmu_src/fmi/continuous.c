/* What does a solver outside need? Time and state vectors in, rates, indicators and derivatives out. */
#include "component.h"

#include <math.h>

static int is_count(struct Component *c, const void *numbers, size_t count, size_t needed, const char *what)
{
    if (count == needed && (numbers || needed == 0))
        return 1;
    report(c, ANSWER_ERROR, "an array of %zu %s is given%s; the FMU has %zu.", count, what, numbers ? "" : " as NULL",
           needed);
    return 0;
}

enum Answer set_time(struct Component *c, double time)
{
    if (!isfinite(time))
        return report(c, ANSWER_ERROR, "the time is %g s; a finite number is needed. The time %.17g s is kept.", time,
                      present_time(c));
    model_lead(c->model, MODEL_TIME, time);
    c->life.stale = 1;
    return ANSWER_OK;
}

enum Answer set_states(struct Component *c, const double *states, size_t count)
{
    if (!is_count(c, states, count, (size_t)c->state_count, "states"))
        return ANSWER_ERROR;
    for (int i = 0; i < c->state_count; ++i)
        if (!isfinite(states[i]))
            return report(c, ANSWER_ERROR, "the state %s is %g; a finite number is needed. All states are kept.",
                          model_variable(c->state[i])->name, states[i]);
    for (int i = 0; i < c->state_count; ++i)
        model_lead(c->model, c->state[i], states[i]);
    c->life.stale = 1;
    return ANSWER_OK;
}

/* The states or their rates. */
static enum Answer give_all(struct Component *c, const int *index, double *numbers)
{
    enum Answer answer = ANSWER_OK;
    for (int i = 0; i < c->state_count && answer == ANSWER_OK; ++i) {
        numbers[i] = model_get(visible_model(c), index[i]);
        answer = give(c, "", model_variable(index[i])->name, numbers[i]);
    }
    return answer;
}

enum Answer get_states(struct Component *c, double *states, size_t count)
{
    if (!is_count(c, states, count, (size_t)c->state_count, "states"))
        return ANSWER_ERROR;
    const enum Answer answer = c->life.mode == INITIALIZING ? refresh(c) : ANSWER_OK;
    return answer > ANSWER_WARNING ? answer : give_all(c, c->state, states);
}

enum Answer get_rates(struct Component *c, double *rates, size_t count)
{
    if (!is_count(c, rates, count, (size_t)c->state_count, "rates"))
        return ANSWER_ERROR;
    const enum Answer answer = refresh(c);
    return answer > ANSWER_WARNING ? answer : give_all(c, c->rate, rates);
}

enum Answer get_nominals(struct Component *c, double *nominals, size_t count)
{
    if (!is_count(c, nominals, count, (size_t)c->state_count, "nominals"))
        return ANSWER_ERROR;
    for (int i = 0; i < c->state_count; ++i)
        nominals[i] = model_nominal(c->model, c->state[i]);
    return ANSWER_OK;
}

enum Answer get_indicators(struct Component *c, double *indicators, size_t count)
{
    if (!is_count(c, indicators, count, (size_t)c->indicator_count, "event indicators"))
        return ANSWER_ERROR;
    enum Answer answer = refresh(c);
    if (answer > ANSWER_WARNING)
        return answer;
    model_indicators(visible_model(c), c->indicators);
    for (int i = 0; i < c->indicator_count && answer == ANSWER_OK; ++i) {
        indicators[i] = c->indicators[c->indicator[i]];
        answer = give(c, "", model_variable(model_indicator(c->indicator[i]))->name, indicators[i]);
    }
    return answer;
}

enum Answer complete_step(struct Component *c)
{
    const enum Status status = model_completed_step(c->model);
    if (status != STATUS_OK)
        return report_status(c, ANSWER_ERROR, status);
    return component_warn(c);
}

static int is_state(const struct Component *c, int index)
{
    for (int i = 0; i < c->state_count; ++i)
        if (c->state[i] == index)
            return 1;
    return 0;
}

static int derivable(struct Component *c, const uint32_t *references, size_t count, int known)
{
    for (size_t i = 0; i < count; ++i) {
        const int there = index_of(c, references[i]) >= 0, index = there ? index_of(c, references[i]) : 0;
        const enum Causality role = model_variable(index)->causality;
        const int fits = there && c->type[index] == REAL &&
                         (known ? role == INPUT || is_state(c, index) : role == OUTPUT || role == LOCAL);
        if (!fits) {
            report(c, ANSWER_ERROR, "value reference %lu%s%s is no %s; allowed are %s.", (unsigned long)references[i],
                   there ? ", " : "", there ? model_variable(index)->name : "", known ? "known" : "unknown",
                   known ? "real inputs and continuous states" : "real outputs and local variables");
            return 0;
        }
    }
    return 1;
}

enum Answer get_derivative(struct Component *c, int adjoint, const uint32_t *unknowns, size_t unknown_count,
                           const uint32_t *knowns, size_t known_count, const double *seed, double *result)
{
    const size_t seed_count = adjoint ? unknown_count : known_count,
                 result_count = adjoint ? known_count : unknown_count;
    if ((unknown_count && !unknowns) || (known_count && !knowns) || (seed_count && !seed) || (result_count && !result))
        return report(c, ANSWER_ERROR, "an array for %zu unknowns and %zu knowns is NULL.", unknown_count, known_count);
    if (!derivable(c, unknowns, unknown_count, 0) || !derivable(c, knowns, known_count, 1))
        return ANSWER_ERROR;
    for (size_t i = 0; i < seed_count; ++i)
        if (!isfinite(seed[i]))
            return report(c, ANSWER_ERROR, "entry %zu of the seed is %g; a finite number is needed.", i, seed[i]);
    enum Answer answer = refresh(c);
    if (answer > ANSWER_WARNING)
        return answer;
    for (size_t i = 0; i < result_count; ++i)
        result[i] = 0;
    for (size_t k = 0; k < known_count; ++k)
        for (size_t first = 0; first < unknown_count; first += DERIVATIVES_AT_ONCE) {
            int index[DERIVATIVES_AT_ONCE], asked[DERIVATIVES_AT_ONCE], count = 0;
            double entry[DERIVATIVES_AT_ONCE];
            for (size_t u = first; u < unknown_count && u < first + DERIVATIVES_AT_ONCE; ++u)
                if (seed[adjoint ? u : k] != 0) {
                    asked[count] = (int)(u - first);
                    index[count++] = index_of(c, unknowns[u]);
                }
            if (count == 0)
                continue;
            const enum Status status = model_derivatives(visible_model(c), index_of(c, knowns[k]), count, index, entry);
            if (status != STATUS_OK)
                return report_status(c, ANSWER_ERROR, status);
            for (int j = 0; j < count; ++j) {
                const size_t u = first + (size_t)asked[j];
                result[adjoint ? k : u] += entry[j] * seed[adjoint ? u : k];
            }
        }
    for (size_t i = 0; i < result_count && answer <= ANSWER_WARNING; ++i)
        answer = give(c, "a derivative by or of ", model_variable(index_of(c, (adjoint ? knowns : unknowns)[i]))->name,
                      result[i]);
    return answer;
}
