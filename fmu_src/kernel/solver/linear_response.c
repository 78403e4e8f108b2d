/* How does a linear state follow a drive that is known over a step? Exactly, where the drive is the parabola through
 * start, middle, end.
 *
 * A sensor may be much faster than a step is long, and its state then says nothing at the middle of its mean. But what
 * follows it is linear and meets it in integrals by Simpson's rule alone; so there the middle stands for the integral,
 * which the state's own equation gives: over T y' = u - y it is that of u less T times what y gains.
 */
#include "../stages.h"

#include <math.h>
#include <string.h>

static double first_order_after(double D, double u_0, double slope, double bend, double y)
{
    double I[3];
    moments(D, I);
    return y + (u_0 - y) * I[0] + slope * I[1] + bend * I[2];
}

/* In units of T: dy/dA = u - y, A = t/T. */
void first_order_response(double h, double T, double u_0, double u_m, double u_1, double y, double *half, double *whole)
{
    if (!(T >= NO_TIME)) { /* it follows at once */
        *half = u_m;
        *whole = u_1;
        return;
    }
    if (h < 1e-12 * T) { /* the parabola's coefficients would overflow; but a state at rest must leave it however short
                            the step */
        *half = y + 0.5 * h / T * (u_0 - y);
        *whole = y + h / T * (u_m - y);
        return;
    }
    const double D = h / T, bend = 2 * (u_0 - 2 * u_m + u_1) / (D * D), slope = (4 * u_m - 3 * u_0 - u_1) / D;
    *half = first_order_after(0.5 * D, u_0, slope, bend, y);
    *whole = first_order_after(D, u_0, slope, bend, y);
}

/* Below, Simpson's rule over the true middle is right to rounding, and this would cancel. */
#define SHORT_STEP 1e-2

/* Simpson's rule over start, this middle and end gives the mean. */
static double middle_of(double mean, double start, double end) { return 0.25 * (6 * mean - start - end); }

void first_order_response_in_mean(double h, double T, double u_0, double u_m, double u_1, double y, double *half,
                                  double *whole)
{
    first_order_response(h, T, u_0, u_m, u_1, y, half, whole);
    if (T >= NO_TIME && h > SHORT_STEP * T)
        *half = middle_of((u_0 + 4 * u_m + u_1) / 6 - T * (*whole - y) / h, y, *whole);
}

/* Short steps, where the coefficients of the parabola would cancel: the series of place and speed over the share of the
 * step, to rounding; of both oscillators at once, which a processor's vectors hold. */
static void second_order_series(double turn, double zeta, const struct Oscillators *o, double half[2][2],
                                double whole[2][2])
{
    enum { TERMS = 11 }; /* (2 zeta turn)^11/11! of them is left out */
    double drive[3][2], x[2], s[2], at_half[2][2], at_end[2][2], share = 1;
    for (int n = 0; n < 2; ++n) {
        drive[0][n] = o->start[n];
        drive[1][n] = 4 * o->middle[n] - 3 * o->start[n] - o->end[n];
        drive[2][n] = 2 * (o->start[n] - 2 * o->middle[n] + o->end[n]);
        at_half[OF_PLACE][n] = at_end[OF_PLACE][n] = x[n] = o->at[OF_PLACE][n];
        at_half[OF_SPEED][n] = at_end[OF_SPEED][n] = s[n] = o->at[OF_SPEED][n];
    }
    for (int k = 0; k < TERMS - 1; ++k) {
        const double part = turn / (k + 1);
        share *= 0.5;
        for (int n = 0; n < 2; ++n) {
            const double next = part * ((k < 3 ? drive[k][n] : 0) - x[n] - 2 * zeta * s[n]);
            x[n] = part * s[n];
            s[n] = next;
            at_end[OF_PLACE][n] += x[n];
            at_end[OF_SPEED][n] += s[n];
            at_half[OF_PLACE][n] += share * x[n];
            at_half[OF_SPEED][n] += share * s[n];
        }
    }
    memcpy(half, at_half, sizeof at_half);
    memcpy(whole, at_end, sizeof at_end);
}

/* In units of 1/w: x'' + 2 zeta x' + x = c_0 + c_1 s + c_2 s^2, solved by a parabola and a free oscillation. */
static void second_order_after(double turn, double zeta, const double c[3][2], const struct Oscillators *o,
                               double after[2][2])
{
    const double square = 1 - zeta * zeta;
    double cosine, sine; /* e^(-zeta turn) cos(n turn), and the sine over n; n^2 = 1 - zeta^2 */
    const double q = square * turn * turn;
    if (fabs(q) < 1e-4) { /* of the series what is above rounding: the quotients below lose digits here */
        const double decay = exp(-zeta * turn);
        cosine = decay * (1 - q / 2 + q * q / 24);
        sine = decay * turn * (1 - q / 6 + q * q / 120);
    } else if (square > 0) {
        const double n = sqrt(square), decay = exponential(-zeta * turn);
        cos_sin_of(n * turn, &cosine, &sine);
        cosine *= decay;
        sine *= decay / n;
    } else { /* two exponentials, so that neither overflows */
        const double n = sqrt(-square), slow = exp((n - zeta) * turn), fast = exp(-(n + zeta) * turn);
        cosine = 0.5 * (slow + fast);
        sine = 0.5 * (slow - fast) / n;
    }
    for (int n = 0; n < 2; ++n) {
        const double p_2 = c[2][n], p_1 = c[1][n] - 4 * zeta * p_2, p_0 = c[0][n] - 2 * zeta * p_1 - 2 * p_2;
        const double x = o->at[OF_PLACE][n] - p_0, s = o->at[OF_SPEED][n] - p_1;
        after[OF_PLACE][n] = x * (cosine + zeta * sine) + s * sine + p_0 + p_1 * turn + p_2 * turn * turn;
        after[OF_SPEED][n] = s * (cosine - zeta * sine) - x * sine + p_1 + 2 * p_2 * turn;
    }
}

void second_order_responses(double h, double w, double zeta, const struct Oscillators *oscillators, double half[2][2],
                            double whole[2][2])
{
    const double turn = w * h;
    struct Oscillators o = *oscillators;
    for (int n = 0; n < 2; ++n)
        o.at[OF_SPEED][n] /= w;
    if (turn < 0.05)
        second_order_series(turn, zeta, &o, half, whole);
    else {
        double c[3][2];
        for (int n = 0; n < 2; ++n) {
            c[0][n] = o.start[n];
            c[1][n] = (4 * o.middle[n] - 3 * o.start[n] - o.end[n]) / turn;
            c[2][n] = 2 * (o.start[n] - 2 * o.middle[n] + o.end[n]) / (turn * turn);
        }
        second_order_after(0.5 * turn, zeta, c, &o, half);
        second_order_after(turn, zeta, c, &o, whole);
    }
    for (int n = 0; n < 2; ++n) {
        half[OF_SPEED][n] *= w;
        whole[OF_SPEED][n] *= w;
    }
}

void second_order_responses_in_mean(double h, double w, double zeta, const struct Oscillators *o, double half[2][2],
                                    double whole[2][2])
{
    const double turn = w * h;
    second_order_responses(h, w, zeta, o, half, whole);
    for (int n = 0; turn > SHORT_STEP && n < 2; ++n) {
        const double moved = whole[OF_PLACE][n] - o->at[OF_PLACE][n],
                     sped = (whole[OF_SPEED][n] - o->at[OF_SPEED][n]) / w,
                     mean = (o->start[n] + 4 * o->middle[n] + o->end[n]) / 6 - (2 * zeta * moved + sped) / turn;
        half[OF_PLACE][n] = middle_of(mean, o->at[OF_PLACE][n], whole[OF_PLACE][n]);
    }
}
