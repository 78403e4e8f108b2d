/* Where in the vibration cycle before this one did steps end that had been too long, so that those of this one may end
 * there at once?
 *
 * While parameters and machine stand still every cycle has its events at the same places, and asks for steps of the
 * same lengths. Where a step of the last one was cut at an event, or had to be tried again, this one need not try what
 * failed; where the first try did, it comes by itself. A breakpoint is an end to aim at and no more: tolerance and
 * events are asked of each step as of any other, so that where something has changed since, a breakpoint costs a step
 * and not its accuracy.
 *
 * Where an effect looks back at a past, steps know no breakpoints: of cycles that drift only the first and the last are
 * kept (see history/drift.c), and fewer of those between lie as close to them where steps hold on to places that have
 * moved.
 */
#include "../stages.h"

#include <math.h>

#define CYCLES_ALIKE 32 /* for so many the steps keep their places; */
#define CYCLES_ANEW 2   /* then they are chosen anew, longer where they may be, and the last of these is kept */
#define JUST_PAST 0.25  /* of the width to which an event is known: aimed at behind it, it lies within the step */
#define WIDEST_EVENT 1e-3        /* of a step: wider than an event is known at any tolerance */

static double period_of(const struct Configuration *w, int lane) { return 1 / w->p[VAR_VIBRATION_FREQUENCY][lane]; }

/* The first cycle begins with steps that know nothing yet, and those after it choose their own, too. */
void begin_breakpoints(struct Contact *contact, const struct Configuration *w, int lane)
{
    contact->breakpoint_count[lane] = contact->breakpoint_next[lane] = 0;
    contact->breakpoint_due[lane] = INFINITY;
    contact->breakpoints_from[lane] = contact->value[VAR_TIME][lane] - (CYCLES_ALIKE - 1) * period_of(w, lane);
}

void look_for_breakpoints(const struct Contact *contact, const struct Configuration *w, const lanes s, lanes breakpoint)
{
    EACH_LANE {
        const double ahead = contact->breakpoint_due[i] - contact->value[VAR_TIME][i] - s[i];
        const int within = (ahead > 0) & (ahead * w->p[VAR_VIBRATION_FREQUENCY][i] <= 1);
        breakpoint[i] = within ? ahead : INFINITY;
    }
}

int aims_at_event(const struct Contact *contact, int lane)
{
    return contact->breakpoint_of_event[lane] >> whole_count(contact->breakpoint_next[lane]) % BREAKPOINTS & 1;
}

/* The first breakpoint that lies less than a cycle back, or not where the contact stands: an event lies within its
 * width only. */
static int64_t next_breakpoint(const struct Contact *contact, const struct Configuration *w, int lane, double t,
                               int64_t count)
{
    const double back = t - period_of(w, lane) + 2 * event_width(w, lane, w->longest[lane], t);
    int64_t next = whole_count(contact->breakpoint_next[lane]);
    if (next < count - BREAKPOINTS)
        next = count - BREAKPOINTS;
    while (next < count && contact->breakpoint[next % BREAKPOINTS][lane] <= back)
        next += 1;
    return next;
}

/* At which of them may a step end next, after the time t? */
static void expect_breakpoint(struct Contact *contact, const struct Configuration *w, int lane, double t)
{
    const double period = period_of(w, lane), alike = (t - contact->breakpoints_from[lane]) / period;
    const int64_t count = whole_count(contact->breakpoint_count[lane]),
                  next = next_breakpoint(contact, w, lane, t, count);
    if (!(alike >= 0 && alike < CYCLES_ALIKE + CYCLES_ANEW))
        contact->breakpoints_from[lane] = t;
    const int anew = alike >= CYCLES_ALIKE && alike < CYCLES_ALIKE + CYCLES_ANEW,
              known = rounding_of(t) <= jump_time(w, lane);
    contact->breakpoint_next[lane] = (double)next;
    contact->breakpoint_due[lane] =
        next < count && !anew && known ? contact->breakpoint[next % BREAKPOINTS][lane] + period : INFINITY;
}

void note_breakpoint(struct Contact *contact, const struct Configuration *w, int lane, double t, double h,
                     enum Ended ended)
{
    if (ended == ENDED_ELSEWHERE && contact->breakpoint_due[lane] - t > WIDEST_EVENT * w->longest[lane])
        return;
    int64_t count = whole_count(contact->breakpoint_count[lane]);
    if (ended != ENDED_ELSEWHERE) {
        const double past = ended == AT_NEW_EVENT ? JUST_PAST * event_width(w, lane, h, t) : 0;
        contact->breakpoint[count % BREAKPOINTS][lane] = t + past;
        const uint64_t bit = (uint64_t)1 << count % BREAKPOINTS;
        contact->breakpoint_of_event[lane] = ended == BY_TOLERANCE ? contact->breakpoint_of_event[lane] & ~bit
                                                                   : contact->breakpoint_of_event[lane] | bit;
        count += 1;
    }
    contact->breakpoint_count[lane] = (double)count;
    expect_breakpoint(contact, w, lane, t);
}

void repeat_breakpoints(struct Contact *contact, const struct Configuration *w, int lane)
{
    const int64_t count = whole_count(contact->breakpoint_count[lane]);
    if (count == 0)
        return;
    const double t = contact->value[VAR_TIME][lane], period = period_of(w, lane),
                 later = period * floor((t - contact->breakpoint[(count - 1) % BREAKPOINTS][lane]) / period);
    for (int n = 0; n < BREAKPOINTS; ++n)
        contact->breakpoint[n][lane] += later;
    contact->breakpoints_from[lane] += later;
    expect_breakpoint(contact, w, lane, t);
}

void copy_breakpoints(struct Contact *to, const struct Contact *from, int lane)
{
    for (int n = 0; n < BREAKPOINTS; ++n)
        to->breakpoint[n][lane] = from->breakpoint[n][lane];
    to->breakpoint_of_event[lane] = from->breakpoint_of_event[lane];
    to->breakpoint_count[lane] = from->breakpoint_count[lane];
    to->breakpoint_next[lane] = from->breakpoint_next[lane];
    to->breakpoint_due[lane] = from->breakpoint_due[lane];
    to->breakpoints_from[lane] = from->breakpoints_from[lane];
}
