/* How does the fuzz get and set values? One or many, of any type, right ones and wrong ones. */
#include "acts.h"

#include <math.h>
#include <stdio.h>

const unsigned *references_of(const unsigned *index, size_t count, unsigned *reference)
{
    for (size_t i = 0; index && i < count; ++i)
        reference[i] = index[i] + FIRST_REFERENCE;
    return index ? reference : NULL;
}

int get_numbers(struct One *one, enum Sort form, const unsigned *index, size_t count, double *value)
{
    unsigned room[CAPACITY];
    const unsigned *const reference = references_of(index, count, room);
    fmi2Integer small[CAPACITY];
    fmi3Int64 large[CAPACITY];
    fmi3Boolean truth[CAPACITY];
    int status;
    if (form == REALS)
        status = EITHER(fmi2GetReal(one->c, reference, count, value),
                        fmi3GetFloat64(one->c, reference, count, value, count));
    else if (form == BOOLEANS && one->version == 3)
        status = (int)fmi3GetBoolean(one->c, reference, count, truth, count);
    else if (form == CHOICES && one->version == 3)
        status = (int)fmi3GetInt64(one->c, reference, count, large, count);
    else if (form == BOOLEANS)
        status = (int)fmi2GetBoolean(one->c, reference, count, small);
    else
        status = EITHER(fmi2GetInteger(one->c, reference, count, small),
                        fmi3GetInt32(one->c, reference, count, small, count));
    for (size_t i = 0; i < count && form != REALS && status <= WARNING; ++i)
        value[i] = form == BOOLEANS && one->version == 3  ? truth[i]
                   : form == CHOICES && one->version == 3 ? (double)large[i]
                                                          : small[i];
    return status;
}

static int set_numbers(struct One *one, enum Sort form, const unsigned *index, size_t count, const double *value)
{
    unsigned room[CAPACITY];
    const unsigned *const reference = references_of(index, count, room);
    fmi2Integer small[CAPACITY];
    fmi3Int64 large[CAPACITY];
    fmi3Boolean truth[CAPACITY];
    for (size_t i = 0; i < count && form != REALS; ++i) {
        small[i] = (int)fmin(fmax(value[i], INT32_MIN), INT32_MAX);
        large[i] = small[i];
        truth[i] = value[i] != 0;
    }
    if (form == REALS)
        return EITHER(fmi2SetReal(one->c, reference, count, value),
                      fmi3SetFloat64(one->c, reference, count, value, count));
    if (form == BOOLEANS)
        return EITHER(fmi2SetBoolean(one->c, reference, count, small),
                      fmi3SetBoolean(one->c, reference, count, truth, count));
    if (form == CHOICES && one->version == 3)
        return (int)fmi3SetInt64(one->c, reference, count, large, count);
    return EITHER(fmi2SetInteger(one->c, reference, count, small),
                  fmi3SetInt32(one->c, reference, count, small, count));
}

const char *const get_names[2][4] = {{"fmi2GetReal", "fmi2GetInteger", "fmi2GetBoolean", "fmi2GetInteger"},
                                     {"fmi3GetFloat64", "fmi3GetInt32", "fmi3GetBoolean", "fmi3GetInt64"}};
static const char *const set_names[2][4] = {{"fmi2SetReal", "fmi2SetInteger", "fmi2SetBoolean", "fmi2SetInteger"},
                                            {"fmi3SetFloat64", "fmi3SetInt32", "fmi3SetBoolean", "fmi3SetInt64"}};

/* FMI 2 reaches enumerations as integers. */
static int reached_by(const struct One *one, enum Sort form, int index)
{
    const enum Sort own = sort_of(index);
    return own == form ||
           (one->version == 2 && (own == CHOICES || own == INTEGERS) && (form == CHOICES || form == INTEGERS));
}

int get_all(struct One *one)
{
    int worst = OK;
    for (int form = REALS; form <= CHOICES; ++form) {
        unsigned reference[CAPACITY];
        double value[CAPACITY];
        size_t count = 0;
        for (int i = 0; i < variables; ++i)
            if (sort_of(i) == (enum Sort)form)
                reference[count++] = (unsigned)i;
        const int status = CALL(one, get_names[one->version - 2][form], reading(one), MAY_FAIL,
                                get_numbers(one, (enum Sort)form, reference, count, value));
        judge(one, status, "value", value, count);
        for (size_t i = 0; i < count && status <= WARNING; ++i) {
            const double given = one->given[reference[i]];
            const double less = form == CHOICES ? 1 : 0;
            if (!isnan(given) && value[i] - less != given)
                finding("%s was set to %.17g and shows %.17g", model_variable((int)reference[i])->name, given,
                        value[i] - less);
        }
        worst = status > worst ? status : worst;
    }
    return worst;
}

void get_some(struct One *one)
{
    unsigned reference[8];
    double value[8];
    size_t count = (size_t)below(8);
    const enum Sort form = (enum Sort)(chance(0.8) ? REALS : below(4));
    enum Verdict verdict = MAY_FAIL;
    for (size_t i = 0; i < count; ++i) {
        do
            reference[i] = (unsigned)below(variables);
        while (!reached_by(one, form, (int)reference[i]) && chance(0.98));
        if (chance(0.01))
            reference[i] = (unsigned)luck();
        if (reference[i] >= (unsigned)variables || !reached_by(one, form, (int)reference[i]))
            verdict = MUST_FAIL;
    }
    const int none = chance(0.01);
    if (none && count)
        verdict = MUST_FAIL;
    const int status = CALL(one, get_names[one->version - 2][form], reading(one), verdict,
                            get_numbers(one, form, none ? NULL : reference, count, value));
    if (verdict != MUST_FAIL)
        judge(one, status, "value", value, count);
}

static unsigned settable(const struct One *one, int index)
{
    const struct Variable *v = model_variable(index);
    if (v->causality == INPUT)
        return SETTING | ASKING;
    if (v->causality == PARAMETER)
        return v->variability != TUNABLE ? INSTANTIATED | INITIALIZING
                                         : INSTANTIATED | INITIALIZING | EVENT | (one->event_mode ? 0 : STEPPING);
    if (is_start[index]) /* a solver may lead states one by one */
        return INSTANTIATED | INITIALIZING | (one->interface == MODEL_EXCHANGE ? EVENT | INTEGRATING : 0);
    return 0;
}

/* Said anew: what the model says of it is what is tried. An input may miss its bounds by a hair. */
int is_allowed(const struct Variable *v, double x)
{
    const double slack = v->causality == INPUT ? 1e-6 * (v->nominal > 0 ? v->nominal : 1) : 0;
    return isfinite(x) && x >= v->min - slack && x <= v->max + slack && (v->type == REAL || x == floor(x));
}

/* One variable, or several of a type, of which one wrong one must leave all others. */
static void set_these(struct One *one, enum Sort form, unsigned *reference, double *value, size_t count)
{
    const unsigned legal = SETTING | (one->version == 3 ? ASKING : 0);
    enum Verdict verdict = MUST_PASS;
    double sent[8];
    for (size_t i = 0; i < count; ++i) {
        const int there = reference[i] < (unsigned)variables && reached_by(one, form, (int)reference[i]);
        const double offset = there && sort_of((int)reference[i]) == CHOICES ? 1 : 0;
        sent[i] = value[i] + offset;
        if (verbose)
            printf("    sets %s = %.17g\n", there ? model_variable((int)reference[i])->name : "-", value[i]);
        if (!there || !(settable(one, (int)reference[i]) & one->mode) ||
            !is_allowed(model_variable((int)reference[i]), value[i]))
            verdict = MUST_FAIL;
    }
    if (CALL(one, set_names[one->version - 2][form], legal, verdict, set_numbers(one, form, reference, count, sent)) >
        WARNING)
        return;
    for (size_t i = 0; i < count; ++i)
        if (reference[i] < (unsigned)variables) {
            const struct Variable *v = model_variable((int)reference[i]);
            const double held = v->causality == INPUT ? fmin(fmax(value[i], v->min), v->max) : value[i];
            one->given[reference[i]] = is_start[reference[i]] ? NAN : held == 0 ? 0 : held;
        }
}

void set_one(struct One *one, int index, double value)
{
    unsigned reference = (unsigned)index;
    set_these(one, sort_of(index), &reference, &value, 1);
}

/* What may be set now, mostly. */
static int drawn_variable(struct One *one)
{
    int index = below(variables);
    for (int tries = 0; tries < 200 && !(settable(one, index) & one->mode); ++tries)
        index = below(variables);
    return chance(0.01) ? below(variables) : index;
}

void set_some(struct One *one)
{
    unsigned reference[8];
    double value[8];
    size_t count = 0;
    const int first = drawn_variable(one);
    const enum Sort form = chance(0.005) ? (enum Sort)below(4) : sort_of(first);
    for (int n = 1 + (chance(0.3) ? below(4) : 0); n > 0; --n) {
        const int index = count ? drawn_variable(one) : first;
        if (count && sort_of(index) != form)
            continue;
        const struct Variable *v = model_variable(index);
        int again = 0;
        for (size_t i = 0; i < count; ++i)
            again |= reference[i] == (unsigned)index;
        if (again)
            continue;
        reference[count] = chance(0.002) ? (unsigned)luck() : (unsigned)index;
        value[count++] = v->type == BOOLEAN ? below(2) : value_of(v);
    }
    set_these(one, form, reference, value, count);
}

void ramp_inputs(struct One *one)
{
    const unsigned legal = INSTANTIATED | INITIALIZING | STEPPING;
    unsigned reference[1] = {(unsigned)(model_input(0) + below(model_input_count() + 1))};
    unsigned room[1];
    if (one->version == 3)
        return; /* FMI 3 ramps its inputs otherwise */
    const int there = reference[0] < (unsigned)variables;
    const struct Variable *v = model_variable(there ? (int)reference[0] : 0);
    const double span = v->nominal > 0 ? v->nominal : 1,
                 slope[1] = {chance(0.9) ? span * between(-1, 1) * spread(1e-3, 1e5) : strange()};
    const int order[1] = {chance(0.98) ? 1 : below(4)};
    const enum Verdict verdict =
        one->interface == CO_SIMULATION && there && v->causality == INPUT && order[0] == 1 && isfinite(slope[0])
            ? MUST_PASS
            : MUST_FAIL;
    if (CALL(one, "fmi2SetRealInputDerivatives", legal, verdict,
             fmi2SetRealInputDerivatives(one->c, references_of(reference, 1, room), 1, order, slope)) <= WARNING)
        one->ramped = 1;
}

double time_of(struct One *one)
{
    unsigned reference = MODEL_TIME;
    double time = NAN;
    const int status = CALL(one, get_names[one->version - 2][REALS], reading(one), MAY_FAIL,
                            get_numbers(one, REALS, &reference, 1, &time));
    judge(one, status, "time", &time, 1);
    return status <= WARNING ? time : NAN;
}
