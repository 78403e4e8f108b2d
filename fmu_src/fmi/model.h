/* What must a model be able to do, so that the shells of FMI can carry it? The neutral interface: the contact
 * (kernel/model.c) and the partners of the contact (machines/machine.c) implement it; the shells know nothing else of
 * them.
 *
 * A model is model_size() bytes that the caller owns, aligned as doubles are; it holds no pointer, and copying its
 * bytes copies the model. A variable is named by its index in the table, of which the first is the time. A program has
 * one model: the FMU's shells are linked with the one that it carries.
 */
#ifndef MODEL_H
#define MODEL_H

#include "../kernel/shared.h"

struct Model;

enum { MODEL_TIME = 0 }; /* index of the time [s] */

/* ---- what it is ---- */

size_t model_size(void);
void model_token(char token[39]); /* binds an XML file to its binary */
int model_variable_count(void);
const struct Variable *model_variable(int index); /* NULL: there is none */
int model_input_count(void);
int model_input(int place); /* index of the place-th input */
int model_state_count(void);
int model_state(int place);         /* index of the place-th continuous state */
int model_derivative_of(int index); /* index of the state whose rate variable `index` is; 0: none */
int model_indicator_count(void);
int model_indicator(int place); /* index of the variable that shows the place-th event indicator */
int model_tolerance(void);      /* index of the parameter that FMI's `tolerance` of the experiment sets; -1: none */

/* ---- its values ---- */

enum Status model_check(int index, double value);
/* How far outside its bounds an input may be given and is held on them, in its unit; 0 for what is no input. */
double model_bound_slack(int index);
double model_get(const struct Model *model, int index);
enum Status model_set(struct Model *model, int index, double value);
/* Unchecked: time or a continuous state that a solver of Model Exchange leads, an input at the end of its ramp. */
void model_lead(struct Model *model, int index, double value);
/* Rate of an input within a communication step, and behind it as what is known of it, per second; 0: it is held. */
double model_slope(const struct Model *model, int input);
void model_set_slope(struct Model *model, int input, double slope);

/* ---- its life ---- */

void model_reset(struct Model *model); /* every value at its start, nothing running */
enum Status model_start(struct Model *model, double time);
int model_started(const struct Model *model);
/* Outputs and rates from the time, the states and the inputs as they stand. */
enum Status model_evaluate(struct Model *model);
void model_indicators(const struct Model *model, double *indicators); /* as model_evaluate has found them */
/* Of which size is a continuous state, as the parameters are now? Above 0. */
double model_nominal(const struct Model *model, int state);
/* A solver of Model Exchange has completed a step that ends at the present time. */
enum Status model_completed_step(struct Model *model);
/* An event has happened at the present time. */
enum Status model_event(struct Model *model);
/* Has the event between these two turned anything that rates depend on, so that a solver has to begin anew? */
int model_turned(const struct Model *before, const struct Model *after);
double model_next_event(const struct Model *model); /* [s]; infinity: none is known ahead */
/* Advance by `step` [s]. With stop_at_events nonzero, return at the first event, before it is acted upon, *taken
 * telling how far it went. */
enum Status model_step(struct Model *model, double step, int stop_at_events, double *taken);
/* The same by what follows from the parameters alone: model_wiring_size() bytes beside the model, found for it where it
 * lies, and good until a parameter changes. */
struct Wiring;
size_t model_wiring_size(void);
void model_wire(const struct Model *model, struct Wiring *wiring);
enum Status model_step_wired(struct Model *model, struct Wiring *wiring, double step, int stop_at_events,
                             double *taken);
/* d unknown / d known of `count` unknowns at the present point. known: inputs and states. */
enum Status model_derivatives(const struct Model *model, int known, int count, const int *unknown, double *derivatives);
/* d output / dt of `count` outputs, at most DERIVATIVES_AT_ONCE, at the present point, as inputs go on by their slopes
 * and states by their rates. room: bytes of another model, to look around in. */
enum Status model_time_derivatives(const struct Model *model, struct Model *room, int count, const int *index,
                                   double *derivatives);

/* ---- what it has to say ---- */

/* What a status means for this model. */
void model_explain(const struct Model *model, enum Status status, char *text, size_t size);
/* What is legal but worth one line in the log; a bit each, the first WARN_AT_BOUND. */
uint32_t model_warnings(const struct Model *model);
int model_warning_count(void);
void model_explain_warning(const struct Model *model, int bit, char *text, size_t size);
/* What keeps a model whose bytes come from outside from going on, in words; NULL: nothing. */
const char *model_flaw(const struct Model *model);
/* What keeps a solver of Model Exchange from following it as it is set, in words; NULL: nothing. */
const char *model_solver_obstacle(const struct Model *model);

#endif
