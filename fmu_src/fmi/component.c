/* How does an instance begin, start and begin anew? From instantiation through initialisation, and back by reset. */
#include "component.h"

#include <math.h>
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
    for (int i = 0; i < c->state_count; ++i)
        if (c->state[i] == index)
            return before; /* its start value */
    return 0;
}

static int learn_tables(struct Component *c)
{
    c->count = kernel_variable_count();
    c->state_count = kernel_state_count();
    if (c->count > CAPACITY || c->state_count > STATES || kernel_size() != sizeof(struct Contact))
        return 0;
    for (int n = 0; n < c->state_count; ++n)
        c->state[n] = kernel_state(n);
    for (int i = 0; i < c->count; ++i) {
        const struct Variable *v = kernel_variable(i);
        c->type[i] = (uint8_t)v->type;
        c->settable[i] = (uint16_t)when_settable(c, i, v);
        for (int n = 0; n < c->state_count; ++n)
            if (kernel_derivative_of(i) == c->state[n])
                c->rate[n] = i;
    }
    kernel_token(c->token);
    return 1;
}

static void begin(struct Component *c, enum Interface interface)
{
    memset(&c->life, 0, sizeof c->life);
    c->life.mode = INSTANTIATED;
    c->life.interface = interface;
    c->life.stop = INFINITY;
    c->told = 0;
    kernel_reset(&c->contact);
#ifdef STARTS /* of this FMU, beside the table's */
    static const struct {
        int index;
        double value;
    } starts[] = {STARTS};
    for (size_t i = 0; i < sizeof starts / sizeof *starts; ++i)
        kernel_set(&c->contact, starts[i].index, 0, starts[i].value);
#endif
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

struct Component *component_new(const char *function, const struct Host *host, enum Interface interface,
                                const char *name, const char *token)
{
    char expected[39], found[64];
    kernel_token(expected);
    quote(token, found, sizeof found);
    if (is_blank(name)) {
        refuse_instance(host, "%s: the instance name is empty; give the instance a name.", function);
        return NULL;
    }
    if (token == NULL || strcmp(token, expected) != 0) {
        refuse_instance(host,
                        "%s: the token of the model description is %s, this binary was built for %s; "
                        "use the modelDescription.xml that came with it.",
                        function, token ? found : "missing", expected);
        return NULL;
    }
    struct Component *c = host->allocate(1, sizeof *c);
    char *own_name = host->allocate(strlen(name) + 1, 1);
    if (c == NULL || own_name == NULL) {
        if (c)
            host->release(c);
        if (own_name)
            host->release(own_name);
        refuse_instance(host, "%s: no memory for an instance of %zu bytes.", function, sizeof *c);
        return NULL;
    }
    memset(c, 0, sizeof *c);
    c->host = *host;
    c->host.name = strcpy(own_name, name);
    c->function = function;
    if (!learn_tables(c)) {
        report(c, ANSWER_ERROR, "shell and kernel were compiled with different sizes; rebuild both together.");
        component_free(c);
        return NULL;
    }
    begin(c, interface);
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
    if (tolerance_defined && !c->life.tolerance_set && kernel_variable(TOLERANCE_ARGUMENT)) {
        const struct Variable *v = kernel_variable(TOLERANCE_ARGUMENT);
        if (kernel_set(&c->contact, TOLERANCE_ARGUMENT, 0, tolerance) != KERNEL_OK)
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
        c->contact.value[VAR_TIME][0] = c->life.start;
        c->life.stale = 1;
    }
    return ANSWER_OK;
}

enum Answer component_start(struct Component *c)
{
    if (c->life.interface == MODEL_EXCHANGE && kernel_averages(&c->contact))
        return report(
            c, ANSWER_ERROR,
            "averaging = cycle belongs to the steps of Co-Simulation; a solver of Model Exchange follows every "
            "cycle: set averaging = resolved, or instantiate for Co-Simulation.");
    const enum Status status = kernel_start(&c->contact, c->life.start);
    if (status != KERNEL_OK)
        return report_kernel(c, ANSWER_ERROR, status);
    const int events = c->life.interface == MODEL_EXCHANGE || c->host.event_mode;
    c->life.mode = events ? EVENT : STEPPING;
    c->life.stale = 1;
    return component_warn(c);
}

enum Answer component_reset(struct Component *c)
{
    begin(c, (enum Interface)c->life.interface);
    return ANSWER_OK;
}
