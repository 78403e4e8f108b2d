/* How does the contact answer as a model among others? The interface of fmi/model.h over one contact, the first lane of
 * its block. */
#include "../fmi/model.h"
#include "kernel.h"

struct Model {
    struct Contact contact;
};

size_t model_size(void) { return kernel_size(); }
void model_token(char token[39]) { kernel_token(token); }
int model_variable_count(void) { return kernel_variable_count(); }
const struct Variable *model_variable(int index) { return kernel_variable(index); }
int model_input_count(void) { return INPUT_END - INPUT_FIRST; }
int model_input(int place) { return INPUT_FIRST + place; }
int model_state_count(void) { return kernel_state_count(); }
int model_state(int place) { return kernel_state(place); }
int model_derivative_of(int index) { return kernel_derivative_of(index); }
int model_indicator_count(void) { return INDICATORS; }
int model_indicator(int place) { return kernel_indicator(place); }
int model_tolerance(void) { return VAR_RELATIVE_TOLERANCE; }

enum Status model_check(int index, double value) { return kernel_check(index, value); }
double model_bound_slack(int index) { return kernel_bound_slack(index); }
double model_get(const struct Model *model, int index) { return model->contact.value[index][0]; }
enum Status model_set(struct Model *model, int index, double value)
{
    return kernel_set(&model->contact, index, 0, value);
}
void model_lead(struct Model *model, int index, double value) { kernel_lead(&model->contact, index, value); }
double model_slope(const struct Model *model, int input) { return model->contact.slope[input - INPUT_FIRST][0]; }
void model_set_slope(struct Model *model, int input, double slope)
{
    model->contact.slope[input - INPUT_FIRST][0] = slope;
}

void model_reset(struct Model *model) { kernel_reset(&model->contact); }
enum Status model_start(struct Model *model, double time) { return kernel_start(&model->contact, time); }
int model_started(const struct Model *model) { return model->contact.started != 0; }
enum Status model_evaluate(struct Model *model) { return kernel_evaluate(&model->contact); }
void model_indicators(const struct Model *model, double *indicators)
{
    /* Where inputs may jump, what is shown follows them at once; a solver has to see the sides that are held. */
    const int jumps = (int)model->contact.value[VAR_KINEMATICS][0] == KINEMATICS_EXTERNAL;
    lanes indicator[INDICATORS];
    if (jumps)
        kernel_indicators(&model->contact, indicator);
    for (int k = 0; k < INDICATORS; ++k)
        indicators[k] = jumps ? indicator[k][0] : model->contact.value[kernel_indicator(k)][0];
}
double model_nominal(const struct Model *model, int state) { return kernel_nominal(&model->contact, state); }
enum Status model_completed_step(struct Model *model) { return kernel_step_completed(&model->contact); }
enum Status model_event(struct Model *model) { return kernel_event(&model->contact); }
int model_turned(const struct Model *before, const struct Model *after)
{
    return kernel_turned(&before->contact, &after->contact);
}
double model_next_event(const struct Model *model) { return kernel_next_event(&model->contact); }
enum Status model_step(struct Model *model, double step, int stop_at_events, double *taken)
{
    return kernel_advance(&model->contact, step, stop_at_events, taken);
}
size_t model_wiring_size(void) { return kernel_wiring_size(); }
void model_wire(const struct Model *model, struct Wiring *wiring) { kernel_wire(&model->contact, wiring); }
enum Status model_step_wired(struct Model *model, struct Wiring *wiring, double step, int stop_at_events, double *taken)
{
    return kernel_advance_wired(&model->contact, wiring, step, stop_at_events, taken);
}
enum Status model_derivatives(const struct Model *model, int known, int count, const int *unknown, double *derivatives)
{
    return kernel_derivatives(&model->contact, known, count, unknown, derivatives);
}
enum Status model_time_derivatives(const struct Model *model, struct Model *room, int count, const int *index,
                                   double *derivatives)
{
    return kernel_time_derivatives(&model->contact, &room->contact, count, index, derivatives);
}

void model_explain(const struct Model *model, enum Status status, char *text, size_t size)
{
    kernel_explain(&model->contact, status, text, size);
}
uint32_t model_warnings(const struct Model *model) { return model->contact.warnings; }
int model_warning_count(void) { return WARNING_COUNT; }
void model_explain_warning(const struct Model *model, int bit, char *text, size_t size)
{
    kernel_explain_warning(&model->contact, bit, text, size);
}
const char *model_flaw(const struct Model *model) { return kernel_flaw(&model->contact); }
const char *model_solver_obstacle(const struct Model *model)
{
    return kernel_averages(&model->contact)
               ? "averaging = cycle belongs to the steps of Co-Simulation; a solver of Model Exchange follows every "
                 "cycle: set averaging = resolved, or instantiate for Co-Simulation"
               : NULL;
}
