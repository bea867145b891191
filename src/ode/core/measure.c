#include "ode/core/measure.h"

#include <string.h>

#include "base/detmath.h"
#include "ode/core/method_internal.h"

/* An initial energy below this fraction of the scale is the difference of larger ones. */
#define NO_ENERGY 1e-6

static void raise_to(double *most, double size)
{
    *most = size > *most ? size : *most;
}

void ll_ode_measure_start(ll_ode_measure *m, double *each, const ll_ode_problem *problem, const ll_ode *ode,
                          const double *y0)
{
    *m = (ll_ode_measure){0};
    memset(each, 0, LL_ODE_ROWS * (size_t)ode->dim * sizeof *each);
    m->energy_start = problem->energy ? problem->energy(ode->params, 0, y0) : 0;
    ll_ode_scale_see(&m->scale, problem, ode, 0, y0);
    for (int i = 0; i < ode->dim; i++)
        each[LL_ODE_SIZE * ode->dim + i] = ll_abs(y0[i]);
}

void ll_ode_measure_at(ll_ode_measure *m, double *each, const ll_ode *ode, double t, double span,
                       const double *y, const double *solution, bool known)
{
    int n = ode->dim;
    double square = 0;
    for (int i = 0; i < n; i++) {
        double size = ll_abs(y[i] - solution[i]);
        square += size * size;
        each[LL_ODE_LAST * n + i] = size;
        raise_to(&each[LL_ODE_SIZE * n + i], ll_abs(solution[i]));
        if (!known)
            continue;
        raise_to(&each[LL_ODE_MOST * n + i], size);
        each[LL_ODE_SQUARES * n + i] += span * size * size;
    }
    m->t = t;
    m->error = ll_sqrt(square);
    if (!known)
        return;
    raise_to(&m->error_max, m->error);
    m->error_squares += span * square;
    m->time += span;
}

void ll_ode_measure_energy(ll_ode_measure *m, const ll_ode_problem *problem, const ll_ode *ode, double passed,
                           double span, const double *y)
{
    if (problem->energy == NULL)
        return;
    m->drift = problem->energy(ode->params, m->t, y) - m->energy_start;
    raise_to(&m->drift_max, ll_abs(m->drift));
    const double terms[] = {1, passed, passed * passed, m->drift, passed * m->drift};
    for (int k = 0; k < 5; k++)
        m->sums[k] += span * terms[k];
}

int ll_ode_measure_points(const ll_ode_run *run, const ll_ode_method *method, double *t)
{
    int points = method->body->dense != NULL ? LL_ODE_POINTS : 1;
    for (int k = 1; k < points; k++)
        t[k - 1] = run->t_last + (run->t - run->t_last) * k / points;
    t[points - 1] = run->t;
    return points;
}

bool ll_ode_measure_blown_up(const ll_ode_measure *m)
{
    return ll_ode_blown_up(&m->scale, m->error, m->drift);
}

double ll_ode_measure_rms(const ll_ode_measure *m)
{
    return m->time > 0 ? ll_sqrt(m->error_squares / m->time) : 0;
}

/* The largest of `n` magnitudes. */
static double largest(const double *size, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        raise_to(&most, size[i]);
    return most;
}

double ll_ode_measure_weighted(const ll_ode_measure *m, const double *each, const ll_ode *ode, int row)
{
    int n = ode->dim, group = ll_ode_mechanical(ode) ? n / 2 : 1;
    const double *size = each + LL_ODE_SIZE * n, *error = each + row * n;
    double all = largest(size, n), worst = 0;
    for (int i = 0; i < n; i++) {
        double scale = largest(size + i / group * group, group);
        double value = row == LL_ODE_SQUARES ? (m->time > 0 ? ll_sqrt(error[i] / m->time) : 0) : error[i];
        scale = scale > 0 ? scale : all;
        if (value > 0)
            raise_to(&worst, scale > 0 ? value / scale : value);
    }
    return worst;
}

bool ll_ode_measure_resolved(const ll_ode_measure *m, const double *each, const ll_ode_problem *problem,
                             const ll_ode *ode)
{
    return !problem->stiff || problem->energy != NULL ||
           (ll_ode_measure_weighted(m, each, ode, LL_ODE_LAST) <= LL_ODE_RESOLVED &&
            ll_ode_measure_weighted(m, each, ode, LL_ODE_SQUARES) <= LL_ODE_RESOLVED);
}

double ll_ode_measure_relative(const ll_ode_measure *m, double drift)
{
    double start = ll_abs(m->energy_start), most = m->scale.energy;
    return drift / (start > NO_ENERGY * most ? start : most > 0 ? most : 1);
}

double ll_ode_measure_slope(const ll_ode_measure *m)
{
    const double *s = m->sums;
    double determinant = s[0] * s[2] - s[1] * s[1];
    return determinant > 0 ? ll_ode_measure_relative(m, (s[0] * s[4] - s[1] * s[3]) / determinant) : 0;
}
