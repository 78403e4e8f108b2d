/* How does an instance begin, start and begin anew? From instantiation through initialisation, and back by reset. */
#include "component.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Modes in which the host may set a variable. */
static unsigned when_settable(const struct Component *c, int index, const struct Variable *v)
{
    const unsigned before = INSTANTIATED | INITIALIZING;
    /* FMI 3: a host that handles events changes parameters in event mode only. */
    const unsigned tuning = c->host.event_mode ? EVENT : EVENT | STEPPING;
    if (v->causality == INPUT)
        return before | RUNNING | ASKING;
    if (v->causality == PARAMETER)
        return v->variability == TUNABLE ? before | tuning : before;
    /* Its start value; and a solver that knows no vector of states, such as CasADi, leads them one by one. */
    for (int i = 0; i < c->state_count; ++i)
        if (c->state[i] == index)
            return c->life.interface == MODEL_EXCHANGE ? before | EVENT | INTEGRATING : before;
    return 0;
}

/* Behind it in one block: model, preview, and arrays whose lengths the model says. */
static size_t aligned(size_t size) { return (size + 15) / 16 * 16; }

static size_t block_size(void)
{
    const size_t variables = (size_t)model_variable_count(), states = (size_t)model_state_count(),
                 indicators = (size_t)model_indicator_count();
    const struct Component *c = NULL; /* whose elements are measured */
    return aligned(sizeof *c) + 2 * aligned(model_size()) + aligned(model_wiring_size()) +
           states * (sizeof *c->state + sizeof *c->rate) + indicators * (sizeof *c->indicators + sizeof *c->indicator) +
           variables * (sizeof *c->settable + sizeof *c->type);
}

static void lay_out(struct Component *c)
{
    const int states = model_state_count(), indicators = model_indicator_count();
    unsigned char *at = (unsigned char *)c + aligned(sizeof *c);
    c->model = (struct Model *)at;
    c->preview = (struct Model *)(at += aligned(model_size()));
    c->wiring = (struct Wiring *)(at += aligned(model_size()));
    c->indicators = (double *)(at += aligned(model_wiring_size()));
    c->state = (int *)(c->indicators + indicators);
    c->rate = c->state + states;
    c->indicator = c->rate + states;
    c->settable = (uint16_t *)(c->indicator + indicators);
    c->type = (uint8_t *)(c->settable + model_variable_count());
}

static void learn_tables(struct Component *c)
{
    c->count = c->variant->shown ? c->variant->count : model_variable_count();
    for (int n = 0; n < model_state_count(); ++n)
        if (reference_of(c, model_state(n)))
            c->state[c->state_count++] = model_state(n);
    for (int n = 0; n < model_indicator_count(); ++n)
        if (reference_of(c, model_indicator(n)))
            c->indicator[c->indicator_count++] = n;
    for (int i = 0; i < model_variable_count(); ++i) {
        const struct Variable *v = model_variable(i);
        c->type[i] = (uint8_t)v->type;
        c->settable[i] = (uint16_t)when_settable(c, i, v);
        for (int n = 0; n < c->state_count; ++n)
            if (model_derivative_of(i) == c->state[n])
                c->rate[n] = i;
    }
}

static void begin(struct Component *c, enum Interface interface)
{
    memset(&c->life, 0, sizeof c->life);
    c->life.mode = INSTANTIATED;
    c->life.interface = interface;
    c->life.stop = INFINITY;
    c->told = 0;
    model_reset(c->model);
    for (int n = 0; n < c->variant->start_count; ++n)
        model_set(c->model, c->variant->starts[n].index, c->variant->starts[n].value);
}

static int is_blank(const char *text) { return text == NULL || text[strspn(text, " \t\r\n")] == '\0'; }

/* Foreign text, safe to stand in a log line: `%` and `#` mean something to FMI's loggers. */
static void quote(const char *text, char *quoted, size_t size)
{
    size_t n = 0;
    for (; text && n + 1 < size && text[n]; ++n)
        quoted[n] = text[n] >= ' ' && text[n] <= '~' && text[n] != '%' && text[n] != '#' ? text[n] : '?';
    quoted[n] = '\0';
}

/* The token by which a host asks for an FMU. */
static const char *token_of(const struct Variant *variant, const char *model)
{
    return variant->token ? variant->token : model;
}

/* Which FMU does the host ask for? NULL: none that was made from these tables. */
static const struct Variant *asked_for(const char *token, const char *model)
{
    for (int n = 0; n < fmu_variant_count; ++n) {
        const struct Variant *v = &fmu_variants[n];
        if (token && strcmp(token, token_of(v, model)) == 0 && (!v->model || strcmp(v->model, model) == 0))
            return v;
    }
    return NULL;
}

static void refuse_token(const char *function, const struct Host *host, const char *token, const char *model)
{
    char given[64], allowed[512] = "";
    quote(token, given, sizeof given);
    for (int n = 0; n < fmu_variant_count; ++n) {
        const struct Variant *v = &fmu_variants[n];
        const size_t used = strlen(allowed);
        snprintf(allowed + used, sizeof allowed - used, "%s%s%s%s", n ? ", " : "", token_of(v, model),
                 *v->name ? " of " : "", v->name);
    }
    refuse_instance(host,
                    "%s: the token of the model description is %s, this binary was built for %s; "
                    "use the modelDescription.xml that came with it.",
                    function, token ? given : "missing", allowed);
}

struct Component *component_new(const char *function, const struct Host *host, enum Interface interface,
                                const char *name, const char *token)
{
    char model[39];
    model_token(model);
    const struct Variant *variant = asked_for(token, model);
    if (is_blank(name)) {
        refuse_instance(host, "%s: the instance name is empty; give the instance a name.", function);
        return NULL;
    }
    if (variant == NULL) {
        refuse_token(function, host, token, model);
        return NULL;
    }
    struct Component *c = host->allocate(1, block_size());
    char *own_name = host->allocate(strlen(name) + 1, 1);
    if (c == NULL || own_name == NULL) {
        if (c)
            host->release(c);
        if (own_name)
            host->release(own_name);
        refuse_instance(host, "%s: no memory for an instance of %zu bytes.", function, block_size());
        return NULL;
    }
    memset(c, 0, block_size());
    c->host = *host;
    c->host.name = strcpy(own_name, name);
    c->function = function;
    c->variant = variant;
    strcpy(c->token, token);
    lay_out(c);
    begin(c, interface);
    learn_tables(c);
    return c;
}

void component_free(struct Component *c)
{
    if (c == NULL)
        return;
    void (*release)(void *) = c->host.release;
    release((void *)c->host.name);
    release(c);
}

enum Answer component_set_up(struct Component *c, int tolerance_defined, double tolerance, double start,
                             int stop_defined, double stop)
{
    if (!isfinite(start))
        return report(c, ANSWER_ERROR, "the start time is %g s; a finite number is needed.", start);
    if (stop_defined && (!isfinite(stop) || stop < start))
        return report(c, ANSWER_ERROR,
                      "the stop time is %g s; a finite time at or after the start time %g s is needed.", stop, start);
    /* A tolerance that was set as a parameter is the more particular wish. */
    const int parameter = model_tolerance();
    if (tolerance_defined && !c->life.tolerance_set && parameter >= 0) {
        const struct Variable *v = model_variable(parameter);
        if (model_set(c->model, parameter, tolerance) != STATUS_OK)
            return report(c, ANSWER_ERROR, "the tolerance is %g; allowed is %g to %g.", tolerance, v->min, v->max);
    }
    c->life.start = c->life.last_time = start;
    c->life.stop = stop_defined ? stop : INFINITY;
    c->life.set_up = 1;
    return ANSWER_OK;
}

enum Answer component_enter(struct Component *c, enum Mode mode)
{
    if (mode == INITIALIZING && !c->life.set_up)
        return report(c, ANSWER_ERROR, "the start time is not known yet; call fmi2SetupExperiment first.");
    c->life.mode = mode;
    if (mode == INITIALIZING) {
        model_lead(c->model, MODEL_TIME, c->life.start);
        c->life.stale = 1;
    }
    return ANSWER_OK;
}

enum Answer component_start(struct Component *c)
{
    const char *obstacle = c->life.interface == MODEL_EXCHANGE ? model_solver_obstacle(c->model) : NULL;
    if (obstacle)
        return report(c, ANSWER_ERROR, "%s.", obstacle);
    const enum Status status = model_start(c->model, c->life.start);
    if (status != STATUS_OK)
        return report_status(c, ANSWER_ERROR, status);
    const int events = c->life.interface == MODEL_EXCHANGE || c->host.event_mode;
    c->life.mode = events ? EVENT : STEPPING;
    c->life.stale = 1;
    c->wired = c->tuned = 0;
    return component_warn(c);
}

enum Answer component_reset(struct Component *c)
{
    begin(c, (enum Interface)c->life.interface);
    return ANSWER_OK;
}
