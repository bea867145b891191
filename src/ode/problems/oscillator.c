/* The harmonic oscillator, x'' = -omega^2 x - 2 zeta omega x': undamped as `oscillator`, and `damped`. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double omega, x0, v0, zeta;
} params;

#define COMMON                                                                                               \
    LL_ODE_PARAM(params, omega, "rad/s", 1e-3, 1e4, 1, "Natural frequency."),                                \
        LL_ODE_PARAM(params, x0, "m", -1e6, 1e6, 1, "Initial position."),                                    \
        LL_ODE_PARAM(params, v0, "m/s", -1e6, 1e6, 0, "Initial speed.")

static const ll_param rows[] = {COMMON};
LL_ODE_TABLE(ll_ode_oscillator_table, "oscillator", "Parameters of the oscillator.", rows, params);

static const ll_param damped_rows[] = {
    COMMON, LL_ODE_PARAM(params, zeta, NULL, 0, 100, 0.1, "Damping ratio; 1 is critical.")};
LL_ODE_TABLE(ll_ode_damped_table, "damped", "Parameters of the damped oscillator.", damped_rows, params);

LL_ODE_ACCELERATION(acceleration, 2, {
    const params *c = p;
    a[0] = -(c->omega * c->omega) * q[0];
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

LL_ODE_ACCELERATION(damped_acceleration, 2, {
    const params *c = p;
    a[0] = -(c->omega * c->omega) * q[0] - 2 * c->zeta * c->omega * v[0];
})

static const struct ll_ode_kernels damped_kernels = {LL_ODE_KERNELS(damped_acceleration)};

static void jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t, (void)y;
    const params *c = p;
    j[0] = 0;
    j[1] = 1;
    j[2] = -(c->omega * c->omega);
    j[3] = -2 * c->zeta * c->omega;
}

static void linear_series(double w2, double damping, int order, double *row)
{
    for (int k = 0; k < order; k++, row += 2) {
        row[2] = row[1] * ll_series_inverse[k + 1];
        row[3] = (-w2 * row[0] - damping * row[1]) * ll_series_inverse[k + 1];
    }
}

static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    const params *c = p;
    linear_series(c->omega * c->omega, 0, order, row);
}

static void damped_series(const void *p, double t, int order, double *row)
{
    (void)t;
    const params *c = p;
    linear_series(c->omega * c->omega, 2 * c->zeta * c->omega, order, row);
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .params = p,
                    .acceleration = acceleration,
                    .series = series,
                    .jacobian = jacobian,
                    .kernels = &kernels};
}

static void damped_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = damped_acceleration,
                    .series = damped_series,
                    .kernels = &damped_kernels,
                    .jacobian = jacobian};
}

static void start(const void *p, double *y)
{
    const params *c = p;
    y[0] = c->x0;
    y[1] = c->v0;
}

/* sin(r t) / r and cos(r t) for real or imaginary r, from r^2: sinh and cosh if it is negative. Includes the
 * damping factor, since the hyperbolic functions alone would overflow. */
static void waves(double r2, double decay, double t, double *c, double *s)
{
    if (r2 > 0) {
        double r = ll_sqrt(r2), e = ll_exp(-decay * t);
        *c = e * ll_cos(r * t);
        *s = e * ll_sin(r * t) / r;
    } else if (r2 < 0) {
        double r = ll_sqrt(-r2), slow = ll_exp((r - decay) * t), fast = ll_exp(-(r + decay) * t);
        *c = (slow + fast) / 2;
        *s = (slow - fast) / (2 * r);
    } else {
        *c = ll_exp(-decay * t);
        *s = t * *c;
    }
}

static bool exact(const void *p, double t, double *y)
{
    const params *k = p;
    double decay = k->zeta * k->omega, w2 = k->omega * k->omega, c, s;
    waves((1 - k->zeta) * (1 + k->zeta) * w2, decay, t, &c, &s);
    y[0] = k->x0 * c + (k->v0 + decay * k->x0) * s;
    y[1] = k->v0 * c - (w2 * k->x0 + decay * k->v0) * s;
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    double w = ((const params *)p)->omega;
    return (y[1] * y[1] + w * w * y[0] * y[0]) / 2;
}

static const char *const components[] = {"x_m", "v_mps"};

const ll_ode_problem ll_ode_oscillator = {.name = "oscillator",
                                          .help = "A mass on a spring, without damping.",
                                          .source = "closed form",
                                          .params = &ll_ode_oscillator_table,
                                          .system = system_of,
                                          .duration = 10,
                                          .start = start,
                                          .components = components,
                                          .exact = exact,
                                          .energy = energy};

const ll_ode_problem ll_ode_damped = {.name = "damped",
                                      .help = "A mass on a spring with linear damping.",
                                      .source = "closed form",
                                      .params = &ll_ode_damped_table,
                                      .system = damped_system,
                                      .duration = 10,
                                      .start = start,
                                      .components = components,
                                      .exact = exact};
