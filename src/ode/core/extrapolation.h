/* Extrapolation of the midpoint rule (Gragg, Bulirsch, Stoer) and of leapfrog, several sequences of substeps
 * at a time.
 *
 * A step of h is made k times, by 1, 2 ... k substeps (pairs of them for the midpoint rule). The error of
 * both rules has only even powers of the substep, so that one weighted sum of the k results is of order 2 k,
 * and another, over the finest k - 1 of them, gives an estimate (E. Hairer, S. P. Norsett, G. Wanner, Solving
 * Ordinary Differential Equations I, II.9 and II.14). The sequences are independent. Four of them run
 * together, one per lane in two pairs, so that the arithmetic of one hides the latency of another; lanes that
 * end early take the short ones. Sequentially, a step costs k evaluations for leapfrog and 2 k for the
 * midpoint rule.
 *
 * The loops stand here, inline, for a problem to have them compiled with its own f within
 * (ode/core/field.h). */
#pragma once

#include <string.h>

#include "ode/core/embedded.h"

enum { LL_COLUMNS_MAX = 7, LL_ROWS_MAX = 2 * LL_COLUMNS_MAX - 1, LL_PAIRS = 2 };

/* One evaluation of two states; lengths are fractions of the step. */
typedef struct ll_ode_row {
    ll_pair h;           /* of the substep; 0: the lane is idle */
    ll_pair c;           /* time of the evaluation */
    ll_pair weight;      /* in the result, for columns that end with this row */
    ll_pair error;       /* in the estimate */
    ll_pair keep;        /* 0: another column begins after this row, otherwise 1 */
    ll_pair next;        /* length of that column's substeps */
    double active;       /* whether any lane is active */
    double ends, begins; /* whether any column ends or begins */
    double reserved;
} ll_ode_row;

typedef struct ll_ode_plan {
    double columns; /* 0: plan not made yet */
    double rows;
    double evaluations; /* of all columns */
    double reserved;
    ll_ode_row row[LL_ROWS_MAX][LL_PAIRS];
} ll_ode_plan;

/* Makes the step of a trial for the midpoint rule; its `k` is f at the start. Returns the mean square of the
 * estimated error relative to the tolerance. */
typedef double ll_ode_rows(const void *params, const ll_ode_plan *plan, const ll_ode_trial *trial);

/* Sums the increment and the estimate over the lanes. */
LL_INLINE double ll_ode_gather(int dim, const ll_pair *sum, const ll_pair *estimate, const ll_ode_trial *s)
{
    double next[LL_ODE_DIM_MAX], error[LL_ODE_DIM_MAX];
    for (int i = 0; i < dim; i++) {
        next[i] = s->y[i] + (sum[i][0] + sum[i][1]);
        error[i] = estimate[i][0] + estimate[i][1];
    }
    memcpy(s->next, next, (size_t)dim * sizeof *next);
    return ll_ode_mean_square(dim, error, s->y, next, s->absolute, s->relative);
}

/* One row of the midpoint rule y(i + 1) = y(i - 1) + 2 h f(y(i)). Lanes hold increments from the initial
 * state: sums of small numbers lose fewer digits. */
LL_INLINE void ll_ode_midpoint_row(int dim, ll_ode_rhs_pair *f, const void *params, const ll_ode_row *x,
                                   double t, double h, const double *y, const double *f0, ll_pair *before,
                                   ll_pair *now, ll_pair *sum, ll_pair *error)
{
    if (x->active == 0)
        return;
    ll_pair time = t + h * x->c, step = 2 * h * x->h, point[LL_ODE_DIM_MAX], slope[LL_ODE_DIM_MAX];
    for (int i = 0; i < dim; i++)
        point[i] = y[i] + now[i];
    f(params, &time, point, slope);
    for (int i = 0; i < dim; i++) {
        ll_pair next = before[i] + step * slope[i];
        before[i] = now[i];
        now[i] = next;
    }
    if (x->ends != 0)
        for (int i = 0; i < dim; i++) {
            sum[i] += x->weight * now[i];
            error[i] += x->error * now[i];
        }
    if (x->begins != 0)
        for (int i = 0; i < dim; i++) {
            before[i] *= x->keep;
            now[i] = now[i] * x->keep + h * x->next * f0[i];
        }
}

/* Every column begins with a step of explicit Euler. */
LL_INLINE double ll_ode_midpoint_rows(int dim, ll_ode_rhs_pair *f, const void *params,
                                      const ll_ode_plan *plan, const ll_ode_trial *trial)
{
    ll_pair before_a[LL_ODE_DIM_MAX], now_a[LL_ODE_DIM_MAX], before_b[LL_ODE_DIM_MAX], now_b[LL_ODE_DIM_MAX];
    ll_pair sum[LL_ODE_DIM_MAX], error[LL_ODE_DIM_MAX];
    const double *y = trial->y, *f0 = trial->k, t = trial->t, h = trial->h;
    for (int i = 0; i < dim; i++) {
        sum[i] = error[i] = (ll_pair){0};
        before_a[i] = before_b[i] = (ll_pair){0};
        now_a[i] = h * plan->row[0][0].h * f0[i];
        now_b[i] = h * plan->row[0][1].h * f0[i];
    }
    const ll_ode_row(*x)[LL_PAIRS] = plan->row, (*end)[LL_PAIRS] = x + (int)plan->rows;
    for (; x < end; x++) {
        ll_ode_midpoint_row(dim, f, params, &(*x)[0], t, h, y, f0, before_a, now_a, sum, error);
        ll_ode_midpoint_row(dim, f, params, &(*x)[1], t, h, y, f0, before_b, now_b, sum, error);
    }
    return ll_ode_gather(dim, sum, error, trial);
}

/* Solves a = e + m x b for a, where m is the mean of v and v + h a. */
LL_INLINE void ll_ode_turn(int half, ll_pair h, const ll_pair *v, const ll_pair *b, ll_pair *a)
{
    ll_pair s = h / 2 * b[2], w[3], m[3];
    for (int i = 0; i < half; i++)
        w[i] = v[i] + h / 2 * a[i];
    if (half == 2) {
        ll_pair size = 1 / (1 + s * s);
        m[0] = (w[0] + w[1] * s) * size;
        m[1] = (w[1] - w[0] * s) * size;
        a[0] += m[1] * b[2];
        a[1] -= m[0] * b[2];
        return;
    }
    ll_pair x = h / 2 * b[0], y = h / 2 * b[1], size = 1 / (1 + x * x + y * y + s * s);
    ll_pair along = w[0] * x + w[1] * y + w[2] * s;
    m[0] = (w[0] + w[1] * s - w[2] * y + along * x) * size;
    m[1] = (w[1] + w[2] * x - w[0] * s + along * y) * size;
    m[2] = (w[2] + w[0] * y - w[1] * x + along * s) * size;
    a[0] += m[1] * b[2] - m[2] * b[1];
    a[1] += m[2] * b[0] - m[0] * b[2];
    a[2] += m[0] * b[1] - m[1] * b[0];
}

enum { LL_HALF_MAX = LL_ODE_DIM_MAX / 2 };

/* One row of leapfrog: half a drift, a kick by an acceleration independent of v or by a magnetic force (the
 * other one is NULL), half a drift. `moved`: increment of q at the middle of a substep, `gained`: of v at its
 * start. */
LL_INLINE void ll_ode_leapfrog_row(int half, ll_ode_acceleration_pair *acceleration,
                                   ll_ode_magnetic_pair *magnetic, const void *params, const ll_ode_row *x,
                                   double t, double h, const double *y, ll_pair *moved, ll_pair *gained,
                                   ll_pair *sum, ll_pair *error)
{
    if (x->active == 0)
        return;
    const double *v = y + half;
    ll_pair time = t + h * x->c, step = h * x->h, b[3];
    ll_pair point[LL_HALF_MAX], speed[LL_HALF_MAX], ahead[LL_HALF_MAX], a[LL_HALF_MAX];
    for (int i = 0; i < half; i++) {
        point[i] = y[i] + moved[i];
        speed[i] = v[i] + gained[i];
        ahead[i] = moved[i] + step * speed[i]; /* does not depend on a */
    }
    if (magnetic != NULL) {
        magnetic(params, &time, point, a, b);
        ll_ode_turn(half, step, speed, b, a);
    } else {
        acceleration(params, &time, point, speed, a);
    }
    if (x->ends != 0)
        for (int i = 0; i < half; i++) {
            ll_pair gain = gained[i] + step * a[i], end = moved[i] + step / 2 * (v[i] + gain);
            sum[i] += x->weight * end;
            error[i] += x->error * end;
            sum[half + i] += x->weight * gain;
            error[half + i] += x->error * gain;
        }
    for (int i = 0; i < half; i++) {
        moved[i] = ahead[i] + step * step * a[i];
        gained[i] += step * a[i];
    }
    if (x->begins != 0)
        for (int i = 0; i < half; i++) {
            gained[i] *= x->keep;
            moved[i] = moved[i] * x->keep + h * x->next * (v[i] / 2);
        }
}

LL_INLINE double ll_ode_leapfrog_rows(int half, ll_ode_acceleration_pair *acceleration,
                                      ll_ode_magnetic_pair *magnetic, const void *params,
                                      const ll_ode_plan *plan, const ll_ode_trial *trial)
{
    const double *y = trial->y, *v = y + half, t = trial->t, h = trial->h;
    ll_pair sum[LL_ODE_DIM_MAX], error[LL_ODE_DIM_MAX];
    for (int i = 0; i < 2 * half; i++)
        sum[i] = error[i] = (ll_pair){0};
    ll_pair moved_a[LL_HALF_MAX], gained_a[LL_HALF_MAX], moved_b[LL_HALF_MAX], gained_b[LL_HALF_MAX];
    for (int i = 0; i < half; i++) {
        moved_a[i] = h * plan->row[0][0].h * (v[i] / 2);
        moved_b[i] = h * plan->row[0][1].h * (v[i] / 2);
        gained_a[i] = gained_b[i] = (ll_pair){0};
    }
    const ll_ode_row(*x)[LL_PAIRS] = plan->row, (*end)[LL_PAIRS] = x + (int)plan->rows;
    for (; x < end; x++) {
        ll_ode_leapfrog_row(half, acceleration, magnetic, params, &(*x)[0], t, h, y, moved_a, gained_a, sum,
                            error);
        ll_ode_leapfrog_row(half, acceleration, magnetic, params, &(*x)[1], t, h, y, moved_b, gained_b, sum,
                            error);
    }
    return ll_ode_gather(2 * half, sum, error, trial);
}
