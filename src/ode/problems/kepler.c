/* Kepler's orbit, q'' = -q / |q|^3, from the pericentre; semi-major axis and period are 1 and 2 pi. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double e;
} params;

static const ll_param rows[] = {LL_ODE_PARAM(params, e, NULL, 0, 0.999, 0.6, "Eccentricity.")};
LL_ODE_TABLE(ll_ode_kepler_table, "kepler", "Parameters of the orbit.", rows, params);

LL_ODE_ACCELERATION(acceleration, 4, {
    real r2 = q[0] * q[0] + q[1] * q[1], w = -1 / (r2 * ll_real_sqrt(r2));
    a[0] = w * q[0];
    a[1] = w * q[1];
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

/* With u = |q|^2, w = -u^(-3/2), a = w q. */
static void series(const void *p, double t, int order, double *row)
{
    (void)p, (void)t;
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS], w[LL_SERIES_TERMS], u[LL_SERIES_TERMS];
    ll_series_take_plane(row, q, v);
    double r2 = q[0][0] * q[0][0] + q[0][1] * q[0][1], over = 1 / r2;
    u[0] = ll_term_of(r2);
    w[0] = ll_term_of(-over / ll_sqrt(r2));
    ll_series_move(q, v, w[0] * q[0], 0);
    for (int k = 1; k < order; k++) {
        ll_term squares = {0}, power = {0}, pull = {0};
        for (int j = 1; j < k; j++) {
            squares += q[j] * q[k - j];
            power += ll_series_power_factor(-1.5, j, k) * (u[j] * w[k - j]);
            pull += w[j] * q[k - j];
        }
        squares += 2 * (q[0] * q[k]);
        u[k] = ll_term_of(squares[0] + squares[1]);
        power += ll_series_power_factor(-1.5, k, k) * (u[k] * w[0]);
        w[k] = power * (over * ll_series_inverse[k]);
        ll_series_move(q, v, pull + ll_series_ends(w, q, k), k);
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
                    .kernels = &kernels};
}

static void start(const void *p, double *y)
{
    double e = ((const params *)p)->e;
    y[0] = 1 - e;
    y[1] = y[2] = 0;
    y[3] = ll_sqrt((1 + e) / (1 - e));
}

/* Kepler's equation E - e sin E = M by Newton, from a start that converges for every e (Danby). */
static double eccentric_anomaly(double m, double e)
{
    double x = m + (ll_sin(m) < 0 ? -0.85 : 0.85) * e;
    for (int i = 0; i < 40; i++) {
        double f = x - e * ll_sin(x) - m, slope = 1 - e * ll_cos(x), step = f / slope;
        x -= step;
        if (step < 1e-16 && step > -1e-16)
            break;
    }
    return x;
}

static bool exact(const void *p, double t, double *y)
{
    static const double turn_high = 6.283185307179586, turn_low = 2.4492935982947064e-16;
    double e = ((const params *)p)->e;
    double turns = (double)(long long)(t / turn_high);
    double x = eccentric_anomaly((t - turns * turn_high) - turns * turn_low, e);
    double c = ll_cos(x), s = ll_sin(x), b = ll_sqrt((1 - e) * (1 + e)), r = 1 - e * c;
    y[0] = c - e;
    y[1] = b * s;
    y[2] = -s / r;
    y[3] = b * c / r;
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)p, (void)t;
    return (y[2] * y[2] + y[3] * y[3]) / 2 - 1 / ll_sqrt(y[0] * y[0] + y[1] * y[1]);
}

static const char *const components[] = {"x_m", "y_m", "vx_mps", "vy_mps"};

const ll_ode_problem ll_ode_kepler = {.name = "kepler",
                                      .help = "An orbit around a fixed sun.",
                                      .source = "closed form, by Kepler's equation",
                                      .params = &ll_ode_kepler_table,
                                      .system = system_of,
                                      .duration = 10,
                                      .start = start,
                                      .components = components,
                                      .exact = exact,
                                      .energy = energy};
