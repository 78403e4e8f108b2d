/* Which x solves A x = b? Gaussian elimination with partial pivoting (Golub and Van Loan, algorithm 3.4.1); an unknown
 * that nothing depends on becomes 0. */
#include "../stages.h"

#include <math.h>

void solve_linear(int count, double A[UNKNOWNS][UNKNOWNS], double x[UNKNOWNS])
{
    for (int c = 0; c < count; ++c) {
        int best = c;
        for (int r = c + 1; r < count; ++r)
            best = fabs(A[r][c]) > fabs(A[best][c]) ? r : best;
        for (int k = 0; k < count && best != c; ++k) {
            const double swap = A[c][k];
            A[c][k] = A[best][k];
            A[best][k] = swap;
        }
        const double other = x[c];
        x[c] = x[best];
        x[best] = best == c ? x[best] : other;
        for (int r = c + 1; r < count && A[c][c] != 0; ++r) {
            const double part = A[r][c] / A[c][c];
            for (int k = c; k < count; ++k)
                A[r][k] -= part * A[c][k];
            x[r] -= part * x[c];
        }
    }
    for (int c = count - 1; c >= 0; --c) {
        for (int k = c + 1; k < count; ++k)
            x[c] -= A[c][k] * x[k];
        x[c] = A[c][c] != 0 ? x[c] / A[c][c] : 0;
    }
}
