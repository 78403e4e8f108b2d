/* How is one step of Radau IIA taken? The stages by Newton's method, with the slope of the rates at each stage. */
#include "radau.h"

#include <math.h>
#include <string.h>

enum { S = STAGES_OF_RADAU, UNKNOWNS = STAGES_OF_RADAU * MOST_STATES };

/* The columns of a row-major system, solved in place by elimination with pivots: rows of `stride`, right sides `width`
 * behind. */
static int eliminate(int count, int stride, double *A, int *pivot)
{
    for (int k = 0; k < count; ++k) {
        int best = k;
        for (int i = k + 1; i < count; ++i)
            best = fabs(A[i * stride + k]) > fabs(A[best * stride + k]) ? i : best;
        pivot[k] = best;
        if (!(fabs(A[best * stride + k]) > 0))
            return 0;
        for (int j = 0; j < count && best != k; ++j) {
            const double held = A[k * stride + j];
            A[k * stride + j] = A[best * stride + j];
            A[best * stride + j] = held;
        }
        for (int i = k + 1; i < count; ++i) {
            const double share = A[i * stride + k] /= A[k * stride + k];
            for (int j = k + 1; j < count && share != 0; ++j)
                A[i * stride + j] -= share * A[k * stride + j];
        }
    }
    return 1;
}

static void substitute(int count, int stride, const double *A, const int *pivot, double *x)
{
    for (int k = 0; k < count; ++k) {
        const double held = x[k];
        x[k] = x[pivot[k]];
        x[pivot[k]] = held;
    }
    for (int k = 0; k < count; ++k)
        for (int j = 0; j < k; ++j)
            x[k] -= A[k * stride + j] * x[j];
    for (int k = count - 1; k >= 0; --k) {
        for (int j = k + 1; j < count; ++j)
            x[k] -= A[k * stride + j] * x[j];
        x[k] /= A[k * stride + k];
    }
}

/* Weights w with sum w_j c_j^k = moment[k]. */
static void weights(const double *c, const double *moment, double *w)
{
    double A[S * S];
    int pivot[S];
    for (int k = 0; k < S; ++k) {
        w[k] = moment[k];
        for (int j = 0; j < S; ++j)
            A[k * S + j] = pow(c[j], k);
    }
    eliminate(S, S, A, pivot);
    substitute(S, S, A, pivot, w);
}

void radau_begin(struct Radau *r)
{
    /* Hairer and Wanner's RADAU, s = 5 */
    static const double c[S] = {0.0571041961145176821931, 0.276843013638123827680, 0.583590432368916820266,
                                0.860240135656219447851, 1};
    const double real_eigenvalue = 6.286704751729276645173; /* of the inverse of a */
    double moment[S];
    memcpy(r->c, c, sizeof c);
    for (int i = 0; i < S; ++i) {
        for (int k = 0; k < S; ++k)
            moment[k] = pow(c[i], k + 1) / (k + 1);
        weights(c, moment, r->a[i]);
    }
    r->first = 1 / real_eigenvalue;
    for (int k = 0; k < S; ++k)
        moment[k] = 1. / (k + 1) - (k == 0 ? r->first : 0);
    weights(c, moment, r->other);
    for (int j = 0; j < S; ++j)
        r->other[j] -= r->a[S - 1][j];
}

/* d f/d y at (t, y), where f is known; J[i * n + j]. */
static int slope(struct Radau *r, double t, const double *y, const double *f, double *J)
{
    const int n = r->states;
    double beside[MOST_STATES], f_beside[MOST_STATES], g[MOST_INTEGRALS];
    memcpy(beside, y, sizeof beside);
    for (int j = 0; j < n; ++j) {
        const double step = 1e-6 * r->scale[j];
        beside[j] = y[j] + step;
        if (r->rates(r->what, t, beside, f_beside, g))
            return 0;
        for (int i = 0; i < n; ++i)
            J[i * n + j] = (f_beside[i] - f[i]) / (beside[j] - y[j]);
        beside[j] = y[j];
    }
    return 1;
}

struct Newton {
    double J[S][MOST_STATES * MOST_STATES];
    double A[UNKNOWNS * UNKNOWNS];
    int pivot[UNKNOWNS];
    double f[S][MOST_STATES], g[S][MOST_INTEGRALS];
};

static int factor(struct Radau *r, double t, double h, struct Newton *w, const struct Step *step)
{
    const int n = r->states, count = S * n;
    for (int k = 0; k < S; ++k)
        if (!slope(r, t + r->c[k] * h, step->node[k], w->f[k], w->J[k]))
            return 0;
    for (int k = 0; k < S; ++k)
        for (int m = 0; m < S; ++m)
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j)
                    w->A[(k * n + i) * count + m * n + j] = (k == m && i == j) - h * r->a[k][m] * w->J[m][i * n + j];
    return eliminate(count, count, w->A, w->pivot);
}

static int rates_at_nodes(struct Radau *r, double t, double h, struct Newton *w, const struct Step *step)
{
    for (int k = 0; k < S; ++k)
        if (r->rates(r->what, t + r->c[k] * h, step->node[k], w->f[k], w->g[k]))
            return 0;
    return 1;
}

/* One correction of all nodes; its size over the scale. */
static double correct(struct Radau *r, double h, const double *y, struct Newton *w, struct Step *step)
{
    const int n = r->states;
    double x[UNKNOWNS], size = 0;
    for (int k = 0; k < S; ++k)
        for (int i = 0; i < n; ++i) {
            double sum = 0;
            for (int m = 0; m < S; ++m)
                sum += r->a[k][m] * w->f[m][i];
            x[k * n + i] = y[i] + h * sum - step->node[k][i];
        }
    substitute(S * n, S * n, w->A, w->pivot, x);
    for (int k = 0; k < S; ++k)
        for (int i = 0; i < n; ++i) {
            step->node[k][i] += x[k * n + i];
            size = fmax(size, fabs(x[k * n + i]) / r->scale[i]);
            if (!isfinite(x[k * n + i]))
                return INFINITY;
        }
    return size;
}

static int solve_nodes(struct Radau *r, double t, double h, const double *y, struct Newton *w, struct Step *step)
{
    double before = INFINITY;
    for (int n = 0; n < 30; ++n) {
        if (!rates_at_nodes(r, t, h, w, step))
            return 0;
        if (n % 5 == 0 && !factor(r, t, h, w, step))
            return 0;
        const double size = correct(r, h, y, w, step);
        if (!isfinite(size))
            return 0;
        if (size < 1e-3 * r->tolerance || (n > 2 && size < 1e-12 && size > 0.5 * before))
            return rates_at_nodes(r, t, h, w, step);
        before = size;
    }
    return 0;
}

int radau_step(struct Radau *r, double t, double h, const double *y, const double *f, const double *g,
               struct Step *step)
{
    const int n = r->states;
    struct Newton w;
    double off[MOST_STATES], A[MOST_STATES * MOST_STATES];
    int pivot[MOST_STATES];
    for (int k = 0; k < S; ++k)
        memcpy(step->node[k], y, sizeof step->node[k]);
    if (!solve_nodes(r, t, h, y, &w, step))
        return 0;
    step->error = 0;
    for (int q = 0; q < r->integrals; ++q) {
        double miss = r->first * g[q];
        step->gain[q] = 0;
        for (int k = 0; k < S; ++k) {
            step->gain[q] += h * r->a[S - 1][k] * w.g[k][q];
            miss += r->other[k] * w.g[k][q];
        }
        step->error = fmax(step->error, 0.1 * fabs(miss) / (r->tolerance * r->integral_scale[q]));
    }
    for (int i = 0; i < n; ++i) {
        off[i] = h * r->first * f[i];
        for (int k = 0; k < S; ++k)
            off[i] += h * r->other[k] * w.f[k][i];
        for (int j = 0; j < n; ++j)
            A[i * n + j] = (i == j) - h * r->first * w.J[0][i * n + j];
    }
    if (!eliminate(n, n, A, pivot))
        return 0;
    substitute(n, n, A, pivot, off);
    step->of_states = 0;
    for (int i = 0; i < n; ++i)
        step->of_states = fmax(step->of_states, fabs(off[i]) / (r->tolerance * r->scale[i]));
    step->error = fmax(step->error, step->of_states);
    return isfinite(step->error) ? 1 : 0;
}

int radau_straight(struct Radau *r, double t, double h, const double *y, const double *f, const double *g,
                   struct Step *step)
{
    const int n = r->states;
    double J[MOST_STATES * MOST_STATES], A[MOST_STATES * MOST_STATES], off[MOST_STATES];
    int pivot[MOST_STATES];
    if (!slope(r, t, y, f, J))
        return 0;
    step->error = step->of_states = 0;
    for (int q = 0; q < r->integrals; ++q)
        step->gain[q] = h * g[q];
    for (int k = 0; k < S; ++k) {
        for (int i = 0; i < n; ++i) {
            off[i] = r->c[k] * h * f[i];
            for (int j = 0; j < n; ++j)
                A[i * n + j] = (i == j) - r->c[k] * h * J[i * n + j];
        }
        if (!eliminate(n, n, A, pivot))
            return 0;
        substitute(n, n, A, pivot, off);
        for (int i = 0; i < n; ++i)
            step->node[k][i] = y[i] + off[i];
    }
    return 1;
}
