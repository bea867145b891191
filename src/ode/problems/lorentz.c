/* A charge in a homogeneous magnetic field: x'' = b y', y'' = -b x'. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double b, speed;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, b, "rad/s", 1e-3, 1e4, 1, "Field, as the angular frequency of the circle."),
    LL_ODE_PARAM(params, speed, "m/s", 1e-3, 1e6, 1, "Initial speed."),
};
LL_ODE_TABLE(ll_ode_lorentz_table, "lorentz", "Parameters of the charge.", rows, params);

LL_ODE_ACCELERATION(acceleration, 4, {
    double b = ((const params *)p)->b;
    a[0] = b * v[1];
    a[1] = -b * v[0];
})

LL_ODE_MAGNETIC(magnetic, 4, {
    e[0] = e[1] = b[0] = b[1] = (real){0};
    b[2] = b[0] + ((const params *)p)->b;
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration), .leapfrog = magnetic_leapfrog};

static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    double b = ((const params *)p)->b;
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS];
    ll_series_take_plane(row, q, v);
    for (int k = 0; k < order; k++)
        ll_series_move(q, v, (ll_term){b, -b} * ll_term_swapped(v[k]), k);
    ll_series_put_plane(row, q, v, order);
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 4,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = acceleration,
                    .magnetic = magnetic,
                    .series = series,
                    .kernels = &kernels};
}

static void start(const void *p, double *y)
{
    y[0] = y[1] = y[3] = 0;
    y[2] = ((const params *)p)->speed;
}

static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    double half = ll_sin(c->b * t / 2);
    y[0] = c->speed * ll_sin(c->b * t) / c->b;
    y[1] = -2 * c->speed * half * half / c->b;
    y[2] = c->speed * ll_cos(c->b * t);
    y[3] = -c->speed * ll_sin(c->b * t);
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)p, (void)t;
    return (y[2] * y[2] + y[3] * y[3]) / 2;
}

static const char *const components[] = {"x_m", "y_m", "vx_mps", "vy_mps"};

const ll_ode_problem ll_ode_lorentz = {.name = "lorentz",
                                       .help =
                                           "A charge in a magnetic field: a force that depends on velocity.",
                                       .source = "closed form",
                                       .params = &ll_ode_lorentz_table,
                                       .system = system_of,
                                       .duration = 10,
                                       .start = start,
                                       .components = components,
                                       .exact = exact,
                                       .energy = energy};
