/* How far is an elastic element bent that gives way at a limit? The stop operator of Prandtl and Ishlinskii.
 *
 * y, -1..1, is the load as a share of the limit, s = +1 or -1 the way that it is driven, and `way` how far, in units of
 * the way from 0 to the limit: dy/dway = s min(1, (1 - s y)/ROUNDED). The ideal element has a corner there, at which
 * its rate would jump; asperities do not all give way at once.
 */
#ifndef STOP_OPERATOR_H
#define STOP_OPERATOR_H

#include "../stages.h"

#include <math.h>

#define ROUNDED 0.1 /* share of the limit over which the corner is round */

static inline double stop_rate(double y, double s) { return s * smaller(1, (1 - s * y) / ROUNDED); }

static inline int gives_way(double y, double s) { return s * y > 1 - ROUNDED; }

/* Exact, whatever the speed was. A load beyond the limit, which no motion leads to and a search may try, is the limit:
 * else it would be one that a cycle hardly changes, and so one that comes back. */
static inline double stop_after(double y, double s, double way)
{
    const double load = larger(smaller(s * y, 1), -1);
    const double straight = smaller(larger(1 - ROUNDED - load, 0), way), u = load + straight;
    return s * (u + (1 - u) * (1 - exponential((straight - way) / ROUNDED)));
}

/* The way of a slip that keeps its side s over the step, after half and whole of it [m]. */
static inline void ways_of(double s, double h, double v_0, double v_m, double v_1, double *half, double *whole)
{
    *whole = larger(s * h / 6 * (v_0 + 4 * v_m + v_1), 0);
    *half = smaller(larger(s * h / 24 * (5 * v_0 + 8 * v_m - v_1), 0), *whole);
}

/* Along s and back [m]. */
struct Ways {
    double along, back;
};

/* The ways of a slip that is solved for, which no event keeps from turning within a step: the parabola of its speed
 * goes through 0 once where it ends on the other side. */
static inline void ways_that_turn(double s, double h, double v_0, double v_m, double v_1, struct Ways *half,
                                  struct Ways *whole)
{
    *half = *whole = (struct Ways){0, 0};
    ways_of(s, h, v_0, v_m, v_1, &half->along, &whole->along);
    if (!(s * v_0 > 0 && s * v_1 < 0))
        return;
    const double c = s * v_0, b = s * (4 * v_m - 3 * v_0 - v_1), a = 2 * s * (v_0 - 2 * v_m + v_1);
    const double root = sqrt(larger(b * b - 4 * a * c, 0)), turns = b > 0 ? -(b + root) / (2 * a) : 2 * c / (root - b);
    const double along = h * turns * (c + turns * (b / 2 + turns * a / 3)), to_half = h / 2 * (c + b / 4 + a / 12),
                 to_end = h * (c + b / 2 + a / 3);
    *half = turns < 0.5 ? (struct Ways){along, along - to_half} : (struct Ways){to_half, 0};
    *whole = (struct Ways){along, along - to_end};
}

static inline double stop_along_and_back(double y, double s, double unit, struct Ways way)
{
    return stop_after(stop_after(y, s, way.along / unit), -s, way.back / unit);
}

#endif
