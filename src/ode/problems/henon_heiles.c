/* Henon and Heiles: a star in a galaxy, V = (q1^2 + q2^2) / 2 + q1^2 q2 - q2^3 / 3. */
#include "ode/core/problem_rows.h"

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

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){
        .dim = 4, .autonomous = true, .params = p, .acceleration = acceleration, .kernels = &kernels};
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
