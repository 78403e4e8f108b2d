/* Can a contact whose bytes come from outside go on? What no table bounds: sides, rings, windows, and what was derived
 * from values.
 *
 * A serialised state may be forged whatever its checksum says. All that steers the course of a step is looked at here,
 * so that a contact without a flaw goes on like one that has come by itself: within its arrays, in the time that it
 * takes, to finite numbers or an error.
 */
#include "stages.h"

#include <math.h>

static int all_finite(const double *x, size_t count)
{
    int lost = 0;
    for (size_t i = 0; i < count; ++i)
        lost |= !(fabs(x[i]) < INFINITY);
    return !lost;
}

#define FINITE(rows) all_finite((const double *)(rows), sizeof(rows) / sizeof(double))

static int is_count(double x) { return x >= 0 && x < 9e15 && x == floor(x); }

/* Outputs are found anew from these. */
static const char *flaw_of_values(const struct Contact *contact)
{
    for (int index = 0; index < kernel_variable_count(); ++index) {
        const enum Causality role = kernel_variable(index)->causality;
        for (int i = 0; i < LANES && (role == PARAMETER || role == INPUT); ++i)
            if (kernel_check(index, contact->value[index][i]) != STATUS_OK)
                return "a parameter or an input lies outside its bounds";
    }
    for (int place = 0; place < kernel_state_count(); ++place)
        if (!FINITE(contact->value[kernel_state(place)]))
            return "a continuous state is no finite number";
    for (int n = 0; n < INTEGRALS; ++n)
        if (!FINITE(contact->value[integral_of[n]]))
            return "an integral is no finite number";
    return FINITE(contact->value[VAR_TIME]) ? NULL : "the time is no finite number";
}

/* What the start has made of values that are fixed since. */
static const char *flaw_of_start(const struct Contact *contact)
{
    if (!contact->started)
        return contact->effects_on >> EFFECT_COUNT ? "an effect is on that is not there" : NULL;
    if (contact->effects_on != effects_switched_on(contact))
        return "the effects that are on are not those that are switched on";
    const struct Configuration w = wire(contact);
    int rivals[2];
    if (rivals_among(contact->effects_on, rivals))
        return kernel_status_text(STATUS_RIVALS);
    if (kernel_averages(contact) && w.kinematics == KINEMATICS_EXTERNAL)
        return kernel_status_text(STATUS_NO_CYCLE);
    EACH_LANE
        if (!(fabs(contact->largest_difference[i] / largest_difference(contact, i) - 1) < 1e-9))
            return "what a step may leave unexplained is not that of relative_tolerance";
    return NULL;
}

static const char *flaw_of_course(const struct Contact *contact)
{
    for (int i = 0; i < LANES; ++i) {
        for (int k = 0; k < INDICATORS; ++k)
            if (fabs(contact->sign[k][i]) != 1)
                return "a side of an event is neither +1 nor -1";
        if (!(contact->next_step[i] > 0))
            return "the next internal step is not above 0";
        if (contact->follows[i] != 0 && contact->follows[i] != 1)
            return "a slip that is followed is neither there nor not";
        if (!is_count(contact->window[i]) || !is_count(contact->served[i]))
            return "a count is no whole number from 0 on";
        const double breakpoints = contact->breakpoint_count[i] - contact->breakpoint_next[i];
        if (!is_count(contact->breakpoint_count[i]) || !is_count(contact->breakpoint_next[i]) ||
            !(breakpoints >= 0 && breakpoints <= (double)BREAKPOINTS) || isnan(contact->breakpoint_due[i]))
            return "the steps of the cycle before have no such place";
        for (int n = 0; n < 2; ++n)
            if (!(contact->earlier_time[n][i] < INFINITY)) /* before the first step it is -infinity */
                return "an earlier time is no number";
    }
    return FINITE(contact->slope) && FINITE(contact->memory) && FINITE(contact->window_start) &&
                   FINITE(contact->event_start) && isfinite(contact->window_origin) && contact->flank_depth >= 0 &&
                   contact->flank_depth < 1 && FINITE(contact->cusp) && FINITE(contact->steady_state) &&
                   FINITE(contact->earlier_force) && FINITE(contact->outlives) && FINITE(contact->changes) &&
                   FINITE(contact->followed_slip) && FINITE(contact->breakpoints_from) && FINITE(contact->breakpoint)
               ? NULL
               : "a memory is no finite number";
}

/* Pieces in their order, none of them before the one before has ended. */
static const char *flaw_of_ring(const struct Ring *ring, int lane)
{
    const double first = ring->first[lane], count = ring->count[lane], settled = ring->settled[lane],
                 joined = ring->joined[lane];
    if (!is_count(first) || !is_count(count) || !is_count(settled) || !is_count(joined) || first > count ||
        settled > count || joined > count || count - first > (double)HISTORY)
        return "the past has no such place";
    for (int n = 0; n < HISTORY; ++n)
        if (ring->length[n][lane] < 0)
            return "a step of the past is shorter than 0";
    for (int64_t n = whole_count(first) + 1; n < whole_count(count); ++n) {
        const double end = ring->end[(n - 1) % HISTORY][lane],
                     start = ring->end[n % HISTORY][lane] - ring->length[n % HISTORY][lane];
        if (!(start >= end - 1e-12 * fabs(end) - 1e-6 * ring->length[n % HISTORY][lane]))
            return "the steps of the past are out of order";
    }
    return NULL;
}

static const char *flaw_of_rings(const struct Contact *contact)
{
    if (!FINITE(contact->past.end) || !FINITE(contact->past.length) || !FINITE(contact->past.drift) ||
        !FINITE(contact->past_force) || !FINITE(contact->surface.end) || !FINITE(contact->surface.length) ||
        !FINITE(contact->surface.drift) || !FINITE(contact->surface_height) || !FINITE(contact->surface_thickest) ||
        !FINITE(contact->slip_time) || !FINITE(contact->slip_given) || !FINITE(contact->late_slip) ||
        !FINITE(contact->late_slope))
        return "the past is no finite number";
    const char *flaw = NULL;
    for (int i = 0; i < LANES && !flaw; ++i) {
        const double first = contact->slip_first[i], count = contact->slip_count[i];
        if (!is_count(first) || !is_count(count) || !is_count(contact->slip_settled[i]) || first > count ||
            count - first > (double)HISTORY)
            return "the past has no such place";
        flaw = flaw_of_ring(&contact->past, i);
        flaw = flaw ? flaw : flaw_of_ring(&contact->surface, i);
    }
    return flaw;
}

const char *kernel_flaw(const struct Contact *contact)
{
    const char *(*const looks[])(const struct Contact *) = {flaw_of_values, flaw_of_start, flaw_of_course,
                                                            flaw_of_rings};
    uint64_t flags = contact->warnings >> WARNING_COUNT;
    EACH_LANE
        flags |= contact->at_bound[i] >> (INPUT_END - INPUT_FIRST);
    const char *flaw = contact->started > 1 || flags ? "a flag is not there" : NULL;
    for (size_t n = 0; n < sizeof looks / sizeof *looks && !flaw; ++n)
        flaw = looks[n](contact);
    return flaw;
}
