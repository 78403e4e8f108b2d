/* Does the tool touch the work between the moments at which a step looks, and leave it again?
 *
 * Out of contact a step is up to a twentieth of a cycle, and sees its start, middle and end. Contacts that lie between
 * them lie beside the moment at which the tool turns, beside the end of the surface that the previous cycle left, or on
 * a hump of the thickness.
 */
#include "root.h"
#include "../stages.h"

#include <math.h>

/* What a moment shows of the contact: its indicators, how fast the tool moves, and its amplitude. */
struct Look {
    double tau, contact, approach, surface, u_x, u_y, a;
};

/* One lane's step from s, in which contacts of length `fine` are sought. */
struct Search {
    const struct Contact *contact;
    const struct Configuration *w;
    const struct Point *start;
    double s, fine;
    int lane;
};

static struct Look seen(const struct Point *x, int i, double tau)
{
    return (struct Look){tau, x->contact[i], x->approach[i], x->surface[i], x->u_x[i], x->u_y[i], x->a[i]};
}

static struct Look look(const struct Search *search, double tau)
{
    struct Point x;
    lanes from, to;
    EACH_LANE {
        from[i] = search->s;
        to[i] = tau;
    }
    point_within(search->contact, search->w, 0, from, to, search->start, &x);
    return seen(&x, search->lane, tau);
}

static double slope(const struct Search *search, const struct Look *at, double ahead)
{
    return (look(search, at->tau + ahead).contact - at->contact) / ahead;
}

/* Does the indicator stay below its tangents at a and b up to where they meet, as far as one look on each shows? Not
 * where one surface rises ever steeper up to a kink, from which another takes over. */
static int below_tangents(const struct Search *search, const struct Look *a, const struct Look *b, double up,
                          double down, double meet)
{
    const double early = 0.5 * meet, late = 0.5 * (b->tau - a->tau - meet);
    return look(search, a->tau + early).contact <= a->contact + up * early &&
           look(search, b->tau - late).contact <= b->contact - down * late;
}

/* Does the indicator, negative at a and b and without a jump between, rise above 0 between? Not where it falls away
 * from its higher end, nor where it stays below tangents that meet below 0. Leaves a before the touch. */
static int rises_between(const struct Search *search, struct Look *a, struct Look b, struct Look *touch)
{
    const double nearby = 0.1 * search->fine;
    const int falling = a->contact > b.contact;
    double up = 1, down = -1;
    if (falling)
        up = slope(search, a, nearby);
    else
        down = slope(search, &b, -nearby);
    if (!(up > 0 && down < 0))
        return 0;
    if (falling)
        down = slope(search, &b, -nearby);
    else
        up = slope(search, a, nearby);
    for (int n = 0; n < 20 && up > 0 && down < 0 && b.tau - a->tau > search->fine; ++n) {
        const double span = b.tau - a->tau, meet = (b.contact - a->contact - down * span) / (up - down);
        const int arched = meet > 0 && meet < span;
        if (arched && a->contact + up * meet <= 0 && below_tangents(search, a, &b, up, down, meet))
            return 0;
        *touch = look(
            search, a->tau + (arched && n % 2 ? meet : span * up / (up - down))); /* a kink, or the top of a parabola */
        if (touch->contact > 0)
            return 1;
        const double there = slope(search, touch, nearby);
        if (there > 0) {
            *a = *touch;
            up = there;
        } else {
            b = *touch;
            down = there;
        }
    }
    return 0;
}

enum Edge { TURN, SURFACE_END };

static double beyond(const struct Look *x, enum Edge edge) { return edge == TURN ? x->approach : x->surface; }

static int apart(const struct Look *a, const struct Look *b, enum Edge edge)
{
    return (beyond(a, edge) > 0) != (beyond(b, edge) > 0);
}

/* Close a and b in on the edge between them. */
static void close_in(const struct Search *search, enum Edge edge, struct Look *a, struct Look *b)
{
    const double side = beyond(a, edge) > 0 ? 1 : -1, close = 0.5 * search->fine;
    struct Bracket k = bracket(a->tau, b->tau, side * beyond(a, edge), side * beyond(b, edge));
    while (k.count < 60 && k.high - k.low > close) {
        const struct Look x = look(search, bracket_next(&k, close));
        bracket_update(&k, x.tau, side * beyond(&x, edge));
        *(side * beyond(&x, edge) < 0 ? b : a) = x;
    }
}

/* Is the tool at x so high above its surface that it does not get there within `span`? The indicator is in um. */
static int high_above(const struct Look *x, double span)
{
    return x->contact < -2e6 * (fabs(x->u_x) + fabs(x->u_y)) * span;
}

/* May another surface count between a and b than at x, one of them, or drop there? The earlier surface is steep where
 * it ends, and the next cycle begins where the tool is fastest backward. */
static int resurfaces(const struct Search *search, const struct Look *a, const struct Look *b, const struct Look *x)
{
    const int i = search->lane;
    const double f = search->w->p[VAR_VIBRATION_FREQUENCY][i],
                 begun = search->w->cycle[i] + search->w->p[VAR_PHASE_X][i] / 6.283185307179586 + 0.75;
    const int near_end = x->surface > 0 && x->surface * x->a < 2 * fabs(x->u_x) * (b->tau - a->tau);
    return near_end || floor(begun + f * a->tau) < floor(begun + f * b->tau);
}

/* Does the tool touch the work between a, out of contact, and b? Leaves a before the touch. */
static int touches_between(const struct Search *search, struct Look *a, struct Look b, struct Look *touch)
{
    const double span = b.tau - a->tau;
    if (apart(a, &b, TURN)) {
        const int enters = b.approach > 0;
        const struct Look *const in = enters ? &b : a;
        struct Look low = *a, high = b;
        if (high_above(in, span) && !resurfaces(search, a, &b, in))
            return 0;
        close_in(search, TURN, &low, &high);
        *touch = enters ? high : low;
        if (touch->contact > 0) {
            *a = enters ? low : *a;
            return 1;
        }
        *(enters ? a : &b) = *touch;
    }
    if (b.contact > 0 || a->approach <= 0)
        return 0;
    if (apart(a, &b, SURFACE_END)) {
        struct Look low = *a, high = b;
        close_in(search, SURFACE_END, &low, &high);
        if (low.contact <= 0 && rises_between(search, a, low, touch))
            return 1;
        *touch = low.contact > 0 ? low : high;
        *a = low.contact > 0 ? *a : low;
        if (touch->contact > 0)
            return 1;
        *a = high;
    }
    return !(high_above(a, span) && high_above(&b, span)) && rises_between(search, a, b, touch);
}

/* Do start, middle and end, on one surface, show that nothing lies between? A hump stands out by less than it bends;
 * where the tool moves away it is that of a sine, which the parabola shows. */
static int plain(double at_start, double at_middle, double at_end, int moves_away)
{
    const double first = at_middle - at_start, last = at_end - at_middle, bend = fabs(last - first);
    const double top = larger(larger(at_start, at_middle), at_end > 0 ? at_middle : at_end);
    return at_middle > 0 || top <= -2 * bend || (moves_away && (3 * first - last <= -bend || 3 * last - first >= bend));
}

int touches_within(const struct Contact *contact, const struct Configuration *w, int i, double s, double h,
                   const struct Point *start, const struct Point *middle, const struct Point *end, double tau[2],
                   double indicator[2])
{
    const int given = w->kinematics == KINEMATICS_EXTERNAL;
    if (contact->sign[AT_CONTACT][i] > 0 || w->held || (start->contact[i] > 0 && middle->contact[i] > 0))
        return 0;
    const struct Look m = seen(middle, i, s + 0.5 * h), b = seen(end, i, s + h);
    struct Look a = seen(start, i, s), touch;
    a.contact = smaller(a.contact, 0); /* rounding, where a contact has just ended */
    const int one_piece =
        !(apart(&a, &m, TURN) || apart(&m, &b, TURN) || apart(&a, &m, SURFACE_END) || apart(&m, &b, SURFACE_END));
    if (one_piece && plain(a.contact, m.contact, b.contact, b.approach <= 0))
        return 0;
    const struct Search search = {contact, w, start, s, given ? 2e-3 * h : 1e-4 / w->p[VAR_VIBRATION_FREQUENCY][i], i};
    if (h < search.fine)
        return 0;
    int touches = one_piece ? rises_between(&search, &a, m, &touch) : touches_between(&search, &a, m, &touch);
    if (!touches && m.contact <= 0) {
        a = m;
        touches = !one_piece ? touches_between(&search, &a, b, &touch)
                             : b.contact <= 0 && rises_between(&search, &a, b, &touch);
    }
    if (touches) {
        tau[0] = a.tau;
        tau[1] = touch.tau;
        indicator[0] = a.contact;
        indicator[1] = touch.contact;
    }
    return touches;
}
