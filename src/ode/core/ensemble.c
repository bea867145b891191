#include "ode/core/ensemble.h"

void ll_ensemble_accelerate(const ll_ensemble *e)
{
    for (int i = 0; i < e->count; i++)
        e->a[i] = -e->k[i] * e->x[i];
}

void ll_ensemble_semi_implicit_euler(const ll_ensemble *e, double dt, int64_t steps)
{
    const double *restrict k = e->k;
    double *restrict x = e->x, *restrict v = e->v;
    for (int64_t n = 0; n < steps; n++)
        for (int i = 0; i < e->count; i++) {
            v[i] += dt * (-k[i] * x[i]);
            x[i] += dt * v[i];
        }
}

void ll_ensemble_velocity_verlet(const ll_ensemble *e, double dt, int64_t steps)
{
    const double *restrict k = e->k;
    double *restrict x = e->x, *restrict v = e->v, *restrict a = e->a;
    for (int64_t n = 0; n < steps; n++)
        for (int i = 0; i < e->count; i++) {
            x[i] = x[i] + dt * v[i] + dt * dt / 2 * a[i];
            double after = -k[i] * x[i];
            v[i] = v[i] + dt / 2 * (a[i] + after);
            a[i] = after;
        }
}
