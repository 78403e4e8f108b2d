/* How do a host's value references reach the model's values? By index_of; type, bounds and roles are asked of the
 * tables.
 *
 * A call that sets several values checks them all before it sets the first.
 */
#include "component.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static const char *const type_names[] = {
    [REAL] = "a real number", [INTEGER] = "an integer", [BOOLEAN] = "a Boolean", [CHOICE] = "an enumeration"};
static const char *const causality_names[] = {[INDEPENDENT] = "the independent variable",
                                              [PARAMETER] = "a parameter",
                                              [CALCULATED] = "a calculated parameter",
                                              [INPUT] = "an input",
                                              [OUTPUT] = "an output",
                                              [LOCAL] = "a local variable"};

uint32_t reference_of(const struct Component *c, int index)
{
    if (!c->variant->shown)
        return (uint32_t)(FIRST_REFERENCE + index);
    for (int place = 0; place < c->count; ++place)
        if (c->variant->shown[place] == index)
            return (uint32_t)(FIRST_REFERENCE + place);
    return 0;
}

double start_of(const struct Variant *variant, int index)
{
    for (int n = 0; n < variant->start_count; ++n)
        if (variant->starts[n].index == index)
            return variant->starts[n].value;
    return model_variable(index)->start;
}

/* A solver of model exchange may try states that are out of reach and come back. */
static enum Answer out_of_reach(const struct Component *c)
{
    return c->life.mode == INTEGRATING ? ANSWER_DISCARD : ANSWER_ERROR;
}

enum Answer refresh(struct Component *c)
{
    enum Status status;
    if (!c->life.stale || !(c->life.mode & (INITIALIZING | RUNNING | STEP_FAILED | TERMINATED | INTERMEDIATE | ASKING)))
        return ANSWER_OK;
    if (c->life.mode == INITIALIZING) { /* the start may still change: try it on a copy */
        memcpy(c->preview, c->model, model_size());
        status = model_start(c->preview, c->life.start);
        status = status == STATUS_OK ? model_evaluate(c->preview) : status;
    } else {
        status = model_evaluate(c->model);
    }
    c->life.stale = status != STATUS_OK;
    return status == STATUS_OK ? ANSWER_OK : report_status(c, out_of_reach(c), status);
}

enum Answer give(struct Component *c, const char *what, const char *name, double x)
{
    if (isfinite(x))
        return ANSWER_OK;
    return report(c, out_of_reach(c), "at time %.17g s: %s%s is %g, which is no finite number. %s", present_time(c),
                  what, name, x,
                  c->life.mode == INTEGRATING
                      ? "Try other states or a shorter step."
                      : "Reset the instance or restore an FMU state, and look for values far from any machine's.");
}

/* The index of a variable that this access reaches; else -1, and said why. */
static int reached(struct Component *c, const struct Access *as, uint32_t reference)
{
    const int index = index_of(c, reference);
    if (index >= 0 && as->types >> c->type[index] & 1u)
        return index;
    if (index < 0)
        report(c, ANSWER_ERROR, "there is no variable with value reference %lu; allowed is %d to %d.",
               (unsigned long)reference, FIRST_REFERENCE, FIRST_REFERENCE + c->count - 1);
    else
        report(c, ANSWER_ERROR, "%s (value reference %lu) is %s; this function reaches %s variables only.",
               model_variable(index)->name, (unsigned long)reference, type_names[c->type[index]], as->word);
    return -1;
}

static int given(struct Component *c, const void *references, const void *values, size_t count)
{
    if (count == 0 || (references && values))
        return 1;
    report(c, ANSWER_ERROR, "%zu values are asked for, but the array of %s is NULL.", count,
           references ? "values" : "value references");
    return 0;
}

/* The items of an FMI enumeration start at 1. */
static double item_offset(const struct Component *c, int index) { return c->type[index] == CHOICE ? 1 : 0; }

static void store(void *values, enum Form form, size_t i, double x)
{
    const double whole = fmin(fmax(x, INT32_MIN), INT32_MAX); /* a count past the type's end stays at the end */
    switch (form) {
    case FORM_DOUBLE:
        ((double *)values)[i] = x;
        break;
    case FORM_INT32:
        ((int32_t *)values)[i] = (int32_t)whole;
        break;
    case FORM_INT64:
        ((int64_t *)values)[i] = (int64_t)whole;
        break;
    case FORM_INT:
        ((int *)values)[i] = x != 0;
        break;
    case FORM_BOOL:
        ((bool *)values)[i] = x != 0;
        break;
    }
}

static double load(const void *values, enum Form form, size_t i)
{
    switch (form) {
    case FORM_DOUBLE:
        return ((const double *)values)[i];
    case FORM_INT32:
        return ((const int32_t *)values)[i];
    case FORM_INT64:
        return (double)((const int64_t *)values)[i];
    case FORM_INT:
        return ((const int *)values)[i] != 0;
    case FORM_BOOL:
        return ((const unsigned char *)values)[i] != 0; /* a host may hold another byte than 0 or 1 */
    }
    return NAN;
}

enum Answer get_values(struct Component *c, const struct Access *as, const uint32_t *references, size_t count,
                       void *values)
{
    if (!given(c, references, values, count))
        return ANSWER_ERROR;
    const enum Answer answer = count ? refresh(c) : ANSWER_OK;
    if (answer > ANSWER_WARNING)
        return answer;
    const struct Model *model = visible_model(c);
    for (size_t i = 0; i < count; ++i) {
        const int index = reached(c, as, references[i]);
        if (index < 0)
            return ANSWER_ERROR;
        const double x = model_get(model, index);
        if (!isfinite(x))
            return give(c, "", model_variable(index)->name, x);
        store(values, as->form, i, x + item_offset(c, index));
    }
    return ANSWER_OK;
}

static enum Answer not_settable(struct Component *c, int index)
{
    const struct Variable *v = model_variable(index);
    const char *fixed = v->causality == PARAMETER && v->variability == FIXED ? " that is fixed" : "";
    const int computed =
        v->causality == OUTPUT || v->causality == LOCAL; /* which of them, each component says itself */
    char allowed[256];
    list_modes(c->settable[index], allowed, sizeof allowed);
    return report(c, ANSWER_ERROR,
                  "%s (value reference %lu) is %s%s and cannot be set now; allowed in: %s. Its value is kept.", v->name,
                  (unsigned long)reference_of(c, index), computed ? "computed" : causality_names[v->causality], fixed,
                  c->settable[index] ? allowed : "no state");
}

static enum Answer bad_value(struct Component *c, int index, double value, enum Status status)
{
    const struct Variable *v = model_variable(index);
    const double offset = item_offset(c, index);
    const int bare = v->unit[0] == '1' && v->unit[1] == '\0';
    const char *space = bare ? "" : " ", *unit = bare ? "" : v->unit;
    return report(c, ANSWER_ERROR,
                  "%s = %g%s%s (value reference %lu): %s; allowed is %g to %g%s%s. The value %g%s%s is kept.", v->name,
                  value + offset, space, unit, (unsigned long)reference_of(c, index), status_text(status),
                  v->min + offset, v->max + offset, space, unit, model_get(c->model, index) + offset, space, unit);
}

enum Answer held_on_bound(struct Component *c, int index, double value)
{
    const struct Variable *v = model_variable(index);
    if (c->told & WARN_AT_BOUND)
        return ANSWER_OK;
    c->told |= WARN_AT_BOUND;
    report(
        c, ANSWER_WARNING,
        "%s = %g %s lies outside its bounds, %g to %g %s, by no more than %g %s: it is held at %g %s, and so is every "
        "such input from now on without a word.",
        v->name, value, v->unit, v->min, v->max, v->unit, model_bound_slack(index), v->unit, within_bounds(v, value),
        v->unit);
    return c->host.warned;
}

enum Answer set_values(struct Component *c, const struct Access *as, const uint32_t *references, size_t count,
                       const void *values)
{
    if (!given(c, references, values, count))
        return ANSWER_ERROR;
    for (size_t i = 0; i < count; ++i) {
        const int index = reached(c, as, references[i]);
        if (index < 0)
            return ANSWER_ERROR;
        if (!(c->settable[index] & c->life.mode))
            return not_settable(c, index);
        const double value = load(values, as->form, i) - item_offset(c, index);
        const enum Status status = model_check(index, value);
        if (status != STATUS_OK)
            return bad_value(c, index, value, status);
    }
    enum Answer answer = ANSWER_OK;
    for (size_t i = 0; i < count; ++i) {
        const int index = index_of(c, references[i]);
        const double value = load(values, as->form, i) - item_offset(c, index);
        const enum Status status = model_set(c->model, index, value);
        if (status != STATUS_OK)
            return bad_value(c, index, value, status);
        if (model_get(c->model, index) != value && answer == ANSWER_OK)
            answer = held_on_bound(c, index, value);
        c->life.tolerance_set |= index == model_tolerance();
        c->wired &= model_variable(index)->causality == INPUT;
        c->tuned |= model_variable(index)->causality == PARAMETER;
    }
    c->life.stale |= count > 0;
    return answer;
}

/* The index of an input or output that has a derivative; else -1, and said why. */
static int differentiable(struct Component *c, uint32_t reference, int order, enum Causality role)
{
    static const struct Access reals = {"real", FORM_DOUBLE, 1u << REAL};
    const int index = reached(c, &reals, reference);
    if (index < 0)
        return -1;
    const struct Variable *v = model_variable(index);
    const char *word = role == INPUT ? "input" : "output";
    if (v->causality != role)
        report(c, ANSWER_ERROR, "%s (value reference %lu) is %s; only %ss have a derivative here.", v->name,
               (unsigned long)reference, causality_names[v->causality], word);
    else if (order != 1)
        report(c, ANSWER_ERROR, "a derivative of order %d is %s %s; allowed is order 1.", order,
               role == INPUT ? "given for" : "asked of", v->name);
    else
        return index;
    return -1;
}

void drop_kept_slopes(struct Component *c)
{
    for (int place = 0; place < model_input_count() && c->life.slope_kept; ++place)
        model_set_slope(c->model, model_input(place), 0);
    c->life.slope_kept = 0;
}

enum Answer set_slopes(struct Component *c, const uint32_t *references, size_t count, const int *orders,
                       const double *slopes)
{
    if (!given(c, references, orders ? (const void *)slopes : NULL, count))
        return ANSWER_ERROR;
    for (size_t i = 0; i < count; ++i) {
        const int index = differentiable(c, references[i], orders[i], INPUT);
        if (index < 0)
            return ANSWER_ERROR;
        if (!isfinite(slopes[i]))
            return report(c, ANSWER_ERROR, "the derivative of %s is %g; a finite number is needed.",
                          model_variable(index)->name, slopes[i]);
    }
    if (count > 0)
        drop_kept_slopes(c);
    for (size_t i = 0; i < count; ++i)
        model_set_slope(c->model, index_of(c, references[i]), slopes[i]);
    c->life.slope_set |= count > 0;
    return ANSWER_OK;
}

enum Answer get_output_slopes(struct Component *c, const uint32_t *references, size_t count, const int *orders,
                              double *slopes)
{
    int index[DERIVATIVES_AT_ONCE];
    if (c->life.interface != CO_SIMULATION || !model_started(c->model))
        return report(c, ANSWER_ERROR, "%s; derivatives of outputs are those of a Co-Simulation that runs.",
                      c->life.interface != CO_SIMULATION ? "the instance is for Model Exchange"
                                                         : "the instance was not initialised");
    if (!given(c, references, orders ? (const void *)slopes : NULL, count))
        return ANSWER_ERROR;
    for (size_t i = 0; i < count; ++i)
        if (differentiable(c, references[i], orders[i], OUTPUT) < 0)
            return ANSWER_ERROR;
    enum Answer answer = ANSWER_OK;
    for (size_t first = 0; first < count; first += DERIVATIVES_AT_ONCE) {
        const size_t left = count - first, part = left < DERIVATIVES_AT_ONCE ? left : DERIVATIVES_AT_ONCE;
        for (size_t i = 0; i < part; ++i)
            index[i] = index_of(c, references[first + i]);
        const enum Status status = model_time_derivatives(c->model, c->preview, (int)part, index, slopes + first);
        if (status != STATUS_OK) /* the instance stands as it did */
            return report_status(c, ANSWER_DISCARD, status);
        for (size_t i = 0; i < part && answer == ANSWER_OK; ++i)
            answer = give(c, "the time derivative of ", model_variable(index[i])->name, slopes[first + i]);
    }
    return answer;
}

enum Answer no_variables(struct Component *c, const char *word, size_t count)
{
    if (count == 0)
        return ANSWER_OK;
    return report(c, ANSWER_ERROR, "%zu %s variables are asked for; this FMU has none.", count, word);
}
