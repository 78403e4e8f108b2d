/* What are the states of a contact, and what are their rates at a time? Asked as a host of model exchange asks. */
#include "course.h"

#include <math.h>
#include <string.h>

double course_named(const struct Course *c, const char *name)
{
    for (int n = 0; n < kernel_variable_count(); ++n)
        if (!strcmp(kernel_variable(n)->name, name))
            return parameter(c, n);
    return NAN;
}

static void set_inputs(struct Course *c, double t)
{
    const struct Motion *m = c->motion;
    const double t_0 = m->times[c->segment], length = m->times[c->segment + 1] - t_0, share = (t - t_0) / length;
    for (int j = 0; j < m->inputs; ++j) {
        const double u_0 = m->begin[c->segment * m->inputs + j], u_1 = m->end[c->segment * m->inputs + j];
        c->contact->value[m->input_index[j]][0] = share >= 1 ? u_1 : u_0 + share * (u_1 - u_0);
        c->contact->slope[m->input_index[j] - INPUT_FIRST][0] = (u_1 - u_0) / length;
    }
    c->contact->value[VAR_TIME][0] = t;
}

void course_put(struct Course *c, double t, const double *y)
{
    set_inputs(c, c->frozen ? c->motion->times[0] : t);
    surface_meet(c, t);
    for (int i = 0; i < c->radau.states; ++i)
        c->contact->value[c->state[i]][0] = y[i];
}

int course_rates(void *what, double t, const double *y, double *f, double *g)
{
    struct Course *c = what;
    course_put(c, t, y);
    c->outcome->evaluations += 1;
    if (kernel_evaluate(c->contact) != STATUS_OK)
        return 1;
    for (int i = 0; i < c->radau.states; ++i)
        f[i] = c->frozen && !c->of_sensor[i] ? 0 : c->contact->value[c->rate[i]][0];
    for (int q = 0; q < c->radau.integrals; ++q)
        g[q] = c->contact->value[c->integrand[q]][0];
    return 0;
}

/* The course's own present state and rates, and how large they have been. */
int course_look(struct Course *c)
{
    for (int q = 0; q < c->radau.integrals; ++q)
        c->contact->value[c->integral[q]][0] = c->sums[q];
    if (course_rates(c, c->t, c->y, c->f, c->g))
        return 0;
    for (int i = 0; i < c->radau.states; ++i)
        c->radau.scale[i] = fmax(c->radau.scale[i], fabs(c->y[i]));
    for (int q = 0; q < c->radau.integrals; ++q)
        c->radau.integral_scale[q] = fmax(c->radau.integral_scale[q], fabs(c->g[q]));
    return 1;
}

void course_take_states(struct Course *c)
{
    for (int i = 0; i < c->radau.states; ++i)
        c->y[i] = c->contact->value[c->state[i]][0];
}

/* Which states move others, and which only sum up. */
void course_sort_states(struct Course *c)
{
    struct Radau *r = &c->radau;
    const double reach = fmax(parameter(c, VAR_F_C), parameter(c, VAR_F_S)) / parameter(c, VAR_SIGMA0);
    int on[STATES], sensor[STATES] = {0};
    for (int place = 0; place < kernel_state_count(); ++place)
        on[place] = place < BASE_STATES;
    for (int n = 0, place = BASE_STATES; n < kernel_effect_count(); ++n)
        for (int k = 0; k < kernel_effect(n)->states; ++k, ++place) {
            sensor[place] = kernel_effect(n)->driver == DRIVEN_BY_SENSOR;
            on[place] = parameter(c, kernel_effect_switch(n)) != 0;
        }
    const int contact_effects = c->contact->effects_on != 0; /* only they ask how far it has slid */
    r->states = r->integrals = 0;
    for (int place = 0; place < kernel_state_count(); ++place) {
        const int index = kernel_state(place);
        int rate = 0;
        while (on[place] && kernel_derivative_of(rate) != index)
            ++rate;
        if (!on[place])
            continue;
        if (place >= BASE_STATES || index == VAR_BRISTLE_DEFLECTION ||
            (index == VAR_SLIDING_DISTANCE && contact_effects)) {
            const double nominal = kernel_variable(index)->nominal;
            c->of_sensor[r->states] = sensor[place];
            c->state[r->states] = index;
            c->rate[r->states] = rate;
            r->scale[r->states++] = index == VAR_BRISTLE_DEFLECTION ? reach : 1e-3 * (nominal > 0 ? nominal : 1);
        } else {
            c->integral[r->integrals] = index;
            c->integrand[r->integrals] = rate;
            r->integral_scale[r->integrals++] =
                rate == VAR_CONTACT_RATE ? 1 : fmax(parameter(c, VAR_F_C), parameter(c, VAR_F_S));
        }
    }
}
