/* How does the bristle get from the start of a step to its end? By exponentials: the law is linear in z once the slip
 * is known.
 *
 * dz/dt = drive - rate z with target = drive/rate. In the "path" A(t) = integral of rate the equation is dz/dA = target
 * - z whatever the slip does, so z(D) = z(0) e^-D + integral of e^-(D - A) target(A) dA. The target is taken as the
 * parabola in A through start, middle and end of the step; its integral is exact (phi functions). Non-stiff steps (D <<
 * 1) are of fourth order; stiff ones (D >> 1, LuGre at high slip speed) end on the target. Laws without a rate (drive
 * only) are integrated by Simpson's rule.
 */
#include "../stages.h"

#include <math.h>

#define SERIES_LIMIT 0.25 /* below, by_parts would cancel */

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
    if (D > SERIES_LIMIT)
        by_parts(D, I);
    else
        by_series(D, I);
}

/* moments() of one lane in two halves: what holds below SERIES_LIMIT, and above it in its place. */
static inline void small_moments(lanes I[3], int i, double D)
{
    double part[3];
    by_series(D > SERIES_LIMIT ? SERIES_LIMIT : D, part);
    for (int k = 0; k < 3; ++k)
        I[k][i] = part[k];
}

static inline void large_moments(lanes I[3], int i, double D)
{
    double part[3];
    by_parts(D, part);
    for (int k = 0; k < 3; ++k)
        I[k][i] = D > SERIES_LIMIT ? part[k] : I[k][i];
}

/* M <= D; the exponential only where a lane needs it. */
static INLINED void both_moments(const lanes M, const lanes D, lanes to_M[3], lanes to_D[3])
{
    int large = 0;
    EACH_LANE {
        small_moments(to_M, i, M[i]);
        small_moments(to_D, i, D[i]);
        large |= D[i] > SERIES_LIMIT;
    }
    if (large)
        EACH_LANE {
            large_moments(to_M, i, M[i]);
            large_moments(to_D, i, D[i]);
        }
}

void moments_in_lanes(const lanes M, const lanes D, lanes to_M[3], lanes to_D[3]) { both_moments(M, D, to_M, to_D); }

/* Is z surely within it? A product, which is cheaper, and right but for roundings. */
static int within(const struct Point *x, int i, double z)
{
    return fabs(z) * x->P[i] < 0.999 * larger(x->F_C[i], x->F_S[i]);
}

/* A law without a rate; out of contact it relaxes like any other. */
static void by_simpson(const lanes h, const struct Point *start, const struct Point *middle, const struct Point *end,
                       lanes z_middle, lanes z_end, lanes difference)
{
    EACH_LANE {
        const double c0 = start->drive[i], cm = middle->drive[i], c1 = end->drive[i],
                     half = exponential(-0.5 * h[i] * middle->rate[i]);
        z_middle[i] = half * start->z[i] + h[i] / 24 * (5 * c0 + 8 * cm - c1);
        z_end[i] = half * half * start->z[i] + h[i] / 6 * (c0 + 4 * cm + c1);
        difference[i] = h[i] / 3 * fabs(c0 - 2 * cm + c1);
    }
}

/* A at half and at the whole of a step, from the rates there; A never falls. */
static inline void path_of(double h, double a0, double am, double a1, double *M, double *D)
{
    const double part = h * (1. / 24);
    *D = or_none(part * (4 * a0 + 16 * am + 4 * a1), NO_PATH);
    *M = smaller(or_none(part * (5 * a0 + 8 * am - a1), NO_PATH), *D);
}

/* The target over a step, q + slope A + bend A^2, which ends at q_end; what all three points show of it (slope_seen,
 * bend_seen); and the chord, the straight one through the ends. */
struct Target {
    double q, slope, bend, q_end, slope_seen, bend_seen, chord;
    int from_reversal, to_reversal;
};

/* Through (0, q0), (M, qm), (D, q1). Where the slip reverses the rate is 0 and the bristle does not follow its target,
 * whose dip of static friction is far narrower than the step: that end is left out, and the target is straight. Step
 * doubling tells whether it may be. */
static inline struct Target target_between(const struct Point *start, const struct Point *middle,
                                           const struct Point *end, double M, double D, int i)
{
    const double per_d = D > 0 ? 1 / D : 0, a0 = start->rate[i], am = middle->rate[i], a1 = end->rate[i];
    const double q0 = start->target[i], qm = middle->target[i], q1 = end->target[i];
    const double first = M > 0 ? (qm - q0) / M : 0, last = D > M ? (q1 - qm) / (D - M) : first,
                 chord = (q1 - q0) * per_d;
    const double bend_seen = (last - first) * per_d, slope_seen = first - bend_seen * M;
    const int wide = middle->speed[i] > middle->flat_from[i];
    const int from_reversal = wide & (a0 < 1e-3 * am) & (D > M),
              to_reversal = wide & !from_reversal & (a1 < 1e-3 * am) & (M > 0);
    const double from = from_reversal ? last : first, to = to_reversal ? first : last, bend = (to - from) * per_d;
    const struct Target t = {from_reversal ? qm - to * M : q0,
                             from - bend * M,
                             bend,
                             to_reversal ? qm + from * (D - M) : q1,
                             slope_seen,
                             bend_seen,
                             chord,
                             from_reversal,
                             to_reversal};
    return t;
}

/* By exponentials. */
static void relax_bristles(int clip, const lanes h, const struct Point *start, const struct Point *middle,
                           const struct Point *end, lanes z_middle, lanes z_end, lanes difference)
{
    lanes M, D, to_M[3], to_D[3];
    int far = 0, moves = 0;
    EACH_LANE
        moves |= (start->rate[i] != 0) | (middle->rate[i] != 0) | (end->rate[i] != 0);
    if (!moves) { /* as out of contact, where nothing relaxes: to the bit what follows would make of it */
        EACH_LANE {
            z_middle[i] = z_end[i] = start->z[i];
            difference[i] = 0;
        }
        return;
    }
    EACH_LANE
        path_of(h[i], start->rate[i], middle->rate[i], end->rate[i], &M[i], &D[i]);
    both_moments(M, D, to_M, to_D);
    EACH_LANE {
        const double z = start->z[i];
        const struct Target t = target_between(start, middle, end, M[i], D[i], i);
        z_middle[i] = z + (t.q - z) * to_M[0][i] + t.slope * to_M[1][i] + t.bend * to_M[2][i];
        const double reached = z + (t.q - z) * to_D[0][i] + t.slope * to_D[1][i] + t.bend * to_D[2][i];
        /* of the target's bend, and of the rate's: it shifts D, of which only the last relaxation is remembered */
        const double shift = h[i] / 3 * fabs(start->rate[i] - 2 * middle->rate[i] + end->rate[i]) / (1 + D[i]);
        difference[i] =
            fabs((t.slope_seen - t.chord) * to_D[1][i] + t.bend_seen * to_D[2][i]) + shift * fabs(t.q_end - reached);
        z_end[i] = reached;
        far |= !((fabs(reached) <= fabs(z)) | within(start, i, reached) | within(end, i, reached));
    }
    if (clip && far) /* no bristle bends further than its largest target, which the parabola may overshoot */
        EACH_LANE {
            const double bound = larger(larger(reach_of(start, i), reach_of(end, i)), fabs(start->z[i]));
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

/* A within which the slip x, h from a reversal, comes to rest where static friction is felt: the slip is straight
 * there. */
static double near_rest(const struct Point *x, double target_at_rest, double h, int i)
{
    const double speed = x->speed[i], share = smaller(x->flat_from[i] / larger(speed, 1e-300), 2);
    const double faster =
        larger(fabs(x->target[i]) / larger(fabs(target_at_rest), 1e-300), 1); /* rate = speed/target */
    return 0.5 * x->rate[i] * h * share * share * faster;
}

void hidden_in_target(const lanes h, const struct Point *a, const struct Point *early, const struct Point *m,
                      const struct Point *late, const struct Point *b, lanes hidden)
{
    lanes at_rest[2], path; /* what is left out at an end, and A over the step */
    int reversal = 0;
    EACH_LANE {
        double M, D, quarter, half, last_quarter, last_half;
        path_of(2 * h[i], a->rate[i], m->rate[i], b->rate[i], &M, &D);
        path_of(h[i], a->rate[i], early->rate[i], m->rate[i], &quarter, &half);
        path_of(h[i], m->rate[i], late->rate[i], b->rate[i], &last_quarter, &last_half);
        const struct Target t = target_between(a, m, b, M, D, i);
        const double A_early = smaller(quarter, M), A_late = smaller(larger(half + last_quarter, M), D);
        const double miss_early = fabs(early->target[i] - (t.q + A_early * (t.slope + A_early * t.bend))),
                     miss_late = fabs(late->target[i] - (t.q + A_late * (t.slope + A_late * t.bend)));
        const double forgotten = exponential(-last_half); /* what is left of the first half at the end */
        hidden[i] = miss_early * forgotten * (1 - exponential(-half)) + miss_late * (1 - forgotten);
        reversal |= t.to_reversal | t.from_reversal;
        at_rest[0][i] = t.to_reversal ? fabs(b->target[i] - t.q_end) : 0;
        at_rest[1][i] = t.from_reversal ? fabs(a->target[i] - t.q) : 0;
        path[i] = half + last_half;
    }
    if (reversal)
        EACH_LANE {
            const double last = near_rest(late, b->target[i], 0.5 * h[i], i),
                         first = near_rest(early, a->target[i], 0.5 * h[i], i);
            hidden[i] += at_rest[0][i] * (1 - exponential(-last)) +
                         at_rest[1][i] * (1 - exponential(-first)) * exponential(-larger(path[i] - first, 0));
        }
}
