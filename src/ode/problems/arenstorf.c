/* Arenstorf orbit: a satellite between earth and moon, in the co-rotating frame; closed after 17.07 time
 * units. */
#include "ode/core/problem_rows.h"

typedef struct params {
    double mu;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, mu, NULL, 1e-6, 0.5, 0.012277471, "Mass fraction of the moon.")};
LL_ODE_TABLE(ll_ode_arenstorf_table, "arenstorf", "Parameters of the three bodies.", rows, params);

LL_ODE_ACCELERATION(acceleration, 4, {
    double mu = ((const params *)p)->mu, rest = 1 - mu;
    real x = q[0], y = q[1], vx = v[0], vy = v[1], y2 = y * y;
    real e = x + mu, m = x - rest, re2 = e * e + y2, rm2 = m * m + y2;
    real earth = rest / (re2 * ll_real_sqrt(re2)), moon = mu / (rm2 * ll_real_sqrt(rm2));
    a[0] = x + 2 * vy - earth * e - moon * m;
    a[1] = y - 2 * vx - (earth + moon) * y;
})

/* The Coriolis force equals that of a magnetic field of 2. */
LL_ODE_MAGNETIC(magnetic, 4, {
    double mu = ((const params *)p)->mu, rest = 1 - mu;
    real x = q[0], y = q[1], y2 = y * y;
    real far = x + mu, near = x - rest, re2 = far * far + y2, rm2 = near * near + y2;
    real earth = rest / (re2 * ll_real_sqrt(re2)), moon = mu / (rm2 * ll_real_sqrt(rm2));
    e[0] = x - earth * far - moon * near;
    e[1] = y - (earth + moon) * y;
    b[0] = b[1] = 0 * x;
    b[2] = b[0] + 2;
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration), .leapfrog = magnetic_leapfrog};

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 4,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = acceleration,
                    .magnetic = magnetic,
                    .kernels = &kernels};
}

static void start(const void *p, double *y)
{
    (void)p;
    y[0] = 0.994;
    y[1] = y[2] = 0;
    y[3] = -2.00158510637908252240537862224;
}

/* Jacobi's integral. */
static double energy(const void *p, double t, const double *y)
{
    (void)t;
    double mu = ((const params *)p)->mu, e = y[0] + mu, m = y[0] - 1 + mu, y2 = y[1] * y[1];
    return (y[2] * y[2] + y[3] * y[3] - y[0] * y[0] - y2) / 2 - (1 - mu) / ll_sqrt(e * e + y2) -
           mu / ll_sqrt(m * m + y2);
}

static const double reference[] = {0.994, 0, 0, -2.00158510637908252};
static const char *const components[] = {"x_m", "y_m", "vx_mps", "vy_mps"};

const ll_ode_problem ll_ode_arenstorf = {.name = "arenstorf",
                                         .help =
                                             "A closed orbit between earth and moon, with a close encounter.",
                                         .source = "Hairer, Norsett and Wanner I, section II.0",
                                         .params = &ll_ode_arenstorf_table,
                                         .system = system_of,
                                         .duration = 17.0652165601579625588917206249,
                                         .start = start,
                                         .components = components,
                                         .reference = reference,
                                         .floor = 1.4e-11,
                                         .energy = energy};
