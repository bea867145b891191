/* A pendulum on a spring, q'' = -k (r - 1) q / r - (0, g): a fast oscillation on a slow one. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double k, g;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, k, "N/m", 1, 1e8, 1e4, "Stiffness of the spring; the mass is 1 kg, the length 1 m."),
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
};
LL_ODE_TABLE(ll_ode_elastic_pendulum_table, "elastic_pendulum", "Parameters of the pendulum on a spring.",
             rows, params);

static const ll_param stiff_rows[] = {
    LL_ODE_PARAM(params, k, "N/m", 1, 1e8, 1e6, "Stiffness of the spring; the mass is 1 kg, the length 1 m."),
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
};
LL_ODE_TABLE(ll_ode_stiff_pendulum_table, "stiff_pendulum", "Parameters of the pendulum on a stiff spring.",
             stiff_rows, params);

LL_ODE_ACCELERATION(acceleration, 4, {
    const params *c = p;
    real x = q[0], z = q[1], r = ll_real_sqrt(x * x + z * z), w = -c->k * (r - 1) / r;
    a[0] = w * x;
    a[1] = w * z - c->g;
})

static void jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t;
    const params *c = p;
    double x = y[0], z = y[1], r2 = x * x + z * z, r = ll_sqrt(r2), r3 = r * r2;
    for (int i = 0; i < 16; i++)
        j[i] = 0;
    j[2] = j[7] = 1;
    j[8] = -c->k * (1 - z * z / r3);
    j[9] = j[12] = -c->k * x * z / r3;
    j[13] = -c->k * (1 - x * x / r3);
}

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

/* With u = r^2, w = 1 / r = u^(-1/2), a = k w q - k q - (0, g). */
static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    const params *c = p;
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS], w[LL_SERIES_TERMS], u[LL_SERIES_TERMS];
    ll_series_take_plane(row, q, v);
    double r2 = q[0][0] * q[0][0] + q[0][1] * q[0][1], over = 1 / r2;
    u[0] = ll_term_of(r2);
    w[0] = ll_term_of(1 / ll_sqrt(r2));
    ll_series_move(q, v, c->k * ((w[0] - 1) * q[0]) - (ll_term){0, c->g}, 0);
    for (int k = 1; k < order; k++) {
        ll_term squares = {0}, power = {0}, pull = {0};
        for (int j = 1; j < k; j++) {
            squares += q[j] * q[k - j];
            power += ll_series_power_factor(-0.5, j, k) * (u[j] * w[k - j]);
            pull += w[j] * q[k - j];
        }
        squares += 2 * (q[0] * q[k]);
        u[k] = ll_term_of(squares[0] + squares[1]);
        power += ll_series_power_factor(-0.5, k, k) * (u[k] * w[0]);
        w[k] = power * (over * ll_series_inverse[k]);
        ll_series_move(q, v, c->k * (pull + ll_series_ends(w, q, k) - q[k]), k);
    }
    ll_series_put_plane(row, q, v, order);
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 4,
                    .autonomous = true,
                    .params = p,
                    .acceleration = acceleration,
                    .series = series,
                    .kernels = &kernels,
                    .jacobian = jacobian};
}

static void start(const void *p, double *y)
{
    (void)p;
    y[0] = 1;
    y[1] = y[2] = y[3] = 0;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    const params *c = p;
    double stretch = ll_sqrt(y[0] * y[0] + y[1] * y[1]) - 1;
    return (y[2] * y[2] + y[3] * y[3] + c->k * stretch * stretch) / 2 + c->g * y[1];
}

static const double reference[] = {0.901229341243433376, -0.436341094340919674, -1.27865934176811728,
                                   -2.65986311000513250};
static const double stiff_reference[] = {0.889238669982539966, -0.457473535369027246, -1.38366491400610039,
                                         -2.68974975990245786};
static const char *const components[] = {"x_m", "y_m", "vx_mps", "vy_mps"};

const ll_ode_problem ll_ode_elastic_pendulum = {.name = "elastic_pendulum",
                                                .help = "A pendulum on a spring, 100 rad/s on 3 rad/s.",
                                                .source = "binary128 reference",
                                                .params = &ll_ode_elastic_pendulum_table,
                                                .system = system_of,
                                                .duration = 5,
                                                .start = start,
                                                .components = components,
                                                .reference = reference,
                                                .floor = 1e-14,
                                                .energy = energy};

const ll_ode_problem ll_ode_stiff_pendulum = {.name = "stiff_pendulum",
                                              .help = "A pendulum on a stiff spring, 1000 rad/s on 3 rad/s.",
                                              .source = "binary128 reference",
                                              .stiff = true,
                                              .params = &ll_ode_stiff_pendulum_table,
                                              .system = system_of,
                                              .duration = 5,
                                              .start = start,
                                              .components = components,
                                              .reference = stiff_reference,
                                              .floor = 1e-13,
                                              .energy = energy};
