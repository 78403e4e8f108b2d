/* Which cycles of a long communication step need not be run? Those that would be the last one over again.
 *
 * While parameters, inputs and machine stand still cycles settle, and a cycle that ends as it has begun is all that
 * follow. Time, running integrals and averaging windows then move on by as many at once, and the step is integrated
 * again from where its last whole cycle begins: a cycle jump, the multirevolution method (Petzold 1981) at a
 * slope of 0. What goes by the time itself, looks back, or has events of a law's own is run as it is, and so are steps
 * in which a host asks for events.
 *
 * The first EACH cycles are looked at one by one, since a change at the start of the step is soon forgotten, then two
 * when twice as many have been run. A step is cut at the same cycles in every lane, and a lane that has settled waits,
 * so that it ends as it would alone, to the last bit.
 */
#include "cycles.h"

#include <math.h>
#include <string.h>

#define EACH 6.0 /* cycles that are looked at one by one: transients of a changed input take three or four */
#define FEWEST_SKIPPED 2.0 /* cycles: fewer are not worth the cuts */
#define RUN_AT_THE_END 1.0 /* cycle, which shows the outputs of the step's end and a mean of its own */
#define MOST_ROUNDED                                                                                                   \
    1e-3 /* cycles: what a step may lack of a whole number of them by roundings, however many there are */
#define MAY_ADD 0.1 /* tolerances, of what all cycles that are skipped may change of a state, or one of a force */
#define MOST_SCATTER 1e3 /* cycles: departures that do not go on as they are or less are of roundings of the steps */

/* Where a cycle ends. */
struct CycleEnd {
    lanes state[UNKNOWNS], integral[INTEGRALS];
};

/* Does nothing go round in a cycle? Steps of a tool that does not vibrate, and that no effect has follow something of
 * its own, are as long as the tolerance lets them. All lanes go on without cycles, or none. */
static int is_even(const struct Configuration *w)
{
    int even = !w->current_angle;
    for (int n = 0; n < w->on_count; ++n)
        even &= w->on[n]->longest_step == NULL;
    EACH_LANE
        even &= (w->p[VAR_AMPLITUDE_X][i] == 0) & (w->p[VAR_AMPLITUDE_Y][i] == 0);
    return even;
}

static int may_jump(const struct Configuration *w, int stop_at_events)
{
    return !is_even(w) && w->kinematics != KINEMATICS_EXTERNAL && !stop_at_events && !w->law->event && !w->looks_back &&
           !w->meets_again && !w->delays && is_steady(w);
}

static void note_end(const struct Contact *contact, const struct Configuration *w, struct CycleEnd *at)
{
    for (int n = 0; n < UNKNOWNS && unknown_index(w, n) >= 0; ++n)
        memcpy(at->state[n], contact->value[unknown_index(w, n)], sizeof(lanes));
    for (int n = 0; n < INTEGRALS; ++n)
        memcpy(at->integral[n], contact->value[integral_of[n]], sizeof(lanes));
}

/* What so many cycles may add to a state that the last two have moved by these. */
static double may_add(double before, double last, double cycles)
{
    const double left = before != 0 ? last / before : 0;
    const double as_much = left >= 0 && left < 1 ? smaller(cycles, 1 / (1 - left)) : cycles;
    return fabs(last) * (left > 0.5 && left < 2 ? as_much : smaller(as_much, MOST_SCATTER));
}

static int is_impulse(int n) { return (n >= FIRST_FORCE) & (n != DUTY); }

/* Are the cycles that follow the last of these two to a tolerance like it? */
static int has_settled(const struct Contact *contact, const struct Configuration *w, const struct CycleEnd ends[2],
                       double cycles, int i)
{
    const struct CycleEnd *const a = &ends[0], *const b = &ends[1];
    const double enough = MAY_ADD * contact->value[VAR_RELATIVE_TOLERANCE][i],
                 level = stated_level(contact->value, i) * period_of(contact);
    int settled = 1;
    for (int k = 0; k < INPUT_END - INPUT_FIRST; ++k)
        settled &= contact->slope[k][i] == 0;
    for (int n = 0; n < UNKNOWNS && unknown_index(w, n) >= 0; ++n) {
        const int index = unknown_index(w, n);
        const double last = contact->value[index][i] - b->state[n][i], before = b->state[n][i] - a->state[n][i];
        settled &= may_add(before, last, cycles) <= enough * scale_of(contact, index, i);
    }
    for (int n = 0; n < INTEGRALS; ++n) {
        const double last = contact->value[integral_of[n]][i] - b->integral[n][i],
                     before = b->integral[n][i] - a->integral[n][i];
        settled &= fabs(last - before) <= enough * larger(fabs(last), is_impulse(n) ? level : 0);
    }
    return settled;
}

/* Does the mean of a window need a part of the cycles that are skipped? */
static int window_ends_within(const struct Contact *contact, double s, int i)
{
    return contact->value[VAR_AVERAGING_WINDOW][i] >= NO_WINDOW &&
           window_end(contact, i) <= contact->value[VAR_TIME][i] + s;
}

static void jump(struct Contact *contact, const struct CycleEnd *before, double cycles, int i)
{
    const double later = cycles * period_of(contact);
    for (int n = 0; n < INTEGRALS; ++n) {
        double *const integral = &contact->value[integral_of[n]][i];
        const double gain = cycles * (*integral - before->integral[n][i]);
        *integral += gain;
        if (n >= FIRST_MEAN && !(contact->value[VAR_AVERAGING_WINDOW][i] >= NO_WINDOW))
            contact->window_start[n - FIRST_MEAN][i] += gain;
    }
    if (!(contact->value[VAR_AVERAGING_WINDOW][i] >= NO_WINDOW))
        contact->window[i] += cycles; /* each has closed one, and its means are those of the last */
    for (int n = 0; n < BREAKPOINTS; ++n)
        contact->breakpoint[n][i] += later;
    contact->breakpoint_due[i] += later;
}

/* To where so many cycles of the step end. */
static enum Status run_to(struct Contact *contact, const struct Configuration *w, double cycles, lanes s,
                          struct Course *course)
{
    const double end = cycles * period_of(contact);
    return end > s[0] ? advance_internal(contact, w, end, 0, s, course) : STATUS_OK;
}

/* Two cycles, of which the second ends the `looked_at`-th of the step. */
static enum Status run_two(struct Contact *contact, const struct Configuration *w, double looked_at, lanes s,
                           struct Course *course, struct CycleEnd ends[2])
{
    enum Status status = run_to(contact, w, looked_at - 2, s, course);
    note_end(contact, w, &ends[0]);
    if (status == STATUS_OK)
        status = run_to(contact, w, looked_at - 1, s, course);
    note_end(contact, w, &ends[1]);
    return status == STATUS_OK ? run_to(contact, w, looked_at, s, course) : status;
}

static enum Status run_one(struct Contact *contact, const struct Configuration *w, double looked_at, lanes s,
                           struct Course *course, struct CycleEnd ends[2])
{
    ends[0] = ends[1];
    note_end(contact, w, &ends[1]);
    return run_to(contact, w, looked_at, s, course);
}

/* Through the cycles of a step that may repeat, `all` in number. */
static enum Status pass_cycles(struct Contact *contact, const struct Configuration *w, double all, lanes s,
                               struct Course *course)
{
    int jumped[LANES] = {0}, running = LANES;
    lanes aside[OWN_ROWS];
    enum Status status = STATUS_OK;
    struct CycleEnd ends[2];
    for (double n = 2; running && all - n >= FEWEST_SKIPPED; n += n < EACH ? 1 : n + 2) {
        status = n > 2 && n <= EACH ? run_one(contact, w, n, s, course, ends) : run_two(contact, w, n, s, course, ends);
        if (status != STATUS_OK)
            return status;
        for (int i = 0; i < LANES; ++i)
            if (!jumped[i] && has_settled(contact, w, ends, all - n, i) &&
                !window_ends_within(contact, all * period_of(contact), i)) {
                jump(contact, &ends[1], all - n, i);
                copy_lane(aside, (const lanes *)contact, OWN_ROWS, i);
                jumped[i] = 1;
                running -= 1;
            }
    }
    if (running)
        status = run_to(contact, w, all, s, course);
    for (int i = 0; i < LANES && status == STATUS_OK; ++i) {
        if (jumped[i])
            copy_lane((lanes *)contact, (const lanes *)aside, OWN_ROWS, i);
        s[i] = all * period_of(contact);
    }
    course->known = 0;
    return status;
}

enum Status advance_cycles(struct Contact *contact, const struct Configuration *w, double step, int stop_at_events,
                           lanes s, struct Course *course)
{
    const double given = step * contact->value[VAR_VIBRATION_FREQUENCY][0],
                 cycles = given + smaller(1e-12 * given, MOST_ROUNDED);
    if (cycles >= 2 + FEWEST_SKIPPED + RUN_AT_THE_END && may_jump(w, stop_at_events)) {
        const double all = floor(cycles) - RUN_AT_THE_END;
        const enum Status status = pass_cycles(contact, w, all, s, course);
        if (status != STATUS_OK)
            return status;
    }
    return advance_internal(contact, w, step, stop_at_events, s, course);
}
