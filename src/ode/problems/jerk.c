/* A constant jerk, x'' = j t: the simplest acceleration that is not constant. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double jerk;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, jerk, "m/s3", -1000, 1000, 6, "Rate of the acceleration.")};
LL_ODE_TABLE(ll_ode_jerk_table, "jerk", "Parameters of the constant jerk.", rows, params);

static void acceleration(const void *p, double t, const double *q, const double *v, double *a)
{
    (void)q, (void)v;
    a[0] = ((const params *)p)->jerk * t;
}

static void series(const void *p, double t, int order, double *row)
{
    double jerk = ((const params *)p)->jerk;
    for (int k = 0; k < order; k++, row += 2) {
        row[2] = row[1] * ll_series_inverse[k + 1];
        row[3] = k == 0 ? jerk * t : k == 1 ? jerk / 2 : 0;
    }
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2, .params = p, .acceleration = acceleration, .series = series};
}

static void start(const void *p, double *y)
{
    (void)p;
    y[0] = y[1] = 0;
}

static bool exact(const void *p, double t, double *y)
{
    double j = ((const params *)p)->jerk;
    y[0] = j * t * t * t / 6;
    y[1] = j * t * t / 2;
    return true;
}

static const char *const components[] = {"x_m", "v_mps"};

const ll_ode_problem ll_ode_jerk = {.name = "jerk",
                                    .help = "An acceleration that grows linearly.",
                                    .source = "closed form",
                                    .params = &ll_ode_jerk_table,
                                    .system = system_of,
                                    .duration = 2,
                                    .start = start,
                                    .components = components,
                                    .exact = exact};
