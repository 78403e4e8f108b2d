/* What were the forces some time ago, and which surface did the tool leave? Two rings: the last internal steps, each
 * with its forces at start, middle and end; and heights in a number of places of each turn.
 */
#include "../stages.h"

#include <math.h>

/* Bytes from outside (a restored state) steer no array index. */
int64_t whole_count(double count) { return count > 0 && count < 9e15 ? (int64_t)count : 0; }

static int64_t steps_kept(const struct Contact *contact, int lane) { return whole_count(contact->past_count[lane]); }

static int64_t first_kept(const struct Contact *contact, int lane)
{
    const int64_t count = steps_kept(contact, lane), first = whole_count(contact->past_first[lane]);
    return first < count && count - first <= HISTORY ? first : count > HISTORY ? count - HISTORY : 0;
}

/* A step is written in its place; the one that stood there is gone. */
static void written(struct Contact *contact, int lane, int64_t count)
{
    contact->past_count[lane] = (double)count;
    contact->past_first[lane] = larger(contact->past_first[lane], (double)(count - HISTORY));
}

static const lanes *forces_of(const struct Point *x, int channel)
{
    return channel == 0 ? &x->F : channel == 1 ? &x->F_p : &x->F_f;
}

/* The first of the places low..high of a ring whose time lies after t, or with `at` set at t or after; high where none
 * does. */
int64_t first_later(const lanes *times, int lane, int64_t low, int64_t high, double t, int at)
{
    while (low < high) {
        const int64_t half = (low + high) / 2;
        const double there = times[half % HISTORY][lane];
        if (there < t || (there == t && !at))
            low = half + 1;
        else
            high = half;
    }
    return low;
}

/* Two steps of one length, one after the other and without a jump, are kept as one where one parabola does for both. */
static int joined(struct Contact *contact, int lane, int64_t before, int64_t after)
{
    const double length = contact->past_length[after][lane],
                 gap = contact->past_end[after][lane] - length - contact->past_end[before][lane];
    if (fabs(contact->past_length[before][lane] - length) > 1e-6 * length || fabs(gap) > 1e-6 * length)
        return 0;
    for (int k = 0; k < CHANNELS; ++k) {
        const lanes *a = contact->past_force[before][k], *b = contact->past_force[after][k];
        const double allowed =
            0.3 * contact->value[VAR_RELATIVE_TOLERANCE][lane] * larger(fabs(a[0][lane]), fabs(b[2][lane]));
        if (fabs(a[2][lane] - b[0][lane]) > allowed ||
            fabs(parabola(0.25, a[0][lane], b[0][lane], b[2][lane]) - a[1][lane]) > allowed ||
            fabs(parabola(0.75, a[0][lane], b[0][lane], b[2][lane]) - b[1][lane]) > allowed)
            return 0;
    }
    for (int k = 0; k < CHANNELS; ++k) {
        contact->past_force[before][k][1][lane] = contact->past_force[after][k][0][lane];
        contact->past_force[before][k][2][lane] = contact->past_force[after][k][2][lane];
    }
    contact->past_end[before][lane] = contact->past_end[after][lane];
    contact->past_length[before][lane] += length;
    return 1;
}

void remember(struct Contact *contact, int lane, double h, const struct Point *start, const struct Point *middle,
              const struct Point *end)
{
    const int64_t count = steps_kept(contact, lane), at = count % HISTORY;
    const struct Point *const at_time[3] = {start, middle, end};
    contact->past_end[at][lane] = end->t[lane];
    contact->past_length[at][lane] = h;
    for (int k = 0; k < CHANNELS; ++k)
        for (int n = 0; n < 3; ++n)
            contact->past_force[at][k][n][lane] = (*forces_of(at_time[n], k))[lane];
    written(contact, lane, count + 1);
    for (int64_t n = count + 1;
         n - 1 > first_kept(contact, lane) && joined(contact, lane, (n - 2) % HISTORY, (n - 1) % HISTORY); --n)
        contact->past_count[lane] = (double)(n - 1);
}

/* Straight from the end of the last step. */
void remember_host_step(struct Contact *contact, int lane, const struct Point *x)
{
    const int64_t count = steps_kept(contact, lane), at = count % HISTORY, last = (count + HISTORY - 1) % HISTORY;
    const double length = count > 0 ? x->t[lane] - contact->past_end[last][lane] : 0;
    for (int k = 0; k < CHANNELS; ++k) {
        const double now = (*forces_of(x, k))[lane], before = length > 0 ? contact->past_force[last][k][2][lane] : now;
        contact->past_force[at][k][0][lane] = before;
        contact->past_force[at][k][1][lane] = 0.5 * (before + now);
        contact->past_force[at][k][2][lane] = now;
    }
    contact->past_end[at][lane] = x->t[lane];
    contact->past_length[at][lane] = larger(length, 0);
    written(contact, lane, count + 1);
}

double recall(const struct Point *x, int channel, int lane, double t)
{
    return recall_in(x->past, x, channel, lane, t);
}

double recall_in(const struct Past *past, const struct Point *x, int channel, int lane, double t)
{
    const struct Contact *contact = past->contact;
    const struct Point *a = past->start, *m = past->middle, *b = past->end;
    const double now = (*forces_of(x, channel))[lane];
    const int64_t count = steps_kept(contact, lane), oldest = first_kept(contact, lane);
    if (t >= x->t[lane])
        return now;
    if (a && t >= a->t[lane]) {
        const double length = b->t[lane] - a->t[lane], share = length > 0 ? (t - a->t[lane]) / length : 1;
        return parabola(share, (*forces_of(a, channel))[lane], (*forces_of(m, channel))[lane],
                        (*forces_of(b, channel))[lane]);
    }
    if (count == 0)
        return a ? (*forces_of(a, channel))[lane] : now;
    const int64_t newest = (count - 1) % HISTORY;
    const double end = contact->past_end[newest][lane];
    if (t >= end) { /* a host's step that is not completed yet: straight on from the last one */
        const double last = contact->past_force[newest][channel][2][lane], span = x->t[lane] - end;
        return span > 0 ? last + (now - last) * (t - end) / span : last;
    }
    const int64_t at = first_later(contact->past_end, lane, oldest, count - 1, t, 1) % HISTORY;
    const double length = contact->past_length[at][lane],
                 share = length > 0 ? 1 - (contact->past_end[at][lane] - t) / length : 1;
    const lanes *u = contact->past_force[at][channel];
    return parabola(larger(share, 0), u[0][lane], u[1][lane], u[2][lane]);
}

/* Is what was at t still there? It is as long as nothing has been overwritten. */
int recall_reaches(const struct Contact *contact, int lane, double t)
{
    const int64_t oldest = first_kept(contact, lane), at = oldest % HISTORY;
    return oldest == 0 || t >= contact->past_end[at][lane] - contact->past_length[at][lane];
}

double recall_jump(const struct Contact *contact, int lane, const struct Point *start, double from, double to)
{
    const int64_t count = steps_kept(contact, lane);
    for (int64_t n = first_later(contact->past_end, lane, first_kept(contact, lane), count, from, 0);
         n < count && contact->past_end[n % HISTORY][lane] < to; ++n)
        for (int k = 0; k < CHANNELS; ++k) {
            const double before = contact->past_force[n % HISTORY][k][2][lane];
            const double after =
                n + 1 < count ? contact->past_force[(n + 1) % HISTORY][k][0][lane] : (*forces_of(start, k))[lane];
            if (fabs(after - before) > 1e-9 * (fabs(after) + fabs(before)))
                return contact->past_end[n % HISTORY][lane];
        }
    return INFINITY;
}

/* The tool cuts the surface down to its own height; where it is in the air the surface stays, one feed higher above the
 * tool that has meanwhile moved on. */
void leave_surface(struct Contact *contact, int lane, double turn, double feed, const struct Point *x)
{
    const int64_t count = whole_count(contact->surface_count[lane]);
    const double t = x->t[lane], tool = x->centre_y[lane] - x->raised[lane] + x->left[lane];
    if (count > 0 && t < contact->surface_time[(count - 1) % HISTORY][lane] + turn / 200)
        return;
    contact->surface_time[count % HISTORY][lane] = t;
    contact->surface_height[count % HISTORY][lane] = smaller(tool, x->left[lane] + feed);
    contact->surface_count[lane] = (double)(count + 1);
}

double surface_left(const struct Contact *contact, int lane, double t)
{
    const int64_t count = whole_count(contact->surface_count[lane]);
    const int64_t oldest = count > HISTORY ? count - HISTORY : 0; /* low: the first height that was left after t */
    const int64_t low = first_later(contact->surface_time, lane, oldest, count, t, 0);
    const int64_t before = (low + HISTORY - 1) % HISTORY;
    if (count == 0 || low == 0 || t < contact->surface_time[before][lane])
        return 0; /* the first turn meets the nominal surface */
    if (low == count)
        return contact->surface_height[before][lane];
    const double t_0 = contact->surface_time[before][lane], t_1 = contact->surface_time[low % HISTORY][lane];
    const double y_0 = contact->surface_height[before][lane], y_1 = contact->surface_height[low % HISTORY][lane];
    return y_0 + (y_1 - y_0) * (t - t_0) / (t_1 - t_0);
}
