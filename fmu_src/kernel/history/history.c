/* What were the forces some time ago, and which surface did the tool leave? Two rings of pieces: ring.c reads and
 * writes them, thinning.c makes room.
 *
 * As the steps have it, a parabola each, as long as there is room; then to about a tolerance of the largest force that
 * is kept, or of the largest thickness of the chip (ALLOWED_SHARE times the factors in thinning.c). A past for which
 * there is no room even then is refused.
 */
#include "ring.h"
#include "../solver/root.h"

#include <math.h>

#define ALLOWED_SHARE 0.2 /* of relative_tolerance */

/* Cycles that may be like one another are those of a resolved vibration. */
static double period_of_cycles(const struct Contact *contact, const struct Configuration *w, int lane)
{
    return w->kinematics == KINEMATICS_EXTERNAL || kernel_averages(contact)
               ? 0
               : 1 / contact->value[VAR_VIBRATION_FREQUENCY][lane];
}

static struct Pieces forces_kept(const struct Contact *contact, double period, int lane)
{
    return (struct Pieces){&contact->past, contact->past_force[0][0],
                           CHANNELS,       lane,
                           period,         0.5 * contact->value[VAR_RELATIVE_TOLERANCE][lane]};
}

static struct Pieces surface_kept(const struct Contact *contact, double period, int lane)
{
    return (struct Pieces){&contact->surface,
                           contact->surface_height[0],
                           1,
                           lane,
                           period,
                           0.5 * contact->value[VAR_RELATIVE_TOLERANCE][lane]};
}

static struct Reel forces_reel(struct Contact *contact, const struct Configuration *w, int lane, double now)
{
    struct Reel reel = {forces_kept(contact, period_of_cycles(contact, w, lane), lane),
                        &contact->past,
                        contact->past_force[0][0],
                        now - look_back(w, lane),
                        {0}};
    return reel;
}

/* What may be lost of the forces: asked only where there is no more room. */
static void allow(struct Contact *contact, struct Reel *reel)
{
    const struct Pieces *const p = &reel->pieces;
    const int64_t count = ring_count(reel->ring, p->lane), first = ring_first(reel->ring, p->lane);
    for (int k = 0; k < p->channels && count - first >= HISTORY; ++k) {
        double largest = 0;
        for (int64_t n = first; n < count; ++n)
            for (int m = 0; m < NODES; ++m)
                largest = larger(largest, fabs(piece_nodes(p, n, k)[m][p->lane]));
        reel->allowed[k] = ALLOWED_SHARE * contact->value[VAR_RELATIVE_TOLERANCE][p->lane] * largest;
    }
}

static const lanes *forces_of(const struct Point *x, int channel)
{
    return channel == 0 ? &x->F : channel == 1 ? &x->F_p : &x->F_f;
}

void remember(struct Contact *contact, const struct Configuration *w, int lane, double h, const struct Point *start,
              const struct Point *middle, const struct Point *end)
{
    const struct Point *const at[3] = {start, middle, end};
    struct Reel reel = forces_reel(contact, w, lane, end->t[lane]);
    double force[CHANNELS][3];
    for (int k = 0; k < CHANNELS; ++k)
        for (int n = 0; n < 3; ++n)
            force[k][n] = (*forces_of(at[n], k))[lane];
    allow(contact, &reel);
    ring_append(&reel, end->t[lane] - h, end->t[lane], force);
}

/* Straight from the end of the last step; from here on where the host has gone back, and where the last lies too far
 * away for the distance to be a number. Forces that are no numbers are not kept: a host may go on from a state before.
 */
void remember_host_step(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *x)
{
    for (int k = 0; k < CHANNELS; ++k)
        if (!(fabs((*forces_of(x, k))[lane]) < INFINITY))
            return;
    struct Reel reel = forces_reel(contact, w, lane, x->t[lane]);
    double force[CHANNELS][3];
    ring_cut(&reel, x->t[lane]);
    const int64_t count = ring_count(&contact->past, lane);
    const double from = count > 0 ? piece_end(&reel.pieces, count - 1) : x->t[lane];
    for (int k = 0; k < CHANNELS; ++k) {
        const double now = (*forces_of(x, k))[lane], last = count > 0 ? piece_end(&reel.pieces, count - 1) : INFINITY;
        const double before = last < x->t[lane] ? piece_nodes(&reel.pieces, count - 1, k)[NODES - 1][lane] : now;
        force[k][0] = before;
        force[k][1] = 0.5 * (before + now);
        force[k][2] = now;
    }
    allow(contact, &reel);
    ring_append(&reel, x->t[lane] - from < INFINITY ? from : x->t[lane], x->t[lane], force);
}

void forget_past(struct Contact *contact, int lane)
{
    struct Ring *const past = &contact->past;
    past->count[lane] = past->first[lane] = past->settled[lane] = past->joined[lane] = 0;
}

static void forces_at_point(const struct Point *x, int lane, double force[CHANNELS])
{
    for (int k = 0; k < CHANNELS; ++k)
        force[k] = (*forces_of(x, k))[lane];
}

void recall(const struct Past *past, const struct Point *x, int lane, double t, double force[CHANNELS])
{
    const struct Contact *contact = past->contact;
    const struct Point *a = past->start, *m = past->middle, *b = past->end;
    const int64_t count = ring_count(&contact->past, lane);
    const int in_step = a && t >= a->t[lane];
    forces_at_point(x, lane, force);
    if (t >= x->t[lane])
        return;
    if (in_step || count == 0) {
        double from[CHANNELS], half[CHANNELS], to[CHANNELS];
        if (!a)
            return;
        forces_at_point(a, lane, from);
        forces_at_point(m, lane, half);
        forces_at_point(b, lane, to);
        const double length = b->t[lane] - a->t[lane], share = length > 0 ? (t - a->t[lane]) / length : 1;
        for (int k = 0; k < CHANNELS; ++k)
            force[k] = in_step ? parabola(share, from[k], half[k], to[k]) : from[k];
        return;
    }
    const struct Pieces p = forces_kept(contact, period_of_cycles(contact, past->w, lane), lane);
    const double end = piece_end(&p, count - 1), span = x->t[lane] - end;
    if (t < end) {
        ring_values(&p, t, force);
        return;
    }
    for (int k = 0; k < CHANNELS; ++k) { /* a host's step that is not completed yet: straight on from the last one */
        const double last = piece_nodes(&p, count - 1, k)[NODES - 1][lane];
        force[k] = span > 0 ? last + (force[k] - last) * (t - end) / span : last;
    }
}

/* It is as long as nothing has been overwritten. */
static int reaches(const struct Pieces *p, double t)
{
    const int64_t first = ring_first(p->ring, p->lane);
    return first == 0 || t >= piece_start(p, first) - 1e-13 * fabs(t);
}

int past_reaches(const struct Contact *contact, const struct Configuration *w, int lane, double t)
{
    const struct Pieces forces = forces_kept(contact, 0, lane), surface = surface_kept(contact, 0, lane);
    return (!w->looks_back || reaches(&forces, t - look_back(w, lane))) &&
           (!w->meets_again || reaches(&surface, t - meeting_time(w, lane)));
}

double recall_jump(const struct Contact *contact, const struct Configuration *w, int lane, const struct Point *start,
                   double from, double to)
{
    const struct Pieces p = forces_kept(contact, period_of_cycles(contact, w, lane), lane);
    double next[CHANNELS];
    for (int k = 0; k < CHANNELS; ++k)
        next[k] = (*forces_of(start, k))[lane];
    return ring_jump(&p, from, to, next);
}

/* ---- the surface ---- */

/* The tool cuts the surface down to its own height; where it is in the air the surface stays, one feed higher above the
 * tool that has meanwhile moved on. */
static double height_of_tool(int lane, const struct Point *x)
{
    return x->centre_y[lane] - x->raised[lane] + x->left[lane];
}

static double height_that_stands(const struct Configuration *w, int lane, const struct Point *x)
{
    return x->left[lane] + w->p[VAR_FEED][lane];
}

static double height_left(const struct Configuration *w, int lane, const struct Point *x)
{
    return smaller(height_of_tool(lane, x), height_that_stands(w, lane, x));
}

static void leave(struct Contact *contact, const struct Configuration *w, int lane, double start, double end,
                  const struct Point *x, double height[1][3])
{
    const double thickest = larger(contact->surface_thickest[lane], x->h[lane]);
    struct Reel reel = {surface_kept(contact, period_of_cycles(contact, w, lane), lane),
                        &contact->surface,
                        contact->surface_height[0],
                        x->t[lane] - meeting_time(w, lane),
                        {ALLOWED_SHARE * w->p[VAR_RELATIVE_TOLERANCE][lane] * thickest}};
    contact->surface_thickest[lane] = thickest;
    ring_append(&reel, start, end, height);
}

/* Over a step: height of the tool and of what stands, at its start, middle and end. */
struct Heights {
    double tool[3], stands[3];
};

static double at_share(const double u[3], double share) { return parabola(share, u[0], u[1], u[2]); }

static double above(const struct Heights *u, double share)
{
    return at_share(u->tool, share) - at_share(u->stands, share);
}

/* Where between two shares of the step the tool leaves what stands, or comes down to it; `to` if nowhere. */
static double kink_between(const struct Heights *u, double from, double to)
{
    const double low = above(u, from), high = above(u, to), side = low < 0 ? -1 : 1;
    if (!(low * high < 0))
        return to;
    struct Bracket b = bracket(from, to, fabs(low), -fabs(high));
    while (b.count < 60 && b.high - b.low > 1e-12) {
        const double share = bracket_next(&b, 1e-12);
        bracket_update(&b, share, side * above(u, share));
    }
    return b.high;
}

/* The lower of both. No polynomial has the kink between them: the step is kept in parts. */
static void leave_in_parts(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *start,
                           const struct Point *end, const struct Heights *u)
{
    const double begin = start->t[lane], length = end->t[lane] - begin;
    const double parts[4] = {0, kink_between(u, 0, 0.5), kink_between(u, 0.5, 1), 1};
    for (int n = 0; n < 3; ++n) {
        const double from = n == 1 && !(parts[1] < 0.5) ? 0 : parts[n], to = parts[n + 1];
        if (n == 0 && !(to < 0.5))
            continue; /* one part with the next */
        const double *const lower = above(u, 0.5 * (from + to)) < 0 ? u->tool : u->stands;
        double height[1][3];
        for (int k = 0; k < 3; ++k)
            height[0][k] = at_share(lower, from + 0.5 * k * (to - from));
        if (to > from)
            leave(contact, w, lane, begin + from * length, to < 1 ? begin + to * length : end->t[lane], end, height);
    }
}

void leave_surface(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *start,
                   const struct Point *middle, const struct Point *end)
{
    const int64_t count = ring_count(&contact->surface, lane);
    const struct Pieces p = surface_kept(contact, 0, lane);
    const double rounding = 1e-13 * fabs(end->t[lane]);
    if (kernel_averages(contact) || (count > 0 && piece_end(&p, count - 1) > start->t[lane] + rounding)) {
        leave_surface_here(contact, w, lane, end);
        return;
    }
    const struct Point *const at[3] = {start, middle, end};
    struct Heights u;
    for (int n = 0; n < 3; ++n) {
        u.tool[n] = height_of_tool(lane, at[n]);
        u.stands[n] = height_that_stands(w, lane, at[n]);
    }
    leave_in_parts(contact, w, lane, start, end, &u);
}

void leave_surface_here(struct Contact *contact, const struct Configuration *w, int lane, const struct Point *x)
{
    const int64_t count = ring_count(&contact->surface, lane);
    const struct Pieces p = surface_kept(contact, 0, lane);
    const double last = count > 0 ? piece_end(&p, count - 1) : x->t[lane], now = height_left(w, lane, x),
                 /* of averaged cycles the mean motion counts, not what each does */
        apart = kernel_averages(contact) ? meeting_time(w, lane) / 200 : 0;
    if (count > 0 && !(x->t[lane] > last && x->t[lane] >= last + apart))
        return;
    const double before = count > 0 ? piece_nodes(&p, count - 1, 0)[NODES - 1][lane] : now;
    double height[1][3] = {{before, 0.5 * (before + now), now}};
    leave(contact, w, lane, last, x->t[lane], x, height);
}

double surface_left(const struct Contact *contact, const struct Configuration *w, int lane, double t)
{
    const int64_t count = ring_count(&contact->surface, lane), first = ring_first(&contact->surface, lane);
    const struct Pieces p = surface_kept(contact, period_of_cycles(contact, w, lane), lane);
    if (count == 0 || t < piece_start(&p, first))
        return 0; /* the first turn meets the nominal surface */
    return ring_value(&p, 0, smaller(t, piece_end(&p, count - 1)));
}

double surface_jump(const struct Contact *contact, const struct Configuration *w, int lane, double from, double to)
{
    const int64_t count = ring_count(&contact->surface, lane);
    const struct Pieces p = surface_kept(contact, period_of_cycles(contact, w, lane), lane);
    if (count == 0)
        return INFINITY;
    const double begin = piece_start(&p, ring_first(&contact->surface, lane)),
                 last = piece_nodes(&p, count - 1, 0)[NODES - 1][lane];
    return from < begin && begin < to ? begin : ring_jump(&p, from, to, &last);
}
