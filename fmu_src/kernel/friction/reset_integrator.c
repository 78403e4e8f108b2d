/* Reset integrator: the bristle follows the slip up to z0 and stays there; stiffer while it sticks. Haessig and
 * Friedland 1991, with their z0 = F_C/sigma0 and 1 + a = F_S/F_C, so that the law needs no parameters of its own. */
#include "../stages.h"

#include <math.h>

enum { BEFORE }; /* what it did up to the last event: */
enum { STUCK, SLID, LET_GO };

static double z_0(const struct Point *x, int i) { return x->F_C[i] / x->P[i]; }

/* Sliding ends only where the slip turns round, also while F_C or P change. */
static void indicator(const lanes *p, const lanes *memory, struct Point *x)
{
    (void)p, (void)memory;
    EACH_LANE {
        const double z0 = z_0(x, i), outward = x->direction[i] * x->z[i];
        x->law[i] = outward <= 0 ? z0 : x->stuck[i] != 0 ? z0 - outward : -z0;
    }
}

static void rates(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE {
        x->rate[i] = x->target[i] = 0;
        x->drive[i] = x->stuck[i] != 0 ? x->v[i] : 0;
    }
}

/* While it slides the bristle is carried along at z0, on the side on which it gave way, whatever F_C and P do. */
static void force(const lanes *p, struct Point *x)
{
    (void)p;
    EACH_LANE {
        const int slides = (x->cutting[i] != 0) & (x->stuck[i] == 0);
        const double side = x->z[i] < 0 ? -1 : x->z[i] > 0 ? 1 : x->direction[i];
        x->z[i] = slides ? side * z_0(x, i) : x->z[i];
        const double sticking = x->s0[i] * x->F_S[i] / x->F_C[i] * x->z[i],
                     sliding = x->s0[i] * x->direction[i] * z_0(x, i);
        x->F[i] = (x->stuck[i] != 0 ? sticking : sliding) + x->s1[i] * x->dz[i];
    }
}

/* Where it sticks again, and where the work ends, it stands at z0, on the side on which it gave way, unless it was let
 * go at once (0); out of the work what slides is let go, and comes back no further than z0. It does so once: other
 * events, which only some hosts have, say nothing to a bristle that sticks while z0 comes down, nor to one that is out
 * of the work. */
static void event(const lanes *p, const struct Point *x, lanes z, lanes *memory)
{
    (void)p;
    EACH_LANE {
        const double bound =
            z_0(x, i) * (1 + 1e-12); /* beyond z0 by more than roundings: it slides, whoever looks again */
        const int in_contact = x->cutting[i] != 0, sticks = in_contact & (x->stuck[i] != 0),
                  slid = memory[BEFORE][i] == (double)SLID, was_let_go = memory[BEFORE][i] == (double)LET_GO;
        const double carried = z[i] < 0 ? -bound : bound, no_further = smaller(larger(z[i], -bound), bound);
        z[i] = slid & (sticks | (!in_contact & (z[i] != 0))) ? carried : sticks & was_let_go ? no_further : z[i];
        memory[BEFORE][i] = sticks ? STUCK : in_contact ? SLID : slid | was_let_go ? LET_GO : STUCK;
    }
}

/* clang-format off */
const struct FrictionLaw friction_reset_integrator = {
    .meaning = "elastic up to the break-away deflection F_C/sigma0 with peak force F_S, then sliding at F_C",
    .equation = "dz/dt = v, or |z| stays z0 = F_C/sigma0 where it has come there and v z > 0;  "
        "F = s0 (1 + a) z + s1 dz/dt, a = F_S/F_C - 1 while sticking, else 0",
    .source = "Haessig and Friedland 1991 (not read)",
    .reads = "sigma0, sigma1, F_C, F_S", .has_static = 1,
    .rates = rates, .force = force, .indicator = indicator, .event = event,
};
/* clang-format on */
