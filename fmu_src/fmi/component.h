/* What is an FMU instance, whatever version of FMI asks for it? A model, a place in the life cycle, and a host to
 * report to.
 *
 * fmi2.c and fmi3.c are shells over this: they translate names and types, this core decides. Neither knows a variable
 * by name or any physics: all comes from the model's tables (model.h). No writable static: every instance stands alone,
 * also in its own thread.
 */
#ifndef COMPONENT_H
#define COMPONENT_H

#include "model.h"

/* The value reference of the first variable that an FMU shows; they follow one another. Not 0: importers are about that
 * take the dependencies of FMI 3 for places in the list, counted from 1 as in FMI 2. So both readings agree. */
enum { FIRST_REFERENCE = 1 };

/* The numbers of fmi2Status and fmi3Status. */
enum Answer { ANSWER_OK, ANSWER_WARNING, ANSWER_DISCARD, ANSWER_ERROR, ANSWER_FATAL };

/* A bit for each state of the standard's state machines. */
enum Mode {
    INSTANTIATED = 1,
    CONFIGURING = 2,
    INITIALIZING = 4,
    EVENT = 8,
    INTEGRATING = 16,
    STEPPING = 32,
    STEP_FAILED = 64,
    TERMINATED = 128,
    FAILED = 256,
    INTERMEDIATE = 512,
    ASKING = 1024, /* within a step, too: and the host may give inputs for the rest of it */
    RUNNING = EVENT | INTEGRATING | STEPPING,
    SHOWING = INITIALIZING | RUNNING | STEP_FAILED | TERMINATED | FAILED, /* where values may be read */
    ANY_MODE = SHOWING | INSTANTIATED | CONFIGURING /* but not from within a step */
};

enum Interface { MODEL_EXCHANGE, CO_SIMULATION };

/* Who asked for the instance, and how it wants to be told. */
struct Host {
    void (*say)(const struct Host *host, enum Answer answer, const char *category, const char *text);
    void (*logger)(void); /* the host's own callback; `say` knows its type */
    void *environment;
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
    const char *name;
    uint32_t categories;      /* bit = place in the list of categories that are let through */
    enum Answer warned;       /* what a call answers that logged a warning */
    enum Answer partial_step; /* what a step answers that ended halfway */
    uint32_t modes;           /* that this version of the standard knows */
    int event_mode;           /* co-simulation: the host handles events */
    int early_return;         /* co-simulation: a step may end before its end */
    /* Show the host a time within a step, with `asks` nonzero ask for inputs from there on; nonzero: it wants the step
     * to end at *until. NULL where nobody looks. */
    int (*show)(const struct Host *host, double time, int asks, double *until);
    void (*intermediate_update)(void); /* the host's own callback; `show` knows its type */
};

/* What an FMU state holds beside the model; no padding, so equal states have equal bytes. */
struct Life {
    double start, stop; /* [s] */
    double last_time; /* end of the last step that was carried out [s] */
    uint32_t mode, interface;
    uint32_t stale; /* outputs do not belong to the present inputs, states, time */
    uint32_t set_up, tolerance_set, event_pending;
    uint32_t slope_set, slope_kept; /* inputs have slopes: given for the next step; of the last step */
};

/* What an FMU starts with, beside its model's tables. */
struct Start {
    int index;
    double value;
};

/* An FMU that carries the model: with other starts, and with a part of its variables. One binary serves all; the token
 * that a host gives says as which. See variants.c. */
struct Variant {
    const char *name; /* of the FMU */
    const char *token; /* of its description; NULL: the model's own */
    const char *model; /* the token of the model that these indices belong to */
    const struct Start *starts;
    int start_count;
    const uint16_t *shown; /* indices of its variables, rising, the time first; NULL: all */
    int count; /* of them */
};
extern const struct Variant fmu_variants[];
extern const int fmu_variant_count;

struct Component {
    struct Life life;
    struct Host host;
    const char *function; /* the FMI function at work */
    uint32_t told; /* warnings that this run has logged */
    const struct Variant *variant;
    int count, state_count, indicator_count; /* of variables, continuous states and event indicators that are shown */
    char token[40];
    /* What depends on the model lies behind, in the same block of memory. */
    struct Model *model, *preview; /* preview: as it would start now; as it was before an event; as it may go on */
    struct Wiring *wiring; /* of `model`, */
    int wired; /* where it still holds */
    int tuned; /* nominal values may have changed since the host was last told so */
    double *indicators; /* of the whole model */
    int *state, *rate, *indicator; /* indices of the states and of their rates; places of the event indicators */
    uint16_t *settable; /* modes in which each variable may be set */
    uint8_t *type;
};
static inline double present_time(const struct Component *c) { return model_get(c->model, MODEL_TIME); }

/* ---- report.c: logging, refusing ---- */

/* One log line, "<function>: <text>", where its category is on; an error ends the run. Returns `answer`. */
enum Answer report(struct Component *c, enum Answer answer, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Why there will be no instance: said whatever the host has switched off. */
void refuse_instance(const struct Host *host, const char *format, ...) __attribute__((format(printf, 2, 3)));
enum Answer report_status(struct Component *c, enum Answer answer, enum Status status);
void list_modes(unsigned modes, char *text, size_t size);
int wrong_mode(struct Component *c, unsigned modes);
enum Answer set_logging(struct Component *c, int on, size_t count, const char *const categories[]);
enum {
    STATUS_CATEGORIES = 1 << ANSWER_WARNING | 1 << ANSWER_DISCARD | 1 << ANSWER_ERROR | 1 << ANSWER_FATAL,
    ERROR_CATEGORIES = 1 << ANSWER_ERROR | 1 << ANSWER_FATAL
};

/* The first line of every FMI function: nonzero where it must not be called now. */
static inline int refuses(struct Component *c, const char *function, unsigned modes)
{
    if (c == NULL)
        return 1;
    c->function = function;
    return !(c->life.mode & modes) && wrong_mode(c, modes);
}

/* ---- component.c: life cycle ---- */

struct Component *component_new(const char *function, const struct Host *host, enum Interface interface,
                                const char *name, const char *token);
void component_free(struct Component *c);
enum Answer component_set_up(struct Component *c, int tolerance_defined, double tolerance, double start,
                             int stop_defined, double stop);
enum Answer component_enter(struct Component *c, enum Mode mode);
enum Answer component_start(struct Component *c);
enum Answer component_reset(struct Component *c);

/* ---- stepping.c: steps, events, warnings ---- */

struct StepEnd {
    double last_time; /* [s] */
    int event, early;
};
enum Answer component_step(struct Component *c, double time, double step, struct StepEnd *end);

struct News {
    int states_changed; /* or their rates */
    int nominals_changed; /* by parameters */
    int next_event_defined;
    double next_event; /* [s] */
};
enum Answer component_event(struct Component *c, struct News *news);
/* Log each new warning of the model once. */
enum Answer component_warn(struct Component *c);

/* ---- values.c: get and set through the tables ---- */

/* How the host keeps numbers of a type, and which types of the tables (a bit each) it reaches by it. */
enum Form { FORM_DOUBLE, FORM_INT32, FORM_INT64, FORM_INT, FORM_BOOL };
struct Access {
    const char *word;
    enum Form form;
    unsigned types;
};
/* The index of the variable that a value reference names; -1: it names none. */
static inline int index_of(const struct Component *c, uint32_t reference)
{
    const uint32_t place = reference - FIRST_REFERENCE; /* 0 becomes the largest */
    if (place >= (uint32_t)c->count)
        return -1;
    return c->variant->shown ? c->variant->shown[place] : (int)place;
}
/* The value reference of a variable; 0: the FMU does not show it. */
uint32_t reference_of(const struct Component *c, int index);
/* What the FMU has a variable at before a host sets it. */
double start_of(const struct Variant *variant, int index);
/* Bring outputs up to date. */
enum Answer refresh(struct Component *c);
/* Every number that leaves an instance passes here: one that is not finite is an error, told in one line; while a
 * solver is integrating it is something to discard. */
enum Answer give(struct Component *c, const char *what, const char *name, double x);
/* The model whose values the host sees. */
static inline const struct Model *visible_model(const struct Component *c)
{
    return c->life.mode == INITIALIZING ? c->preview : c->model;
}
enum Answer get_values(struct Component *c, const struct Access *as, const uint32_t *references, size_t count,
                       void *values);
enum Answer set_values(struct Component *c, const struct Access *as, const uint32_t *references, size_t count,
                       const void *values);
/* An input that is given a hair outside its bounds is held on them: said once. */
enum Answer held_on_bound(struct Component *c, int index, double value);
/* Forget the slopes of the last step. */
void drop_kept_slopes(struct Component *c);
enum Answer set_slopes(struct Component *c, const uint32_t *references, size_t count, const int *orders,
                       const double *slopes);
/* d output / dt as inputs go on by the slopes of the last step, or by those that are given for the next one; 0 for an
 * output that is constant between events. */
enum Answer get_output_slopes(struct Component *c, const uint32_t *references, size_t count, const int *orders,
                              double *slopes);
/* Variables of a type that no table has: fine as long as none is asked for. */
enum Answer no_variables(struct Component *c, const char *word, size_t count);

/* ---- continuous.c: vectors of model exchange, derivatives ---- */

enum Answer set_time(struct Component *c, double time);
enum Answer set_states(struct Component *c, const double *states, size_t count);
enum Answer get_states(struct Component *c, double *states, size_t count);
enum Answer get_rates(struct Component *c, double *rates, size_t count);
enum Answer get_nominals(struct Component *c, double *nominals, size_t count);
enum Answer get_indicators(struct Component *c, double *indicators, size_t count);
enum Answer complete_step(struct Component *c);
/* result = J seed, or with `adjoint` result = J^T seed; J = d unknowns / d knowns. */
enum Answer get_derivative(struct Component *c, int adjoint, const uint32_t *unknowns, size_t unknown_count,
                           const uint32_t *knowns, size_t known_count, const double *seed, double *result);

/* ---- state.c: copies of the whole ---- */

enum Answer state_get(struct Component *c, void **state);
enum Answer state_set(struct Component *c, const void *state);
enum Answer state_free(struct Component *c, void **state);
enum Answer state_size(struct Component *c, const void *state, size_t *size);
enum Answer state_serialize(struct Component *c, const void *state, void *bytes, size_t size);
enum Answer state_deserialize(struct Component *c, const void *bytes, size_t size, void **state);

#endif
