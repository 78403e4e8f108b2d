/* How is the past kept in a bounded number of pieces? Only where there is no more room: what nobody looks back to goes;
 * one polynomial stands for as many steps as it serves; one vibration cycle for those that are like it, two for those
 * that lie between them (drift.c).
 *
 * Steps are joined once and a cycle is compared with what is kept of others, so that errors do not add up. Where there
 * are no cycles they are joined to a share of what is allowed as long as that makes room: a thickness drives a holder,
 * and where the chip presses hard a bristle feels even little of it. No piece leads across a jump. Memory: kernel.h.
 * `allowed` of ring.h is a fifth of a tolerance: a polynomial meets what steps have computed to it, and their parabolas
 * in between to five; so do cycles that are taken for alike, but in a fiftieth of one.
 */
#include "ring.h"

#include <math.h>

#define RETHINNING_SHARE 0.01 /* of what is allowed: so little that it may be lost many times */
#define BESIDE 0.2 /* how far what repeats may lie beside, in cycles, of what may differ */
#define PARABOLA_FACTOR 5 /* times as much where a step is only known by its parabola */
/* Of a cycle: what is shorter may differ by more, so that its mean over that time does not. */
#define SHORT_TIME 0.02
#define MOST_MORE 50 /* by so many times at most */
#define JUMP_SHARE 0.05 /* of what is allowed: less is no jump */

/* ---- what nobody looks back to ---- */

/* Of each gap that is still looked back to the cycle before is kept, too. */
static void drop_old(struct Reel *reel)
{
    const struct Pieces *const p = &reel->pieces;
    const int64_t count = ring_count(reel->ring, p->lane);
    int64_t first = ring_first(reel->ring, p->lane);
    double keep_from = reel->keep_from;
    for (int64_t n = count - 1; n > first && p->period > 0; --n)
        if (gap_before(p, n) && piece_start(p, n) > keep_from)
            keep_from = smaller(keep_from, piece_end(p, n - 1) - 1.001 * p->period);
    while (first < count - 1 && piece_end(p, first) < keep_from)
        ++first;
    reel->ring->first[p->lane] = (double)first;
    reel->ring->settled[p->lane] = larger(reel->ring->settled[p->lane], (double)first);
    reel->ring->joined[p->lane] = larger(reel->ring->joined[p->lane], (double)first);
}

/* ---- one polynomial for several steps ---- */

/* What is known of the pieces n and on: the values at nodes that are no interpolation. A step has seen its middle, a
 * host's step not even that. `at`: share of the stretch. */
enum { MOST = (NODES - 1) * HISTORY + 1 };
struct Known {
    int count, piece[MOST], node[MOST];
    double at[MOST];
};

static int nodes_between(const struct Reel *reel, int64_t n)
{
    const struct Pieces *const p = &reel->pieces;
    int straight = 1, parabolic = 1;
    for (int k = 0; k < p->channels; ++k) {
        const lanes *const node = piece_nodes(p, n, k);
        const struct Quartic own = quartic_through(node, p->lane);
        const double rounding = 1e-12 * (fabs(node[0][p->lane]) + fabs(node[2][p->lane]) + fabs(node[4][p->lane]));
        straight &= fabs(own.d[2]) <= rounding;
        parabolic &= fabs(own.d[3]) <= rounding && fabs(own.d[4]) <= rounding;
    }
    return parabolic ? !straight : 3;
}

static void find_known(const struct Reel *reel, int64_t from, int64_t to, struct Known *known)
{
    const struct Pieces *const p = &reel->pieces;
    const double start = piece_start(p, from), length = piece_end(p, to) - start;
    known->count = 0;
    for (int64_t n = from; n <= to; ++n) {
        const int between = nodes_between(reel, n), stride = (NODES - 1) / (between + 1);
        const double begin = piece_start(p, n), own = piece_end(p, n) - begin;
        for (int m = n > from ? stride : 0; m < NODES; m += stride) {
            known->piece[known->count] = (int)(n - from);
            known->node[known->count] = m;
            known->at[known->count++] = length > 0 ? (begin + 0.25 * m * own - start) / length : 1;
        }
    }
}

static double known_value(const struct Reel *reel, const struct Known *known, int64_t from, int channel, int which)
{
    const lanes *const node = piece_nodes(&reel->pieces, from + known->piece[which], channel);
    return node[known->node[which]][reel->pieces.lane];
}

/* At the quarters of the stretch the polynomial through what is known nearest to them. */
static void fit(const struct Reel *reel, const struct Known *known, int64_t from, int channel, lanes node[NODES])
{
    const int used = known->count < NODES ? known->count : NODES;
    double x[NODES], d[NODES];
    for (int n = 0, which = 0; n < used; ++n, ++which) {
        const double wanted = (double)n / (used - 1);
        while (which < known->count - (used - n) &&
               fabs(known->at[which + 1] - wanted) <= fabs(known->at[which] - wanted))
            ++which;
        x[n] = known->at[which];
        d[n] = known_value(reel, known, from, channel, which);
    }
    for (int order = 1; order < used; ++order)
        for (int n = used - 1; n >= order; --n)
            d[n] = x[n] > x[n - order] ? (d[n] - d[n - 1]) / (x[n] - x[n - order]) : 0;
    for (int m = 0; m < NODES; ++m) {
        double sum = d[used - 1];
        for (int n = used - 2; n >= 0; --n)
            sum = d[n] + (0.25 * m - x[n]) * sum;
        node[m][reel->pieces.lane] = sum;
    }
}

/* Does one polynomial serve for them? */
static int one_serves(const struct Reel *reel, int64_t from, int64_t to, double share)
{
    const struct Pieces *const p = &reel->pieces;
    const int i = p->lane;
    const double start = piece_start(p, from), length = piece_end(p, to) - start;
    struct Known known;
    for (int64_t n = from; n < to; ++n) {
        if (fabs(piece_start(p, n + 1) - piece_end(p, n)) > 1e-9 * length + 1e-14 * fabs(start))
            return 0;
        for (int k = 0; k < p->channels; ++k)
            if (fabs(piece_nodes(p, n, k)[NODES - 1][i] - piece_nodes(p, n + 1, k)[0][i]) >
                JUMP_SHARE * share * reel->allowed[k])
                return 0;
    }
    if (!(length > 0))
        return 1;
    find_known(reel, from, to, &known);
    for (int k = 0; k < p->channels; ++k) {
        lanes node[NODES];
        fit(reel, &known, from, k, node);
        const struct Quartic joined = quartic_through((const lanes *)node, i);
        for (int n = 0; n < known.count; ++n)
            if (!(fabs(quartic_at(&joined, known.at[n]) - known_value(reel, &known, from, k, n)) <=
                  share * reel->allowed[k]))
                return 0;
        for (int64_t n = from; n <= to; ++n) {
            const double begin = piece_start(p, n), own = piece_end(p, n) - begin;
            for (int m = 1; m < NODES; m += 2)
                if (!(fabs(quartic_at(&joined, (begin + 0.25 * m * own - start) / length) -
                           piece_nodes(p, n, k)[m][i]) <= PARABOLA_FACTOR * share * reel->allowed[k]))
                    return 0;
        }
    }
    return 1;
}

/* The last piece, no further than `last`, up to which one polynomial serves. */
static int64_t serves_up_to(const struct Reel *reel, int64_t from, int64_t last, double share)
{
    int64_t good = from, size = 1;
    while (good + size <= last && one_serves(reel, from, good + size, share)) {
        good += size;
        size = good - from + 1;
    }
    int64_t bad = good + size <= last ? good + size : last + 1;
    while (bad - good > 1) {
        const int64_t half = (good + bad) / 2;
        if (one_serves(reel, from, half, share))
            good = half;
        else
            bad = half;
    }
    return good;
}

/* In the place `at`, which is not later, one piece for `from`..`to`. */
static void join(struct Reel *reel, int64_t at, int64_t from, int64_t to)
{
    if (from == to) {
        move_piece(reel, at, from);
        return;
    }
    const struct Pieces *const p = &reel->pieces;
    const double start = piece_start(p, from), end = piece_end(p, to),
                 drift = reel->ring->drift[from % HISTORY][p->lane];
    struct Known known;
    find_known(reel, from, to, &known);
    lanes node[CHANNELS][NODES];
    for (int k = 0; k < p->channels; ++k)
        fit(reel, &known, from, k, node[k]);
    for (int k = 0; k < p->channels; ++k)
        copy_lane(reel->value + (at % HISTORY * p->channels + k) * NODES, (const lanes *)node[k], NODES, p->lane);
    reel->ring->length[at % HISTORY][p->lane] = larger(end - start, 0);
    reel->ring->end[at % HISTORY][p->lane] = end;
    reel->ring->drift[at % HISTORY][p->lane] = drift;
}

/* From piece `from` on, to a share of what is allowed. The last piece stays as it is: the next step goes on from it. */
static void thin(struct Reel *reel, int64_t from, double share)
{
    const int lane = reel->pieces.lane;
    const int64_t count = ring_count(reel->ring, lane);
    int64_t at = from;
    for (int64_t n = at; n < count; ++at) {
        const int64_t to = n < count - 1 ? serves_up_to(reel, n, count - 2, share) : n;
        join(reel, at, n, to);
        n = to + 1;
    }
    reel->ring->count[lane] = (double)at;
    reel->ring->joined[lane] = (double)(at - 1);
}

/* ---- one cycle for several ---- */

/* Is `value` what is kept at t, or within `beside` of it? A force may rise like a square root, and no difference in its
 * height says there how little it is late. */
static int was_there(const struct Pieces *p, int channel, double t, double beside, double value, double allowed)
{
    double lowest = INFINITY, highest = -INFINITY;
    for (int n = 0; n < 3; ++n) {
        const double was = ring_value(p, channel, t + (n == 1 ? beside : n == 2 ? -beside : 0));
        lowest = smaller(lowest, was);
        highest = larger(highest, was);
        if (value >= lowest - allowed && value <= highest + allowed)
            return 1;
    }
    return 0;
}

double more_where_short(const struct Pieces *p, double length)
{
    return smaller(larger(SHORT_TIME * p->period / length, 1), MOST_MORE);
}

/* Is piece n, as far as it is known, like what is kept of cycles before? A short one need not be as much. */
static int is_repeated(const struct Reel *reel, int64_t n)
{
    const struct Pieces *const p = &reel->pieces;
    const double start = piece_start(p, n), end = piece_end(p, n), beside = BESIDE * p->alike * p->period,
                 kept_to = piece_end(p, ring_count(reel->ring, p->lane) - 1);
    if (end - start <= 4 * beside)
        return 1;
    const double more = more_where_short(p, end - start), inside[2] = {start + 2 * beside, end - 2 * beside};
    const int stride = (NODES - 1) / (nodes_between(reel, n) + 1);
    double there[2] = {0};
    for (int k = 0; k < p->channels; ++k) {
        const struct Quartic mine = quartic_through(piece_nodes(p, n, k), p->lane);
        for (int m = 0; m < NODES; m += stride) {
            const double t = smaller(larger(start + 0.25 * m * (end - start), inside[0]), inside[1]);
            there[m > 0] = t - p->period * larger(ceil((t - kept_to) / p->period), 1);
            if (!was_there(p, k, there[m > 0], beside, quartic_at(&mine, (t - start) / (end - start)),
                           more * REPEATED * reel->allowed[k]))
                return 0;
        }
    }
    const double until = there[0] < there[1] ? there[1] : kept_to; /* it may begin at the end of what is kept */
    return !(ring_jump(p, there[0], until - beside, NULL) < INFINITY) &&
           !(there[1] < there[0] && ring_jump(p, kept_to - p->period + beside, there[1], NULL) < INFINITY);
}

/* Pieces like what is kept of the cycles before leave a gap behind; the last one stays. */
static void drop_repeats(struct Reel *reel, int64_t from)
{
    const struct Pieces *const p = &reel->pieces;
    const int64_t count = ring_count(reel->ring, p->lane), first = ring_first(reel->ring, p->lane);
    int64_t at = from > first ? from : first + 1;
    for (int64_t n = at; n < count; ++n) {
        reel->ring->count[p->lane] = (double)at; /* what is kept so far */
        const int known = piece_start(p, n) - piece_start(p, first) >= 1.001 * p->period;
        if (known && n < count - 1 && is_repeated(reel, n))
            continue;
        join(reel, at, n, n);
        ++at;
    }
    reel->ring->count[p->lane] = (double)at;
    reel->ring->settled[p->lane] = reel->ring->joined[p->lane] = (double)(at - 1);
}

/* Is the newest cycle, as far as it is known, like the one in the middle of those since cycles have drifted last? */
static int is_steady(const struct Reel *reel)
{
    const struct Pieces *const p = &reel->pieces;
    const int64_t count = ring_count(reel->ring, p->lane), first = behind_drifting(p);
    const double end = piece_end(p, count - 2), beside = BESIDE * p->alike * p->period,
                 back = p->period * larger(floor(0.5 * (end - piece_start(p, first)) / p->period), 1);
    for (int64_t n = count - 2; n > first && piece_start(p, n) >= end - p->period; --n) {
        const double start = piece_start(p, n), length = piece_end(p, n) - start;
        if (length <= 4 * beside)
            continue;
        const double more = more_where_short(p, length), t = start + 0.5 * length;
        for (int k = 0; k < p->channels; ++k)
            if (!was_there(p, k, t - back, beside, ring_value(p, k, t), more * REPEATED * reel->allowed[k]))
                return 0;
    }
    return 1;
}

/* Cycles that drift are left out as a whole, before those that repeat themselves: of these only some pieces would go,
 * and what stays would go up by steps. */
static void drop_cycles(struct Reel *reel, int64_t from)
{
    if (!is_steady(reel)) {
        const int64_t before = pieces_kept(reel);
        drop_drifting(reel);
        from -= before - pieces_kept(reel);
    }
    const int64_t free = behind_drifting(&reel->pieces);
    if (HISTORY - pieces_kept(reel) < ROOM)
        drop_repeats(reel, from > free ? from : free);
}

/* The first piece that has not been tried. */
static int64_t untried(const struct Reel *reel, const lanes tried)
{
    const int lane = reel->pieces.lane;
    const int64_t first = ring_first(reel->ring, lane), from = whole_count(tried[lane]);
    return from > first && from <= ring_count(reel->ring, lane) ? from : first;
}

void make_room(struct Reel *reel)
{
    const int lane = reel->pieces.lane;
    if (pieces_kept(reel) < HISTORY)
        return;
    drop_old(reel);
    if (HISTORY - pieces_kept(reel) < ROOM && !(reel->pieces.period > 0))
        thin(reel, untried(reel, reel->ring->joined), RETHINNING_SHARE);
    const int64_t first = ring_first(reel->ring, lane), from = untried(reel, reel->ring->settled);
    if (HISTORY - pieces_kept(reel) < ROOM) {
        thin(reel, from, 1);
        reel->ring->settled[lane] = reel->ring->joined[lane];
    }
    const int64_t before = pieces_kept(reel);
    if (HISTORY - before < ROOM) { /* first what goes on for many cycles: across a gap nothing can be joined */
        thin(reel, first, RETHINNING_SHARE);
        reel->ring->settled[lane] = reel->ring->joined[lane];
    }
    if (HISTORY - pieces_kept(reel) < ROOM && reel->pieces.period > 0)
        drop_cycles(reel, from - (before - pieces_kept(reel)));
    if (pieces_kept(reel) >= HISTORY) /* whoever looks back as far finds it gone */
        reel->ring->first[lane] = (double)(ring_first(reel->ring, lane) + 1);
}
