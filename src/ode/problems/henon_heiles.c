/* Henon and Heiles: a star in a galaxy, V = (q1^2 + q2^2) / 2 + q1^2 q2 - q2^3 / 3. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double q1, q2, p1, p2;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, q1, "m", -1, 1, 0.1, "Initial first coordinate."),
    LL_ODE_PARAM(params, q2, "m", -1, 1, 0, "Initial second coordinate."),
    LL_ODE_PARAM(params, p1, "m/s", -1, 1, 0, "Initial first velocity."),
    LL_ODE_PARAM(params, p2, "m/s", -1, 1, 0.5, "Initial second velocity."),
};
LL_ODE_TABLE(ll_ode_henon_heiles_table, "henon_heiles", "Parameters of the star.", rows, params);

LL_ODE_ACCELERATION(acceleration, 4, {
    real x = q[0], y = q[1];
    a[0] = -x - 2 * x * y;
    a[1] = -y - x * x + y * y;
})

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

/* The sums are symmetric: half of their terms, and the middle one. */
static void series(const void *p, double t, int order, double *row)
{
    (void)p, (void)t;
    ll_term q[LL_SERIES_TERMS], v[LL_SERIES_TERMS], swapped[LL_SERIES_TERMS];
    ll_series_take_plane(row, q, v);
    for (int k = 0; k < order; k++) {
        ll_term squares = {0}, cross = {0};
        swapped[k] = ll_term_swapped(q[k]);
        for (int j = 0; 2 * j < k; j++) {
            squares += q[j] * q[k - j];
            cross += q[j] * swapped[k - j];
        }
        squares *= 2;
        double xy = cross[0] + cross[1];
        if (k % 2 == 0) {
            squares += q[k / 2] * q[k / 2];
            xy += q[k / 2][0] * q[k / 2][1];
        }
        ll_series_move(q, v, -q[k] + (ll_term){-2 * xy, squares[1] - squares[0]}, k);
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
    const params *c = p;
    y[0] = c->q1;
    y[1] = c->q2;
    y[2] = c->p1;
    y[3] = c->p2;
}

static double energy(const void *p, double t, const double *y)
{
    (void)p, (void)t;
    return (y[2] * y[2] + y[3] * y[3] + y[0] * y[0] + y[1] * y[1]) / 2 + y[0] * y[0] * y[1] -
           y[1] * y[1] * y[1] / 3;
}

static const double reference[] = {-0.0401942378760688168, 0.679016921772021642, 0.0384509289518598345,
                                   0.0485948315530036422};
static const char *const components[] = {"q1_m", "q2_m", "p1_mps", "p2_mps"};

const ll_ode_problem ll_ode_henon_heiles = {.name = "henon_heiles",
                                            .help = "A star in the field of a galaxy, at an energy of 0.13.",
                                            .source = "Henon and Heiles 1964; binary128 reference",
                                            .params = &ll_ode_henon_heiles_table,
                                            .system = system_of,
                                            .duration = 100,
                                            .start = start,
                                            .components = components,
                                            .reference = reference,
                                            .floor = 1e-15,
                                            .energy = energy};
