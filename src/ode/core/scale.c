#include "ode/core/scale.h"

#include "base/detmath.h"
#include "base/run_status.h"

static void raise_to(double *most, double value)
{
    double size = value < 0 ? -value : value;
    if (size - size == 0 && size > *most)
        *most = size;
}

static void see_energy(ll_ode_scale *scale, const ll_ode_problem *problem, const ll_ode *ode, double t,
                       const double *y)
{
    double total = problem->energy(ode->params, t, y), resting[LL_ODE_DIM_MAX];
    raise_to(&scale->energy, total);
    if (!ll_ode_mechanical(ode))
        return;
    int half = ode->dim / 2;
    resting[0] = y[0]; /* one coordinate is the usual case, and too few for a loop in vectors */
    resting[half] = 0;
    for (int i = 1; i < half; i++) {
        resting[i] = y[i];
        resting[half + i] = 0;
    }
    double potential = problem->energy(ode->params, t, resting);
    raise_to(&scale->energy, potential);
    raise_to(&scale->energy, total - potential);
}

void ll_ode_scale_see(ll_ode_scale *scale, const ll_ode_problem *problem, const ll_ode *ode, double t,
                      const double *y)
{
    double square = 0;
    for (int i = 0; i < ode->dim; i++)
        square += y[i] * y[i];
    raise_to(&scale->state, ll_sqrt(square));
    if (problem->energy != NULL)
        see_energy(scale, problem, ode, t, y);
}

void ll_ode_scale_join(ll_ode_scale *scale, const ll_ode_scale *other)
{
    raise_to(&scale->state, other->state);
    raise_to(&scale->energy, other->energy);
}

static bool beyond(double value, double scale)
{
    double size = value < 0 ? -value : value;
    return !(size - size == 0) || (scale > 0 && size > LL_BLOWN_UP * scale);
}

bool ll_ode_blown_up(const ll_ode_scale *scale, double error, double energy)
{
    return beyond(error, scale->state) || beyond(energy, scale->energy);
}

ll_ode_control ll_ode_reference_control(double t_end)
{
    return (ll_ode_control){.t_end = t_end, .tolerance = 1e-14, .absolute = 1e-18};
}
