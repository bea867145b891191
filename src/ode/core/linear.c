#include "ode/core/linear.h"

#include <float.h>

#include "base/detmath.h"
#include "ode/core/method_internal.h"

bool ll_lu_factorise(int n, double *a, int32_t *pivot)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k + 1; i < n; i++)
            if (ll_abs(a[i * n + k]) > ll_abs(a[best * n + k]))
                best = i;
        pivot[k] = best;
        if (best != k)
            for (int j = 0; j < n; j++) {
                double other = a[k * n + j];
                a[k * n + j] = a[best * n + j];
                a[best * n + j] = other;
            }
        if (!(ll_abs(a[k * n + k]) > 0) || !(ll_abs(a[k * n + k]) <= DBL_MAX))
            return false;
        double inverse = 1 / a[k * n + k];
        for (int i = k + 1; i < n; i++) {
            double factor = a[i * n + k] *= inverse;
            if (factor != 0)
                for (int j = k + 1; j < n; j++)
                    a[i * n + j] -= factor * a[k * n + j];
        }
        a[k * n + k] = inverse; /* the solution needs the inverse of the diagonal */
    }
    return true;
}

bool ll_lu_positive(int n, const double *a, const int32_t *pivot)
{
    bool positive = true;
    for (int k = 0; k < n; k++)
        positive ^= (a[k * n + k] < 0) ^ (pivot[k] != k);
    return positive;
}

void ll_lu_solve(int n, const double *a, const int32_t *pivot, double *b)
{
    for (int k = 0; k < n; k++) {
        double value = b[pivot[k]];
        b[pivot[k]] = b[k];
        b[k] = value;
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++)
            b[i] -= a[i * n + j] * b[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[i * n + j] * b[j];
        b[i] *= a[i * n + i];
    }
}

static void swap(double *x, double *y)
{
    double other = *x;
    *x = *y;
    *y = other;
}

bool ll_lu_factorise_complex(int n, double *re, double *im, int32_t *pivot)
{
    for (int k = 0; k < n; k++) {
        int best = k;
        double most = -1;
        for (int i = k; i < n; i++) {
            double size = ll_abs(re[i * n + k]) + ll_abs(im[i * n + k]);
            if (size > most)
                most = size, best = i;
        }
        pivot[k] = best;
        for (int j = 0; j < n && best != k; j++) {
            swap(&re[k * n + j], &re[best * n + j]);
            swap(&im[k * n + j], &im[best * n + j]);
        }
        if (!(most > 0) || !(most <= DBL_MAX))
            return false;
        double x = re[k * n + k], y = im[k * n + k], size = x * x + y * y;
        double inverse_re = x / size, inverse_im = -y / size;
        for (int i = k + 1; i < n; i++) {
            double p = re[i * n + k], q = im[i * n + k];
            double factor_re = re[i * n + k] = p * inverse_re - q * inverse_im;
            double factor_im = im[i * n + k] = p * inverse_im + q * inverse_re;
            for (int j = k + 1; j < n; j++) {
                re[i * n + j] -= factor_re * re[k * n + j] - factor_im * im[k * n + j];
                im[i * n + j] -= factor_re * im[k * n + j] + factor_im * re[k * n + j];
            }
        }
        re[k * n + k] = inverse_re;
        im[k * n + k] = inverse_im;
    }
    return true;
}

void ll_lu_solve_complex(int n, const double *re, const double *im, const int32_t *pivot, double *b_re,
                         double *b_im)
{
    for (int k = 0; k < n; k++) {
        swap(&b_re[k], &b_re[pivot[k]]);
        swap(&b_im[k], &b_im[pivot[k]]);
    }
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++) {
            b_re[i] -= re[i * n + j] * b_re[j] - im[i * n + j] * b_im[j];
            b_im[i] -= re[i * n + j] * b_im[j] + im[i * n + j] * b_re[j];
        }
    for (int i = n - 1; i >= 0; i--) {
        double x = b_re[i], y = b_im[i];
        for (int j = i + 1; j < n; j++) {
            x -= re[i * n + j] * b_re[j] - im[i * n + j] * b_im[j];
            y -= re[i * n + j] * b_im[j] + im[i * n + j] * b_re[j];
        }
        b_re[i] = x * re[i * n + i] - y * im[i * n + i];
        b_im[i] = x * im[i * n + i] + y * re[i * n + i];
    }
}

void ll_ode_jacobian_at(ll_ode_run *run, const ll_ode *ode, double t, const double *y, const double *f,
                        double *jacobian, double *scratch)
{
    int n = run->dim;
    run->counters.jacobians++;
    if (ode->jacobian != NULL) {
        ode->jacobian(ode->params, t, y, jacobian);
        return;
    }
    double *moved = scratch, *g = scratch + run->stride;
    for (int i = 0; i < n; i++)
        moved[i] = y[i];
    for (int j = 0; j < n; j++) {
        double size = ll_abs(y[j]);
        double step = ll_sqrt(DBL_EPSILON * (size > 1e-5 ? size : 1e-5));
        moved[j] = y[j] + step;
        step = moved[j] - y[j]; /* the step as rounded in y */
        ll_ode_f(run, ode, t, moved, g);
        for (int i = 0; i < n; i++)
            jacobian[i * n + j] = (g[i] - f[i]) / step;
        moved[j] = y[j];
    }
}
