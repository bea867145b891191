/* Pendulum, theta'' = -(g / l) sin theta, released at rest: sin(theta / 2) = k cd(w t, k). */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"
#include "ode/problems/special.h"

typedef struct params {
    double g, length, theta0;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(params, length, "m", 0.01, 1000, 1, "Length."),
    LL_ODE_PARAM(params, theta0, "rad", -3.14, 3.14, 2, "Initial angle, at rest; 0 hangs down."),
};
LL_ODE_TABLE(ll_ode_pendulum_table, "pendulum", "Parameters of the pendulum.", rows, params);

LL_ODE_ACCELERATION(acceleration, 2, {
    const params *c = p;
    real x = q[0];
    a[0] = -c->g / c->length * ll_real_sin(x);
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

/* k sin_k = sum of j q_j cos_(k-j), k cos_k = -(sum of j q_j sin_(k-j)): the lanes of `wave`. */
static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    const params *c = p;
    double pull = c->g / c->length, sine, cosine, q = row[0], v = row[1];
    ll_term steep[LL_SERIES_TERMS], wave[LL_SERIES_TERMS];
    ll_sincos(q, &sine, &cosine);
    wave[0] = (ll_term){sine, cosine};
    for (int k = 0; k < order; k++) {
        if (k > 0) {
            ll_term even = {0}, odd = {0};
            steep[k] = ll_term_of(k * q);
            int j = 1;
            for (; j + 1 <= k; j += 2) {
                even += steep[j] * wave[k - j];
                odd += steep[j + 1] * wave[k - j - 1];
            }
            if (j == k)
                even += steep[k] * wave[0];
            even = (even + odd) * ll_series_inverse[k];
            wave[k] = (ll_term){even[1], -even[0]};
        }
        q = row[2 * k + 2] = v * ll_series_inverse[k + 1];
        v = row[2 * k + 3] = -pull * wave[k][0] * ll_series_inverse[k + 1];
    }
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .params = p,
                    .acceleration = acceleration,
                    .series = series,
                    .kernels = &kernels};
}

static void start(const void *p, double *y)
{
    y[0] = ((const params *)p)->theta0;
    y[1] = 0;
}

static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    double w = ll_sqrt(c->g / c->length), sign = c->theta0 < 0 ? -1 : 1, k = sign * ll_sin(c->theta0 / 2);
    ll_ode_elliptic j = ll_ode_jacobi(w * t, k);
    y[0] = sign * 2 * ll_ode_asin(k * j.cn / j.dn);
    y[1] = -sign * 2 * k * w * ll_sqrt((1 - k) * (1 + k)) * j.sn / j.dn;
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    const params *c = p;
    double half = ll_sin(y[0] / 2);
    return c->length * c->length * y[1] * y[1] / 2 + 2 * c->g * c->length * half * half;
}

static const char *const components[] = {"theta_rad", "omega_radps"};

const ll_ode_problem ll_ode_pendulum = {.name = "pendulum",
                                        .help = "A pendulum of large amplitude.",
                                        .source = "closed form, by Jacobi's elliptic functions",
                                        .params = &ll_ode_pendulum_table,
                                        .system = system_of,
                                        .duration = 10,
                                        .start = start,
                                        .components = components,
                                        .exact = exact,
                                        .energy = energy};
