/* Which slip does the contact feel whose input comes late or early? The record that is followed says it, or a ring of
 * the corners of slip_velocity, straight in between; each lane keeps the straight part that holds now.
 *
 * Where such a part ends the lane's internal step ends, too, and the next one begins as after an event: what jumps
 * there is felt as a jump.
 */
#include "../stages.h"

#include <math.h>

#define KEPT 0.4 /* how far the slip may be from what was given, in tolerances of the largest that is kept */

static double delay_of(const struct Configuration *w, int lane)
{
    double late = 0;
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->delays)
            late += w->on[n]->delays(w->on_p[n], lane);
    return late;
}

/* The first corner that is still there. */
static int64_t oldest_of(const struct Contact *contact, int lane)
{
    const int64_t count = whole_count(contact->slip_count[lane]), first = whole_count(contact->slip_first[lane]);
    return first < count && count - first <= HISTORY ? first : count > HISTORY ? count - HISTORY : 0;
}

/* Does the last corner but one lead straight through the last to this one? */
static int straight_on(const struct Contact *contact, int lane, int64_t count, double t, double v)
{
    if (count < 2)
        return 0;
    const int64_t a = (count - 2) % HISTORY, b = (count - 1) % HISTORY;
    const double t_a = contact->slip_time[a][lane], t_b = contact->slip_time[b][lane];
    const double v_a = contact->slip_given[a][lane], v_b = contact->slip_given[b][lane];
    if (!(t_b > t_a && t > t_b))
        return 0;
    return fabs(v_a + (v - v_a) * (t_b - t_a) / (t - t_a) - v_b) <= 1e-14 * (fabs(v_a) + fabs(v_b) + fabs(v));
}

/* Does a straight line from corner a to corner b serve for those in between, small jumps among them, to this
 * difference?
 */
static int straight_serves(const struct Contact *contact, int lane, int64_t a, int64_t b, double allowed)
{
    const double t_a = contact->slip_time[a % HISTORY][lane], t_b = contact->slip_time[b % HISTORY][lane];
    const double v_a = contact->slip_given[a % HISTORY][lane], v_b = contact->slip_given[b % HISTORY][lane];
    int serves = t_b > t_a;
    for (int64_t n = a; n < b && serves; ++n) {
        const double t = contact->slip_time[n % HISTORY][lane], v = contact->slip_given[n % HISTORY][lane];
        serves = fabs(v_a + (v_b - v_a) * (t - t_a) / (t_b - t_a) - v) <= allowed;
    }
    return serves;
}

/* One straight line for as many corners as it serves, each taken once; the last two stay, from which the next goes on.
 */
static void thin_corners(struct Contact *contact, int lane)
{
    const int64_t count = whole_count(contact->slip_count[lane]), oldest = oldest_of(contact, lane),
                  settled = whole_count(contact->slip_settled[lane]);
    double largest = 0;
    for (int64_t n = oldest; n < count; ++n)
        largest = larger(largest, fabs(contact->slip_given[n % HISTORY][lane]));
    const double allowed = KEPT * contact->value[VAR_RELATIVE_TOLERANCE][lane] * largest;
    int64_t at = settled > oldest && settled < count ? settled : oldest;
    for (int64_t n = at; n < count; ++at) {
        contact->slip_time[at % HISTORY][lane] = contact->slip_time[n % HISTORY][lane];
        contact->slip_given[at % HISTORY][lane] = contact->slip_given[n % HISTORY][lane];
        int64_t next = n + 1;
        while (next + 1 < count - 1 && straight_serves(contact, lane, n, next + 1, allowed))
            ++next;
        n = next;
    }
    contact->slip_count[lane] = (double)at;
    contact->slip_settled[lane] = larger((double)(at - 2), 0);
}

/* Corners that nobody looks back to go first. */
static void make_room_for_corner(struct Contact *contact, const struct Configuration *w, int lane)
{
    const int64_t count = whole_count(contact->slip_count[lane]);
    const double keep_from = contact->value[VAR_TIME][lane] - larger(delay_of(w, lane), 0);
    int64_t first = oldest_of(contact, lane);
    if (count - first < HISTORY)
        return;
    while (first < count - 2 && contact->slip_time[(first + 1) % HISTORY][lane] < keep_from)
        ++first;
    contact->slip_first[lane] = (double)first;
    contact->slip_settled[lane] = larger(contact->slip_settled[lane], (double)first);
    if (count - first > HISTORY - HISTORY / 8)
        thin_corners(contact, lane);
    if (whole_count(contact->slip_count[lane]) - first >= HISTORY) /* whoever looks back as far finds it gone */
        contact->slip_first[lane] = (double)(first + 1);
}

void note_slip(struct Contact *contact, const struct Configuration *w, int lane, double t, double v)
{
    int64_t count = whole_count(contact->slip_count[lane]);
    if (count > 0) {
        const int64_t last = (count - 1) % HISTORY;
        const double t_last = contact->slip_time[last][lane];
        if (t < t_last || (t == t_last && v == contact->slip_given[last][lane]))
            return; /* known already */
        if ((t == t_last && count == 1) || straight_on(contact, lane, count, t, v))
            contact->slip_count[lane] = (double)(count - 1);
    }
    make_room_for_corner(contact, w, lane);
    count = whole_count(contact->slip_count[lane]);
    contact->slip_time[count % HISTORY][lane] = t;
    contact->slip_given[count % HISTORY][lane] = v;
    contact->slip_count[lane] = (double)(count + 1);
}

void note_slip_now(struct Contact *contact, const struct Configuration *w)
{
    for (int i = 0; i < LANES; ++i)
        note_slip(contact, w, i, contact->value[VAR_TIME][i], contact->value[VAR_SLIP_VELOCITY][i]);
}

/* A straight part of slip_velocity: v at t_0, with this slope, up to t_1. */
struct Part {
    double t_0, v_0, slope, t_1;
};

static struct Part between(double t_a, double v_a, double t_b, double v_b)
{
    const struct Part part = {t_a, v_a, (v_b - v_a) / (t_b - t_a), t_b};
    return part;
}

static struct Part held(double v, double until)
{
    const struct Part part = {0, v, 0, until};
    return part;
}

/* In a record, which knows what comes; past its end the slip stays. */
static struct Part part_in_record(const struct Configuration *w, int lane, int64_t next)
{
    const struct Record *const r = w->record;
    const int64_t width = r->per_lane ? LANES : 1;
    const double *const slip = r->inputs + w->slip_column * width + (r->per_lane ? lane : 0);
    const int64_t row = r->input_count * width;
    if (next == r->count)
        return held(slip[(next - 1) * row], INFINITY);
    return between(r->times[next - 1], slip[(next - 1) * row], r->times[next], slip[next * row]);
}

/* After the last corner that is known: as it goes on in this step, or of a host's step that is not completed towards
 * what it is now. */
static struct Part last_part(const struct Contact *contact, int lane)
{
    const int64_t count = whole_count(contact->slip_count[lane]), last = (count + HISTORY - 1) % HISTORY;
    const double now = contact->value[VAR_TIME][lane], v = contact->value[VAR_SLIP_VELOCITY][lane];
    struct Part part = {now, v, contact->slope[(int)VAR_SLIP_VELOCITY - (int)INPUT_FIRST][lane], INFINITY};
    if (count > 0 && now > contact->slip_time[last][lane]) {
        part = between(contact->slip_time[last][lane], contact->slip_given[last][lane], now, v);
        part.t_1 = INFINITY;
    }
    return part;
}

static struct Part part_in_ring(const struct Contact *contact, int lane, int64_t oldest, int64_t next)
{
    const int64_t b = next % HISTORY, a = (next + HISTORY - 1) % HISTORY;
    return next == oldest ? held(contact->slip_given[b][lane], contact->slip_time[b][lane])
                          : between(contact->slip_time[a][lane], contact->slip_given[a][lane],
                                    contact->slip_time[b][lane], contact->slip_given[b][lane]);
}

static int64_t later_in_record(const struct Record *r, double t)
{
    int64_t low = 0, high = r->count;
    while (low < high) {
        const int64_t half = (low + high) / 2;
        if (r->times[half] <= t)
            low = half + 1;
        else
            high = half;
    }
    return low;
}

enum Status feel_slip(struct Contact *contact, const struct Configuration *w, int lane, double s)
{
    const double late = delay_of(w, lane), now = contact->value[VAR_TIME][lane];
    const double t = now + s - late, inside = t + 1e-13 * (fabs(now) + fabs(s) + fabs(late));
    const int64_t sample = w->record ? later_in_record(w->record, inside) : 0;
    struct Part part = {now, contact->value[VAR_SLIP_VELOCITY][lane],
                        contact->slope[(int)VAR_SLIP_VELOCITY - (int)INPUT_FIRST][lane], INFINITY};
    if (late != 0 && sample > 0)
        part = part_in_record(w, lane, sample);
    else if (late != 0) {
        const int64_t count = whole_count(contact->slip_count[lane]), oldest = oldest_of(contact, lane);
        const int64_t next = first_later(contact->slip_time, lane, oldest, count, inside, 0);
        if (next < count && next == oldest && oldest > 0)
            return STATUS_HISTORY_SHORT;
        part = next == count ? last_part(contact, lane) : part_in_ring(contact, lane, oldest, next);
    }
    contact->late_slip[lane] = part.v_0 + part.slope * (now - late - part.t_0); /* at value[VAR_TIME] */
    contact->late_slope[lane] = part.slope;
    contact->late_until[lane] = s + (part.t_1 - t);
    return STATUS_OK;
}

enum Status feel_slip_now(struct Contact *contact, const struct Configuration *w)
{
    enum Status status = STATUS_OK;
    for (int i = 0; i < LANES && status == STATUS_OK; ++i)
        status = feel_slip(contact, w, i, 0);
    return status;
}

double slip_lead(const struct Configuration *w, int lane) { return larger(-delay_of(w, lane), 0); }
