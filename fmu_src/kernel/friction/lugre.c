/* LuGre: bristles that bend, yield and damp. Canudas de Wit, Olsson, Astrom, Lischinsky 1995, eqs. 2 to 5; thermally
 * modified by the paper's eq. 8 through s0 and s1. Three exponents are those of the published law at their starts, and
 * others were measured: of the Stribeck curve, of how bristles yield before they slide, of viscous friction. */
#include "../stages.h"

#include <math.h>

enum { STRIBECK_EXPONENT, PRESLIDING_EXPONENT, VISCOUS_EXPONENT, VISCOUS_REFERENCE, COUNT };

/* clang-format off */
static const struct Variable variables[COUNT] = {
    [STRIBECK_EXPONENT] = {.name = "lugre.stribeck_exponent", .unit = "1", .start = 2, .min = 0.3, .max = 6,
        .neutral = 2, .causality = PARAMETER, .variability = TUNABLE,
        .meaning = "exponent of |v|/v_s in the Stribeck curve: 2 is LuGre's, 1 Tustin's, others were measured",
        .source = "Canudas de Wit et al. 1995: 2; Bo and Pavelescu 1982 (not read): 0.5 to 1; "
            "Armstrong-Helouvry et al. 1994 (not read)"},
    [PRESLIDING_EXPONENT] = {.name = "lugre.presliding_exponent", .unit = "1", .start = 1, .min = 0.5, .max = 6,
        .neutral = 1, .causality = PARAMETER, .variability = TUNABLE,
        .meaning = "exponent of |z| over its steady value in the yielding of the bristles: 1 is LuGre's; the larger, the "
            "later they yield; without a say where elasto_plastic has a share",
        .source = "Canudas de Wit et al. 1995: 1; Wen 1976 (not read): the exponent n of the Bouc-Wen model"},
    [VISCOUS_EXPONENT] = {.name = "lugre.viscous_exponent", .unit = "1", .start = 1, .min = 0.2, .max = 3,
        .neutral = 1, .causality = PARAMETER, .variability = TUNABLE,
        .meaning = "exponent of |v|/(reference velocity) in viscous friction: 1 is LuGre's",
        .source = "Canudas de Wit et al. 1995: 1; Armstrong-Helouvry et al. 1994 (not read)"},
    [VISCOUS_REFERENCE] = {.name = "lugre.viscous_reference", .unit = "m/s", .start = 1, .min = 1e-12, .max = 1e6,
        .reference = 1, .causality = PARAMETER, .variability = TUNABLE,
        .meaning = "slip velocity at which viscous friction is sigma2 times it, whatever its exponent",
        .source = "Ostwald 1925 and de Waele 1923 (not read): a power law is said at a reference"},
};
/* clang-format on */

/* With a presliding exponent n, the least of S^(n + 1)/(S^n - 1) over deflections S beyond the steady one; 4 of 1. */
static void prepare(const lanes *p, struct Configuration *w)
{
    for (int i = 0; i < LANES; ++i) {
        const double exponent = p[STRIBECK_EXPONENT][i], n = w->yielding[i] ? p[PRESLIDING_EXPONENT][i] : 1;
        w->flat_share[i] = exponent == 2 ? w->root_decayed[i] : power_of(w->decayed[i], 1 / exponent);
        w->damping_room[i] = n == 1 ? 4 : power_of(n + 1, (n + 1) / n) / n;
    }
}

/* (v/v_s)^exponent, and the slip from which on it leaves no static friction. */
static void powers(const lanes *p, struct Point *x, lanes power)
{
    int other = 0;
    EACH_LANE {
        const double ratio = x->speed[i] / x->v_s[i];
        power[i] = ratio * ratio;
        x->flat_from[i] = x->v_s[i] * x->configuration->flat_share[i];
        other |= p[STRIBECK_EXPONENT][i] != 2;
    }
    if (other)
        EACH_LANE {
            const double exponent = p[STRIBECK_EXPONENT][i], raised = power_of(x->speed[i] / x->v_s[i], exponent);
            power[i] = chosen_of(exponent != 2, raised, power[i]);
        }
}

/* The damping that stands in the force: with damping_mode = dissipative |v| s1 <= 4 c g, from which v F is at least
 * what the bristles store; with s0 below P that bound shrinks by s0/P. `most`: steady deflection g(v)/P. */
static void limit_damping(struct Point *x, const lanes most)
{
    lanes bound;
    int bounded = 0;
    EACH_LANE
        bound[i] = x->configuration->damping_room[i] * x->margin[i] * most[i] * x->s0[i];
    EACH_LANE {
        x->limited[i] = x->s1[i] * x->speed[i] > bound[i];
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

static int smooth(const lanes *p, int lane) { return p[STRIBECK_EXPONENT][lane] == 2; }

static int yields(const lanes *p, int lane) { return p[PRESLIDING_EXPONENT][lane] != 1; }

/* dz/dt = v - rate z (|z|/most)^(n - 1), linearised at this z as elasto_plastic does: a rate of at least the law's own,
 * lest the step's parabola of the rate throw the target out of its reach. */
static void yield(const lanes *p, struct Point *x)
{
    const double slack = 1e-4; /* of the steady deflection: below it an exponent under 1 has no finite rate */
    EACH_LANE {
        const double n = p[PRESLIDING_EXPONENT][i], most = fabs(x->target[i]);
        const int yields = (x->configuration->yielding[i] != 0) & (most != 0);
        const double share = power_of(larger(fabs(x->z[i]) / most, slack), n - 1), steep = larger(n * share, 1);
        const double target = (x->target[i] + (steep - share) * x->z[i]) / steep,
                     drive = x->drive[i] + (steep - share) * x->rate[i] * x->z[i], rate = x->rate[i] * steep;
        x->target[i] = chosen_of(yields, target, x->target[i]);
        x->drive[i] = chosen_of(yields, drive, x->drive[i]);
        x->rate[i] = chosen_of(yields, rate, x->rate[i]);
    }
}

/* F = s0 z + s1 dz/dt + sigma2 v, with the damping s1 that limit_damping() leaves. */
static void force(const lanes *p, struct Point *x)
{
    int other = 0;
    EACH_LANE {
        x->F[i] = x->s0[i] * x->z[i] + x->s1[i] * x->dz[i] + x->sigma2[i] * x->v[i];
        other |= p[VISCOUS_EXPONENT][i] != 1;
    }
    if (other)
        EACH_LANE {
            const double exponent = p[VISCOUS_EXPONENT][i];
            const double with_power =
                x->F[i] + x->sigma2[i] * x->v[i] * (power_of(x->speed[i] / p[VISCOUS_REFERENCE][i], exponent - 1) - 1);
            x->F[i] = chosen_of((exponent != 1) & (x->speed[i] > 0), with_power, x->F[i]);
        }
}

/* clang-format off */
const struct FrictionLaw friction_lugre = {
    .meaning = "mean deflection of elastic bristles with Stribeck curve, damping and viscous friction",
    .equation = "dz/dt = v - P |v| z / g(v) (P |z|/g(v))^(presliding_exponent - 1);  g(v) = F_C + (F_S - F_C) "
        "exp(-(|v|/v_s)^stribeck_exponent);  F = s0 z + s1 dz/dt + sigma2 v |v/viscous_reference|^(viscous_exponent - 1)",
    .source = "Canudas de Wit et al. 1995, eqs. 2 to 5; the paper, eq. 8",
    .reads = "sigma0, sigma1, sigma2, F_C, F_S, v_s", .has_static = 1,
    .relaxes = 1, .smooth = smooth, .prepare = prepare, .rates = rates, .yields = yields, .yield = yield, .force = force,
    .variables = variables, .count = COUNT,
};
/* clang-format on */
