/* What does the friction law get to see, and what does it answer? Opens its fields, lets effects act on them, closes their limits. */
#include "stages.h"

#include <math.h>

static double proxy(const struct Contact *contact, const struct Wiring *w, int i, double tau, struct Point *x)
{
    const lanes *p = w->p;
    switch ((enum ProxySource)chosen(p, PROXY_SOURCE, 0)) {
    case PROXY_IS_INPUT: return input_at(contact, PROXY_SPEED, i, tau);
    case PROXY_IS_CUTTING_SPEED: return input_at(contact, CUTTING_SPEED, i, tau);
    case PROXY_IS_TEMPERATURE: {
        const double rise = input_at(contact, CONTACT_TEMPERATURE, i, tau) - p[AMBIENT_TEMPERATURE][i];
        const double share = rise / (p[REFERENCE_TEMPERATURE][i] - p[AMBIENT_TEMPERATURE][i]);
        x->clamped[i] += share < 0;
        x->warnings |= share < 0 ? WARN_TEMPERATURE : 0u;
        return p[THETA_REF][i] * pow(fmax(share, 0), 1 / p[ALPHA_T][i]); /* the paper, eq. 3, turned round */
    }
    case PROXY_IS_SLIP_SPEED: break;
    }
    return x->speed[i];
}

void friction_open(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x)
{
    const lanes *p = w->p;
    x->warnings = 0;
    EACH_LANE {
        x->clamped[i] = 0;
        x->speed[i] = fmax(x->direction[i] * x->v[i], 0);
        x->theta[i] = fmax(proxy(contact, w, i, tau[i], x), 0);
        x->theta_ratio[i] = x->theta[i] / p[THETA_REF][i];
        x->applied[i] = input_at(contact, APPLIED_FORCE, i, tau[i]);
        x->F_C[i] = p[F_C][i];
        x->F_S[i] = p[F_S][i];
        x->v_s[i] = p[V_S][i];
        x->P[i] = x->s0[i] = p[SIGMA0][i];
        x->s1[i] = p[SIGMA1][i];
        x->sigma2[i] = p[SIGMA2][i];
        x->margin[i] = chosen(p, DAMPING_MODE, i) == DISSIPATIVE ? p[DAMPING_MARGIN][i] : INFINITY;
    }
    act(w, STAGE_FRICTION, x);
    EACH_LANE {
        const double floor = p[STIFFNESS_FLOOR][i] * p[SIGMA0][i];
        const int below = x->s0[i] < floor;
        x->clamped[i] += below;
        x->warnings |= below ? WARN_STIFFNESS_FLOOR : 0u;
        x->s0[i] = fmax(x->s0[i], floor); /* the paper, eq. 7 */
        x->P[i] = chosen(p, RATE_STIFFNESS, i) == THERMAL_STIFFNESS ? x->s0[i] : x->P[i];
    }
}

/* Out of contact nothing drives the bristles: they relax, or (release_time 0) were let go at separation. */
void friction_rates(const struct Wiring *w, struct Point *x)
{
    w->law->rates(w->law_p, x);
    EACH_LANE if (x->cutting[i] == 0) {
        const double release_time = w->p[RELEASE_TIME][i];
        x->rate[i] = release_time > 0 ? 1 / release_time : 0;
        x->drive[i] = x->target[i] = 0;
    }
}

void friction_force(const struct Wiring *w, struct Point *x)
{
    EACH_LANE x->dz[i] = x->drive[i] - x->rate[i] * x->z[i];
    w->law->force(w->law_p, x);
    EACH_LANE x->F[i] *= x->cutting[i];
}

static void answer(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x)
{
    EACH_LANE x->direction[i] = x->v[i] < 0 ? -1 : 1;
    friction_open(contact, w, tau, x);
    friction_rates(w, x);
    friction_force(w, x);
    forces_at(w, x);
}

/* chip_flow_angle = current_shear_angle: v = V(phi(F(v))). More slip means more friction, a flatter shear plane and so less slip: the
 * difference of both sides rises with v, and bisection between the flattest and the steepest plane finds its zero, also where the law
 * jumps (there v = 0: the chip sticks). */
void friction_solved(const struct Contact *contact, const struct Wiring *w, const lanes tau, struct Point *x)
{
    enum { HALVINGS = 52 };
    const double flattest = 0.02, steepest = 1.5;
    lanes low, high;
    EACH_LANE {
        const double alpha = w->p[RAKE_ANGLE][i];
        const double a = slip_along_rake(w, x, i, tan(fmax(flattest - alpha, -steepest)));
        const double b = slip_along_rake(w, x, i, tan(fmin(steepest - alpha, steepest)));
        low[i] = fmin(a, b);
        high[i] = fmax(a, b);
    }
    for (int n = 0; n < HALVINGS; ++n) {
        EACH_LANE x->v[i] = 0.5 * (low[i] + high[i]);
        answer(contact, w, tau, x);
        EACH_LANE {
            const double angle = fmin(fmax(shear_angle(w, x, i), flattest), steepest) - w->p[RAKE_ANGLE][i];
            const int above = x->v[i] > slip_along_rake(w, x, i, tan(fmin(fmax(angle, -steepest), steepest)));
            high[i] = above ? x->v[i] : high[i];
            low[i] = above ? low[i] : x->v[i];
        }
    }
}
