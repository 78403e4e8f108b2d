/* What was a quantity some time ago? A polynomial for each stretch of time; for stretches that are like a vibration
 * cycle before only that cycle, and for cycles that drift slowly the first and the last of them.
 */
#include "ring.h"

#include <math.h>

/* Bytes from outside (a restored state) steer no array index. */
int64_t whole_count(double count) { return count > 0 && count < 9e15 ? (int64_t)count : 0; }

int64_t ring_count(const struct Ring *ring, int lane) { return whole_count(ring->count[lane]); }

int64_t ring_first(const struct Ring *ring, int lane)
{
    const int64_t count = ring_count(ring, lane), first = whole_count(ring->first[lane]);
    return first < count && count - first <= HISTORY ? first : count > HISTORY ? count - HISTORY : 0;
}

/* The place of the n-th that was written. */
static inline int in_ring(int64_t n) { return (int)((uint64_t)n % HISTORY); }

double piece_end(const struct Pieces *p, int64_t n) { return p->ring->end[in_ring(n)][p->lane]; }
double piece_start(const struct Pieces *p, int64_t n) { return piece_end(p, n) - p->ring->length[in_ring(n)][p->lane]; }
const lanes *piece_nodes(const struct Pieces *p, int64_t n, int channel)
{
    return p->value + (in_ring(n) * p->channels + channel) * NODES;
}

/* The first of the places low..high of a ring whose time lies after t, or with `at` set at t or after; high where none
 * does. */
int64_t first_later(const lanes *times, int lane, int64_t low, int64_t high, double t, int at)
{
    /* most look back by little: from the end in steps of twice the length, then between the last two */
    for (int64_t far = 1; low < high - far; far *= 2) {
        const double there = times[in_ring(high - far)][lane];
        if (there < t || (there == t && !at)) {
            low = high - far + 1;
            break;
        }
        high -= far;
    }
    while (low < high) {
        const int64_t half = (low + high) / 2;
        const double there = times[in_ring(half)][lane];
        if (there < t || (there == t && !at))
            low = half + 1;
        else
            high = half;
    }
    return low;
}

/* Newton's forward differences. */
struct Quartic quartic_through(const lanes *node, int lane)
{
    struct Quartic q;
    for (int n = 0; n < NODES; ++n)
        q.d[n] = node[n][lane];
    for (int order = 1; order < NODES; ++order)
        for (int n = NODES - 1; n >= order; --n)
            q.d[n] -= q.d[n - 1];
    return q;
}

double quartic_at(const struct Quartic *q, double share)
{
    const double s = 4 * smaller(larger(share, 0), 1);
    return q->d[0] + s * (q->d[1] + (s - 1) * (1. / 2) *
                                        (q->d[2] + (s - 2) * (1. / 3) * (q->d[3] + (s - 3) * (1. / 4) * q->d[4])));
}

double share_of_piece(const struct Pieces *p, int64_t n, double t)
{
    const double length = p->ring->length[in_ring(n)][p->lane];
    return length > 0 ? 1 - (piece_end(p, n) - t) / length : 1;
}

static double at_share(const struct Pieces *p, int64_t n, int channel, double share)
{
    const struct Quartic q = quartic_through(piece_nodes(p, n, channel), p->lane);
    return quartic_at(&q, share);
}

static double in_piece(const struct Pieces *p, int64_t n, int channel, double t)
{
    return at_share(p, n, channel, share_of_piece(p, n, t));
}

int gap_before(const struct Pieces *p, int64_t n)
{
    const double start = piece_start(p, n), rounding = 1e-14 * fabs(start);
    return p->period > 0 && start - piece_end(p, n - 1) > 1e-9 * p->period + rounding &&
           n > ring_first(p->ring, p->lane);
}

int drifts_before(const struct Pieces *p, int64_t n)
{
    return p->ring->drift[in_ring(n)][p->lane] > 0 && gap_before(p, n);
}

static double cycles_back(const struct Pieces *p, double t, int64_t last)
{
    return larger(ceil((t - piece_end(p, last)) / p->period), 0);
}

/* Where a value at t is found: at `t` in `piece`, and if there is another (else -1) on the way from there to what is
 * found at `other_t` in that, as far as `share` says. */
struct Place {
    int64_t piece, other;
    double t, other_t, share;
};

/* The same phase in the first cycle from piece `next` on; where that holds no piece, it is as the cycle before. */
static void look_ahead(const struct Pieces *p, int64_t last, int64_t next, struct Place *place)
{
    const double on = larger(ceil((piece_start(p, next) - place->t) / p->period), 0),
                 back = cycles_back(p, place->t, last);
    const int64_t count = ring_count(p->ring, p->lane);
    place->other_t = place->t + p->period * on;
    place->other = first_later(p->ring->end, p->lane, next, count, place->other_t, 1);
    if (place->other >= count ||
        (place->other > next && gap_before(p, place->other) && place->other_t < piece_start(p, place->other)))
        place->other = -1;
    place->share = on > 0 ? back / (back + on) : 1;
}

/* A t in a gap is led whole cycles back, and again where that is one. until: until when [s] the same pieces tell. */
static struct Place place_of(const struct Pieces *p, double t, double *until)
{
    const int64_t first = ring_first(p->ring, p->lane);
    const double asked = t;
    struct Place place = {.other = -1, .t = t};
    int64_t last = ring_count(p->ring, p->lane) - 1;
    *until = INFINITY;
    for (int n = 0; n < HISTORY; ++n) {
        const int64_t at = place.piece = first_later(p->ring->end, p->lane, first, last, place.t, 1);
        if (!gap_before(p, at) || place.t >= piece_start(p, at))
            break;
        last = at - 1;
        if (place.other < 0 && drifts_before(p, at))
            look_ahead(p, last, at, &place);
        if (place.other >= 0)
            *until = smaller(*until, piece_end(p, place.other) + (asked - place.other_t));
        *until = smaller(*until, piece_start(p, at) + (asked - place.t));
        place.t -= p->period * cycles_back(p, place.t, last);
    }
    *until = smaller(*until, piece_end(p, place.piece) + (asked - place.t));
    return place;
}

static double value_at(const struct Pieces *p, int channel, const struct Place *place)
{
    const double before = in_piece(p, place->piece, channel, place->t);
    if (place->other < 0)
        return before;
    return before + place->share * (in_piece(p, place->other, channel, place->other_t) - before);
}

double ring_value(const struct Pieces *p, int channel, double t)
{
    double until;
    const struct Place place = place_of(p, t, &until);
    return value_at(p, channel, &place);
}

void ring_values(const struct Pieces *p, double t, double *value)
{
    double until;
    const struct Place place = place_of(p, t, &until);
    const double share = share_of_piece(p, place.piece, place.t);
    for (int k = 0; k < p->channels; ++k)
        value[k] = place.other < 0 ? at_share(p, place.piece, k, share) : value_at(p, k, &place);
}

double ring_value_between(const struct Pieces *p, int channel, double t, int64_t last, int64_t next)
{
    struct Place place = {.t = t};
    look_ahead(p, last, next, &place);
    const double before = ring_value(p, channel, t - p->period * cycles_back(p, t, last));
    return place.other < 0 ? before
                           : before + place.share * (in_piece(p, place.other, channel, place.other_t) - before);
}

static int differ(double before, double after, double alike)
{
    return fabs(after - before) > alike * (fabs(after) + fabs(before));
}

/* Does a value jump from piece n to the next one, where none is missing in between? */
static int jumps_after(const struct Pieces *p, int64_t n)
{
    int jumps = 0;
    for (int k = 0; k < p->channels; ++k)
        jumps |= differ(piece_nodes(p, n, k)[NODES - 1][p->lane], piece_nodes(p, n + 1, k)[0][p->lane], 1e-9);
    return jumps;
}

/* Does it at a t that lies in a gap, or at its end? What differs no more than it may is no jump. */
static int jumps_at(const struct Pieces *p, double t, double close)
{
    int jumps = 0;
    for (int k = 0; k < p->channels; ++k)
        jumps |= differ(ring_value(p, k, t - close), ring_value(p, k, t + close), p->alike);
    return jumps;
}

/* The first time in [from, to] at which it does, in one gap and at its ends. */
static double jump_in_gap(const struct Pieces *p, double from, double to)
{
    const double close = 1e-15 * fabs(to) + 1e-12 * p->period;
    for (int n = 0; n < HISTORY && from <= to; ++n) {
        double until;
        if (jumps_at(p, from, close))
            return from;
        place_of(p, from + 2 * close, &until);
        from = larger(until, from + 2 * close);
    }
    return INFINITY;
}

double ring_jump(const struct Pieces *p, double from, double to, const double *beyond)
{
    const int64_t count = ring_count(p->ring, p->lane);
    for (int64_t n = first_later(p->ring->end, p->lane, ring_first(p->ring, p->lane), count, from, 0); n < count; ++n) {
        if (gap_before(p, n) && from < piece_start(p, n)) {
            const double close = 1e-12 * p->period, jump = jump_in_gap(p, larger(from + close, piece_end(p, n - 1)),
                                                                       smaller(to, piece_start(p, n)));
            if (jump < to)
                return jump;
        }
        if (piece_end(p, n) >= to)
            break;
        int jumps = 0;
        for (int k = 0; k < p->channels && n + 1 == count; ++k)
            jumps |= differ(piece_nodes(p, n, k)[NODES - 1][p->lane], beyond[k], 1e-9);
        if (n + 1 < count && !gap_before(p, n + 1))
            jumps = jumps_after(p, n);
        if (jumps)
            return piece_end(p, n);
    }
    return INFINITY;
}

int64_t pieces_kept(const struct Reel *reel)
{
    return ring_count(reel->ring, reel->pieces.lane) - ring_first(reel->ring, reel->pieces.lane);
}

void move_piece(struct Reel *reel, int64_t to, int64_t from)
{
    const int lane = reel->pieces.lane, rows = reel->pieces.channels * NODES;
    struct Ring *const ring = reel->ring;
    copy_lane(reel->value + in_ring(to) * rows, (const lanes *)(reel->value + in_ring(from) * rows), rows, lane);
    ring->length[in_ring(to)][lane] = ring->length[in_ring(from)][lane];
    ring->end[in_ring(to)][lane] = ring->end[in_ring(from)][lane];
    ring->drift[in_ring(to)][lane] = ring->drift[in_ring(from)][lane];
}

void ring_append(struct Reel *reel, double start, double end, double value[][3])
{
    const int lane = reel->pieces.lane;
    make_room(reel);
    const int64_t n = ring_count(reel->ring, lane);
    reel->ring->end[in_ring(n)][lane] = end;
    reel->ring->length[in_ring(n)][lane] = larger(end - start, 0);
    reel->ring->drift[in_ring(n)][lane] = 0;
    for (int k = 0; k < reel->pieces.channels; ++k) {
        lanes *const node = reel->value + (in_ring(n) * reel->pieces.channels + k) * NODES;
        for (int m = 0; m < NODES; ++m)
            node[m][lane] = m % 2 ? parabola(0.25 * m, value[k][0], value[k][1], value[k][2]) : value[k][m / 2];
    }
    reel->ring->count[lane] = (double)(n + 1);
}

void ring_cut(struct Reel *reel, double t)
{
    const struct Pieces *const p = &reel->pieces;
    const int lane = p->lane;
    for (int64_t n = ring_count(p->ring, lane) - 1; n >= ring_first(p->ring, lane) && piece_end(p, n) > t; --n) {
        if (!(piece_start(p, n) < t)) {
            reel->ring->count[lane] = (double)n;
            continue;
        }
        for (int k = 0; k < p->channels; ++k) {
            double u[NODES];
            for (int m = 0; m < NODES; ++m)
                u[m] = in_piece(p, n, k, piece_start(p, n) + 0.25 * m * (t - piece_start(p, n)));
            for (int m = 0; m < NODES; ++m)
                reel->value[(in_ring(n) * p->channels + k) * NODES + m][lane] = u[m];
        }
        reel->ring->length[in_ring(n)][lane] = t - piece_start(p, n);
        reel->ring->end[in_ring(n)][lane] = t;
    }
    reel->ring->first[lane] = smaller(reel->ring->first[lane], reel->ring->count[lane]);
    reel->ring->settled[lane] = smaller(reel->ring->settled[lane], reel->ring->count[lane]);
    reel->ring->joined[lane] = smaller(reel->ring->joined[lane], reel->ring->count[lane]);
}
