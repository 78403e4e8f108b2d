/* Where does a step have to end because an event falls into it? At the change of sign of an indicator, searched for by
 * its bracket. */
#include "root.h"
#include "../stages.h"

#include <math.h>

void point_within(const struct Contact *contact, const struct Configuration *w, int forces, const lanes s,
                  const lanes tau, const struct Point *start, struct Point *x)
{
    if (forces || w->feedback) {
        struct Point middle;
        lanes h, difference;
        EACH_LANE
            h[i] = tau[i] - s[i];
        try_step(contact, w, s, h, start, NULL, &middle, x, difference);
    } else
        path_at(contact, w, tau, x);
}

/* Where an event is sought, by lanes: between low and high, where the indicator has these values; not in lanes that are
 * not open. */
struct Search {
    lanes low, high, at_low, at_high;
    int open[LANES];
    int blind[LANES]; /* whether the low end is past it by roundings: infinity where nothing else is before it */
};

/* In each lane the first tau in (low, high] at which indicator k is on the other side, to a thousandth of the
 * tolerance, and one just before it; a step on the held sides leads there from s. All lanes take their steps at once.
 */
static void locate(const struct Contact *contact, const struct Configuration *w, int k, const lanes s,
                   const struct Search *search, const struct Point *start, lanes before, lanes crossing)
{
    struct Bracket b[LANES];
    lanes tau, close, now[INDICATORS];
    int open = 0;
    for (int i = 0; i < LANES; ++i) {
        const double side = contact->sign[k][i], high = search->high[i];
        /* the last: rounding of tau */
        close[i] = event_width(w, i, high - s[i], w->p[VAR_TIME][i] + high) + 4.4e-16 * high;
        b[i] = bracket(search->low[i], high, side * search->at_low[i], side * search->at_high[i]);
        tau[i] = search->open[i] ? high : s[i];
        open |= search->open[i] && b[i].high - b[i].low > close[i];
    }
    while (open) {
        struct Point x;
        for (int i = 0; i < LANES; ++i)
            if (search->open[i] && b[i].count < 100 && b[i].high - b[i].low > close[i])
                tau[i] = bracket_next(&b[i], close[i]);
        point_within(contact, w, k == AT_LAW, s, tau, start, &x);
        indicators(w, &x, now);
        open = 0;
        for (int i = 0; i < LANES; ++i) {
            if (!search->open[i] || b[i].count >= 100 || !(b[i].high - b[i].low > close[i]))
                continue;
            bracket_update(&b[i], tau[i], contact->sign[k][i] * now[k][i]);
            open |= b[i].count < 100 && b[i].high - b[i].low > close[i];
        }
    }
    for (int i = 0; i < LANES; ++i) {
        before[i] = b[i].low;
        crossing[i] = search->blind[i] && !(b[i].low > search->low[i]) ? INFINITY : b[i].high;
    }
}

/* The sides of the events of the path, and of those that are not where the slip is solved for: of all but the contact
 * itself only in contact, see watched(). */
static inline int path_event(const struct Contact *contact, int i, const struct Point *middle, const struct Point *end)
{
    const double contact_side = contact->sign[AT_CONTACT][i], surface_side = contact->sign[AT_SURFACE][i];
    return (contact_side * middle->contact[i] < 0) | (contact_side * end->contact[i] < 0) |
           ((contact_side > 0) & ((surface_side * middle->surface[i] < 0) | (surface_side * end->surface[i] < 0)));
}

static inline int slip_event(const struct Contact *contact, int i, const struct Point *middle, const struct Point *end)
{
    const double slip_side = contact->sign[AT_SLIP][i], law_side = contact->sign[AT_LAW][i];
    return (contact->sign[AT_CONTACT][i] > 0) & ((slip_side * middle->v[i] < 0) | (slip_side * end->v[i] < 0) |
                                                 (law_side * middle->law[i] < 0) | (law_side * end->law[i] < 0));
}

int shows_slip_event(const struct Contact *contact, const struct Configuration *w, int i, const struct Point *early,
                     const struct Point *late)
{
    return !w->current_angle && slip_event(contact, i, early, late);
}

/* Where in a step an indicator that starts, is and ends on its side comes nearest to 0, as the parabola says, if that
 * is near: as a share of the step; 0: nowhere. */
#define NEAR_SHARE 0.5 /* of the least that the three points show */

static double dip(double u_0, double u_m, double u_1)
{
    const double slope = 4 * u_m - 3 * u_0 - u_1, bend = 2 * (u_0 - 2 * u_m + u_1);
    if (!(bend > 0 && slope < 0 && slope + 2 * bend > 0))
        return 0;
    const double share = -slope / (2 * bend), least = smaller(smaller(u_0, u_m), u_1);
    return u_0 + 0.5 * slope * share < NEAR_SHARE * least ? share : 0;
}

static double field_dip(double side, const lanes a, const lanes m, const lanes b, int i)
{
    return dip(side * a[i], side * m[i], side * b[i]);
}

/* The same of the contact, which ends by the thickness or by the motion into the material: the lesser of both has kinks
 * where a parabola through three points shows nothing. */
static double contact_dip(const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const double by_thickness = field_dip(1, a->h, m->h, b->h, i);
    return by_thickness > 0 ? by_thickness : field_dip(1, a->approach, m->approach, b->approach, i);
}

/* May the tool leave the work and be back within the step? Where its forces move it step doubling tells. */
static int may_leave(const struct Contact *contact, const struct Configuration *w, int i, const struct Point *a,
                     const struct Point *m, const struct Point *b)
{
    return contact->sign[AT_CONTACT][i] > 0 && !w->held && !w->feedback && contact_dip(a, m, b, i) > 0;
}

/* May the slip turn twice, or a law that knows no more than the slip change its side twice, within the step? Of laws
 * with bristles step doubling tells. */
static int may_turn(const struct Contact *contact, const struct Configuration *w, int i, const struct Point *a,
                    const struct Point *m, const struct Point *b)
{
    return contact->sign[AT_CONTACT][i] > 0 && !w->current_angle && !w->law->relaxes && !w->held &&
           (field_dip(contact->sign[AT_SLIP][i], a->v, m->v, b->v, i) > 0 ||
            field_dip(contact->sign[AT_LAW][i], a->law, m->law, b->law, i) > 0);
}

int sees_event(const struct Contact *contact, const struct Configuration *w, int i, const struct Point *start,
               const struct Point *middle, const struct Point *end)
{
    return path_event(contact, i, middle, end) || (!w->current_angle && slip_event(contact, i, middle, end)) ||
           may_leave(contact, w, i, start, middle, end) || may_turn(contact, w, i, start, middle, end);
}

int any_event(const struct Contact *contact, const struct Configuration *w, const struct Point *start,
              const struct Point *middle, const struct Point *end)
{
    int any = 0;
    EACH_LANE
        any |= path_event(contact, i, middle, end);
    if (!w->held)
        EACH_LANE
            any |= (contact->sign[AT_CONTACT][i] < 0) & !((start->contact[i] > 0) & (middle->contact[i] > 0));
    if (!w->current_angle)
        EACH_LANE
            any |= slip_event(contact, i, middle, end);
    for (int i = 0; i < LANES; ++i)
        any |= may_leave(contact, w, i, start, middle, end);
    for (int i = 0; !w->law->relaxes && i < LANES; ++i)
        any |= may_turn(contact, w, i, start, middle, end);
    return any;
}

/* In the lanes in which indicator k comes near to 0 and is not past it at middle or end: is it there? */
static int look_into_dips(const struct Contact *contact, const struct Configuration *w, int k, const lanes s,
                          const lanes h, const struct Point *const points[3], const lanes *const at[3],
                          const int asked[LANES], const int known[LANES], const int cut[LANES], struct Search *search)
{
    lanes tau, share, now[INDICATORS];
    int any = 0;
    for (int i = 0; i < LANES; ++i) {
        const int in_contact = contact->sign[AT_CONTACT][i] > 0; /* out of it touches_within() looks */
        const int sought = asked[i] && cut[i] != JUMP && k != known[i] && in_contact && !search->open[i] && h[i] > 0;
        share[i] = !sought           ? 0
                   : k == AT_CONTACT ? contact_dip(points[0], points[1], points[2], i)
                                     : field_dip(contact->sign[k][i], *at[0], *at[1], *at[2], i);
        tau[i] = s[i] + share[i] * h[i];
        any |= share[i] > 0;
    }
    if (!any)
        return 0;
    struct Point x;
    any = 0;
    point_within(contact, w, k == AT_LAW, s, tau, points[0], &x);
    indicators(w, &x, now);
    for (int i = 0; i < LANES; ++i) {
        if (!(share[i] > 0) || !(contact->sign[k][i] * now[k][i] < 0))
            continue;
        const int late = share[i] > 0.5;
        any = search->open[i] = 1;
        search->low[i] = late ? s[i] + 0.5 * h[i] : s[i];
        search->at_low[i] = (*at[late])[i];
        search->high[i] = tau[i];
        search->at_high[i] = now[k][i];
    }
    return any;
}

/* Where contact ends because the tool turns, no earlier surface counts from there on, and its indicator says nothing of
 * one that has ended just before. In the lanes that are cut there: has it? `before`: a time before the turn. */
static int look_before_turn(const struct Contact *contact, const struct Configuration *w, const lanes s, const lanes h,
                            const struct Point *start, const lanes at_start, const lanes at_middle, const lanes before,
                            const int asked[LANES], const int known[LANES], const int cut[LANES], struct Search *search)
{
    lanes tau, now[INDICATORS];
    int any = 0, sought[LANES];
    for (int i = 0; i < LANES; ++i) {
        sought[i] = asked[i] && cut[i] == AT_CONTACT && known[i] != AT_SURFACE && watched(contact, AT_SURFACE, i) &&
                    !search->open[i];
        tau[i] = sought[i] ? before[i] : s[i];
        any |= sought[i];
    }
    if (!any || w->kinematics == KINEMATICS_EXTERNAL)
        return 0;
    struct Point x;
    any = 0;
    point_within(contact, w, 0, s, tau, start, &x);
    indicators(w, &x, now);
    for (int i = 0; i < LANES; ++i) {
        const double half = s[i] + 0.5 * h[i];
        if (!sought[i] || !(contact->sign[AT_SURFACE][i] * now[AT_SURFACE][i] < 0))
            continue;
        any = search->open[i] = 1;
        search->low[i] = tau[i] > half ? half : s[i];
        search->at_low[i] = (tau[i] > half ? at_middle : at_start)[i];
        search->high[i] = tau[i];
        search->at_high[i] = now[AT_SURFACE][i];
    }
    return any;
}

void cut_at_events(const struct Contact *contact, const struct Configuration *w, const int asked[LANES],
                   const int known[LANES], const int acted[LANES], const lanes wait, const lanes s, lanes h,
                   const struct Point *start, const struct Point *middle, const struct Point *end, int cut[LANES])
{
    lanes at_start[INDICATORS], at_middle[INDICATORS], at_end[INDICATORS], step, before, crossing;
    indicators(w, middle, at_middle);
    indicators(w, end, at_end);
    indicators(w, start, at_start);
    EACH_LANE {
        step[i] = h[i];
        before[i] = s[i];
    }
    for (int k = 0; k < INDICATORS; ++k) {
        struct Search search = {{0}, {0}, {0}, {0}, {0}, {0}};
        int any = 0;
        for (int i = 0; i < LANES; ++i) {
            const double side = contact->sign[k][i], half = s[i] + 0.5 * h[i];
            const int early = side * at_middle[k][i] < 0, late = side * at_end[k][i] < 0;
            if (!asked[i] || cut[i] == JUMP || k == known[i] || !watched(contact, k, i) || !(early || late))
                continue;
            search.blind[i] = early && side * at_start[k][i] < 0;
            if (search.blind[i] && !acted[i]) {
                cut[i] = JUMP;
                continue;
            }
            any = search.open[i] = 1;
            search.low[i] = early ? s[i] : half;
            search.high[i] = early ? half : s[i] + h[i];
            search.at_low[i] = search.blind[i] ? 0 : early ? at_start[k][i] : at_middle[k][i];
            search.at_high[i] = early ? at_middle[k][i] : at_end[k][i];
        }
        if (!w->held && ((k == AT_CONTACT && !w->feedback) || (!w->law->relaxes && (k == AT_SLIP || k == AT_LAW)))) {
            const struct Point *const points[3] = {start, middle, end};
            const lanes *const at[3] = {&at_start[k], &at_middle[k], &at_end[k]};
            any |= look_into_dips(contact, w, k, s, h, points, at, asked, known, cut, &search);
        }
        if (k == AT_SURFACE)
            any |= look_before_turn(contact, w, s, h, start, at_start[k], at_middle[k], before, asked, known, cut,
                                    &search);
        if (any)
            locate(contact, w, k, s, &search, start, before, crossing);
        for (int i = 0; any && i < LANES; ++i) {
            const int passed_over = search.open[i] && k == AT_CONTACT && w->feedback && contact->sign[k][i] < 0 &&
                                    !(crossing[i] < INFINITY) && wait[i] < search.high[i] - s[i];
            const double at = passed_over ? wait[i] : crossing[i] == s[i] + step[i] ? step[i] : crossing[i] - s[i];
            if (!search.open[i] || !(at < INFINITY) || !(cut[i] == NO_EVENT || at < step[i]))
                continue;
            cut[i] = k;
            step[i] = at;
        }
    }
    for (int i = 0; i < LANES; ++i)
        h[i] = asked[i] && cut[i] >= 0 ? step[i] : h[i];
}

void cut_at_touch(const struct Contact *contact, const struct Configuration *w, int i, const lanes s, lanes h,
                  const struct Point *start, const struct Point *middle, const struct Point *end, int cut[LANES])
{
    double tau[2], indicator[2];
    if (!(h[i] > 0) || !touches_within(contact, w, i, s[i], h[i], start, middle, end, tau, indicator))
        return;
    struct Search search = {{0}, {0}, {0}, {0}, {0}, {0}};
    lanes before, crossing;
    search.open[i] = 1;
    search.low[i] = tau[0];
    search.high[i] = tau[1];
    search.at_low[i] = indicator[0];
    search.at_high[i] = indicator[1];
    locate(contact, w, AT_CONTACT, s, &search, start, before, crossing);
    h[i] = crossing[i] - s[i];
    cut[i] = AT_CONTACT;
}
