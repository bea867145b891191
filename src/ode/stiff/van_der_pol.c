/* Van der Pol's oscillator, y'' = mu (1 - y^2) y' - y: stiff for a large mu. */
#include "ode/core/problem_rows.h"

typedef struct params {
    double mu;
} params;

static const ll_param rows[] = {LL_ODE_PARAM(params, mu, NULL, 0, 1e6, 1000, "Strength of the damping.")};
LL_ODE_TABLE(ll_ode_van_der_pol_table, "van_der_pol", "Parameters of van der Pol's oscillator.", rows,
             params);

static void acceleration(const void *p, double t, const double *q, const double *v, double *a)
{
    (void)t;
    a[0] = ((const params *)p)->mu * (1 - q[0] * q[0]) * v[0] - q[0];
}

static void jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t;
    double mu = ((const params *)p)->mu;
    j[0] = 0;
    j[1] = 1;
    j[2] = -2 * mu * y[0] * y[1] - 1;
    j[3] = mu * (1 - y[0] * y[0]);
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .velocity_dependent = true,
                    .params = p,
                    .acceleration = acceleration,
                    .jacobian = jacobian};
}

static void start(const void *p, double *y)
{
    (void)p;
    y[0] = 2;
    y[1] = 0;
}

static const double reference[] = {1.70616773217046501, -0.000892809701024816548};
static const char *const components[] = {"x_m", "v_mps"};

const ll_ode_problem ll_ode_van_der_pol = {.name = "van_der_pol",
                                           .help = "An oscillator with slow relaxation and fast jumps.",
                                           .source = "Test Set for IVP Solvers; binary128 reference",
                                           .stiff = true,
                                           .params = &ll_ode_van_der_pol_table,
                                           .system = system_of,
                                           .duration = 2000,
                                           .start = start,
                                           .components = components,
                                           .reference = reference,
                                           .floor = 1e-14};
