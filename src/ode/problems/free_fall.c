/* Free fall, s'' = g: the paper's first example, s pointing down. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double g, v0;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, g, "m/s2", 0.01, 1000, 10, "Gravity."),
    LL_ODE_PARAM(params, v0, "m/s", -1000, 1000, 0, "Initial speed, downwards."),
};
LL_ODE_TABLE(ll_ode_free_fall_table, "free_fall", "Parameters of free fall.", rows, params);

static void acceleration(const void *p, double t, const double *q, const double *v, double *a)
{
    (void)t, (void)q, (void)v;
    a[0] = ((const params *)p)->g;
}

static void series(const void *p, double t, int order, double *row)
{
    (void)t;
    for (int k = 0; k < order; k++, row += 2) {
        row[2] = row[1] * ll_series_inverse[k + 1];
        row[3] = k == 0 ? ((const params *)p)->g : 0;
    }
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode =
        (ll_ode){.dim = 2, .autonomous = true, .params = p, .acceleration = acceleration, .series = series};
}

static void start(const void *p, double *y)
{
    y[0] = 0;
    y[1] = ((const params *)p)->v0;
}

static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    y[0] = (c->v0 + c->g * t / 2) * t;
    y[1] = c->v0 + c->g * t;
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    return y[1] * y[1] / 2 - ((const params *)p)->g * y[0];
}

static const char *const components[] = {"s_m", "v_mps"};

const ll_ode_problem ll_ode_free_fall = {.name = "free_fall",
                                         .help = "A body falls from rest, without drag.",
                                         .source = "the paper, Figures 1 to 4",
                                         .params = &ll_ode_free_fall_table,
                                         .system = system_of,
                                         .duration = 3,
                                         .start = start,
                                         .components = components,
                                         .exact = exact,
                                         .energy = energy};
