/* Is a step within the tolerance, and how long may the next one be? */
#include "../stages.h"

#include <math.h>

/* How much a lower order would change, and in which units: deflection, friction force, principal force, feed force.
 * `share` of the forces' that counts; `reach` of a loaded bristle. */
struct Change {
    double of[4], in[4];
};

/* Does a force act across the cut that the other two do not show? */
static inline int loads_feed(const struct Configuration *w) { return w->stages >> STAGE_LOAD & 1; }

static inline struct Change change(const struct Configuration *w, int i, int feed, double share, const struct Point *a,
                                   const struct Point *m, const struct Point *b, double difference, double reach)
{
    const double force = level_of(w, a, i);
    const double z = larger(larger(fabs(a->z[i]), fabs(b->z[i])), 1e-3 * reach);
    const double F = larger(larger(fabs(a->F[i]), fabs(b->F[i])), force),
                 F_p = larger(larger(fabs(a->F_p[i]), fabs(b->F_p[i])), force),
                 F_f = larger(larger(fabs(a->F_f[i]), fabs(b->F_f[i])), force);
    return (struct Change){{difference, share * fabs(a->F[i] - 2 * m->F[i] + b->F[i]),
                            share * fabs(a->F_p[i] - 2 * m->F_p[i] + b->F_p[i]),
                            share * (feed * fabs(a->F_f[i] - 2 * m->F_f[i] + b->F_f[i]))},
                           {z, 3 * F, 3 * F_p, 3 * F_f}};
}

/* How far a step is from the tolerance: 1 is just right. The measured differences are those of a second-order solution,
 * h^3; the step's own error is of h^5 and taken as a tenth of their power 5/3. */
static inline double badness(const struct Contact *contact, const struct Configuration *w, int i, int feed,
                             double share, const struct Point *a, const struct Point *m, const struct Point *b,
                             double difference, double of_late)
{
    const struct Change c = change(w, i, feed, share, a, m, b, difference, larger(a->F_C[i], a->F_S[i]) / b->P[i]);
    const double worst =
        larger(larger(c.of[0] / c.in[0], c.of[1] / c.in[1]), larger(c.of[2] / c.in[2], c.of[3] / c.in[3]));
    return a->cutting[i] == 0 ? of_late : larger(worst / contact->largest_difference[i], of_late);
}

/* A step may grow fourfold where its badness is below this. */
#define WELL_WITHIN 0.011

/* Is the badness surely below in every lane? By products, which are cheaper than quotients. */
static int all_well_within(const struct Contact *contact, const struct Configuration *w, int feed, const lanes share,
                           const struct Point *a, const struct Point *m, const struct Point *b, const lanes difference)
{
    int beyond = 0;
    EACH_LANE {
        const struct Change c = change(w, i, feed, share[i], a, m, b, difference[i], 0);
        const double allowed = 0.99 * WELL_WITHIN * contact->largest_difference[i];
        const double excess = larger(larger(c.of[0] - allowed * c.in[0], c.of[1] - allowed * c.in[1]),
                                     larger(c.of[2] - allowed * c.in[2], c.of[3] - allowed * c.in[3]));
        beyond |= (a->cutting[i] != 0) & !(excess <= 0);
    }
    return !beyond;
}

/* Of a ripple within a step, at a tolerance of 0.1: more would not show how it bends. What a stiff bristle lags behind
 * it is of third order. */
#define MOST_PERIODS 0.6

/* A level may rise so many times within a step before an event that hangs on it: as the tool enters, friction that
 * follows the load rises from next to nothing, and a bristle may outrun it between the points of a longer step. */
#define MOST_RISE 2

/* How far beyond that, as badness. */
static double rise_of_level(const struct Point *a, const struct Point *m, const struct Point *b, int i)
{
    const double rise = larger(m->F_C[i], b->F_C[i]) / a->F_C[i];
    if (!(a->cutting[i] != 0 && rise > MOST_RISE))
        return 0;
    const double doublings = log(rise) / log(MOST_RISE);
    return doublings * doublings * doublings;
}

/* What swings under forces that it moves may be excited by them, and then magnifies what steps leave of its swing,
 * which is too small to be seen beside the forces. Where these bend by more than QUIET_BEND tolerances over its longest
 * step, that is as much shorter as the tolerance asks of a method of fourth order. */
#define QUIET_BEND 0.1

static double swings(const struct Configuration *w, int i, int feed, double h, const struct Point *a,
                     const struct Point *m, const struct Point *b)
{
    const double tolerance = w->p[VAR_RELATIVE_TOLERANCE][i];
    if (tolerance >= USUAL_TOLERANCE)
        return 0;
    const struct Change c = change(w, i, feed, 1, a, m, b, 0, 0);
    const double bend = 3 * larger(larger(c.of[1] / c.in[1], c.of[2] / c.in[2]), c.of[3] / c.in[3]);
    double part = 0;
    for (int n = 0; n < w->on_count; ++n)
        if (w->on[n]->driver == DRIVEN_BY_FORCE && w->on[n]->longest_step)
            part = larger(part, h / w->on[n]->longest_step(w->on_p[n], i));
    const double finer = w->finer[i];
    return bend > QUIET_BEND * tolerance * part * part ? part * part * part * finer * finer * finer : 0;
}

/* Where the badness itself is asked for. */
static int accurate_by(const struct Contact *contact, const struct Configuration *w, double shortest, int eventful,
                       const lanes share, const lanes h, const struct Point *start, const struct Point *middle,
                       const struct Point *end, const lanes difference, lanes next, int fits[LANES])
{
    const int feed = loads_feed(w);
    int all = 1, coarse = 0;
    lanes of_late = {0}, bad, factor;
    for (int i = 0; w->looks_back && i < LANES; ++i)
        of_late[i] = late_bend(contact, w, i, start, middle, end) / contact->largest_difference[i];
    for (int i = 0; w->comes_back && i < LANES; ++i) {
        const double part = periods_between(w, i, start, end) / MOST_PERIODS;
        of_late[i] = larger(of_late[i], part * part * part / (10 * w->p[VAR_RELATIVE_TOLERANCE][i]));
    }
    for (int i = 0; eventful && i < LANES; ++i)
        of_late[i] = larger(of_late[i], rise_of_level(start, middle, end, i));
    for (int i = 0; w->feedback && i < LANES; ++i)
        of_late[i] = larger(of_late[i], swings(w, i, feed, h[i], start, middle, end));
    EACH_LANE {
        bad[i] = badness(contact, w, i, feed, share[i], start, middle, end, difference[i], of_late[i]);
        factor[i] = 4;
        coarse |= bad[i] > WELL_WITHIN;
    }
    if (coarse)
        EACH_LANE
            factor[i] = bad[i] > WELL_WITHIN ? 0.9 * one_over_root(3, bad[i]) : 4;
    EACH_LANE {
        const double changed = h[i] * smaller(larger(factor[i], 0.1), bad[i] > 1 ? 0.7 : 4);
        const int shortest_of_all = (h[i] <= shortest) & (bad[i] > 1) & (bad[i] < INFINITY);
        /* a step that was short because it had to end somewhere says nothing against a longer one */
        const double wanted = smaller(factor[i] < 1 ? changed : larger(changed, next[i]), w->longest[i]);
        next[i] = shortest_of_all ? next[i] : bad[i] > 1 ? larger(wanted, shortest) : wanted;
        fits[i] = shortest_of_all | (bad[i] <= 1);
        all &= fits[i];
    }
    return all;
}

int accurate(const struct Contact *contact, const struct Configuration *w, double shortest, const lanes h,
             const struct Point *start, const struct Point *middle, const struct Point *end, const lanes difference,
             lanes next, int fits[LANES])
{
    const int eventful = w->law->event != NULL && w->stages >> STAGE_FRICTION & 1;
    lanes share;
    force_shares(w, h, share);
    if (w->looks_back || w->comes_back || eventful || w->feedback ||
        !all_well_within(contact, w, loads_feed(w), share, start, middle, end, difference))
        return accurate_by(contact, w, shortest, eventful, share, h, start, middle, end, difference, next, fits);
    EACH_LANE
        next[i] = smaller(larger(4 * h[i], next[i]), w->longest[i]);
    return 1;
}

int accurate_in_halves(const struct Contact *contact, const struct Configuration *w, double shortest,
                       const struct Feedback *known, const lanes s, const lanes h, const struct Point *start,
                       const struct Point *middle, const struct Point *end, const int doubtful[LANES], lanes next,
                       int fits[LANES])
{
    int all = 1;
    lanes error;
    step_doubling_error(contact, w, shortest, doubtful, known, s, h, start, middle, end, error);
    EACH_LANE {
        /* the error of a step is of fifth order; beyond the tolerance that says little, and halves are tried */
        const double factor = error[i] > 1e-3 ? 0.9 * one_over_root(5, error[i]) : 4;
        const int shortest_of_all = (error[i] > 1) & (h[i] <= shortest), fit = (error[i] <= 1) | shortest_of_all;
        const double wanted = fit ? smaller(next[i], h[i] * factor) : h[i] * larger(smaller(factor, 0.5), 0.1);
        const double asked = error[i] > 1 ? larger(wanted, shortest) : wanted;
        next[i] = (doubtful[i] == 0) | shortest_of_all ? next[i] : asked;
        fits[i] = (doubtful[i] == 0) | fit;
        all &= fits[i];
    }
    return all;
}
