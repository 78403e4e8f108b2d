/* How does a linear state follow a drive that is known over a step? Exactly, where the drive is the parabola through
 * start, middle, end.
 *
 * A sensor may be much faster than a step is long, and its state then says nothing at the middle of its mean. But what
 * follows it is linear and meets it in integrals by Simpson's rule alone; so there the middle stands for the integral,
 * which the state's own equation gives: over T y' = u - y it is that of u less T times what y gains.
 */
#include "../stages.h"

#include <math.h>

/* Below this part of T the parabola's coefficients would overflow; but a state at rest must leave it however short the
 * step. */
#define BRIEF_PART 1e-12

/* In units of T: dy/dA = u - y, A = t/T. */
void first_order_response(const lanes h, const lanes T, const lanes u_0, const lanes u_m, const lanes u_1,
                          const lanes y, lanes half, lanes whole)
{
    lanes M, D, to_M[3], to_D[3];
    EACH_LANE {
        const double follows = T[i] >= NO_TIME ? T[i] : 1;
        D[i] = larger(h[i] / follows, BRIEF_PART);
        M[i] = 0.5 * D[i];
    }
    moments_in_lanes(M, D, to_M, to_D);
    EACH_LANE {
        const int at_once = !(T[i] >= NO_TIME), brief = h[i] < BRIEF_PART * T[i];
        const double share = h[i] / (at_once ? 1 : T[i]), d = D[i];
        const double bend = 2 * (u_0[i] - 2 * u_m[i] + u_1[i]) / (d * d),
                     slope = (4 * u_m[i] - 3 * u_0[i] - u_1[i]) / d;
        const double reached = y[i] + (u_0[i] - y[i]) * to_M[0][i] + slope * to_M[1][i] + bend * to_M[2][i],
                     ended = y[i] + (u_0[i] - y[i]) * to_D[0][i] + slope * to_D[1][i] + bend * to_D[2][i];
        const double left = y[i] + 0.5 * share * (u_0[i] - y[i]), gone = y[i] + share * (u_m[i] - y[i]);
        half[i] = at_once ? u_m[i] : brief ? left : reached;
        whole[i] = at_once ? u_1[i] : brief ? gone : ended;
    }
}

/* Below, Simpson's rule over the true middle is right to rounding, and this would cancel. */
#define SHORT_STEP 1e-2

/* Simpson's rule over start, this middle and end gives the mean. */
static INLINED double middle_of(double mean, double start, double end) { return 0.25 * (6 * mean - start - end); }

void first_order_response_in_mean(const lanes h, const lanes T, const lanes u_0, const lanes u_m, const lanes u_1,
                                  const lanes y, lanes half, lanes whole)
{
    first_order_response(h, T, u_0, u_m, u_1, y, half, whole);
    EACH_LANE {
        const int long_step = (T[i] >= NO_TIME) & (h[i] > SHORT_STEP * T[i]);
        const double mean = (u_0[i] + 4 * u_m[i] + u_1[i]) / 6 - T[i] * (whole[i] - y[i]) / (long_step ? h[i] : 1);
        half[i] = long_step ? middle_of(mean, y[i], whole[i]) : half[i];
    }
}

/* Of a free oscillation, in radians. */
#define SHORT_TURN 0.05

/* Short steps, where the coefficients of the parabola would cancel: the series of place and speed over the share of the
 * step, to rounding. */
static void second_order_series(const lanes turn, const lanes zeta, const lanes w, const struct Oscillators *o,
                                lanes half[2][2], lanes whole[2][2])
{
    enum { TERMS = 11 }; /* (2 zeta turn)^11/11! of them is left out */
    lanes drive[3][2], x[2], s[2];
    EACH_LANE
        for (int n = 0; n < 2; ++n) {
            drive[0][n][i] = o->start[n][i];
            drive[1][n][i] = 4 * o->middle[n][i] - 3 * o->start[n][i] - o->end[n][i];
            drive[2][n][i] = 2 * (o->start[n][i] - 2 * o->middle[n][i] + o->end[n][i]);
            half[OF_PLACE][n][i] = whole[OF_PLACE][n][i] = x[n][i] = o->at[OF_PLACE][n][i];
            half[OF_SPEED][n][i] = whole[OF_SPEED][n][i] = s[n][i] = o->at[OF_SPEED][n][i] / w[i];
        }
    double share = 1;
    for (int k = 0; k < TERMS - 1; ++k) {
        share *= 0.5;
        EACH_LANE {
            const double part = turn[i] / (k + 1);
            for (int n = 0; n < 2; ++n) {
                const double next = part * ((k < 3 ? drive[k < 3 ? k : 0][n][i] : 0) - x[n][i] - 2 * zeta[i] * s[n][i]);
                x[n][i] = part * s[n][i];
                s[n][i] = next;
                whole[OF_PLACE][n][i] += x[n][i];
                whole[OF_SPEED][n][i] += s[n][i];
                half[OF_PLACE][n][i] += share * x[n][i];
                half[OF_SPEED][n][i] += share * s[n][i];
            }
        }
    }
}

/* How what swings freely goes on: e^(-zeta turn) cos(n turn), and the sine over n; n^2 = 1 - zeta^2. */
static void free_response(const lanes turn, const lanes zeta, lanes cosine, lanes sine)
{
    int others = 0;
    EACH_LANE {
        const double square = 1 - zeta[i] * zeta[i];
        const int swings = (square > 0) & !(fabs(square * turn[i] * turn[i]) < 1e-4);
        const double n = sqrt(swings ? square : 1), decay = exponential(-zeta[i] * turn[i]);
        cos_sin_of(n * turn[i], &cosine[i], &sine[i]);
        cosine[i] *= decay;
        sine[i] *= decay / n;
        others |= !swings;
    }
    for (int i = 0; others && i < LANES; ++i) {
        const double square = 1 - zeta[i] * zeta[i], q = square * turn[i] * turn[i];
        if (fabs(q) < 1e-4) { /* of the series what is above rounding: the quotients below lose digits here */
            const double decay = exp(-zeta[i] * turn[i]);
            cosine[i] = decay * (1 - q / 2 + q * q / 24);
            sine[i] = decay * turn[i] * (1 - q / 6 + q * q / 120);
        } else if (square <= 0) { /* two exponentials, so that neither overflows */
            const double n = sqrt(-square), slow = exp((n - zeta[i]) * turn[i]), fast = exp(-(n + zeta[i]) * turn[i]);
            cosine[i] = 0.5 * (slow + fast);
            sine[i] = 0.5 * (slow - fast) / n;
        }
    }
}

/* In units of 1/w: x'' + 2 zeta x' + x = c_0 + c_1 s + c_2 s^2, solved by a parabola and a free oscillation; of the
 * lanes whose step is not short. */
static void second_order_after(double part, const lanes turn, const lanes zeta, const lanes w,
                               const struct Oscillators *o, lanes after[2][2])
{
    lanes turned, cosine, sine;
    EACH_LANE
        turned[i] = part * turn[i];
    free_response(turned, zeta, cosine, sine);
    EACH_LANE
        for (int n = 0; n < 2; ++n) {
            const int by_parabola = !(turn[i] < SHORT_TURN);
            const double to = turned[i], whole = by_parabola ? turn[i] : 1, start = o->start[n][i],
                         middle = o->middle[n][i], end = o->end[n][i];
            const double c_1 = (4 * middle - 3 * start - end) / whole,
                         p_2 = 2 * (start - 2 * middle + end) / (whole * whole);
            const double p_1 = c_1 - 4 * zeta[i] * p_2, p_0 = start - 2 * zeta[i] * p_1 - 2 * p_2;
            const double x = o->at[OF_PLACE][n][i] - p_0, s = o->at[OF_SPEED][n][i] / w[i] - p_1;
            const double place = x * (cosine[i] + zeta[i] * sine[i]) + s * sine[i] + p_0 + p_1 * to + p_2 * to * to,
                         speed = s * (cosine[i] - zeta[i] * sine[i]) - x * sine[i] + p_1 + 2 * p_2 * to;
            after[OF_PLACE][n][i] = by_parabola ? place : after[OF_PLACE][n][i];
            after[OF_SPEED][n][i] = by_parabola ? speed : after[OF_SPEED][n][i];
        }
}

void second_order_responses(const lanes h, const lanes w, const lanes zeta, const struct Oscillators *oscillators,
                            lanes half[2][2], lanes whole[2][2])
{
    lanes turn;
    int some_short = 0, some_long = 0;
    EACH_LANE {
        turn[i] = w[i] * h[i];
        some_short |= turn[i] < SHORT_TURN;
        some_long |= !(turn[i] < SHORT_TURN);
    }
    if (some_short)
        second_order_series(turn, zeta, w, oscillators, half, whole);
    if (some_long) {
        second_order_after(0.5, turn, zeta, w, oscillators, half);
        second_order_after(1, turn, zeta, w, oscillators, whole);
    }
    EACH_LANE
        for (int n = 0; n < 2; ++n) {
            half[OF_SPEED][n][i] *= w[i];
            whole[OF_SPEED][n][i] *= w[i];
        }
}

void second_order_responses_in_mean(const lanes h, const lanes w, const lanes zeta, const struct Oscillators *o,
                                    lanes half[2][2], lanes whole[2][2])
{
    second_order_responses(h, w, zeta, o, half, whole);
    EACH_LANE
        for (int n = 0; n < 2; ++n) {
            const double turn = w[i] * h[i], place = o->at[OF_PLACE][n][i];
            const int long_step = turn > SHORT_STEP;
            const double moved = whole[OF_PLACE][n][i] - place,
                         sped = (whole[OF_SPEED][n][i] - o->at[OF_SPEED][n][i]) / w[i],
                         mean = (o->start[n][i] + 4 * o->middle[n][i] + o->end[n][i]) / 6 -
                                (2 * zeta[i] * moved + sped) / (long_step ? turn : 1);
            half[OF_PLACE][n][i] = long_step ? middle_of(mean, place, whole[OF_PLACE][n][i]) : half[OF_PLACE][n][i];
        }
}
