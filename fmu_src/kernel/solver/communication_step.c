/* How does a host's step pass, and what does it leave for the next? The configuration, and where nothing has been moved
 * since, the point that it has reached. */
#include "../stages.h"

#include <math.h>
#include <string.h>

void move_on(struct Contact *contact, const lanes s)
{
    EACH_LANE
        contact->value[VAR_TIME][i] += s[i];
    if (!any_rises(contact))
        return;
    for (int k = INPUT_FIRST; k < INPUT_END; ++k)
        EACH_LANE
            contact->value[k][i] = given_then(contact->value[k][i], contact->slope[k - INPUT_FIRST][i] * s[i]);
}

static enum Status advance_by_means(struct Contact *contact, double step, double *taken)
{
    const double start = contact->value[VAR_TIME][0];
    const enum Status status = average_step(contact, step);
    *taken = status == STATUS_OK ? step : contact->value[VAR_TIME][0] - start;
    return status;
}

static enum Status advance_by(const struct Configuration *w, struct Contact *contact, double step, int stop_at_events,
                              struct Course *course, double *taken)
{
    *taken = 0;
    course->most_steps = course->guard.length = 0;
    if (!is_step(step))
        return STATUS_BAD_STEP;
    if (!ordered_temperatures(contact))
        return STATUS_TEMPERATURES;
    if (kernel_averages(contact))
        return advance_by_means(contact, step, taken);
    lanes s = {0};
    for (int i = 0; w->delays && i < LANES; ++i)
        if (slip_lead(w, i) > 0)
            return STATUS_AHEAD;
    if (w->delays)
        note_slip_now(contact, w);
    const enum Status status = advance_cycles(contact, w, step, stop_at_events, s, course);
    move_on(contact, s);
    if (status != STATUS_OK)
        return_to_window(contact);
    if (w->delays)
        note_slip_now(contact, w);
    *taken = s[0];
    return status;
}

enum Status kernel_advance(struct Contact *contact, double step, int stop_at_events, double *taken)
{
    struct Configuration w = wire(contact);
    struct Course course;
    course.now = course.known = 0;
    wire_step(step, &w);
    return advance_by(&w, contact, step, stop_at_events, &course, taken);
}

/* What a point depends on and does not show, and what may change between two steps. */
enum { INPUTS = INPUT_END - INPUT_FIRST };
struct Place {
    lanes time, window, input[INPUTS], sign[INDICATORS];
};

struct Wiring {
    struct Configuration w;
    struct Course course;
    struct Place reached; /* where the course's point is known */
};

size_t kernel_wiring_size(void) { return sizeof(struct Wiring); }

void kernel_wire(const struct Contact *contact, struct Wiring *wired)
{
    wired->w = wire(contact);
    wired->course.now = wired->course.known = 0;
}

/* Does a point that ends a step begin the next one, to the bit? Not where effects keep more than it shows, where passes
 * have settled it, where the law remembers, or where inputs have slopes, which end with the step. */
static int goes_on(const struct Configuration *w)
{
    return !w->rises && w->on_count == 0 && !w->iterates && !w->law->event;
}

static void note_place(const struct Contact *contact, struct Place *at)
{
    EACH_LANE {
        at->time[i] = contact->value[VAR_TIME][i];
        at->window[i] = contact->window[i];
    }
    memcpy(at->sign, contact->sign, sizeof at->sign);
    memcpy(at->input, contact->value[INPUT_FIRST], sizeof at->input);
}

static int are_equal(const lanes *a, const lanes *b, int count)
{
    uint64_t apart = 0;
    for (int k = 0; k < count; ++k)
        EACH_LANE
            apart |= (uint64_t)(bits_of(a[k][i]) ^ bits_of(b[k][i]));
    return apart == 0;
}

static int stands_at(const struct Contact *contact, const struct Place *at, const struct Point *x)
{
    return are_equal(at->input, contact->value + INPUT_FIRST, INPUTS) &&
           are_equal(&at->time, contact->value + VAR_TIME, 1) &&
           are_equal(&x->z, contact->value + VAR_BRISTLE_DEFLECTION, 1) &&
           are_equal(&at->window, &contact->window, 1) && are_equal(at->sign, contact->sign, INDICATORS);
}

enum Status kernel_advance_wired(struct Contact *contact, struct Wiring *wired, double step, int stop_at_events,
                                 double *taken)
{
    struct Configuration *const w = &wired->w;
    struct Course *const course = &wired->course;
    wire_time(contact, w);
    wire_step(step, w);
    const int keeps = goes_on(w);
    course->known = course->known && keeps && stands_at(contact, &wired->reached, &course->room[course->now].point);
    const enum Status status = advance_by(w, contact, step, stop_at_events, course, taken);
    course->known = course->known && course->arrived && keeps && status == STATUS_OK;
    if (course->known)
        note_place(contact, &wired->reached);
    return status;
}
