/* How do linear states answer over a step? By the functions phi1 and phi2 of the matrix A h: series for a short step,
 * then doubled.
 *
 * phi1(x) = (e^x - 1)/x, phi2(x) = (e^x - 1 - x)/x^2; once = h phi1(A h), twice = h^2 phi2(A h). From x to 2x: phi1 =
 * (e^x + 1) phi1 / 2, phi2 = (phi1^2 + 2 phi2) / 4. A may be singular (a position that nothing holds). Hochbruck and
 * Ostermann 2010, section 4.2.
 */
#include "linear_response.h"
#include "machine.h"

#include <math.h>
#include <string.h>

enum { TERMS = 14 }; /* at a norm of 1/2 the next one is below 1e-17 */

static void multiply(int n, const double *a, const double *b, double *product)
{
    double sum[STATES * STATES] = {0};
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            for (int j = 0; j < n; ++j)
                sum[i * n + j] += a[i * n + k] * b[k * n + j];
    memcpy(product, sum, (size_t)(n * n) * sizeof *sum);
}

static double norm(int n, const double *a)
{
    double largest = 0;
    for (int i = 0; i < n; ++i) {
        double row = 0;
        for (int j = 0; j < n; ++j)
            row += fabs(a[i * n + j]);
        largest = fmax(largest, row);
    }
    return largest;
}

/* Scales of the states, powers of 2, in which rows and columns of A are of like size: metres and metres per second are
 * not, and a norm that is larger than it need be costs doublings, each of which adds its rounding. Osborne 1960. */
static void balance(int n, const double *A, double *scale)
{
    for (int i = 0; i < n; ++i)
        scale[i] = 1;
    for (int sweep = 0, moved = 1; moved && sweep < 20; ++sweep) {
        moved = 0;
        for (int i = 0; i < n; ++i) {
            double row = 0, column = 0;
            for (int j = 0; j < n; ++j) {
                row += i == j ? 0 : fabs(A[i * n + j]) * scale[j] / scale[i];
                column += i == j ? 0 : fabs(A[j * n + i]) * scale[i] / scale[j];
            }
            const double ratio = row / column;
            if (!(ratio > 1e-100 && ratio < 1e100)) /* what is smaller says nothing in the other's units, either */
                continue;
            const double doublings = round(0.5 * log2(ratio));
            if (doublings != 0)
                scale[i] *= exp2(doublings);
            moved |= doublings != 0;
        }
    }
}

void linear_response(int n, const double *A, double h, double *once, double *twice)
{
    double x[STATES * STATES] = {0}, power[STATES * STATES] = {0}, phi1[STATES * STATES] = {0},
                      phi2[STATES * STATES] = {0};
    double scale[STATES], even[STATES * STATES];
    balance(n, A, scale);
    for (int i = 0; i < n * n; ++i)
        even[i] = A[i] * scale[i % n] / scale[i / n];
    const double size = norm(n, even) * h;
    const int doublings = size > 0.5 && size < INFINITY ? (int)ceil(log2(size) + 1) : 0;
    for (int i = 0; i < n * n; ++i)
        x[i] = ldexp(even[i] * h, -doublings);
    for (int i = 0; i < n; ++i)
        power[i * n + i] = 1;
    double factorial = 1; /* of k + 1 */
    for (int k = 0; k < TERMS; ++k) {
        factorial *= k + 1;
        for (int i = 0; i < n * n; ++i) {
            phi1[i] += power[i] / factorial;
            phi2[i] += power[i] / (factorial * (k + 2));
        }
        multiply(n, power, x, power);
    }
    multiply(n, x, phi1, power);
    for (int i = 0; i < n; ++i)
        power[i * n + i] += 1; /* e^x */
    for (int d = 0; d < doublings; ++d) {
        double square[STATES * STATES], grown[STATES * STATES];
        multiply(n, phi1, phi1, square);
        multiply(n, power, phi1, grown);
        multiply(n, power, power, power);
        for (int i = 0; i < n * n; ++i) {
            phi1[i] = (grown[i] + phi1[i]) / 2;
            phi2[i] = (square[i] + 2 * phi2[i]) / 4;
        }
    }
    for (int i = 0; i < n * n; ++i) {
        once[i] = h * phi1[i] * scale[i / n] / scale[i % n];
        twice[i] = h * h * phi2[i] * scale[i / n] / scale[i % n];
    }
}
