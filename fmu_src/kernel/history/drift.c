/* Which vibration cycles of the past lie between two others? A slide, run-out or a turn of the work make each cycle a
 * little other than the one before, and no two are alike; but from phase to phase the force goes straight from that of
 * the first to that of the last of them, for as long as the drift does. Only these two are kept then.
 *
 * How far off that is adds up where such gaps are joined; it stands in the ring, and never passes what is allowed: once
 * more a tolerance (ring.h), beside what thinning.c may lose.
 */
#include "ring.h"

#include <math.h>

#define BESIDE 1.0 /* how far what drifts may lie beside, in cycles, of what may differ */

/* Of what may be lost, what is at t would be if the pieces between `last` and `next` were not there. */
static double lost_at(const struct Reel *reel, double t, double more, int64_t last, int64_t next)
{
    const struct Pieces *const p = &reel->pieces;
    const double beside = BESIDE * p->alike * p->period;
    double worst = 0;
    for (int k = 0; k < p->channels; ++k) {
        const double value = ring_value(p, k, t);
        double lowest = INFINITY, highest = -INFINITY;
        for (int n = 0; n < 3; ++n) {
            const double there = ring_value_between(p, k, t + (n == 1 ? beside : n == 2 ? -beside : 0), last, next);
            lowest = smaller(lowest, there);
            highest = larger(highest, there);
            if (value >= lowest && value <= highest)
                break;
        }
        const double off = larger(larger(value - highest, lowest - value), 0);
        worst = off > 0 ? larger(worst, off / (more * REPEATED * reel->allowed[k])) : worst;
    }
    return worst;
}

/* Of piece n, a little inside: where it begins and ends a value may jump. */
static double lost_in_piece(const struct Reel *reel, int64_t n, int64_t last, int64_t next)
{
    const struct Pieces *const p = &reel->pieces;
    const double start = piece_start(p, n), length = piece_end(p, n) - start,
                 inside = 2 * BESIDE * p->alike * p->period;
    if (length <= 2 * inside)
        return 0;
    const double more = more_where_short(p, length);
    double worst = 0;
    for (int m = 0; m < NODES && worst <= 1; ++m) {
        const double t = smaller(larger(start + 0.25 * m * length, start + inside), start + length - inside);
        worst = larger(worst, lost_at(reel, t, more, last, next));
    }
    return worst;
}

/* In the gap before piece n, in which cycles are like the one before: in its first and in its last cycle, at the phases
 * of what is kept of the one that would stand for it. */
static double lost_in_gap(const struct Reel *reel, int64_t n, int64_t last, int64_t next)
{
    const struct Pieces *const p = &reel->pieces;
    const double begin = piece_end(p, n - 1), end = piece_start(p, n), kept_from = piece_end(p, last) - p->period;
    double worst = 0;
    for (int64_t a = last; a >= ring_first(p->ring, p->lane) && piece_end(p, a) > kept_from && worst <= 1; --a) {
        const double middle = 0.5 * (piece_start(p, a) + piece_end(p, a)),
                     early = middle + p->period * ceil((begin - middle) / p->period),
                     late = middle + p->period * floor((end - middle) / p->period);
        if (late >= early)
            worst = larger(worst, larger(lost_at(reel, early, 1, last, next), lost_at(reel, late, 1, last, next)));
    }
    return worst;
}

/* How far off would it be, of what may be lost, if the pieces between `last` and `next` were not there? Gaps in which
 * cycles drift already count as they are: between straight lines it is furthest off where two of them meet. */
static double lost_between(const struct Reel *reel, int64_t last, int64_t next)
{
    const struct Pieces *const p = &reel->pieces;
    const double until = piece_start(p, next) + p->period;
    double worst = 0, before = 0;
    for (int64_t n = last + 1; n < ring_count(p->ring, p->lane) && piece_start(p, n) < until && worst <= 1; ++n) {
        if (n <= next && drifts_before(p, n))
            before = larger(before, reel->ring->drift[n % HISTORY][p->lane]);
        else if (gap_before(p, n))
            worst = larger(worst, lost_in_gap(reel, n, last, next));
        if (n < next)
            worst = larger(worst, lost_in_piece(reel, n, last, next));
    }
    return before + worst;
}

/* Leaves a gap between `last` and `next`, in which cycles drift. */
static void drop_between(struct Reel *reel, int64_t last, int64_t next, double lost)
{
    const int lane = reel->pieces.lane;
    const int64_t count = ring_count(reel->ring, lane), fewer = next - last - 1;
    for (int64_t n = next; n < count; ++n)
        move_piece(reel, n - fewer, n);
    reel->ring->drift[(last + 1) % HISTORY][lane] = larger(lost, 1e-9);
    reel->ring->count[lane] = (double)(count - fewer);
    reel->ring->settled[lane] = reel->ring->joined[lane] = (double)(count - fewer - 1);
}

/* The first piece from n on up to which there is a whole cycle, and a little more than thinning.c keeps before a gap;
 * the last one from which there is one, in all. */
static int64_t cycle_from(const struct Pieces *p, int64_t n)
{
    const double until = piece_start(p, n) + 1.002 * p->period;
    return first_later(p->ring->end, p->lane, n, ring_count(p->ring, p->lane) - 1, until, 1);
}

static int64_t last_cycle(const struct Pieces *p)
{
    int64_t n = ring_count(p->ring, p->lane) - 2;
    const double until = piece_end(p, n) - p->period;
    while (n > ring_first(p->ring, p->lane) && piece_start(p, n) > until)
        --n;
    return n;
}

static int64_t last_drift(const struct Pieces *p, int64_t before)
{
    int64_t n = before - 1;
    while (n > ring_first(p->ring, p->lane) && !drifts_before(p, n))
        --n;
    return n;
}

/* Behind the last such gap as many cycles at once as lie between two, from the first cycle from which any do: the
 * cycles after a start are like nothing that follows. */
static int drop_newest(struct Reel *reel)
{
    const struct Pieces *const p = &reel->pieces;
    const int64_t newest = last_cycle(p);
    for (int64_t last = cycle_from(p, last_drift(p, ring_count(p->ring, p->lane))); last + 1 < newest;
         last = cycle_from(p, last + 1)) {
        double lost = INFINITY;
        int64_t next = newest;
        while (next > last + 1 && !((lost = lost_between(reel, last, next)) <= 1))
            next = last + (next - last) / 2;
        if (next > last + 1) {
            drop_between(reel, last, next, lost);
            return 1;
        }
    }
    return 0;
}

/* Two such gaps and the cycle between them become one: those first that are together the shortest, so that little adds
 * up. */
static int join_shortest(struct Reel *reel)
{
    const struct Pieces *const p = &reel->pieces;
    const int64_t first = ring_first(p->ring, p->lane);
    double passed = 0;
    for (int n = 0; n < HISTORY; ++n) {
        double shortest = INFINITY;
        int64_t last = 0, next = 0;
        for (int64_t b = last_drift(p, ring_count(p->ring, p->lane)), a; b > first; b = a) {
            a = last_drift(p, b);
            if (a <= first)
                break;
            const double span = piece_start(p, b) - piece_end(p, a - 1);
            if (span > passed && span < shortest) {
                shortest = span;
                last = a - 1;
                next = b;
            }
        }
        if (!(shortest < INFINITY))
            return 0;
        const double lost = lost_between(reel, last, next);
        if (lost <= 1) {
            drop_between(reel, last, next, lost);
            return 1;
        }
        passed = shortest;
    }
    return 0;
}

int64_t behind_drifting(const struct Pieces *p)
{
    const int64_t n = last_drift(p, ring_count(p->ring, p->lane));
    return drifts_before(p, n) ? cycle_from(p, n) + 1 : ring_first(p->ring, p->lane);
}

void drop_drifting(struct Reel *reel)
{
    if (pieces_kept(reel) < 3)
        return;
    while (drop_newest(reel)) {
    }
    while (HISTORY - pieces_kept(reel) < ROOM && join_shortest(reel)) {
    }
}
