/* How is a quantity's past written and read? See ring.c and thinning.c. */
#ifndef RING_H
#define RING_H

#include "../stages.h"

/* Of one lane, to read. value: [HISTORY][channels][NODES]; period: of the vibration [s], 0: nothing comes back; alike:
 * by which share of itself a value may differ from what it is taken for. */
struct Pieces {
    const struct Ring *ring;
    const lanes *value;
    int channels, lane;
    double period, alike;
};

/* The same to write. keep_from: nobody looks back further [s]; allowed: how far what is kept of a channel may be from
 * what was, by one polynomial for several steps, and once more by one cycle for several. */
struct Reel {
    struct Pieces pieces;
    struct Ring *ring;
    lanes *value;
    double keep_from, allowed[CHANNELS];
};

/* ring.c: pieces written, and the first that is still there; start and end of a piece [s]; its values. */
int64_t ring_count(const struct Ring *ring, int lane);
int64_t ring_first(const struct Ring *ring, int lane);
double piece_start(const struct Pieces *p, int64_t n);
double piece_end(const struct Pieces *p, int64_t n);
const lanes *piece_nodes(const struct Pieces *p, int64_t n, int channel);
/* ring.c: the polynomial through the nodes of a piece, at a share of it, 0..1; and at which share of it t lies. */
struct Quartic {
    double d[NODES];
};
struct Quartic quartic_through(const lanes *node, int lane);
double quartic_at(const struct Quartic *q, double share);
double share_of_piece(const struct Pieces *p, int64_t n, double t);
/* ring.c: is there none between this piece and the one before? And do cycles drift there? */
int gap_before(const struct Pieces *p, int64_t n);
int drifts_before(const struct Pieces *p, int64_t n);
/* ring.c: a value at t, not after the last piece; before the first: as that begins. */
double ring_value(const struct Pieces *p, int channel, double t);
void ring_values(const struct Pieces *p, double t, double *value); /* of all channels */
/* ring.c: the value at t if between the pieces `last` and `next` there were none, and cycles drifted. */
double ring_value_between(const struct Pieces *p, int channel, double t, int64_t last, int64_t next);
/* ring.c: the first time in (from, to) at which a value jumps; after the last piece stands `beyond`. */
double ring_jump(const struct Pieces *p, double from, double to, const double *beyond);
/* ring.c: a step with its values at start, middle and end; nothing at all after t. */
void ring_append(struct Reel *reel, double start, double end, double value[][3]);
void ring_cut(struct Reel *reel, double t);
/* ring.c: how many pieces there are; the same piece in a place that is not later. */
int64_t pieces_kept(const struct Reel *reel);
void move_piece(struct Reel *reel, int64_t to, int64_t from);
/* thinning.c: make room for a piece. How many places are worth the trouble. */
enum { ROOM = HISTORY / 8 };
void make_room(struct Reel *reel);
/* thinning.c: from cycle to cycle so many times as much may be lost; and by how many times more in a short time. */
#define REPEATED 5
double more_where_short(const struct Pieces *p, double length);
/* drift.c: leave out cycles that lie between others; the first piece that does not stand for any. */
void drop_drifting(struct Reel *reel);
int64_t behind_drifting(const struct Pieces *p);

#endif
