/* Is a step as good as its two halves? Step doubling, where three points may not show what lies between them.
 *
 * The measured differences of tolerance.c are those of parabolas through start, middle and end. Where the slip speed
 * changes by a large factor within the step (it comes to rest, or out of it) a friction law may rise and fall between
 * these points: static friction is felt below some v_s only, and a state of an effect renews itself at the pace of the
 * slip. There the step is taken again in two halves. So it is where a sensor has states: it follows the parabola of the
 * forces exactly, but they are none, and the second of two sensors in a row hears what the first one rings; and where
 * the shear angle is solved for, which has a kink where the flattest and the steepest plane begin.
 */
#include "../stages.h"

#include <math.h>

/* Speeds of a step that differ by more than this do not show the law between them; where static friction is felt, and
 * where a state of an effect follows the motion, whose error no difference in tolerance.c shows, by little more than 1.
 * What is left of a parabola is of third order in the step, so that a tighter tolerance than usual
 * asks for less. */
#define FACTOR 3
#define LITTLE 1.02
#define FACTOR_OF_RATE 1.2 /* of one that depends on the deflection */
#define BENT_TARGET 200    /* tolerances */
#define BENT_LEVELS 20

/* Does a state that follows the motion bend over the step, by more than this share of itself? Where it does not, a step
 * is as right as a parabola through it. */
#define STRAIGHT 0.1 /* times what the tolerance allows a force or a deflection to bend */

static int states_bend(const struct Configuration *w, double share, const struct Point *a, const struct Point *m,
                       const struct Point *b, int i)
{
    int bends = 0;
    for (int n = 0; n < w->on_count; ++n)
        for (int k = 0; w->on[n]->driver == DRIVEN_BY_MOTION && k < w->on[n]->states; ++k) {
            const lanes *const at = a->state + w->on_state[n] + k, *const mid = m->state + w->on_state[n] + k,
                               *const end = b->state + w->on_state[n] + k;
            bends |= fabs((*at)[i] - 2 * (*mid)[i] + (*end)[i]) > share * fabs((*end)[i]);
        }
    return bends;
}

/* By which the slip speed may change over a step that is believed as it is. A parabola that comes within a third of its
 * slowest point to a reversal between the points differs at them by a factor of 6 at least. */
static void doubtful_factors(const struct Contact *contact, const struct Configuration *w, const struct Point *a,
                             const struct Point *m, const struct Point *b, lanes factor)
{
    EACH_LANE {
        const double tight = w->tighter[i], usual = tight < 1 ? 1 + (FACTOR - 1) / one_over_root(3, tight) : FACTOR;
        const int bends = w->acting[i] >> DRIVEN_BY_MOTION & 1 &&
                          states_bend(w, STRAIGHT * contact->largest_difference[i], a, m, b, i);
        factor[i] = bends ? LITTLE : usual;
    }
}

static inline int changes_by(double factor, const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    return smaller(smaller(a->speed[i], m->speed[i]), b->speed[i]) * factor <
           larger(larger(a->speed[i], m->speed[i]), b->speed[i]);
}

static inline int slows_down(double factor, const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const double low = smaller(smaller(a->speed[i], m->speed[i]), b->speed[i]),
                 high = larger(larger(a->speed[i], m->speed[i]), b->speed[i]);
    return low * (low < larger(a->flat_from[i], b->flat_from[i]) ? LITTLE : factor) < high;
}

/* Does a rate that depends on the deflection change over the step, or what the bristle strives for bend? There are
 * kinks where it begins to yield, and where it is steady. */
static int yields_within(double tolerance, const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const double low = smaller(smaller(a->rate[i], m->rate[i]), b->rate[i]),
                 high = larger(larger(a->rate[i], m->rate[i]), b->rate[i]);
    return low * FACTOR_OF_RATE < high ||
           fabs(a->target[i] - 2 * m->target[i] + b->target[i]) > BENT_TARGET * tolerance * fabs(b->target[i]);
}

/* Do states of effects, or a load, bend the levels within a step over which a bristle that is stiff follows them? */
static inline int levels_bend(const struct Configuration *w, double h, const struct Point *a, const struct Point *m,
                              const struct Point *b, int i)
{
    const double bend =
        larger(fabs(a->F_C[i] - 2 * m->F_C[i] + b->F_C[i]), fabs(a->F_S[i] - 2 * m->F_S[i] + b->F_S[i]));
    return (h * m->rate[i] > 1) & (bend > BENT_LEVELS * w->p[VAR_RELATIVE_TOLERANCE][i] * larger(b->F_C[i], b->F_S[i]));
}

/* Does a level move by so much that what the bristle does behind it counts? How far it is behind goes by its rate,
 * that is by the slip and the level itself. */
static inline int levels_move(const struct Configuration *w, const struct Point *a, const struct Point *m,
                              const struct Point *b, int i)
{
    const double low = smaller(smaller(a->F_C[i], m->F_C[i]), b->F_C[i]),
                 high = larger(larger(a->F_C[i], m->F_C[i]), b->F_C[i]);
    return (high - low > BENT_LEVELS * w->p[VAR_RELATIVE_TOLERANCE][i] * high) &
           ((low * LITTLE < high) | slows_down(LITTLE, a, m, b, i));
}

/* Does a stiffness rise from next to nothing, or fall to it, as where bristles that heat had softened begin to cool?
 * The steady deflection goes by 1/P and the rate by P, and no parabolas of both make the slip of their product. */
static inline int stiffness_moves(const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    return FACTOR * smaller(smaller(a->P[i], m->P[i]), b->P[i]) < larger(larger(a->P[i], m->P[i]), b->P[i]);
}

/* Or does it bend within a step over which the bristle follows it? How far that is behind goes by the slope of its
 * steady deflection at the end, which a parabola of one over the stiffness does not have. */
static inline int stiffness_bends(const struct Configuration *w, double h, const struct Point *a, const struct Point *m,
                                  const struct Point *b, int i)
{
    const double bend = fabs(a->P[i] - 2 * m->P[i] + b->P[i]);
    return (h * m->rate[i] > 1) &
           (bend > BENT_LEVELS * w->p[VAR_RELATIVE_TOLERANCE][i] * smaller(smaller(a->P[i], m->P[i]), b->P[i]));
}

/* Friction force that is not borne. What damping adds to a bristle that comes to its steady deflection falls to a
 * hundredth and less before it is borne again: the force then shows what had been lost of it, which neither the bound
 * nor the bristle, bent nearly as far as it will, showed. */
static inline int is_bounded(const struct Point *x, int i)
{
    return (x->cutting[i] != 0) & (fabs(x->unbounded[i]) > fabs(x->F[i]));
}

static inline double unbounded_size(const struct Configuration *w, const struct Point *a, const struct Point *b, int i)
{
    return larger(level_of(w, b, i), larger(fabs(a->unbounded[i]), fabs(b->unbounded[i])));
}

/* Does it bend? */
static inline int bends_unseen(const struct Configuration *w, const struct Point *a, const struct Point *m,
                               const struct Point *b, int i)
{
    const double bend = fabs(a->unbounded[i] - 2 * m->unbounded[i] + b->unbounded[i]);
    return (is_bounded(a, i) | is_bounded(m, i) | is_bounded(b, i)) &
           (bend > BENT_LEVELS * w->p[VAR_RELATIVE_TOLERANCE][i] * unbounded_size(w, a, b, i));
}

/* Forces so far from straight, in tolerances, that what they are beside a parabola counts behind a sensor, which takes
 * means, and where they are recalled as they were. An ellipse, cut where its steps are as long as the default tolerance
 * lets them, lies below the first. */
#define CURVED 200
#define CURVED_ENOUGH_TO_RECALL 20
/* So far where the step passes a kink, which lies off the parabola by about as much as it bends the points. */
#define CURVED_BY_A_KINK 6
#define CURVED_AT_A_KINK                                                                                               \
    20 /* what has no bristle is smooth up to where it jumps or reaches a limit; and no cycle says how                 \
          long a step is where the slip is given */

static int curved(const struct Configuration *w, double by, const struct Point *a, const struct Point *m,
                  const struct Point *b, int i)
{
    const double force = larger(level_of(w, b, i), larger(fabs(a->F[i]), fabs(b->F[i])));
    const double bend = larger(fabs(a->F[i] - 2 * m->F[i] + b->F[i]) / force,
                               fabs(a->F_p[i] - 2 * m->F_p[i] + b->F_p[i]) / larger(force, fabs(b->F_p[i])));
    return bend > by * w->p[VAR_RELATIVE_TOLERANCE][i];
}

/* Does a force that moves the tool go, and come back, within the step? So it does at the turn of a swing; and where the
 * tool is held so stiffly by damping that it follows its path at once: there a step that is long beside that goes to
 * and fro, by ever a little less. */
#define SWINGS_BACK 20 /* tolerances */

static inline int swings_back(const struct Configuration *w, const struct Point *a, const struct Point *m,
                              const struct Point *b, int i)
{
    const double there = m->F[i] - a->F[i], back = m->F[i] - b->F[i];
    return (a->cutting[i] != 0) & (there * back > 0) &
           (smaller(fabs(there), fabs(back)) > SWINGS_BACK * w->p[VAR_RELATIVE_TOLERANCE][i] * fabs(m->F[i]));
}

/* Does the chip begin to pull on the tool within the step, or end to? There the normal force stops at 0. Or does a
 * force of the edge begin, or end? */
static inline int has_kink(const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const int pulls = (a->outside[i] != m->outside[i]) | (m->outside[i] != b->outside[i]),
              presses = ((a->edge_f[i] == 0) != (m->edge_f[i] == 0)) | ((m->edge_f[i] == 0) != (b->edge_f[i] == 0));
    return (a->cutting[i] != 0) & (pulls | presses);
}

/* By minimum energy the normal force goes by the root of k (k + F cos(alpha)), which is steep where this comes to 0:
 * where contact begins or ends, and where the chip pulls no more. */
#define STEEP 100

static inline double radicand(const struct Configuration *w, const struct Point *x, int i)
{
    return larger(x->k[i] * (x->k[i] + x->F[i] * w->cos_rake[i]), 0);
}

static int is_steep(const struct Configuration *w, const struct Point *a, const struct Point *m, const struct Point *b,
                    int i)
{
    const double at_a = radicand(w, a, i), at_m = radicand(w, m, i), at_b = radicand(w, b, i);
    return a->cutting[i] != 0 && STEEP * smaller(smaller(at_a, at_m), at_b) < larger(larger(at_a, at_m), at_b);
}

/* Where do kinks count that each cycle of an ellipse has, of the surface that is met and of a limit of the law? They
 * are within the usual tolerance, but where a sensor hears them, and where nothing else asks for short steps. What is
 * recalled has them as pieces of its own, of which few can be kept. */
static void count_all_kinks(const struct Configuration *w, int all[LANES])
{
    EACH_LANE
        all[i] = (w->p[VAR_RELATIVE_TOLERANCE][i] < USUAL_TOLERANCE) | !w->law->relaxes;
    for (int i = 0; w->looks_back && i < LANES; ++i)
        all[i] &= !(look_back(w, i) > 0) | !w->law->relaxes;
    for (int i = 0; w->sensors && i < LANES; ++i)
        all[i] |= sensors_that_remember(w, i) > 0;
}

/* Might a kink between the three points move the mean over a cycle? By a twelfth of what they bend, over as much of the
 * cycle as the step takes: a host's communication points may lie such that a step there is a long one. */
#define IN_MEAN 0.35 /* tolerances */
#define COMES_TO_REST 0.5 /* of the way to it, in relaxation lengths */

static inline int shows_in_mean(const struct Configuration *w, double h, const struct Point *a, const struct Point *m,
                                const struct Point *b, int i)
{
    const double bend = fabs(a->F_p[i] - 2 * m->F_p[i] + b->F_p[i]) / 12,
                 of_cycle = h * w->p[VAR_VIBRATION_FREQUENCY][i];
    return of_cycle * bend > IN_MEAN * w->p[VAR_RELATIVE_TOLERANCE][i] * level_of(w, b, i);
}

/* Does a bristle that comes to rest within the step leave a peak of force behind? Where damping is as large as sliding
 * friction, and more, the mean power of a cycle hears it, by as much of the cycle as the step takes. */
static inline int peaks_in_mean(const struct Configuration *w, double h, const struct Point *a, const struct Point *m,
                                const struct Point *b, int i)
{
    const double bend = fabs(a->F[i] - 2 * m->F[i] + b->F[i]) / 12, of_cycle = h * w->p[VAR_VIBRATION_FREQUENCY][i];
    return (h * m->rate[i] > COMES_TO_REST) &
           (of_cycle * bend > IN_MEAN * w->p[VAR_RELATIVE_TOLERANCE][i] * larger(level_of(w, b, i), fabs(b->F[i])));
}

/* Does the step pass a kink of what the effects do, or of these two? Where friction follows the thickness the surface
 * counts, too. */
static inline int changes_side(const struct Configuration *w, int all, const struct Point *a, const struct Point *m,
                               const struct Point *b, int i)
{
    const int of_surface = (w->kinematics != KINEMATICS_EXTERNAL) & (all | w->levelled[i]);
    const int effect = (a->piece[i] != m->piece[i]) | (m->piece[i] != b->piece[i]),
              limit = (a->limited[i] != m->limited[i]) | (m->limited[i] != b->limited[i]) |
                      (a->clamped[i] != m->clamped[i]) | (m->clamped[i] != b->clamped[i]),
              surface = (a->surface_piece[i] != m->surface_piece[i]) | (m->surface_piece[i] != b->surface_piece[i]);
    return (a->cutting[i] != 0) & (effect | (all & limit) | (of_surface & surface));
}

/* A force that bends one way and then the other, as it goes through 0, lies on the straight line through the three
 * points and off it in between, by a fifth of what its rate at the middle says of the chord. */
static int turns_its_bend(const struct Configuration *w, double by, double h, const struct Point *a,
                          const struct Point *m, const struct Point *b, int i)
{
    if (a->cutting[i] == 0) /* out of contact no force bends, and the law's part of a point is not set */
        return 0;
    const double force = larger(level_of(w, b, i), larger(fabs(a->F[i]), fabs(b->F[i])));
    return b->s0[i] * fabs(b->z[i] - a->z[i] - h * m->dz[i]) > 0.25 * by * w->p[VAR_RELATIVE_TOLERANCE][i] * force;
}

/* Does a deflection pass 0 whose power the rate follows? There the force of damping has a kink, which three points may
 * have between them. */
static inline int turns_over(const struct Configuration *w, const struct Point *a, const struct Point *b, int i)
{
    return (w->bent[i] != 0) & (a->cutting[i] != 0) & (a->z[i] * b->z[i] < 0);
}

/* Is a force recalled otherwise than it was, by the parabola through these points? */
static int is_recalled_otherwise(const struct Configuration *w, const struct Point *a, const struct Point *m,
                                 const struct Point *b, int i)
{
    return curved(w, CURVED_ENOUGH_TO_RECALL, a, m, b, i) || turns_over(w, a, b, i) ||
           (!w->held && changes_side(w, 1, a, m, b, i) && curved(w, CURVED_BY_A_KINK, a, m, b, i));
}

/* Does what a sensor hears bend: the forces now, and those that it is shown late? */
static int heard(const struct Contact *contact, const struct Configuration *w, double h, const struct Point *a,
                 const struct Point *m, const struct Point *b, int i)
{
    const int sensors = w->sensors > 0 ? sensors_that_remember(w, i) : 0, given = w->kinematics == KINEMATICS_EXTERNAL;
    const double bent = w->law->relaxes && !given ? CURVED : CURVED_AT_A_KINK;
    return sensors > 1 ||
           (sensors > 0 &&
            (curved(w, bent, a, m, b, i) || turns_its_bend(w, bent, h, a, m, b, i) || turns_over(w, a, b, i) ||
             (w->looks_back && look_back(w, i) > 0 &&
              3 * late_bend(contact, w, i, a, m, b) > bent * w->p[VAR_RELATIVE_TOLERANCE][i])));
}

/* May the law do something between the points that they do not show? */
static void hides_law(const struct Contact *contact, const struct Configuration *w, const lanes h,
                      const struct Point *a, const struct Point *m, const struct Point *b, lanes next,
                      int doubtful[LANES])
{
    int curved = 0, shown[LANES];
    lanes factor;
    doubtful_factors(contact, w, a, m, b, factor);
    EACH_LANE {
        doubtful[i] = (a->cutting[i] != 0) & slows_down(factor[i], a, m, b, i);
        curved |= doubtful[i];
    }
    if (curved) {
        show_curve(w, h, a, m, b, doubtful, next, shown);
        EACH_LANE
            doubtful[i] &= (shown[i] == 0) | changes_by(factor[i], a, m, b, i);
    }
    if (w->stages >> STAGE_FRICTION & 1)
        EACH_LANE
            doubtful[i] |=
                (a->cutting[i] != 0) & (w->levelled[i] != 0) &
                (levels_bend(w, h[i], a, m, b, i) | levels_move(w, a, m, b, i) | stiffness_moves(a, m, b, i) |
                 stiffness_bends(w, h[i], a, m, b, i) | bends_unseen(w, a, m, b, i));
    for (int i = 0; (w->bends || w->yields || w->current_angle) && i < LANES; ++i)
        doubtful[i] |= a->cutting[i] != 0 &&
                       (w->current_angle || (w->bent[i] && yields_within(w->p[VAR_RELATIVE_TOLERANCE][i], a, m, b, i)));
}

/* Does the way across a gap add up unseen? What Simpson's rule leaves of it over a twentieth of a cycle is within the
 * usual tolerance, and not within a tighter one. */
static inline int crosses_unseen(const struct Configuration *w, int i)
{
    return (w->acting[i] >> DRIVEN_BY_APPROACH & 1) & (w->kinematics != KINEMATICS_EXTERNAL) &
           (w->p[VAR_RELATIVE_TOLERANCE][i] < USUAL_TOLERANCE);
}

/* Does an effect pass on another part of the motion at one point than at another? What adds up with the slip shows it
 * as far as Simpson's rule does. */
#define PASSED_IN_PART 10 /* tolerances */

static inline int passes_in_part(const struct Configuration *w, const struct Point *a, const struct Point *m,
                                 const struct Point *b, int i)
{
    const double low = smaller(smaller(a->passed[i], m->passed[i]), b->passed[i]),
                 high = larger(larger(a->passed[i], m->passed[i]), b->passed[i]);
    return (a->cutting[i] != 0) & (high - low > PASSED_IN_PART * w->p[VAR_RELATIVE_TOLERANCE][i] * high);
}

/* Does Simpson's rule have to be as right as the forces? For means over a window; and for energies where a bristle
 * comes to rest within the step. */
static inline int adds_up_unseen(const struct Configuration *w, double h, const struct Point *m, int i)
{
    return (w->p[VAR_AVERAGING_WINDOW][i] > 0) | (h * m->rate[i] > COMES_TO_REST);
}

int in_doubt(const struct Contact *contact, const struct Configuration *w, const lanes h, const struct Point *a,
             const struct Point *m, const struct Point *b, lanes next, int doubtful[LANES])
{
    const int of_slip = !w->held &&
                        (w->law->relaxes || w->bends || w->drivers || w->current_angle || w->stages >> STAGE_SHEAR & 1),
              given = w->kinematics == KINEMATICS_EXTERNAL;
    int any = 0, adds_up = 0, cuts = 0, all[LANES] = {0};
    EACH_LANE {
        doubtful[i] = 0;
        cuts |= a->cutting[i] != 0;
    }
    if (!cuts && !given && !w->sensors && !w->looks_back)
        return 0; /* out of contact there is nothing else to miss */
    if (of_slip)
        hides_law(contact, w, h, a, m, b, next, doubtful);
    EACH_LANE {
        doubtful[i] |= has_kink(a, m, b, i) | crosses_unseen(w, i);
        doubtful[i] |= !given & (w->law->relaxes != 0) & (a->cutting[i] != 0) & peaks_in_mean(w, h[i], a, m, b, i);
    }
    for (int i = 0; given && i < LANES; ++i)
        adds_up |= adds_up_unseen(w, h[i], m, i);
    for (int i = 0; (w->feedback || w->drivers) && i < LANES; ++i)
        doubtful[i] |= (w->feedback && swings_back(w, a, m, b, i)) ||
                       (w->acting[i] >> DRIVEN_BY_APPROACH & 1 && passes_in_part(w, a, m, b, i));
    if (!w->held) {
        count_all_kinks(w, all);
        EACH_LANE
            doubtful[i] |= changes_side(w, all[i] || (!given && shows_in_mean(w, h[i], a, m, b, i)), a, m, b, i);
    }
    for (int i = 0; (adds_up || w->sensors || w->looks_back || w->by_energy) && i < LANES; ++i)
        doubtful[i] |= (given && adds_up_unseen(w, h[i], m, i) && curved(w, CURVED_AT_A_KINK, a, m, b, i)) ||
                       heard(contact, w, h[i], a, m, b, i) || (w->by_energy && is_steep(w, a, m, b, i)) ||
                       (w->looks_back && look_back(w, i) > 0 && is_recalled_otherwise(w, a, m, b, i));
    EACH_LANE {
        doubtful[i] &= h[i] > 0;
        any |= doubtful[i];
    }
    return any;
}

/* Errors of many steps add up in a sensor that rings on: each may be this much smaller. What is recalled adds to
 * nothing. */
#define SENSORS_REMEMBER 5
#define RECALLED_ONCE 0.25

/* Means over a step by Simpson's rule, of what its points and of what those and its quarters show. */
static inline double simpson(double a, double m, double b) { return (a + 4 * m + b) / 6; }
static inline double simpson_of_halves(double a, double early, double m, double late, double b)
{
    return (a + 4 * early + 2 * m + 4 * late + b) / 12;
}

/* In units of the tolerance, as tolerance.c has them. */
static double apart(double x, double y, double scale) { return fabs(x - y) / scale; }

/* The forces at start, quarters and end of a step. */
struct Forces {
    const lanes *at[CHANNELS][5];
};

static struct Forces forces_of(const struct Point *a, const struct Point *early, const struct Point *m,
                               const struct Point *late, const struct Point *b)
{
    return (struct Forces){{{&a->F, &early->F, &m->F, &late->F, &b->F},
                            {&a->F_p, &early->F_p, &m->F_p, &late->F_p, &b->F_p},
                            {&a->F_f, &early->F_f, &m->F_f, &late->F_f, &b->F_f}}};
}

/* At the quarters beside the parabola through start, middle and end, which is what is kept of them; and their mean by
 * Simpson's rule. A brief step adds to a mean by its length: so does the size of a peak of which it is a part, beside
 * the level, which the whole mean is measured by. */
static void force_errors(const struct Configuration *w, const struct Forces *forces, const lanes share,
                         const struct Point *b, lanes recalled, lanes of_mean)
{
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE {
            double u[5];
            for (int n = 0; n < 5; ++n)
                u[n] = (*forces->at[k][n])[i];
            const double level = level_of(w, b, i), force = larger(level, larger(fabs(u[0]), fabs(u[4])));
            const double first = apart(parabola(0.25, u[0], u[2], u[4]), u[1], force),
                         last = apart(parabola(0.75, u[0], u[2], u[4]), u[3], force);
            recalled[i] = larger(recalled[i], larger(first, last));
            of_mean[i] =
                larger(of_mean[i], apart(simpson(u[0], u[2], u[4]), simpson_of_halves(u[0], u[1], u[2], u[3], u[4]),
                                         larger(level, share[i] * force)));
        }
}

/* Behind the sensors, after a step and after its halves. */
static void sensor_error(const struct Contact *contact, const struct Configuration *w, const lanes h, const lanes step,
                         const struct Point *a, const struct Point *m, const struct Point *b, struct Point *early,
                         struct Point *half, struct Point *late, struct Point *whole, lanes error)
{
    struct Point middle = *m, end = *b;
    measure_step(contact, w, h, a, &middle, &end);
    measure_step(contact, w, step, a, early, half);
    measure_step(contact, w, step, half, late, whole);
    EACH_LANE
        error[i] = 0;
    for (int k = 0; k < CHANNELS; ++k)
        EACH_LANE {
            const double force =
                larger(level_of(w, b, i), larger(fabs(end.measured[k][i]), fabs(whole->measured[k][i])));
            error[i] = larger(error[i], apart(end.measured[k][i], whole->measured[k][i], force));
        }
}

#define OF_MOTION 0.3 /* where a force shows a state it says how right it has to be */
#define BY_FORCE 5 /* where none does before the contact gives way, it does so as much too late as the state is off */

/* Of the states of one driver, as shares of their nominal or of themselves. Where the slip is solved for no event says
 * that it turns, and from there on a state that forces drive may go the other way. What a state that follows the motion
 * misses while a level is at its floor no force shows before it comes off it. */
static double state_error(const struct Configuration *w, enum Driver driver, const struct Point *b,
                          const struct Point *whole, int i)
{
    double worst = 0;
    for (int n = 0; n < w->on_count; ++n) {
        const struct Effect *const effect = w->on[n];
        for (int k = 0; driver_of(w, effect) == driver && k < effect->states; ++k) {
            const double nominal = effect->variables[effect->count - 2 * effect->states + k].nominal,
                         here = b->state[w->on_state[n] + k][i], there = whole->state[w->on_state[n] + k][i];
            worst = larger(worst, apart(here, there, larger(nominal > 0 ? nominal : 1, fabs(here))));
        }
    }
    return worst;
}

/* By Simpson's rule, of the motion, of which the contact gets the part that is passed on. */
static double way_of_motion(double h, const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    return h * simpson(a->speed[i] / a->passed[i], m->speed[i] / m->passed[i], b->speed[i] / b->passed[i]);
}

/* Of the way that the contact slips, what do the points of a step not show: those at its quarters to the bristle [m],
 * and start, middle and end to what adds up with it, as a share of the way of the motion? */
struct UnseenWay {
    double to_bristle, in_sums;
};

static struct UnseenWay unseen_way(const struct Configuration *w, double h, const struct Point *a,
                                   const struct Point *early, const struct Point *m, const struct Point *late,
                                   const struct Point *b, int i)
{
    struct UnseenWay most = {0, 0};
    const int bends = a->drive[i] != 0 || m->drive[i] != 0 || b->drive[i] != 0;
    for (int n = 0; n < w->on_count; ++n) {
        const int at = w->on_state[n];
        if (!w->on[n]->slip_way || a->cutting[i] == 0)
            continue;
        const double seen = h * simpson_of_halves(a->v[i], early->v[i], m->v[i], late->v[i], b->v[i]),
                     added = h * simpson(a->v[i], m->v[i], b->v[i]);
        const double way = w->on[n]->slip_way(w->on_p[n], h, a, m, b, a->state + at, b->state + at, seen, i);
        most.to_bristle = larger(most.to_bristle, bends ? fabs(way - seen) : 0);
        most.in_sums = larger(most.in_sums, fabs(way - added) / way_of_motion(h, a, m, b, i));
    }
    return most;
}

/* What adds up counts as far as the step does: where force and load both begin at 0 no step of a cycle is so short that
 * the slip does not move by some thousandths. */
#define COUNTS 0.1 /* of the longest step */

static double counts(const struct Configuration *w, double h, int i)
{
    return w->longest[i] < INFINITY ? smaller(h / (COUNTS * w->longest[i]), 1) : 1;
}

/* How far is the mean slip speed by Simpson's rule from that with the quarters, where the slip is solved for, which
 * bends as its shear angle does, whatever the friction force? As a share of how fast the tool moves. */
static double mean_slip_error(const struct Configuration *w, const struct Point *a, const struct Point *early,
                              const struct Point *m, const struct Point *late, const struct Point *b, int i)
{
    const double tool = larger(larger(fabs(a->u_x[i]), fabs(a->u_y[i])), larger(fabs(b->u_x[i]), fabs(b->u_y[i])));
    if (!w->current_angle || a->cutting[i] == 0 || !(tool > 0))
        return 0;
    return apart(simpson(a->speed[i], m->speed[i], b->speed[i]),
                 simpson_of_halves(a->speed[i], early->speed[i], m->speed[i], late->speed[i], b->speed[i]), tool);
}

/* An event at the quarters, which start, middle and end do not show, has happened twice: as where the slip comes out of
 * a band of sticking when a gap closes, and falls back into it. As an error it asks for a step of half the length; for
 * a moment beside an event that has just been acted upon it is of roundings. */
#define UNSEEN_EVENT 32

void step_doubling_error(const struct Contact *contact, const struct Configuration *w, double shortest,
                         const int doubtful[LANES], const struct Feedback *known, const lanes s, const lanes h,
                         const struct Point *a, const struct Point *m, const struct Point *b, lanes error)
{
    struct Point early, half, late, whole;
    lanes share, step, hidden = {0}, behind = {0}, recalled = {0}, of_mean = {0};
    force_shares(w, h, share);
    EACH_LANE
        step[i] = doubtful[i] ? 0.5 * h[i] : 0;
    try_halves(contact, w, s, step, known, a, m, b, &early, &half, &late, &whole);
    if (w->law->relaxes && !w->current_angle)
        hidden_in_target(step, a, &early, &half, &late, b, hidden);
    const struct Forces forces = forces_of(a, &early, m, &late, b);
    force_errors(w, &forces, share, b, recalled, of_mean);
    if (w->sensors)
        sensor_error(contact, w, h, step, a, m, b, &early, &half, &late, &whole, behind);
    lanes beside = {0}; /* what is asked of few: levels that states of effects have moved, and that the force shows only
                           later, as where it sticks; states that forces drive; what is recalled; what sensors hear */
    for (int i = 0; (w->drivers || w->looks_back) && i < LANES; ++i) {
        const double highest = larger(b->F_C[i], b->F_S[i]), most = larger(highest, fabs(b->F[i]));
        const double levels =
            w->acting[i] ? larger(apart(b->F_C[i], whole.F_C[i], most), apart(b->F_S[i], whole.F_S[i], most)) : 0;
        const double by_force = w->current_angle && w->acting[i] >> DRIVEN_BY_FORCE & 1
                                    ? BY_FORCE * state_error(w, DRIVEN_BY_FORCE, b, &whole, i)
                                    : 0;
        const double by_approach =
            w->acting[i] >> DRIVEN_BY_APPROACH & 1 ? BY_FORCE * state_error(w, DRIVEN_BY_APPROACH, b, &whole, i) : 0;
        const double by_motion =
            w->acting[i] >> DRIVEN_BY_MOTION & 1 ? OF_MOTION * state_error(w, DRIVEN_BY_MOTION, b, &whole, i) : 0;
        const double driven = larger(larger(by_force, by_approach), by_motion);
        const double remembered = w->looks_back && look_back(w, i) > 0 ? RECALLED_ONCE * recalled[i] : 0;
        const double heard = w->sensors && sensors_that_remember(w, i) > 0 ? SENSORS_REMEMBER * behind[i] : 0;
        beside[i] = larger(larger(levels, driven), larger(remembered, heard));
    }
    if (w->stages >> STAGE_FRICTION & 1)
        EACH_LANE
            beside[i] =
                larger(beside[i],
                       is_bounded(b, i) ? apart(b->unbounded[i], whole.unbounded[i], unbounded_size(w, a, b, i)) : 0);
    EACH_LANE {
        const double reach = larger(b->F_C[i], b->F_S[i]) / b->P[i], force = larger(level_of(w, b, i), fabs(b->F[i]));
        const double z = larger(larger(fabs(a->z[i]), fabs(b->z[i])), 1e-3 * reach);
        const struct UnseenWay unseen = unseen_way(w, h[i], a, &early, m, &late, b, i);
        const double of_z = apart(b->z[i], whole.z[i], z) + (hidden[i] + unseen.to_bristle) / z;
        const double of_force =
            larger(apart(b->F[i], whole.F[i], force), apart(b->F_p[i], whole.F_p[i], larger(force, fabs(b->F_p[i]))));
        const double added = counts(w, h[i], i), of_slip = added * mean_slip_error(w, a, &early, m, &late, b, i);
        const double worst = larger(larger(larger(beside[i], added * unseen.in_sums), of_z),
                                    share[i] * larger(larger(of_force, of_mean[i]), of_slip));
        error[i] = doubtful[i] ? worst / (0.5 * w->p[VAR_RELATIVE_TOLERANCE][i]) : 0;
    }
    for (int i = 0; i < LANES; ++i) {
        const double moment = larger(1e3 * shortest, w->longest[i] < INFINITY ? 1e-8 * w->longest[i] : 0);
        const int unseen = doubtful[i] && h[i] > moment && shows_slip_event(contact, w, i, &early, &late);
        error[i] = unseen ? larger(error[i], UNSEEN_EVENT) : error[i];
    }
}
