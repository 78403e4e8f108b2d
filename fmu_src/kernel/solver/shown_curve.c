/* Do the three points of a step show what the friction law does between them, so that it need not be halved?
 *
 * Where the slip is given it is straight over a step, and where the levels stand still the target is a function of the
 * speed alone: a curve as smooth as e^-(v/V)^2, of the width V = v_s, as the law says (smooth). What the parabolas of
 * integrate.c leave of it is then known ahead. The path A goes nearly by v^2, in which the curve is smooth through
 * rest, too; the third derivative of e^-x, x = (v/V)^2, bounds what a parabola of the target misses, and that of v/g(v)
 * what one of the rate does. With the step's range of x, c = |target - F_C/P| at most, T the least |target|, D the
 * path, and G how far the bristle is from its target, the end of the step is off by no more than
 *
 *     c min(1, D) (x^3 (1 + c/T) min(1 + D, 3)/50 + dv^3/(v V^2) G/T/10),
 *
 * and the force between the ends by what Simpson's rule leaves of an exponential, G D^4/2880, too. The fractions bound
 * what halving has found over 64 000 steps of random contacts; SAFETY_SHARE keeps a distance from them.
 */
#include "../stages.h"

#include <math.h>

#define SAFETY_SHARE 0.7

/* Is the slip straight, and does nothing but the law's own curve bend the rate? */
static int goes_by_speed(const struct Configuration *w)
{
    const int moved = 1 << STAGE_PATH | 1 << STAGE_ENGAGEMENT | 1 << STAGE_BRISTLE;
    return w->kinematics == KINEMATICS_EXTERNAL && w->law->relaxes && w->law->smooth && !w->bends && !w->drivers &&
           !w->looks_back && !w->by_energy && !(w->stages & moved);
}

static inline int stands(const struct Point *a, const struct Point *b, int i)
{
    return (a->F_C[i] == b->F_C[i]) & (a->F_S[i] == b->F_S[i]) & (a->P[i] == b->P[i]) & (a->s0[i] == b->s0[i]) &
           (a->v_s[i] == b->v_s[i]) & (a->limited[i] == b->limited[i]);
}

void show_curve(const struct Configuration *w, const lanes h, const struct Point *a, const struct Point *m,
                const struct Point *b, const int asked[LANES], lanes next, int shown[LANES])
{
    const int known = goes_by_speed(w);
    EACH_LANE
        shown[i] = 0;
    if (!known)
        return;
    int smooth[LANES];
    for (int i = 0; i < LANES; ++i)
        smooth[i] = asked[i] && !w->iterated[i] && w->law->smooth(w->law_p, i);
    EACH_LANE {
        const double low = smaller(smaller(a->speed[i], m->speed[i]), b->speed[i]),
                     high = larger(larger(a->speed[i], m->speed[i]), b->speed[i]);
        const double V = m->v_s[i], per = 1 / (V * V), range = high - low, sum = high + low;
        const double x = range * sum * per, of_rate = 2 * range * range * range * per / sum;
        const double at_a = fabs(a->target[i]), at_b = fabs(b->target[i]), flat = m->F_C[i] / m->P[i];
        const double c = larger(fabs(at_a - flat), fabs(at_b - flat)), T = smaller(at_a, at_b);
        const double G = larger(fabs(a->target[i] - a->z[i]), fabs(b->target[i] - b->z[i]));
        const double D = h[i] * m->rate[i], D_2 = smaller(D, 2) * smaller(D, 2);
        const double of_end =
            c * smaller(D, 1) * ((T + c) * smaller(1 + D, 3) * (x * x * x) * 0.02 + of_rate * G * 0.1) / T;
        const double z = larger(larger(fabs(a->z[i]), fabs(b->z[i])), 1e-3 * larger(flat, b->F_S[i] / b->P[i]));
        const double of_force = (of_end + G * D_2 * D_2 / 2880) * (b->s0[i] + b->s1[i] * b->rate[i]),
                     force = larger(level_of(w, b, i), fabs(b->F[i]));
        /* the principal force follows friction by 1/(cos + sin) of the rake */
        const double passed_on = smaller(w->cos_rake[i] + w->sin_rake[i], 1),
                     allowed = SAFETY_SHARE * 0.5 * w->p[VAR_RELATIVE_TOLERANCE][i];
        const double share = larger(of_end / (allowed * z), of_force / (allowed * force * passed_on));
        shown[i] = (smooth[i] != 0) & stands(a, m, i) & stands(m, b, i) & (V > 0) & (share <= 1);
        /* of fourth order and more */
        next[i] = (shown[i] & (share > 1e-3)) != 0 ? smaller(next[i], h[i] / sqrt(sqrt(larger(share, 1e-3)))) : next[i];
    }
}
