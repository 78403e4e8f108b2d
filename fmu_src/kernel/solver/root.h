/* Where does a function change its sign? A bracket that closes by regula falsi with the weights of Anderson and Bjorck
 * 1973, by halves where that is slow. The caller evaluates: low stays where the function is >= 0, high where it is < 0.
 */
#ifndef ROOT_H
#define ROOT_H

#include "../stages.h"

struct Bracket {
    double low, high, weight_low, weight_high, last;
    int count;
};

static inline struct Bracket bracket(double low, double high, double at_low, double at_high)
{
    const struct Bracket b = {low, high, at_low, at_high, 0, 0};
    return b;
}

/* Where to look next; never nearer than `close`/2 to an end, so that both ends move. */
static inline double bracket_next(struct Bracket *b, double close)
{
    const double share = b->weight_low > 0 && b->count < 30 ? b->weight_low / (b->weight_low - b->weight_high) : 0.5;
    b->count += 1;
    return smaller(larger(b->low + (b->high - b->low) * share, b->low + 0.5 * close), b->high - 0.5 * close);
}

static inline void bracket_update(struct Bracket *b, double at, double value)
{
    double *const old = value < 0 ? &b->weight_high : &b->weight_low, *const other =
                                                                          value < 0 ? &b->weight_low : &b->weight_high;
    const double left = *old != 0 ? 1 - value / *old : 0.5;
    if (b->last * value > 0) /* the same end again: the other end's value counts less */
        *other *= left > 0 ? left : 0.5;
    *old = b->last = value;
    if (value < 0)
        b->high = at;
    else
        b->low = at;
}

#endif
