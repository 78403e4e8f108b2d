/* What is shown at a time, and what of it jumps? */
#include "course.h"

#include <math.h>

/* Each mean, and the integrand it is the mean of. */
static const int means[][2] = {
    {VAR_MEAN_FRICTION_FORCE, VAR_FRICTION_FORCE},
    {VAR_MEAN_PRINCIPAL_FORCE, VAR_PRINCIPAL_FORCE},
    {VAR_MEAN_FEED_FORCE, VAR_FEED_FORCE},
    {VAR_MEAN_NORMAL_FORCE, VAR_NORMAL_FORCE},
    {VAR_MEAN_MEASURED_FRICTION_FORCE, VAR_MEASURED_FRICTION_FORCE},
    {VAR_MEAN_MEASURED_PRINCIPAL_FORCE, VAR_MEASURED_PRINCIPAL_FORCE},
    {VAR_MEAN_MEASURED_FEED_FORCE, VAR_MEASURED_FEED_FORCE},
    {VAR_MEAN_DISSIPATED_POWER, VAR_DISSIPATED_POWER},
    {VAR_MEAN_SHEAR_POWER, VAR_SHEAR_POWER},
};

/* What adds up since the start, and at which rate. */
static const int totals[][2] = {
    {VAR_DISSIPATED_ENERGY, VAR_DISSIPATED_POWER},
    {VAR_SHEAR_ENERGY, VAR_SHEAR_POWER},
    {VAR_SLIDING_DISTANCE, VAR_SLIDING_SPEED},
};

static double shown(const struct Course *c, int index)
{
    for (size_t n = 0; n < sizeof means / sizeof means[0] && c->window > 0; ++n)
        for (int q = 0; q < c->radau.integrals && means[n][0] == index; ++q)
            if (c->integrand[q] == means[n][1])
                return c->mean[q];
    for (size_t n = 0; n < sizeof totals / sizeof totals[0]; ++n)
        for (int q = 0; q < c->radau.integrals && totals[n][0] == index; ++q)
            if (c->integrand[q] == totals[n][1])
                return c->sums[q];
    return parameter(c, index);
}

static void show(const struct Course *c, double *row)
{
    for (int j = 0; j < c->motion->outputs; ++j)
        row[j] = shown(c, c->motion->output_index[j]);
}

static double patience(const struct Course *c)
{
    if ((int)parameter(c, VAR_KINEMATICS) != KINEMATICS_EXTERNAL)
        return 0.159 / parameter(c, VAR_VIBRATION_FREQUENCY);
    const double reach = fmax(parameter(c, VAR_F_C), parameter(c, VAR_F_S)) / parameter(c, VAR_SIGMA0);
    return reach / fmax(fabs(parameter(c, VAR_SLIP_VELOCITY_USED)), 1e-12);
}

static void note_jump(struct Course *c, double in_time)
{
    struct Jump *const jump = &c->outcome->jumps[c->outcome->jump_count];
    jump->time = c->t;
    jump->first = c->outcome->jump_count++ * 2;
    jump->patience = in_time;
}

static double *sides(const struct Course *c, int after)
{
    return c->outcome->sides + ((int64_t)c->outcome->jump_count * 2 + after) * c->motion->outputs;
}

/* A host that ramps slip or thickness to 0 by its slope lands a rounding error beside it, on either side. */
void notes_both_sides(struct Course *c)
{
    const struct Motion *m = c->motion;
    for (int j = 0; j < m->inputs && m->rounds; ++j) {
        const double u_0 = m->begin[c->segment * m->inputs + j], u_1 = m->end[c->segment * m->inputs + j];
        const int index = m->input_index[j], matters = index == VAR_SLIP_VELOCITY || index == VAR_UNCUT_THICKNESS;
        if (!matters || u_1 != 0 || u_0 == 0 || c->outcome->jump_count == c->outcome->jump_room)
            continue;
        for (int after = 0; after < 2; ++after) {
            c->contact->value[index][0] = (after ? 1e-15 : -1e-15) * u_0;
            kernel_evaluate(c->contact);
            show(c, sides(c, after));
        }
        c->contact->value[index][0] = u_1;
        note_jump(c, 1e-12 * m->times[m->segments]);
    }
}

/* An event at the end of a communication step or at a sample: it is shown before or after, and a host's rounding of the
 * inputs decides. */
static int ends_a_step(const struct Course *c)
{
    const struct Motion *m = c->motion;
    const double from = m->times[c->segment], to = m->times[c->segment + 1];
    return to - c->t <= 1e-9 * (to - from) + 1e-12 * fabs(to);
}

/* What is shown before an event; where rounding decides on it, with inputs that have not quite come to 0. */
static void show_before(struct Course *c, int rounded)
{
    const struct Motion *m = c->motion;
    double given[INPUT_END - INPUT_FIRST];
    for (int j = 0; j < m->inputs && rounded; ++j) {
        double *const value = c->contact->value[m->input_index[j]];
        given[j] = *value;
        if (m->end[c->segment * m->inputs + j] == 0)
            *value = 1e-15 * m->begin[c->segment * m->inputs + j];
    }
    if (rounded)
        kernel_evaluate(c->contact);
    show(c, sides(c, 0));
    for (int j = 0; j < m->inputs && rounded; ++j)
        c->contact->value[m->input_index[j]][0] = given[j];
    if (rounded)
        kernel_evaluate(c->contact);
}

/* At the present time: sides anew, and a note of what has jumped where the time of it hangs on a state or on rounding.
 */
int notes_event(struct Course *c, int hangs_on_state)
{
    const int rounded = !hangs_on_state && ends_a_step(c);
    const int noted = (hangs_on_state || rounded) && c->outcome->jump_count < c->outcome->jump_room;
    if (!course_look(c))
        return 0;
    if (noted)
        show_before(c, rounded);
    if (kernel_event(c->contact) != STATUS_OK)
        return 0;
    course_take_states(c);
    if (!course_look(c))
        return 0;
    if (!noted)
        return 1;
    show(c, sides(c, 1));
    for (int j = 0; j < c->motion->outputs; ++j)
        if (fabs(sides(c, 1)[j] - sides(c, 0)[j]) > 1e-9 * (fabs(sides(c, 1)[j]) + fabs(sides(c, 0)[j]))) {
            note_jump(c, rounded ? 1e-12 * c->motion->times[c->motion->segments] : patience(c));
            if (rounded)
                c->outcome->jumps[c->outcome->jump_count - 1].time = c->motion->times[c->segment + 1];
            break;
        }
    return 1;
}

/* What is shown at the present time; `late` outputs, or the others. */
void notes_row(struct Course *c, int row, int late)
{
    const struct Motion *m = c->motion;
    for (int j = 0; j < m->outputs; ++j)
        if (!(m->late > 0) || late == m->lags[j])
            c->outcome->rows[(int64_t)row * m->outputs + j] = shown(c, m->output_index[j]);
}

double notes_next_late(const struct Course *c)
{
    const int due = c->motion->late > 0 && c->late_row <= c->motion->segments;
    return due ? c->motion->times[c->late_row] - c->motion->late : INFINITY;
}

void notes_late(struct Course *c)
{
    while (notes_next_late(c) <= c->t)
        notes_row(c, c->late_row++, 1);
}

double notes_window_end(const struct Course *c)
{
    return c->window > 0 ? c->motion->times[0] + (double)(c->windows + 1) * c->window : INFINITY;
}

void notes_close_window(struct Course *c)
{
    for (int q = 0; q < c->radau.integrals; ++q) {
        c->mean[q] = (c->sums[q] - c->opened[q]) / c->window;
        c->opened[q] = c->sums[q];
    }
    c->windows += 1;
}
