/* What is right? Takes from the kernel what a host of model exchange takes: rates, event indicators and what happens
 * at an event. Steps, their length, the search for events, windows, delays and the surface of the turn before are the
 * reference's own. */
#include "course.h"

#include <math.h>
#include <stdlib.h>

/* The next corner of the motion, end of an averaging window, late output or turn of the work. */
static double next_stop(const struct Course *c)
{
    const double corner = fmin(c->motion->times[c->segment + 1], notes_window_end(c));
    return fmax(fmin(corner, fmin(notes_next_late(c), surface_next_turn(c))), c->t);
}

static int inputs_jump(const struct Course *c)
{
    const struct Motion *m = c->motion;
    for (int j = 0; j < m->inputs && c->segment > 0; ++j)
        if (m->end[(c->segment - 1) * m->inputs + j] != m->begin[c->segment * m->inputs + j])
            return 1;
    return 0;
}

static enum Verdict run_segment(struct Course *c)
{
    const double end = c->motion->times[c->segment + 1];
    if (!(inputs_jump(c) ? notes_event(c, 0) : course_look(c)))
        return NO_RATES;
    c->next = fmin(c->next, 0.1 * (end - c->t));
    while (c->t < end) {
        const double stop = next_stop(c);
        const enum Verdict verdict = stop > c->t ? walk_to(c, stop) : DONE;
        if (verdict != DONE)
            return verdict;
        notes_late(c);
        if (c->t >= notes_window_end(c) - 1e-9 * c->window) /* a sample lies beside it by roundings */
            notes_close_window(c);
        if (c->t < surface_next_turn(c))
            continue;
        c->turns += 1;
        if (!notes_event(c, 0))
            return NO_RATES;
    }
    notes_row(c, c->segment + 1, 0);
    notes_both_sides(c);
    return DONE;
}

enum Verdict reference_run(struct Contact *contact, const struct Motion *motion, const struct Care *care,
                           struct Outcome *outcome)
{
    struct Course c = {.contact = contact, .motion = motion, .care = care, .outcome = outcome};
    enum Verdict verdict = DONE;
    outcome->steps = outcome->events = outcome->evaluations = 0;
    outcome->jump_count = outcome->branches = 0;
    c.t = c.counted_at = motion->times[0];
    c.next = motion->times[1] - c.t;
    c.turn = course_named(&c, "regenerative") != 0 ? course_named(&c, "regenerative.revolution_time") : 0;
    c.slow = 0.1 * parameter(&c, VAR_V_S);
    if (course_named(&c, "stribeck") != 0)
        c.slow *= fmin(course_named(&c, "stribeck.v_s_ratio"), 1);
    c.radau.tolerance = care->tolerance;
    c.radau.rates = course_rates;
    c.radau.what = &c;
    radau_begin(&c.radau);
    course_put(&c, c.t, c.y);
    for (int j = 0; j < motion->inputs; ++j)
        contact->slope[motion->input_index[j] - INPUT_FIRST][0] = 0;
    if (kernel_start(contact, c.t) != STATUS_OK)
        return NO_RATES;
    course_sort_states(&c);
    course_take_states(&c);
    for (int q = 0; q < c.radau.integrals; ++q)
        c.sums[q] = c.opened[q] = contact->value[c.integral[q]][0];
    c.moved = (int)parameter(&c, VAR_CHIP_FLOW_ANGLE) == CURRENT_ANGLE || c.turn > 0;
    for (int n = 0; n < kernel_effect_count(); ++n)
        c.moved |= contact->value[kernel_effect_switch(n)][0] != 0 &&
                   (kernel_effect(n)->driver == DRIVEN_BY_APPROACH || kernel_effect(n)->driver == DRIVEN_BY_FORCE);
    c.window = parameter(&c, VAR_AVERAGING_WINDOW);
    if (!(c.window > 0) && (int)parameter(&c, VAR_KINEMATICS) != KINEMATICS_EXTERNAL)
        c.window = 1 / parameter(&c, VAR_VIBRATION_FREQUENCY);
    if (!course_look(&c))
        return NO_RATES;
    notes_row(&c, 0, 0);
    if (motion->late > 0)
        verdict = walk_sensors(&c);
    for (c.segment = 0; c.segment < motion->segments && verdict == DONE; c.segment += verdict == DONE)
        verdict = run_segment(&c);
    outcome->failed_at = c.t;
    free(c.left);
    return verdict;
}
