/* How far is an elastic element bent that gives way at a limit? The stop operator of Prandtl and Ishlinskii.
 *
 * y, -1..1, is the load as a share of the limit, s = +1 or -1 the way that it is driven, and `way` how far, in units of
 * the way from 0 to the limit: dy/dway = s min(1, (1 - s y)/ROUNDED). The ideal element has a corner there, at which
 * its rate would jump; asperities do not all give way at once.
 */
#ifndef STOP_OPERATOR_H
#define STOP_OPERATOR_H

#include "../stages.h"

#define ROUNDED 0.1 /* share of the limit over which the corner is round */

static inline double stop_rate(double y, double s) { return s * smaller(1, (1 - s * y) / ROUNDED); }

/* Exact, whatever the speed was. */
static inline double stop_after(double y, double s, double way)
{
    const double straight = smaller(larger(1 - ROUNDED - s * y, 0), way), u = s * y + straight;
    return s * (u + (1 - u) * (1 - exponential((straight - way) / ROUNDED)));
}

/* The way of a slip that keeps its side s over the step, after half and whole of it [m]. */
static inline void ways_of(double s, double h, double v_0, double v_m, double v_1, double *half, double *whole)
{
    *whole = larger(s * h / 6 * (v_0 + 4 * v_m + v_1), 0);
    *half = smaller(larger(s * h / 24 * (5 * v_0 + 8 * v_m - v_1), 0), *whole);
}

#endif
