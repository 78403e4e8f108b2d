/* What do friction and shear load together put on the tool? One thin shear plane, both shear-angle principles in closed
 * form.
 *
 * With R the resultant on the rake and f = F/k the paper's two principles give beta without iteration. They are written
 * here for N = R cos(beta) itself, which has limits where the angles have poles (no load, no friction): maximum shear
 * stress, phi = pi/4 - beta + alpha:    N = (sqrt(2) k + F cos(s)) / sin(s), s = pi/4 + alpha minimum energy, phi =
 * pi/4 - (beta - alpha)/2:      (2 k + F cos(alpha) - N sin(alpha))^2 = F^2 + N^2 N < 0 would be a chip pulling on the
 * tool: kept at 0 and counted.
 */
#include "stages.h"

#include <math.h>

static double normal_by_shear_stress(double F, double k, double cos_rake, double sin_rake)
{
    /* sqrt(2) cos(s) = cos - sin, sqrt(2) sin(s) = cos + sin of the rake */
    return (2 * k + F * (cos_rake - sin_rake)) / (cos_rake + sin_rake);
}

static double normal_by_energy(double F, double k, double cos_rake, double sin_rake)
{
    const double load = 2 * k + F * cos_rake;
    return (2 * sqrt(larger(k * (k + F * cos_rake), 0)) - load * sin_rake) / (cos_rake * cos_rake);
}

static double normal_force(const struct Configuration *w, double F, double k, int i)
{
    return w->by_energy ? normal_by_energy(F, k, w->cos_rake[i], w->sin_rake[i])
                        : normal_by_shear_stress(F, k, w->cos_rake[i], w->sin_rake[i]);
}

double normal_of(const struct Configuration *w, double F, int lane, double *slope)
{
    const double cos_rake = w->cos_rake[lane], sin_rake = w->sin_rake[lane];
    *slope = (cos_rake - sin_rake) / (cos_rake + sin_rake);
    if (w->by_energy)
        *slope = (1 / sqrt(larger(1 + F * cos_rake, 1e-300)) - sin_rake) / cos_rake;
    return normal_force(w, F, 1, lane);
}

/* sin and cos of the largest beta - alpha: a shear plane flatter than 0.02 rad is no chip formation, and where mu asks
 * for one the chip rather sticks. pi/2 - 2 * 0.02 of minimum energy, pi/4 - 0.02 of maximum shear stress. */
static const double flattest[2][2] = {{0.6928241717107472, 0.721106557377838},
                                      {0.9992001066609779, 0.03998933418663416}};

/* R = k/(sin(phi) cos(phi + beta - alpha)) with the principle's phi, and F = R sin(beta): mu = tan(beta) has the sign
 * of the side. Along the flow the shear plane becomes no flatter than the flattest. Against it minimum energy lets the
 * plane bear all of the shear load, F cos(alpha) = -k; a mu for which the face still bears more there is not reached.
 */
double friction_of(const struct Configuration *w, double mu, double side, int lane)
{
    const double cos_rake = w->cos_rake[lane], sin_rake = w->sin_rake[lane], *flat = flattest[w->by_energy];
    const double cos_beta = 1 / sqrt(1 + mu * mu);
    double sin_beta = side * mu * cos_beta;
    double sine = sin_beta * cos_rake - cos_beta * sin_rake, cosine = cos_beta * cos_rake + sin_beta * sin_rake;
    if (side > 0 && sine * flat[1] > cosine * flat[0]) {
        sine = flat[0];
        cosine = flat[1];
        sin_beta = sine * cos_rake + cosine * sin_rake;
    }
    if (side < 0 && w->by_energy && cos_beta < -sin_rake)
        return 1 / cos_rake;
    return side * 2 * sin_beta / (w->by_energy ? 1 - sine : cosine - sine);
}

INLINED void load_at(const struct Contact *contact, const struct Configuration *w, const lanes tau, struct Point *x)
{
    const lanes *p = w->p;
    act(w, STAGE_TEMPERATURE, x);
    if (w->on_count > 0)
        EACH_LANE
            x->theta_ratio[i] =
                smaller(x->theta[i] / p[VAR_THETA_REF][i], 1e30); /* its powers, up to the 10th, stay finite */
    EACH_LANE {
        x->tau_s[i] = p[VAR_SHEAR_STRESS][i];
        x->w[i] = p[VAR_WIDTH][i];
        x->edge_p[i] = x->edge_f[i] = 0;
    }
    act(w, STAGE_SHEAR, x);
    EACH_LANE
        x->k[i] = x->cutting[i] * larger(x->tau_s[i] * x->w[i] * x->h[i], 0);
    act(w, STAGE_LOAD, x);
    if (w->on_count > 0 || w->law->level) {
        const int given = w->kinematics == KINEMATICS_EXTERNAL;
        EACH_LANE
            x->load[i] = given ? input_at(contact, VAR_NORMAL_LOAD, i, tau[i]) : normal_force(w, 0, x->k[i], i);
    }
}

/* Both heat sources. N V_n, V_n = V_s cos(phi - alpha) the approach of tool and chip along the rake's normal, and F v,
 * less the power that goes along with the tool's own motion, is what the tool gives: so shear takes the rest, F_s V_s.
 * Who gives the slip says no more: a steady chip that slides at v along the rake approaches at
 * v cos(alpha) cos(phi - alpha)/sin(phi). */
static void powers_at(const struct Configuration *w, struct Point *x)
{
    EACH_LANE
        x->P_f[i] = x->F[i] * x->v[i];
    if (w->kinematics == KINEMATICS_EXTERNAL)
        EACH_LANE {
            const double cos_rake = w->cos_rake[i], sin_rake = w->sin_rake[i], cot = w->cot_flow[i];
            x->P_s[i] = larger(x->v[i], 0) * cos_rake *
                        (x->N[i] * (cos_rake * cot + sin_rake) - x->F[i] * (cos_rake - sin_rake * cot));
        }
    else
        EACH_LANE {
            const double along = x->u_x[i] * w->sin_rake[i] - x->u_y[i] * w->cos_rake[i];
            x->P_s[i] = x->N[i] * x->approach[i] - x->F[i] * (x->v[i] - along);
        }
}

INLINED void forces_at(const struct Configuration *w, struct Point *x)
{
    if (w->by_energy)
        EACH_LANE {
            x->N[i] = normal_by_energy(x->F[i], x->k[i], w->cos_rake[i], w->sin_rake[i]);
            x->outside[i] = (x->N[i] < 0) | (x->k[i] + x->F[i] * w->cos_rake[i] < 0);
        }
    else
        EACH_LANE {
            x->N[i] = normal_by_shear_stress(x->F[i], x->k[i], w->cos_rake[i], w->sin_rake[i]);
            x->outside[i] = x->N[i] < 0;
        }
    EACH_LANE {
        x->N[i] = larger(x->N[i], 0);
        x->beside_N[i] = 0;
    }
    act(w, STAGE_FORCES, x);
    EACH_LANE {
        const double F = x->F[i], cos_rake = w->cos_rake[i], sin_rake = w->sin_rake[i];
        x->N[i] = larger(x->N[i] + x->beside_N[i], 0);
        x->F_p[i] = x->N[i] * cos_rake + F * sin_rake + x->cutting[i] * x->edge_p[i];
        x->F_f[i] = F * cos_rake - x->N[i] * sin_rake + x->cutting[i] * x->edge_f[i];
    }
    powers_at(w, x);
}

double shear_angle(const struct Configuration *w, const struct Point *x, int lane)
{
    const double beta = x->F[lane] == 0 ? 0 : atan2(x->F[lane], x->N[lane]);
    return PI / 4 - (w->by_energy ? 0.5 : 1) * (beta - w->p[VAR_RAKE_ANGLE][lane]);
}
