/* Prothero and Robinson: y' = -lambda (y - cos t) - sin t; the solution is cos t at any stiffness. */
#include "ode/core/problem_rows.h"

typedef struct params {
    double lambda;
} params;

static const ll_param rows[] = {LL_ODE_PARAM(params, lambda, "1/s", 0, 1e9, 1e4, "Stiffness.")};
LL_ODE_TABLE(ll_ode_prothero_robinson_table, "prothero_robinson", "Parameters of the stiff problem.", rows,
             params);

static void f(const void *p, double t, const double *y, double *dy)
{
    dy[0] = -((const params *)p)->lambda * (y[0] - ll_cos(t)) - ll_sin(t);
}

static void jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t, (void)y;
    j[0] = -((const params *)p)->lambda;
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 1, .params = p, .f = f, .jacobian = jacobian};
}

static void start(const void *p, double *y)
{
    (void)p;
    y[0] = 1;
}

static bool exact(const void *p, double t, double *y)
{
    (void)p;
    y[0] = ll_cos(t);
    return true;
}

static const char *const components[] = {"y"};

const ll_ode_problem ll_ode_prothero_robinson = {.name = "prothero_robinson",
                                                 .help = "A slow solution under a stiff restoring force.",
                                                 .source = "Prothero and Robinson 1974; closed form",
                                                 .stiff = true,
                                                 .params = &ll_ode_prothero_robinson_table,
                                                 .system = system_of,
                                                 .duration = 10,
                                                 .start = start,
                                                 .components = components,
                                                 .exact = exact};
