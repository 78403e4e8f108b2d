/* Is a step as good as its two halves? Step doubling, where three points may not show what lies between them.
 *
 * The measured differences of tolerance.c are those of parabolas through start, middle and end. Where the slip speed changes by a large
 * factor within the step (it comes to rest, or out of it) a friction law may rise and fall between these points: static friction is felt
 * below some v_s only, and a state of an effect renews itself at the pace of the slip. There the step is taken again in two halves.
 */
#include "stages.h"

#include <math.h>

/* Speeds of a step that differ by more than this do not show the law between them; where static friction is felt, by little more than 1. */
#define FACTOR 3
#define LITTLE 1.02

static int slows_down(const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const double low = smaller(smaller(a->speed[i], m->speed[i]), b->speed[i]), high = larger(larger(a->speed[i], m->speed[i]), b->speed[i]);
    return low * (low < larger(a->flat_from[i], b->flat_from[i]) ? LITTLE : FACTOR) < high;
}

/* Does the slip come near to a reversal between the points, by the parabola through them? */
static int dips(const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const double v_0 = a->v[i], v_m = m->v[i], v_1 = b->v[i], slope = 4 * v_m - 3 * v_0 - v_1, bend = 2 * (v_0 - 2 * v_m + v_1);
    const double at = -slope / (2 * bend), turn = v_0 + 0.5 * slope * at; /* share of the step, and the slip there */
    const double least = smaller(smaller(fabs(v_0), fabs(v_m)), fabs(v_1));
    return at > 0 && at < 1 && turn * (v_m < 0 ? -1 : 1) * FACTOR < least;
}

int in_doubt(const struct Wiring *w, const lanes h, const struct Point *a, const struct Point *m, const struct Point *b, int doubtful[LANES])
{
    int any = 0;
    for (int i = 0; i < LANES; ++i)
        doubtful[i] = 0;
    if (w->held || !(w->law->relaxes || w->bends || w->drivers))
        return 0;
    for (int i = 0; i < LANES; ++i) {
        doubtful[i] = h[i] > 0 && a->cutting[i] != 0 && (slows_down(a, m, b, i) || dips(a, m, b, i));
        any |= doubtful[i];
    }
    return any;
}

/* In units of the tolerance, as tolerance.c has them. */
static double apart(double x, double y, double scale) { return fabs(x - y) / scale; }

void step_doubling_error(const struct Contact *contact, const struct Wiring *w, const int doubtful[LANES], const lanes s, const lanes h,
                         const struct Point *a, const struct Point *m, const struct Point *b, lanes error)
{
    struct Point early, half, late, whole;
    lanes step, from, ignored, hidden = {0};
    EACH_LANE {
        step[i] = doubtful[i] ? 0.5 * h[i] : 0;
        from[i] = s[i] + step[i];
    }
    try_step(contact, w, s, step, a, &early, &half, ignored);
    try_step(contact, w, from, step, &half, &late, &whole, ignored);
    if (w->law->relaxes && !w->current_angle)
        hidden_in_target(step, a, &early, &half, &late, b, hidden);
    for (int i = 0; i < LANES; ++i) {
        const double force = larger(larger(b->F_C[i], b->F_S[i]), fabs(b->F[i])), reach = larger(b->F_C[i], b->F_S[i]) / b->P[i];
        const double z = larger(larger(fabs(a->z[i]), fabs(b->z[i])), 1e-3 * reach);
        const double worst = larger(apart(b->z[i], whole.z[i], z) + hidden[i] / z,
                                    larger(apart(b->F[i], whole.F[i], force), apart(b->F_p[i], whole.F_p[i], larger(force, fabs(b->F_p[i])))));
        error[i] = doubtful[i] ? worst / (0.5 * w->p[RELATIVE_TOLERANCE][i]) : 0;
    }
    (void)m;
}
