/* Which slip does the contact feel whose input comes late or early? A ring of the corners of slip_velocity, straight in
 * between, and in each lane the straight part that holds now.
 *
 * Where such a part ends the lane's internal step ends, too, and the next one begins as after an event: what jumps
 * there is felt as a jump.
 */
#include "../stages.h"

#include <math.h>

static double delay_of(const struct Configuration *w, int lane)
{
    double late = 0;
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->delays)
            late += w->on[n]->delays(w->on_p[n], lane);
    return late;
}

static int64_t oldest_of(int64_t count) { return count > HISTORY ? count - HISTORY : 0; }

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

void note_slip(struct Contact *contact, int lane, double t, double v)
{
    int64_t count = whole_count(contact->slip_count[lane]);
    if (count > 0) {
        const int64_t last = (count - 1) % HISTORY;
        const double t_last = contact->slip_time[last][lane];
        if (t < t_last || (t == t_last && v == contact->slip_given[last][lane]))
            return; /* known already */
        if ((t == t_last && count == 1) || straight_on(contact, lane, count, t, v))
            --count;
    }
    contact->slip_time[count % HISTORY][lane] = t;
    contact->slip_given[count % HISTORY][lane] = v;
    contact->slip_count[lane] = (double)(count + 1);
}

void note_slip_now(struct Contact *contact)
{
    for (int i = 0; i < LANES; ++i)
        note_slip(contact, i, contact->value[VAR_TIME][i], contact->value[VAR_SLIP_VELOCITY][i]);
}

/* The straight part in which slip_velocity is at t, which lies at or after the last corner: towards what it is now;
 * past what is known of the future it stays. */
static void part_after(const struct Contact *contact, int lane, double late, double *t_0, double *v_0, double *slope)
{
    const int64_t count = whole_count(contact->slip_count[lane]), last = (count + HISTORY - 1) % HISTORY;
    const double now = contact->value[VAR_TIME][lane], v = contact->value[VAR_SLIP_VELOCITY][lane];
    *t_0 = count > 0 ? contact->slip_time[last][lane] : now;
    *v_0 = count > 0 ? contact->slip_given[last][lane] : v;
    if (now > *t_0)
        *slope = (v - *v_0) / (now - *t_0);
    else
        *slope = late > 0 ? contact->slope[(int)VAR_SLIP_VELOCITY - (int)INPUT_FIRST][lane] : 0;
}

enum Status feel_slip(struct Contact *contact, const struct Configuration *w, int lane, double s)
{
    const double late = delay_of(w, lane), now = contact->value[VAR_TIME][lane];
    const double t = now + s - late, inside = t + 1e-13 * (fabs(now) + fabs(s) + fabs(late));
    const int64_t count = whole_count(contact->slip_count[lane]), oldest = oldest_of(count);
    const int64_t next = first_later(contact->slip_time, lane, oldest, count, inside, 0);
    double t_0, v_0, slope, end = INFINITY;
    if (late == 0) {
        t_0 = now;
        v_0 = contact->value[VAR_SLIP_VELOCITY][lane];
        slope = contact->slope[(int)VAR_SLIP_VELOCITY - (int)INPUT_FIRST][lane];
    } else if (next == count)
        part_after(contact, lane, late, &t_0, &v_0, &slope);
    else {
        const int64_t b = next % HISTORY, a = (next + HISTORY - 1) % HISTORY;
        end = contact->slip_time[b][lane] - t; /* from s on */
        t_0 = contact->slip_time[next > oldest ? a : b][lane];
        v_0 = contact->slip_given[next > oldest ? a : b][lane];
        slope = next > oldest ? (contact->slip_given[b][lane] - v_0) / (contact->slip_time[b][lane] - t_0) : 0;
        if (next == oldest && oldest > 0)
            return KERNEL_HISTORY_SHORT;
    }
    contact->late_slip[lane] = v_0 + slope * (now - late - t_0); /* at value[VAR_TIME] */
    contact->late_slope[lane] = slope;
    contact->late_until[lane] = s + end;
    return KERNEL_OK;
}

enum Status feel_slip_now(struct Contact *contact, const struct Configuration *w)
{
    enum Status status = KERNEL_OK;
    for (int i = 0; i < LANES && status == KERNEL_OK; ++i)
        status = feel_slip(contact, w, i, 0);
    return status;
}

double slip_lead(const struct Configuration *w, int lane) { return larger(-delay_of(w, lane), 0); }
