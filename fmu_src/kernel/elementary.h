/* How are exp, powers, sin and cos taken in many lanes at once? In plain arithmetic that a compiler turns into vectors,
 * and the same in one lane, so that a lane's bits do not depend on its neighbours. Errors below 1e-15 of 1.
 */
#ifndef ELEMENTARY_H
#define ELEMENTARY_H

#include <math.h>
#include <stdint.h>

/* A loop over lanes with a call in it is taken lane by lane. */
#if defined(__GNUC__)
#define IN_LOOPS static inline __attribute__((always_inline))
#else
#define IN_LOOPS static inline
#endif

#define PI 3.14159265358979323846

/* The double with these bits. */
IN_LOOPS double with_bits(int64_t bits)
{
    const union {
        int64_t bits;
        double value;
    } both = {bits};
    return both.value;
}

IN_LOOPS int64_t bits_of(double value)
{
    const union {
        double value;
        int64_t bits;
    } both = {value};
    return both.bits;
}

/* One of two numbers in memory, by bits: of a plain choice compilers make one between their places, taken lane by lane.
 */
IN_LOOPS double chosen_of(int first, double a, double b)
{
    const int64_t mask = -(int64_t)(first != 0);
    return with_bits((bits_of(a) & mask) | (bits_of(b) & ~mask));
}

/* 1.5 * 2^52: adding it rounds to a whole number and shows it in the lowest bits */
#define ROUNDER 6755399441055744.0

/* e^x; 0 below -700, where it is less than 1e-304; e^700 above 700. x = n ln 2 + r, |r| < 0.35: Taylor's series to
 * r^13. */
IN_LOOPS double exponential(double x)
{
    const double inside = x < -700  ? -700
                          : x > 700 ? 700
                                    : x,
                 shifted = inside * 1.44269504088896340736 + ROUNDER, n = shifted - ROUNDER;
    const double r = (inside - n * 6.93147180369123816490e-1) - n * 1.90821492927058770002e-10, r2 = r * r,
                 r4 = r2 * r2;
    const double a = (1 + r) + r2 * (1. / 2 + r * (1. / 6)),
                 b = (1. / 24 + r * (1. / 120)) + r2 * (1. / 720 + r * (1. / 5040));
    const double c = (1. / 40320 + r * (1. / 362880)) + r2 * (1. / 3628800 + r * (1. / 39916800));
    const double d = 1. / 479001600 + r * (1. / 6227020800), sum = a + r4 * (b + r4 * (c + r4 * d));
    const double power = with_bits((int64_t)((uint64_t)(bits_of(shifted) + 1023) << 52));
    return x < -700 ? 0 : sum * power;
}

/* ln x of a normal number above 0: x = 2^n m, m from sqrt(1/2) to sqrt(2), and the series of ln((1 + f)/(1 - f)) to
 * f^21, |f| < 0.172. */
IN_LOOPS double log_of(double x)
{
    const uint64_t from = 0x3fe6a09e667f3bcd; /* sqrt(1/2) */
    const uint64_t above = ((uint64_t)bits_of(x) - from) & 0xfff0000000000000u;
    const double m = with_bits((int64_t)((uint64_t)bits_of(x) - above)), f = (m - 1) / (m + 1);
    /* the exponent as a number: its bits below those of 1.5 * 2^52 */
    const double n = with_bits((int64_t)(((above >> 52 ^ 0x800u) & 0xfffu) | 0x4338000000000000u)) - (ROUNDER + 2048);
    const double f2 = f * f, f4 = f2 * f2, f8 = f4 * f4;
    const double a = (2. / 3 + f2 * (2. / 5)) + f4 * (2. / 7 + f2 * (2. / 9)),
                 b = (2. / 11 + f2 * (2. / 13)) + f4 * (2. / 15 + f2 * (2. / 17)), c = 2. / 19 + f2 * (2. / 21);
    return n * 6.93147180369123816490e-1 +
           (2 * f + (f * f2 * (a + f8 * (b + f8 * c)) + n * 1.90821492927058770002e-10));
}

/* ln(1 + x) of x >= 0 and far from infinity, to its last digits where x is small: rounding 1 + x moves both factors
 * alike. */
IN_LOOPS double log_1p(double x)
{
    const double one_and_x = 1 + x, added = one_and_x - 1;
    return added > 0 ? log_of(one_and_x) * (x / (added > 0 ? added : 1)) : x;
}

/* x^y of x >= 0, to 1e-15 of it times the larger of 1 and |y ln x|; below 1e-300 x counts as 0. An x that is not finite
 * comes back. */
IN_LOOPS double power_of(double x, double y)
{
    const double raised = exponential(y * log_of(x)), of_none = y > 0 ? 0 : y < 0 ? 1e304 : 1;
    return x < 1e-300 ? of_none : x < INFINITY ? raised : x;
}

/* x^(-1/n) of x > 0; 0 above 1e300. */
IN_LOOPS double one_over_root(int n, double x) { return x < 1e300 ? exponential(log_of(x) * (-1. / n)) : 0; }

/* cos and sin of 2 pi turns: by quarter turns, Taylor's series to 16th and 17th order on |angle| <= pi/4. */
IN_LOOPS void cos_sin(double turns, double *cosine, double *sine)
{
    const double shifted = 4 * turns + ROUNDER, n = shifted - ROUNDER, x = (turns - 0.25 * n) * 6.28318530717958647693,
                 x2 = x * x;
    const double x4 = x2 * x2, x8 = x4 * x4;
    const double s = x + x * x2 *
                             ((-1. / 6 + x2 * (1. / 120)) + x4 * (-1. / 5040 + x2 * (1. / 362880)) +
                              x8 * ((-1. / 39916800 + x2 * (1. / 6227020800)) +
                                    x4 * (-1. / 1307674368000 + x2 * (1. / 355687428096000))));
    const double c =
        1 +
        x2 * ((-1. / 2 + x2 * (1. / 24)) + x4 * (-1. / 720 + x2 * (1. / 40320)) +
              x8 * ((-1. / 3628800 + x2 * (1. / 479001600)) + x4 * (-1. / 87178291200 + x2 * (1. / 20922789888000))));
    /* which of the two is which, and its sign: by bits, which costs a third of a choice */
    const uint64_t quarter = (uint64_t)bits_of(shifted), of_c = (uint64_t)bits_of(c), of_s = (uint64_t)bits_of(s),
                   apart = (of_c ^ of_s) & (0 - (quarter & 1));
    *cosine = with_bits((int64_t)(of_c ^ apart ^ (quarter + 1) >> 1 << 63));
    *sine = with_bits((int64_t)(of_s ^ apart ^ quarter >> 1 << 63));
}

/* The same of an angle in radians. Not libm's, whose sin, cos and sincos need not agree in the last bit: which of them
 * a compiler takes depends on what stands beside it. */
IN_LOOPS void cos_sin_of(double angle, double *cosine, double *sine)
{
    cos_sin(angle * 0.159154943091895335769, cosine, sine);
}

#endif
