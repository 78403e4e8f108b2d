/* How does a linear state follow a drive that is known over a step? Exactly, where the drive is the parabola through
 * start, middle, end.
 *
 * A sensor may be much faster than a step is long, and its state then says nothing at the middle of its mean. But what
 * follows it is linear and meets it in integrals by Simpson's rule alone; so there the middle stands for the integral,
 * which the state's own equation gives: over T y' = u - y it is that of u less T times what y gains.
 */
#include "../stages.h"

#include <math.h>

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
#define SHORT 1e-2

/* Simpson's rule over start, this middle and end gives the mean. */
static double middle_of(double mean, double start, double end) { return 0.25 * (6 * mean - start - end); }

void first_order_response_in_mean(double h, double T, double u_0, double u_m, double u_1, double y, double *half,
                                  double *whole)
{
    first_order_response(h, T, u_0, u_m, u_1, y, half, whole);
    if (T >= NO_TIME && h > SHORT * T)
        *half = middle_of((u_0 + 4 * u_m + u_1) / 6 - T * (*whole - y) / h, y, *whole);
}

/* Short steps, where the coefficients of the parabola would cancel: the series of place and speed over the share of the
 * step, to rounding. */
static void second_order_series(double turn, double zeta, double u_0, double u_m, double u_1, const double y[2],
                                double half[2], double whole[2])
{
    enum { TERMS = 11 }; /* (2 zeta turn)^11/11! of them is left out */
    const double drive[3] = {u_0, 4 * u_m - 3 * u_0 - u_1, 2 * (u_0 - 2 * u_m + u_1)};
    double x = y[0], s = y[1], share = 1;
    half[0] = whole[0] = x;
    half[1] = whole[1] = s;
    for (int k = 0; k < TERMS - 1; ++k) {
        const double part = turn / (k + 1), next = part * ((k < 3 ? drive[k] : 0) - x - 2 * zeta * s);
        x = part * s;
        s = next;
        share *= 0.5;
        whole[0] += x;
        whole[1] += s;
        half[0] += share * x;
        half[1] += share * s;
    }
}

/* In units of 1/w: x'' + 2 zeta x' + x = c_0 + c_1 s + c_2 s^2, solved by a parabola and a free oscillation. */
static void second_order_after(double turn, double zeta, const double c[3], const double y[2], double after[2])
{
    const double p_2 = c[2], p_1 = c[1] - 4 * zeta * p_2, p_0 = c[0] - 2 * zeta * p_1 - 2 * p_2;
    const double x = y[0] - p_0, s = y[1] - p_1, square = 1 - zeta * zeta;
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
    after[0] = x * (cosine + zeta * sine) + s * sine + p_0 + p_1 * turn + p_2 * turn * turn;
    after[1] = s * (cosine - zeta * sine) - x * sine + p_1 + 2 * p_2 * turn;
}

void second_order_response(double h, double w, double zeta, double u_0, double u_m, double u_1, const double y[2],
                           double half[2], double whole[2])
{
    const double turn = w * h, from[2] = {y[0], y[1] / w};
    if (turn < 0.05)
        second_order_series(turn, zeta, u_0, u_m, u_1, from, half, whole);
    else {
        const double c[3] = {u_0, (4 * u_m - 3 * u_0 - u_1) / turn, 2 * (u_0 - 2 * u_m + u_1) / (turn * turn)};
        second_order_after(0.5 * turn, zeta, c, from, half);
        second_order_after(turn, zeta, c, from, whole);
    }
    half[1] *= w;
    whole[1] *= w;
}

void second_order_response_in_mean(double h, double w, double zeta, double u_0, double u_m, double u_1,
                                   const double y[2], double half[2], double whole[2])
{
    const double turn = w * h;
    second_order_response(h, w, zeta, u_0, u_m, u_1, y, half, whole);
    if (turn > SHORT)
        half[0] = middle_of((u_0 + 4 * u_m + u_1) / 6 - (2 * zeta * (whole[0] - y[0]) + (whole[1] - y[1]) / w) / turn,
                            y[0], whole[0]);
}
