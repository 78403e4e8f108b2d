/* What does the friction law get to see, and what does it answer? Opens its fields, lets effects act on them, closes
 * their limits. */
#include "solver/root.h"
#include "stages.h"

#include <math.h>

/* The paper, eq. 3, turned round. */
static double of_temperature(const struct Contact *contact, const struct Configuration *w, int i, double tau,
                             struct Point *x)
{
    const lanes *p = w->p;
    const double rise = input_at(contact, VAR_CONTACT_TEMPERATURE, i, tau) - p[VAR_AMBIENT_TEMPERATURE][i];
    const double share = rise / (p[VAR_REFERENCE_TEMPERATURE][i] - p[VAR_AMBIENT_TEMPERATURE][i]);
    x->clamped[i] += share < 0;
    x->warnings |= share < 0 ? WARN_TEMPERATURE : 0u;
    return p[VAR_THETA_REF][i] * power_of(larger(share, 0), 1 / p[VAR_ALPHA_T][i]);
}

INLINED void proxy_open(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    const int given = w->proxy_source == PROXY_IS_CUTTING_SPEED ? VAR_CUTTING_SPEED : VAR_PROXY_SPEED;
    x->warnings = 0;
    EACH_LANE {
        x->clamped[i] = 0;
        x->speed[i] = larger(x->direction[i] * x->v[i], 0);
        x->theta[i] = x->speed[i];
        x->theta_given[i] =
            x->cutting[i] * x->speed[i]; /* a speed of slip says nothing of heat where nothing touches */
    }
    if (w->proxy_source == PROXY_IS_SLIP_SPEED)
        return;
    EACH_LANE {
        const int hot = w->proxy_source == PROXY_IS_TEMPERATURE;
        x->theta[i] = x->theta_given[i] =
            hot ? of_temperature(contact, w, i, tau[i], x) : larger(input_at(contact, given, i, tau[i]), 0);
    }
}

/* Of friction, what a law's bristles need to be bent at all where nothing is borne. They yield the faster the less that
 * is: far below this it would go by the roundings of the moment at which a chip ends how much of them is left. */
#define LEAST_SHARE 1e-4

/* What is borne bounds the laws' limits, so that bristles yield at it, and the force, in which damping and viscous
 * friction stand beside the bristles. With limits no larger than that the bounded force still takes energy: as v > 0,
 * s0 z dz/dt <= g(v)/4 v <= most v. */
static void bound_levels(struct Point *x)
{
    EACH_LANE {
        const double most = chosen_of(x->direction[i] < 0, x->most_against[i], x->most_along[i]);
        x->piece[i] = 4 * x->piece[i] + 2 * (most < x->F_C[i]) + (most < x->F_S[i]);
        x->F_C[i] = larger(smaller(x->F_C[i], most), LEAST_SHARE * x->F_C[i]);
        x->F_S[i] = larger(smaller(x->F_S[i], most), LEAST_SHARE * x->F_S[i]);
    }
}

static void bound_force(struct Point *x)
{
    EACH_LANE {
        x->unbounded[i] = x->F[i];
        x->F[i] = larger(smaller(x->F[i], x->most_along[i]), -x->most_against[i]);
    }
}

static void set_level(const struct Configuration *w, struct Point *x)
{
    lanes as_it_is;
    EACH_LANE
        as_it_is[i] = 1;
    w->law->level(w->law_p, as_it_is, x);
}

/* What raises a level that answers to the load by itself raises what it is in proportion to. */
static void act_on_levels(const struct Configuration *w, struct Point *x)
{
    lanes before, raised, static_share;
    EACH_LANE
        before[i] = x->F_C[i];
    act(w, STAGE_FRICTION, x);
    if (!w->law->level)
        return;
    EACH_LANE {
        raised[i] = before[i] > 0 ? x->F_C[i] / before[i] : 1;
        static_share[i] = x->F_C[i] > 0 ? x->F_S[i] / x->F_C[i] : 1;
    }
    w->law->level(w->law_p, raised, x);
    EACH_LANE
        x->F_S[i] = static_share[i] * x->F_C[i];
}

INLINED void friction_open(const struct Contact *contact, const struct Configuration *w, const lanes tau,
                           struct Point *x)
{
    const lanes *p = w->p;
    const double *const F_S = p[w->law->has_static ? VAR_F_S : VAR_F_C];
    EACH_LANE {
        x->sticking[i] = x->limited[i] = 0;
        x->applied[i] = input_at(contact, VAR_APPLIED_FORCE, i, tau[i]);
        x->F_C[i] = p[VAR_F_C][i];
        x->F_S[i] = F_S[i];
        x->v_s[i] = p[VAR_V_S][i];
        x->P[i] = x->s0[i] = p[VAR_SIGMA0][i];
        x->s1[i] = p[VAR_SIGMA1][i];
        x->sigma2[i] = p[VAR_SIGMA2][i];
        x->margin[i] = w->dissipative ? p[VAR_DAMPING_MARGIN][i] : INFINITY;
        x->flat_from[i] = INFINITY;
    }
    x->configuration = w;
    if (w->law->level)
        set_level(w, x);
    if (w->stages >> STAGE_FRICTION & 1) {
        EACH_LANE {
            x->beside[i] = 0;
            x->most_along[i] = x->most_against[i] = INFINITY;
        }
        act_on_levels(w, x);
        for (int i = 0; !w->law->has_static && i < LANES; ++i)
            x->F_S[i] = x->F_C[i];
        bound_levels(x);
    }
    int softest = 0;
    EACH_LANE {
        const double floor = p[VAR_STIFFNESS_FLOOR][i] * p[VAR_SIGMA0][i];
        const int below = x->s0[i] < floor;
        x->clamped[i] += below;
        softest |= below;
        x->s0[i] = larger(x->s0[i], floor); /* the paper, eq. 7 */
    }
    if (w->thermal_rate)
        EACH_LANE
            x->P[i] = x->s0[i];
    x->warnings |= softest ? WARN_STIFFNESS_FLOOR : 0u;
    if (w->stages >> STAGE_BRISTLE & 1)
        EACH_LANE
            x->open_piece[i] = x->piece[i];
}

/* Out of contact nothing drives the bristles: they relax, or (release_time 0) were let go at separation. */
INLINED void friction_rates(const struct Configuration *w, struct Point *x)
{
    w->law->rates(w->law_p, x);
    if (w->stages >> STAGE_BRISTLE & 1)
        EACH_LANE
            x->steady[i] = x->cutting[i] != 0 ? x->target[i] : 0;
    if (w->yields)
        w->law->yield(w->law_p, x);
    if (w->stages >> STAGE_BRISTLE & 1) {
        EACH_LANE {
            x->kept[i] = 1;
            x->instead[i] = 0;
            x->piece[i] = x->open_piece[i];
        }
        act(w, STAGE_BRISTLE, x);
    }
    int apart = 0;
    EACH_LANE
        apart |= x->cutting[i] == 0;
    if (!apart)
        return;
    EACH_LANE {
        const double release_time = or_none(w->p[VAR_RELEASE_TIME][i], NO_TIME),
                     release = release_time > 0 ? 1 / release_time : 0;
        x->rate[i] = x->cutting[i] == 0 ? release : x->rate[i];
        x->drive[i] = x->cutting[i] == 0 ? 0 : x->drive[i];
        x->target[i] = x->cutting[i] == 0 ? 0 : x->target[i];
    }
}

/* The law's force with the share of its bristle that stands, and what stands instead of the rest. */
static void force_in_part(const struct Configuration *w, struct Point *x)
{
    lanes z, dz;
    EACH_LANE {
        z[i] = x->z[i];
        dz[i] = x->dz[i];
        x->z[i] *= x->kept[i];
        x->dz[i] *= x->kept[i];
    }
    w->law->force(w->law_p, x);
    EACH_LANE { /* a law may carry its bristle along, and does where all of it stands */
        x->z[i] = chosen_of(x->kept[i] != 1, z[i], x->z[i]);
        x->dz[i] = chosen_of(x->kept[i] != 1, dz[i], x->dz[i]);
        x->F[i] += x->instead[i];
    }
}

INLINED void friction_force(const struct Configuration *w, struct Point *x)
{
    EACH_LANE
        x->dz[i] = x->drive[i] - x->rate[i] * x->z[i];
    if (w->stages >> STAGE_BRISTLE & 1)
        force_in_part(w, x);
    else
        w->law->force(w->law_p, x);
    if (w->stages >> STAGE_FRICTION & 1)
        EACH_LANE
            x->F[i] += x->beside[i];
    if (w->stages >> STAGE_FRICTION & 1)
        bound_force(x);
    if (w->current_angle)
        EACH_LANE
            x->F[i] = x->sticking[i] != 0 ? x->F_stick[i] : x->F[i];
    EACH_LANE
        x->F[i] *= x->cutting[i];
}

/* What of a motion reaches the contact goes by the way that the slip itself turns, which is tried for. */
static void part_passed_on(const struct Configuration *w, struct Point *x)
{
    if (!(w->stages >> STAGE_ENGAGEMENT & 1))
        return;
    EACH_LANE
        x->passed[i] = 1;
    act(w, STAGE_ENGAGEMENT, x);
}

/* The slip that reaches the contact with this tangent of the shear angle less the rake angle. */
static void slip_passed_on(const struct Configuration *w, const lanes tan_flow, struct Point *x)
{
    EACH_LANE
        x->v[i] = slip_along_rake(w, x, i, tan_flow[i]);
    part_passed_on(w, x);
    EACH_LANE
        x->v[i] *= x->passed[i];
}

static void answer(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    EACH_LANE {
        x->direction[i] = x->v[i] < 0 ? -1 : 1;
        x->piece[i] = x->path_piece[i];
    }
    part_passed_on(w, x);
    proxy_open(contact, w, tau, x);
    load_at(contact, w, tau, x);
    friction_open(contact, w, tau, x);
    if (w->law->indicator) {
        w->law->indicator(w->law_p, contact->memory, x);
        EACH_LANE
            x->stuck[i] = x->law[i] > 0;
    }
    friction_rates(w, x);
    friction_force(w, x);
    forces_at(w, x);
}

/* How far is the shear plane of x's forces from the one that its slip asks for? In newton, at or above 0 where the
 * forces' plane is the steeper one and gives more slip, and falling with the slip: as straight as the law is, where the
 * slip that the forces give leaps from one bound of the angle to the other within k over the law's damping. Both
 * principles have tan(phi - alpha) = (p - q)/(p + q), q/p = tan(beta), or that of half of alpha + beta. `slope`: what
 * it falls by with the slip at these forces [N s/m]. */
static double excess(const struct Configuration *w, const struct Point *x, int i, double *slope)
{
    const double F = x->F[i], N = F == 0 ? 1 : x->N[i]; /* shear_angle() has no friction where there is no force */
    double p = N, q = F;
    if (w->by_energy) {
        const double along = N * w->cos_rake[i] - F * w->sin_rake[i];
        p = sqrt(F * F + N * N) + along;
        q = N * w->sin_rake[i] + F * w->cos_rake[i];
    }
    const double per_tangent = x->passed[i] * x->approach[i], side = per_tangent < 0 ? -1 : 1;
    const double at_none = x->passed[i] * slip_along_rake(w, x, i, 0);
    const double tangent = per_tangent == 0 ? 0 : (x->v[i] - at_none) / per_tangent;
    *slope = -fabs(p + q) / larger(fabs(per_tangent), 1e-300);
    return side * (p - q - tangent * (p + q));
}

/* Where the law jumps at the slip that the search has closed in on, the force lies within the jump such that its shear
 * angle gives this slip. */
static void stick(const struct Contact *contact, const struct Configuration *w, const lanes tau,
                  const struct Bracket *b, const int closed[LANES], struct Point *x)
{
    lanes F_low;
    EACH_LANE
        x->v[i] = closed[i] ? b[i].low : x->v[i];
    answer(contact, w, tau, x);
    EACH_LANE {
        F_low[i] = x->F[i];
        x->v[i] = closed[i] ? b[i].high : x->v[i];
    }
    answer(contact, w, tau, x);
    EACH_LANE {
        const double F_high = x->F[i], size = fabs(F_low[i]) + fabs(F_high);
        if (!closed[i] || fabs(F_high - F_low[i]) <= 1e-6 * size)
            continue;
        struct Bracket force = bracket(F_low[i], F_high, 1, -1);
        while (force.count < 90 && force.high - force.low > 1e-14 * size) {
            double slope;
            x->F[i] = bracket_next(&force, 1e-14 * size);
            forces_at(w, x);
            bracket_update(&force, x->F[i], excess(w, x, i, &slope));
        }
        x->sticking[i] = 1;
        x->F_stick[i] = x->F[i];
    }
}

void recall_slip(const struct Contact *contact, struct Point *x)
{
    EACH_LANE {
        x->solved_slip[i] = chosen_of(contact->follows[i] != 0, contact->followed_slip[i], NAN);
        x->solved_slope[i] = NAN;
    }
}

/* Where to look for the slip next: by the secant of the last two places; beyond them all at an end, where the flattest
 * or the steepest plane lies; beside 0, where a law without bristles jumps; and by the bracket where that leads out of
 * it or takes long. */
static double slip_to_try(struct Bracket *b, int jumps, double close, double at, double there, double slope)
{
    const double secant = at - there / slope;
    b->count += 1;
    if (b->count < 10 && secant > b->low && secant < b->high)
        return secant;
    if (jumps && b->low < 0 && b->high > 0 && b->high - b->low > 2 * close)
        return b->high > close ? 0.5 * close : -0.5 * close;
    if (b->count < 10 && secant <= b->low && b->weight_low == 0)
        return b->low;
    if (b->weight_high == 0)
        return b->high;
    if (b->weight_low == 0)
        return b->low;
    b->count -= 1;
    return bracket_next(b, close);
}

/* chip_flow_angle = current_shear_angle: v = V(phi(F(v))). More slip means more friction, a flatter shear plane and so
 * less slip: V(phi(F(v))) - v falls with v, and has one zero between the slips of the flattest and the steepest plane,
 * also where the law jumps. The search begins at the slip that was solved for last (solved_slip), where there is one.
 */
static void solve_slip(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    struct Bracket b[LANES];
    lanes close, least, most, before, excess_before;
    int open[LANES], closed[LANES], any = 1;
    lanes flattest;
    slip_passed_on(w, w->tan_flattest, x);
    EACH_LANE
        flattest[i] = x->v[i];
    slip_passed_on(w, w->tan_steepest, x);
    EACH_LANE {
        const double low = smaller(flattest[i], x->v[i]), high = larger(flattest[i], x->v[i]), last = x->solved_slip[i];
        b[i] = bracket(low, high, 0, 0);
        close[i] = 1e-14 * (fabs(low) + fabs(high));
        least[i] = low;
        most[i] = high;
        x->sticking[i] = 0;
        open[i] = 1;
        closed[i] = 0;
        x->v[i] = last > low && last < high ? last : 0.5 * (low + high);
        before[i] = excess_before[i] = NAN;
    }
    for (answer(contact, w, tau, x); any; answer(contact, w, tau, x)) {
        any = 0;
        for (int i = 0; i < LANES; ++i) {
            if (!open[i])
                continue;
            double least_slope;
            const double at = x->v[i], there = excess(w, x, i, &least_slope),
                         slope = (there - excess_before[i]) / (at - before[i]);
            bracket_update(&b[i], at, there);
            /* nearer than that it is of roundings, and across a reversal it may be of a jump */
            const int seen = slope < 0 && fabs(at - before[i]) > 30 * close[i] && at * before[i] > 0;
            x->solved_slope[i] = seen ? slope : x->solved_slope[i];
            /* a law that jumps looks as steep there as one likes, and its force is then asked for within the jump */
            const double steepest = seen && w->law->relaxes ? smaller(slope, least_slope) : least_slope;
            const int bound = at <= least[i] ? there <= 0 : at >= most[i] && there >= 0;
            closed[i] = !bound && (b[i].high - b[i].low <= close[i] || b[i].count >= 90);
            open[i] = !bound && !closed[i] && fabs(there) > -0.1 * close[i] * steepest;
            before[i] = at;
            excess_before[i] = there;
            if (open[i])
                x->v[i] = slip_to_try(&b[i], !w->law->relaxes, close[i], at, there, x->solved_slope[i]);
            any |= open[i];
        }
        if (!any)
            break;
    }
    any = 0;
    EACH_LANE
        any |= closed[i];
    if (any)
        stick(contact, w, tau, b, closed, x);
    EACH_LANE
        x->solved_slip[i] = x->v[i];
}

/* The slip then depends on z, steeply where the chip is thin. The rate equation is therefore linearised at this z, so
 * that the exponential takes the steep part with it: dz/dt = f + (df/dz) (z' - z). */
void friction_solved(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    solve_slip(contact, w, tau, x);
    struct Point beside = *x;
    lanes step;
    EACH_LANE {
        step[i] = 1e-7 * larger(fabs(x->z[i]), x->F_C[i] / x->P[i]);
        beside.z[i] = x->z[i] + step[i];
    }
    solve_slip(contact, w, tau, &beside);
    friction_rates(w, &beside);
    friction_rates(w, x);
    EACH_LANE
        if (x->cutting[i] != 0) {
            const double f = x->drive[i] - x->rate[i] * x->z[i],
                         f_beside = beside.drive[i] - beside.rate[i] * beside.z[i];
            /* never 0, and such that the target is within reach: it must not leap where an angle comes to its bound */
            const double least = larger(fabs(f) * w->p[VAR_SIGMA0][i] / stated_level(w->p, i), 1);
            x->rate[i] = larger((f - f_beside) / step[i], least);
            x->drive[i] = f + x->rate[i] * x->z[i];
            x->target[i] = x->drive[i] / x->rate[i];
        }
}
