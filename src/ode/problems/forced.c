/* A free mass under a periodic force, x'' = cos(omega t). */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct params {
    double omega;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, omega, "rad/s", 0.01, 1000, 1, "Frequency of the force.")};
LL_ODE_TABLE(ll_ode_forced_table, "forced", "Parameters of the periodic force.", rows, params);

LL_ODE_ACCELERATION(acceleration, 2, { a[0] = ll_real_cos(((const params *)p)->omega * t); })

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

static void series(const void *p, double t, int order, double *row)
{
    double omega = ((const params *)p)->omega, sine, cosine;
    ll_sincos(omega * t, &sine, &cosine);
    for (int k = 0; k < order; k++, row += 2) {
        double over = ll_series_inverse[k + 1], turned = cosine;
        row[2] = row[1] * over;
        row[3] = cosine * over;
        cosine = -omega * sine * over;
        sine = omega * turned * over;
    }
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode =
        (ll_ode){.dim = 2, .params = p, .acceleration = acceleration, .series = series, .kernels = &kernels};
}

static void start(const void *p, double *y)
{
    (void)p;
    y[0] = y[1] = 0;
}

/* 1 - cos z = 2 sin^2(z / 2), which keeps its digits near 0. */
static bool exact(const void *p, double t, double *y)
{
    double w = ((const params *)p)->omega, s = ll_sin(w * t / 2);
    y[0] = 2 * s * s / (w * w);
    y[1] = ll_sin(w * t) / w;
    return true;
}

static const char *const components[] = {"x_m", "v_mps"};

const ll_ode_problem ll_ode_forced = {.name = "forced",
                                      .help = "A free mass under a periodic force.",
                                      .source = "closed form",
                                      .params = &ll_ode_forced_table,
                                      .system = system_of,
                                      .duration = 10,
                                      .start = start,
                                      .components = components,
                                      .exact = exact};
