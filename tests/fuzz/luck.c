/* What does the fuzz draw? Numbers that repeat with the seed: ordinary ones, those at the bounds, and those at the ends
 * of a double. */
#include "host.h"

#include <float.h>
#include <math.h>

static uint64_t state;

/* Splitmix64, Steele et al. 2014. */
uint64_t luck(void)
{
    uint64_t z = state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

void luck_begin(uint64_t seed, uint64_t sequence)
{
    state = seed;
    state = luck() ^ sequence * 0xd1342543de82ef95u;
    luck();
}

int below(int n) { return (int)(luck() % (uint64_t)n); }
static double unit(void) { return (double)(luck() >> 11) / 9007199254740992.0; }
int chance(double share) { return unit() < share; }
double between(double low, double high) { return low + unit() * (high - low); }
double spread(double low, double high) { return low * pow(high / low, unit()); }

double strange(void)
{
    static const double ends[] = {0,      -0.0,   5e-324, 1e-320, 1e-310,  DBL_MIN,  1e-300, 1e-200,
                                  1e-160, 1e-100, 1e-30,  1e-16,  1e-9,    1,        1e9,    1e16,
                                  1e30,   1e100,  1e160,  1e300,  DBL_MAX, INFINITY, NAN};
    const double x = ends[below((int)(sizeof ends / sizeof *ends))];
    return chance(0.3) ? -x : x;
}

static double ordinary(const struct Variable *v)
{
    const double scale = v->nominal > 0 ? v->nominal : 1, near = v->start != 0 ? v->start : scale * between(-1, 1);
    const double x = chance(0.5) ? near * spread(0.2, 5) : near * spread(1e-3, 1e3);
    return fmin(fmax(x, v->min), v->max);
}

static double at_a_bound(const struct Variable *v)
{
    const double bound = chance(0.5) ? v->min : v->max;
    switch (below(4)) {
    case 0:
        return nextafter(bound, chance(0.5) ? INFINITY : -INFINITY);
    case 1:
        return bound * (1 + between(-1e-3, 1e-3));
    default:
        return bound;
    }
}

double value_of(const struct Variable *v)
{
    if (v->type != REAL) {
        const double span = v->max - v->min;
        return chance(0.05) ? (chance(0.5) ? v->min - 1 : v->max + 1) : v->min + floor(unit() * (fmin(span, 1e6) + 1));
    }
    if (chance(0.6))
        return ordinary(v);
    double x = chance(0.4)   ? at_a_bound(v)
               : chance(0.5) ? strange()
                             : between(fmax(v->min, -1e300), fmin(v->max, 1e300));
    if (chance(0.9) &&
        !(x >= v->min && x <= v->max)) /* beyond the bounds the call is refused, and the instance is of little use */
        x = v->min > 0 && chance(0.5) ? spread(v->min, v->max) : chance(0.5) ? v->min : v->max;
    return x;
}
