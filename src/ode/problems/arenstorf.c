/* Arenstorf orbit: a satellite between earth and moon, in the co-rotating frame; closed after 17.07 time
 * units. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

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

/* Lanes are earth and moon: u the squares of the distances, w = mass u^(-3/2). */
static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    double mu = ((const params *)p)->mu;
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS];
    ll_term x[LL_SERIES_TERMS], y[LL_SERIES_TERMS], u[LL_SERIES_TERMS], w[LL_SERIES_TERMS];
    ll_series_take_plane(row, q, v);
    for (int k = 0; k < order; k++) {
        ll_term squares = {0}, power = {0}, pull_x = {0}, pull_y = {0};
        x[k] = ll_term_of(q[k][0]);
        y[k] = ll_term_of(q[k][1]);
        if (k == 0) {
            x[0] += (ll_term){mu, mu - 1};
            u[0] = x[0] * x[0] + y[0] * y[0];
            w[0] = (ll_term){1 - mu, mu} / (u[0] * (ll_term){ll_sqrt(u[0][0]), ll_sqrt(u[0][1])});
            pull_x = w[0] * x[0];
            pull_y = w[0] * y[0];
        } else {
            for (int j = 1; j < k; j++) {
                squares += x[j] * x[k - j] + y[j] * y[k - j];
                power += ll_series_power_factor(-1.5, j, k) * (u[j] * w[k - j]);
                pull_x += w[j] * x[k - j];
                pull_y += w[j] * y[k - j];
            }
            u[k] = squares + 2 * (x[0] * x[k] + y[0] * y[k]);
            power += ll_series_power_factor(-1.5, k, k) * (u[k] * w[0]);
            w[k] = power / (k * u[0]);
            pull_x += ll_series_ends(w, x, k);
            pull_y += ll_series_ends(w, y, k);
        }
        ll_term pull = {pull_x[0] + pull_x[1], pull_y[0] + pull_y[1]};
        ll_series_move(q, v, q[k] + (ll_term){2, -2} * ll_term_swapped(v[k]) - pull, k);
    }
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
