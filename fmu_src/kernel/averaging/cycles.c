/* How do many cycles go on, of which one or two are run?
 *
 * Where the bristle comes back to where it was, all are like the last. Else a second cycle tells by which ratio a
 * departure shrinks and what it does to forces: with a law that is linear in the deflection the cycles are a geometric
 * series, transients included. Ratio and effect on the forces serve the steps that follow, as long as little is left. A
 * law with events of its own makes no such series; nor do states that a separation resets and that outlive one, or that
 * none comes to: these are run until cycles leave them where they were.
 */
#include "cycles.h"

#include <math.h>
#include <string.h>

enum { MOST_CYCLES = 8, MOST_TO_SETTLE = 64 }; /* of one step; where states that a separation resets still drift */
#define SMALL_DEPARTURE 3e-3 /* of a bristle's reach: a departure for which what an earlier step has found will do */

/* Of states that a separation resets: how far from where they were, as shares of what they are. */
static double drift_of(const struct Contact *contact, const struct Configuration *w, const lanes *from, int i)
{
    double most = 0;
    for (int n = 0; n < w->on_count; ++n) {
        const struct Effect *const effect = w->on[n];
        for (int k = 0; effect->forgets && k < effect->states; ++k) {
            const double nominal = effect->variables[effect->count - 2 * effect->states + k].nominal,
                         now = contact->value[w->on_value[n] + k][i];
            most = larger(most, fabs(now - from[w->on_state[n] + k][i]) / larger(nominal > 0 ? nominal : 1, fabs(now)));
        }
    }
    return most;
}

static enum Status run_cycle(struct Contact *contact, struct Configuration *w, const lanes begin,
                             struct CycleSums *seen)
{
    struct Course course;
    struct Point from; /* of which the states alone are asked */
    lanes s = {0}, start[INTEGRALS], z;
    load_states(contact, w, &from);
    for (int n = 0; n < INTEGRALS; ++n) { /* from 0, so that no digits are lost; but effects ask for the distance */
        lanes *const integral = &contact->value[integral_of[n]];
        EACH_LANE
            start[n][i] = (*integral)[i] = integral_of[n] == VAR_SLIDING_DISTANCE ? (*integral)[i] : 0;
    }
    EACH_LANE {
        contact->value[VAR_TIME][i] = begin[i];
        z[i] = contact->value[VAR_BRISTLE_DEFLECTION][i];
        repeat_breakpoints(contact, w, i);
    }
    wire_time(contact, w);
    course.now = course.known = 0;
    course.guard.length = 0;
    course.most_steps = most_steps_of_cycles(contact);
    const enum Status status = advance_internal(contact, w, period_of(contact), 0, s, &course);
    for (int i = 0; i < LANES; ++i) {
        for (int n = 0; n < INTEGRALS && !seen->done[i]; ++n) {
            seen->before[n][i] = seen->last[n][i];
            seen->last[n][i] = contact->value[integral_of[n]][i] - start[n][i];
            seen->gain[n][i] += seen->last[n][i];
        }
        if (seen->done[i])
            continue;
        seen->departure_before[i] = seen->departure[i];
        seen->departure[i] = contact->value[VAR_BRISTLE_DEFLECTION][i] - z[i];
        seen->drift[i] = drift_of(contact, w, (const lanes *)from.state, i);
        seen->cycles[i] += 1;
    }
    return status;
}

/* What a second cycle would show, from what an earlier step has found. */
static void foretell(struct Contact *contact, struct CycleSums *seen, int i)
{
    seen->left[i] = contact->outlives[i];
    for (int n = 0; n < INTEGRALS; ++n)
        seen->next[n][i] = contact->changes[n][i] * seen->departure[i];
    contact->served[i] += 1;
}

static void keep_for_later(struct Contact *contact, const struct CycleSums *seen, int i)
{
    contact->outlives[i] = seen->left[i];
    for (int n = 0; n < INTEGRALS; ++n)
        contact->changes[n][i] = (seen->last[n][i] - seen->before[n][i]) / seen->departure_before[i];
    contact->served[i] = 0;
}

/* Cycles over which what each moves counts. */
static double at_most(double cycles) { return smaller(larger(cycles, 1), 1e3); }

/* Is the last of so many cycles like those that follow, or are they members of a geometric series? A law with events of
 * its own makes none. */
static int goes_on_alike(struct Contact *contact, const struct Configuration *w, double cycles, struct CycleSums *seen,
                         int i)
{
    const double reach = stated_level(contact->value, i) / contact->value[VAR_SIGMA0][i],
                 departure = fabs(seen->departure[i]);
    seen->drifts[i] = seen->drift[i] * at_most(cycles) > contact->value[VAR_RELATIVE_TOLERANCE][i];
    if (seen->drifts[i])
        return 0;
    if (departure * at_most(cycles) <= contact->value[VAR_RELATIVE_TOLERANCE][i] * reach)
        return 1;
    if (w->law->event)
        return 0;
    if (seen->cycles[i] < 2) {
        const int known = departure <= SMALL_DEPARTURE * reach && contact->served[i] < (double)MOST_SERVED;
        if (known)
            foretell(contact, seen, i);
        return known;
    }
    const double ratio = seen->departure[i] / seen->departure_before[i];
    if (!(ratio >= 0 && ratio <= 1))
        return 0;
    seen->left[i] = ratio;
    for (int n = 0; n < INTEGRALS; ++n)
        seen->next[n][i] = ratio * (seen->last[n][i] - seen->before[n][i]);
    keep_for_later(contact, seen, i);
    return 1;
}

/* No more than there are: cycles of which none is like the next are those of the step itself. */
static double cycles_to_run(double cycles, int most) { return smaller(larger(floor(cycles + 0.5), 1), most); }

int stand_for(const struct CycleSums *seen, double cycles, int i)
{
    return seen->periodic[i] || cycles < seen->cycles[i] + 0.5;
}

enum Status run_cycles(struct Contact *contact, struct Configuration *w, const lanes begin, double cycles,
                       struct CycleSums *seen)
{
    lanes from[EFFECT_STATES], slid, aside[OWN_ROWS];
    memset(seen, 0, sizeof *seen);
    get_slow_states(contact, w, from);
    EACH_LANE
        slid[i] = contact->value[VAR_SLIDING_DISTANCE][i];
    const double few = cycles_to_run(cycles, MOST_CYCLES), most = cycles_to_run(cycles, MOST_TO_SETTLE);
    for (int n = 0, all = 0; n < most && !all; ++n) {
        if (n > 0) {
            memcpy(aside, contact, sizeof aside);
            set_slow_states(contact, w, (const lanes *)from);
            EACH_LANE
                contact->value[VAR_SLIDING_DISTANCE][i] = slid[i];
        }
        const enum Status status = run_cycle(contact, w, begin, seen);
        if (status != STATUS_OK)
            return status;
        all = 1;
        for (int i = 0; i < LANES; ++i) {
            if (seen->done[i])
                copy_lane((lanes *)contact, (const lanes *)aside, OWN_ROWS, i);
            else {
                seen->periodic[i] = goes_on_alike(contact, w, cycles, seen, i);
                seen->done[i] = seen->periodic[i] || seen->cycles[i] >= (seen->drifts[i] ? most : few);
            }
            all &= seen->done[i];
        }
    }
    get_slow_states(contact, w, seen->state);
    find_steady_states(contact, w, period_of(contact), (const lanes *)from, (const lanes *)seen->state);
    for (int i = 0; i < LANES; ++i)
        contact->warnings |= stand_for(seen, cycles, i) ? 0u : WARN_NOT_PERIODIC;
    return STATUS_OK;
}

/* q + ... + q^m, and the sum up to the m-th of 1, 1 + q, 1 + q + q^2, ...; m need not be whole. */
static double series(double q, double m) { return q < 1 ? q * (1 - pow(q, m)) / (1 - q) : m; }
static double series_of_series(double q, double m) { return q < 1 ? (m - series(q, m)) / (1 - q) : 0.5 * m * (m + 1); }

void go_on(struct Contact *contact, const struct CycleSums *seen, double cycles, lanes mean[INTEGRALS])
{
    const double period = period_of(contact);
    for (int i = 0; i < LANES; ++i) {
        const double run = seen->cycles[i], more = larger(cycles - run, 0), q = seen->left[i];
        for (int n = 0; n < INTEGRALS; ++n) {
            const double gain =
                seen->gain[n][i] + more * seen->last[n][i] + seen->next[n][i] * series_of_series(q, more);
            mean[n][i] = seen->periodic[i] ? gain / ((run + more) * period) : seen->gain[n][i] / (run * period);
        }
        contact->value[VAR_BRISTLE_DEFLECTION][i] += seen->periodic[i] ? seen->departure[i] * series(q, more) : 0;
    }
}
