/* How does the bristle get from the start of a step to its end? By exponentials: the law is linear in z once the slip is known.
 *
 * dz/dt = drive - rate z with target = drive/rate. In the "path" A(t) = integral of rate the equation is dz/dA = target - z whatever
 * the slip does, so z(D) = z(0) e^-D + integral of e^-(D - A) target(A) dA. The target is taken as the parabola in A through start,
 * middle and end of the step; its integral is exact (phi functions). Non-stiff steps (D << 1) are of fourth order; stiff ones (D >> 1,
 * LuGre at high slip speed) end on the target. Laws without a rate (drive only) are integrated by Simpson's rule.
 */
#include "stages.h"

#include <math.h>

#define FEW 0.25 /* below, by_parts would cancel */

/* k! D^(k+1) phi_(k+1)(-D). */
static inline void by_parts(double D, double I[3])
{
    I[0] = 1 - exponential(-D);
    I[1] = D - I[0];
    I[2] = D * D - 2 * I[1];
}

/* The same by the series of phi_3, in pairs that do not wait for one another. */
static inline void by_series(double D, double I[3])
{
    const double x = -D, x2 = x * x, x4 = x2 * x2;
    const double low = (1. / 6 + x * (1. / 24)) + (1. / 120 + x * (1. / 720)) * x2;
    const double high = (1. / 5040 + x * (1. / 40320)) + (1. / 362880 + x * (1. / 3628800)) * x2;
    const double phi3 = low + high * x4 + (1. / 39916800 + x * (1. / 479001600)) * (x4 * x4);
    const double phi2 = 0.5 - D * phi3, phi1 = 1 - D * phi2;
    I[0] = D * phi1;
    I[1] = D * D * phi2;
    I[2] = 2 * D * D * D * phi3;
}

void moments(double D, double I[3])
{
    if (D > FEW)
        by_parts(D, I);
    else
        by_series(D, I);
}

/* moments() of one lane in two halves: what holds below FEW, and above it in its place. */
static inline void small_moments(lanes I[3], int i, double D)
{
    double part[3];
    by_series(D > FEW ? FEW : D, part);
    for (int k = 0; k < 3; ++k)
        I[k][i] = part[k];
}

static inline void large_moments(lanes I[3], int i, double D)
{
    double part[3];
    by_parts(D, part);
    for (int k = 0; k < 3; ++k)
        I[k][i] = D > FEW ? part[k] : I[k][i];
}

static double reach(const struct Point *x, int i) { return larger(x->F_C[i], x->F_S[i]) / x->P[i]; }
/* Is z surely within it? A product, which is cheaper, and right but for roundings. */
static int within(const struct Point *x, int i, double z) { return fabs(z) * x->P[i] < 0.999 * larger(x->F_C[i], x->F_S[i]); }

/* A law without a rate; out of contact it relaxes like any other. */
static void by_simpson(const lanes h, const struct Point *start, const struct Point *middle, const struct Point *end, lanes z_middle,
                       lanes z_end, lanes difference)
{
    EACH_LANE {
        const double c0 = start->drive[i], cm = middle->drive[i], c1 = end->drive[i], half = exponential(-0.5 * h[i] * middle->rate[i]);
        z_middle[i] = half * start->z[i] + h[i] / 24 * (5 * c0 + 8 * cm - c1);
        z_end[i] = half * half * start->z[i] + h[i] / 6 * (c0 + 4 * cm + c1);
        difference[i] = h[i] / 3 * fabs(c0 - 2 * cm + c1);
    }
}

/* By exponentials. */
static void relax_bristles(int clip, const lanes h, const struct Point *start, const struct Point *middle, const struct Point *end,
                           lanes z_middle, lanes z_end, lanes difference)
{
    lanes M, D, to_M[3], to_D[3];
    int large = 0, far = 0;
    EACH_LANE {
        const double part = h[i] * (1. / 24), a0 = start->rate[i], am = middle->rate[i], a1 = end->rate[i];
        D[i] = or_none(part * (4 * a0 + 16 * am + 4 * a1), NO_PATH);
        M[i] = smaller(or_none(part * (5 * a0 + 8 * am - a1), NO_PATH), D[i]);
        small_moments(to_M, i, M[i]);
        small_moments(to_D, i, D[i]);
        large |= D[i] > FEW;
    }
    if (large) /* the exponential only where a lane needs it */
        EACH_LANE {
            large_moments(to_M, i, M[i]);
            large_moments(to_D, i, D[i]);
        }
    EACH_LANE {
        const double z = start->z[i], m = M[i], d = D[i], per_d = d > 0 ? 1 / d : 0;
        const double a0 = start->rate[i], am = middle->rate[i], a1 = end->rate[i];
        const double q0 = start->target[i], qm = middle->target[i], q1 = end->target[i];
        /* target = q + slope A + bend A^2 through (0, q0), (M, qm), (D, q1); `chord` is the straight one through the ends */
        double first = m > 0 ? (qm - q0) / m : 0, last = d > m ? (q1 - qm) / (d - m) : first;
        const double chord = (q1 - q0) * per_d, bend_seen = (last - first) * per_d, slope_seen = first - bend_seen * m;
        /* Where the slip reverses the rate is 0 and the bristle does not follow its target, whose dip of static friction is far narrower
         * than the step: that end is left out, and the target is straight. */
        const int from_reversal = (a0 < 1e-3 * am) & (d > m), to_reversal = !from_reversal & (a1 < 1e-3 * am) & (m > 0);
        first = from_reversal ? last : first;
        last = to_reversal ? first : last;
        const double q = from_reversal ? qm - last * m : q0, bend = (last - first) * per_d, slope = first - bend * m;
        const double q_end = to_reversal ? qm + first * (d - m) : q1;
        z_middle[i] = z + (q - z) * to_M[0][i] + slope * to_M[1][i] + bend * to_M[2][i];
        const double reached = z + (q - z) * to_D[0][i] + slope * to_D[1][i] + bend * to_D[2][i];
        /* of the target's bend, and of the rate's: it shifts D, of which only the last relaxation is remembered */
        const double shift = h[i] / 3 * fabs(a0 - 2 * am + a1) / (1 + d);
        difference[i] = fabs((slope_seen - chord) * to_D[1][i] + bend_seen * to_D[2][i]) + shift * fabs(q_end - reached);
        z_end[i] = reached;
        far |= !((fabs(reached) <= fabs(z)) | within(start, i, reached) | within(end, i, reached));
    }
    if (clip && far) /* no bristle bends further than its largest target, which the parabola may overshoot */
        EACH_LANE {
            const double bound = larger(larger(reach(start, i), reach(end, i)), fabs(start->z[i]));
            z_end[i] = larger(smaller(z_end[i], bound), -bound);
        }
}

void bristle_step(int relaxes, int clip, const lanes h, const struct Point *start, const struct Point *middle,
                  const struct Point *end, lanes z_middle, lanes z_end, lanes difference)
{
    if (relaxes)
        relax_bristles(clip, h, start, middle, end, z_middle, z_end, difference);
    else
        by_simpson(h, start, middle, end, z_middle, z_end, difference);
}
