/* LuGre: bristles that bend, yield and damp. Canudas de Wit, Olsson, Astrom, Lischinsky 1995, eqs. 2 to 5; thermally
 * modified by the paper's eq. 8 through s0 and s1; the exponent 2 of the Stribeck curve is the start of a parameter. */
#include "../stages.h"

#include <math.h>

enum { STRIBECK_EXPONENT, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [STRIBECK_EXPONENT] = {.name = "lugre.stribeck_exponent", .unit = "1", .start = 2, .min = 0.3, .max = 6,
        .neutral = 2, .causality = PARAMETER, .variability = TUNABLE,
        .meaning = "exponent of |v|/v_s in the Stribeck curve: 2 is LuGre's, 1 Tustin's, others were measured",
        .source = "Canudas de Wit et al. 1995: 2; Bo and Pavelescu 1982: 0.5 to 1; Armstrong-Helouvry et al. 1994"},
};
/* clang-format on */

#define NO_STATIC_FRICTION 9.2 /* e^-9.2 is 1e-4: above v_s times its root, static friction is gone */

/* (v/v_s)^exponent, and the slip from which on it leaves no static friction. */
static void powers(const lanes *p, struct Point *x, lanes power)
{
    int other = 0;
    EACH_LANE {
        const double ratio = x->speed[i] / x->v_s[i];
        power[i] = ratio * ratio;
        x->flat_from[i] = x->v_s[i] * 3.0331501776206204; /* sqrt(NO_STATIC_FRICTION) */
        other |= p[STRIBECK_EXPONENT][i] != 2;
    }
    for (int i = 0; other && i < LANES; ++i) {
        if (p[STRIBECK_EXPONENT][i] == 2)
            continue;
        power[i] = pow(x->speed[i] / x->v_s[i], p[STRIBECK_EXPONENT][i]);
        x->flat_from[i] = x->v_s[i] * pow(NO_STATIC_FRICTION, 1 / p[STRIBECK_EXPONENT][i]);
    }
}

/* The damping that stands in the force: with damping_mode = dissipative |v| s1 <= 4 c g, from which v F is at least
 * what the bristles store; with s0 below P that bound shrinks by s0/P. `most`: steady deflection g(v)/P. */
static void limit_damping(struct Point *x, const lanes most)
{
    lanes bound;
    int bounded = 0;
    EACH_LANE {
        bound[i] = 4 * x->margin[i] * most[i] * x->s0[i];
        bounded |= x->s1[i] * x->speed[i] > 0.999 * bound[i];
    }
    if (bounded)
        EACH_LANE
            x->s1[i] = smaller(x->s1[i], bound[i] / larger(x->speed[i], 1e-300));
}

static void rates(const lanes *p, struct Point *x)
{
    lanes power;
    powers(p, x, power);
    lanes most; /* steady deflection g(v)/P */
    EACH_LANE {
        most[i] = (x->F_C[i] + (x->F_S[i] - x->F_C[i]) * exponential(-power[i])) / x->P[i];
        x->drive[i] = x->v[i];
        x->rate[i] = x->speed[i] / most[i];
        x->target[i] = x->direction[i] * most[i];
    }
    limit_damping(x, most);
}

/* F = s0 z + s1 dz/dt + sigma2 v, with the damping s1 that limit_damping() leaves. */
static void force(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE
        x->F[i] = x->s0[i] * x->z[i] + x->s1[i] * x->dz[i] + x->sigma2[i] * x->v[i];
}

/* clang-format off */
const struct FrictionLaw friction_lugre = {
    .meaning = "mean deflection of elastic bristles with Stribeck curve, damping and viscous friction",
    .equation = "dz/dt = v - P |v| z / g(v);  g(v) = F_C + (F_S - F_C) exp(-(|v|/v_s)^stribeck_exponent);  F = s0 z + "
        "s1 dz/dt + sigma2 v",
    .source = "Canudas de Wit et al. 1995, eqs. 2 to 5; the paper, eq. 8",
    .reads = "sigma0, sigma1, sigma2, F_C, F_S, v_s",
    .relaxes = 1, .rates = rates, .force = force, .variables = variables, .count = COUNT,
};
/* clang-format on */
