/* Where does a step have to end because an event falls into it? At the change of sign of an indicator, searched for by its bracket. */
#include "root.h"
#include "stages.h"

#include <math.h>

void point_within(const struct Contact *contact, const struct Wiring *w, int forces, double s, double tau, const struct Point *start,
                  struct Point *x)
{
    struct Point middle;
    lanes from, h, difference;
    EACH_LANE {
        from[i] = s;
        h[i] = tau - s;
    }
    if (forces || w->feedback)
        try_step(contact, w, from, h, start, &middle, x, difference);
    else {
        EACH_LANE from[i] = tau;
        path_at(contact, w, from, x);
    }
}

/* Indicator k at tau, reached from s by a step on the held sides. */
static double indicator_at(const struct Contact *contact, const struct Wiring *w, int k, int lane, double s, double tau,
                           const struct Point *start)
{
    struct Point x;
    lanes now[INDICATORS];
    point_within(contact, w, k == AT_LAW, s, tau, start, &x);
    indicators(w, &x, now);
    return now[k][lane];
}

/* The first tau in (low, high] at which indicator k is on the other side, to a thousandth of the tolerance. */
static double locate(const struct Contact *contact, const struct Wiring *w, int k, int i, double s, double low, double high,
                     double at_low, double at_high, const struct Point *start)
{
    const double side = contact->sign[k][i];
    const double close = 1e-3 * w->p[RELATIVE_TOLERANCE][i] * (high - s) + 4.4e-16 * high; /* the last: rounding of tau */
    struct Bracket b = bracket(low, high, side * at_low, side * at_high);
    while (b.count < 100 && b.high - b.low > close) {
        const double tau = bracket_next(&b, close);
        bracket_update(&b, tau, side * indicator_at(contact, w, k, i, s, tau, start));
    }
    return b.high;
}

/* The sides of some events that are watched wherever a point is, and of those that are not where the slip is solved for. */
static inline int path_event(const struct Contact *contact, int i, const struct Point *middle, const struct Point *end)
{
    const double contact_side = contact->sign[AT_CONTACT][i], surface_side = contact->sign[AT_SURFACE][i];
    return (contact_side * middle->contact[i] < 0) | (contact_side * end->contact[i] < 0) |
           (surface_side * middle->surface[i] < 0) | (surface_side * end->surface[i] < 0);
}

static inline int slip_event(const struct Contact *contact, int i, const struct Point *middle, const struct Point *end)
{
    const double slip_side = contact->sign[AT_SLIP][i], law_side = contact->sign[AT_LAW][i];
    return (slip_side * middle->v[i] < 0) | (slip_side * end->v[i] < 0) | (law_side * middle->law[i] < 0) | (law_side * end->law[i] < 0);
}

int sees_event(const struct Contact *contact, const struct Wiring *w, int i, const struct Point *middle, const struct Point *end)
{
    return path_event(contact, i, middle, end) || (!w->current_angle && slip_event(contact, i, middle, end));
}

int any_event(const struct Contact *contact, const struct Wiring *w, const struct Point *start, const struct Point *middle,
              const struct Point *end)
{
    int any = 0;
    EACH_LANE any |= path_event(contact, i, middle, end);
    if (!w->held)
        EACH_LANE any |= (contact->sign[AT_CONTACT][i] < 0) & !((start->contact[i] > 0) & (middle->contact[i] > 0));
    if (!w->current_angle)
        EACH_LANE any |= slip_event(contact, i, middle, end);
    return any;
}

int cut_at_event(const struct Contact *contact, const struct Wiring *w, int i, int known, double s, double *h,
                        const struct Point *start, const struct Point *middle, const struct Point *end)
{
    lanes at_start[INDICATORS], at_middle[INDICATORS], at_end[INDICATORS];
    int first = NO_EVENT;
    double step = *h;
    indicators(w, middle, at_middle);
    indicators(w, end, at_end);
    indicators(w, start, at_start);
    for (int k = 0; k < INDICATORS; ++k) {
        const double side = contact->sign[k][i], half = 0.5 * *h;
        double at;
        if (k == known || !watched(contact, k, i))
            continue;
        if (side * at_middle[k][i] < 0) {
            if (side * at_start[k][i] < 0)
                return JUMP;
            at = locate(contact, w, k, i, s, s, s + half, at_start[k][i], at_middle[k][i], start) - s;
        } else if (side * at_end[k][i] < 0)
            at = locate(contact, w, k, i, s, s + half, s + *h, at_middle[k][i], at_end[k][i], start) - s;
        else
            continue;
        if (first == NO_EVENT || at < step) {
            first = k;
            step = at;
        }
    }
    *h = step;
    return first;
}

int cut_at_touch(const struct Contact *contact, const struct Wiring *w, int i, double s, double *h, const struct Point *start,
                        const struct Point *middle, const struct Point *end)
{
    double tau[2], indicator[2];
    if (!(*h > 0) || !touches_within(contact, w, i, s, *h, start, middle, end, tau, indicator))
        return NO_EVENT;
    *h = locate(contact, w, AT_CONTACT, i, s, tau[0], tau[1], indicator[0], indicator[1], start) - s;
    return AT_CONTACT;
}
