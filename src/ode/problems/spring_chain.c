/* Sixteen masses between springs, both ends fixed, the eighth displaced: a sum of modes. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

enum { MASSES = 16, PLUCKED = 7 };

typedef struct params {
    double k, m;
} params;

static const ll_param rows[] = {
    LL_ODE_PARAM(params, k, "N/m", 1e-3, 1e8, 1e4, "Stiffness of each spring."),
    LL_ODE_PARAM(params, m, "kg", 1e-3, 1e3, 1, "Each mass."),
};
LL_ODE_TABLE(ll_ode_spring_chain_table, "spring_chain", "Parameters of the chain.", rows, params);

LL_ODE_ACCELERATION(acceleration, 2 * MASSES, {
    const params *c = p;
    double w2 = c->k / c->m;
    a[0] = w2 * (q[1] - 2 * q[0]);
    for (int i = 1; i < MASSES - 1; i++)
        a[i] = w2 * (q[i - 1] - 2 * q[i] + q[i + 1]);
    a[MASSES - 1] = w2 * (q[MASSES - 2] - 2 * q[MASSES - 1]);
})

static void jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t, (void)y;
    const params *c = p;
    double w2 = c->k / c->m;
    const int n = 2 * MASSES;
    for (int i = 0; i < n * n; i++)
        j[i] = 0;
    for (int i = 0; i < MASSES; i++) {
        double *row = j + (MASSES + i) * n;
        j[i * n + MASSES + i] = 1;
        row[i] = -2 * w2;
        if (i > 0)
            row[i - 1] = w2;
        if (i + 1 < MASSES)
            row[i + 1] = w2;
    }
}

static const struct ll_ode_kernels kernels = {LL_ODE_KERNELS(acceleration),
                                              .leapfrog = acceleration_leapfrog};

static void series(const void *p, double t, int order, double *row)
{
    for (int k = 0; k < order; k++, row += 2 * MASSES) {
        double *next = row + 2 * MASSES;
        acceleration(p, t, row, row + MASSES, next + MASSES);
        for (int i = 0; i < MASSES; i++) {
            next[i] = row[MASSES + i] * ll_series_inverse[k + 1];
            next[MASSES + i] *= ll_series_inverse[k + 1];
        }
    }
}

static void system_of(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2 * MASSES,
                    .autonomous = true,
                    .params = p,
                    .acceleration = acceleration,
                    .series = series,
                    .kernels = &kernels,
                    .jacobian = jacobian};
}

static void start(const void *p, double *y)
{
    (void)p;
    for (int i = 0; i < 2 * MASSES; i++)
        y[i] = i == PLUCKED;
}

/* Mode j is sin(i j pi / (n + 1)) with w_j = 2 sqrt(k / m) sin(j pi / (2 (n + 1))). */
static bool exact(const void *p, double t, double *y)
{
    const params *c = p;
    const double part = 3.14159265358979323846 / (MASSES + 1);
    for (int i = 0; i < 2 * MASSES; i++)
        y[i] = 0;
    for (int j = 1; j <= MASSES; j++) {
        double w = 2 * ll_sqrt(c->k / c->m) * ll_sin(j * part / 2), cosine = ll_cos(w * t),
               sine = ll_sin(w * t);
        double share = 2.0 / (MASSES + 1) * ll_sin((PLUCKED + 1) * j * part);
        for (int i = 0; i < MASSES; i++) {
            double shape = share * ll_sin((i + 1) * j * part);
            y[i] += shape * cosine;
            y[MASSES + i] -= shape * w * sine;
        }
    }
    return true;
}

static double energy(const void *p, double t, const double *y)
{
    (void)t;
    const params *c = p;
    double kinetic = 0, stretch2 = 0;
    for (int i = 0; i <= MASSES; i++) {
        double stretch = (i < MASSES ? y[i] : 0) - (i > 0 ? y[i - 1] : 0);
        stretch2 += stretch * stretch;
        kinetic += i < MASSES ? y[MASSES + i] * y[MASSES + i] : 0;
    }
    return (c->m * kinetic + c->k * stretch2) / 2;
}

static const char *const components[] = {
    "x1_m",   "x2_m",    "x3_m",    "x4_m",    "x5_m",    "x6_m",    "x7_m",    "x8_m",
    "x9_m",   "x10_m",   "x11_m",   "x12_m",   "x13_m",   "x14_m",   "x15_m",   "x16_m",
    "v1_mps", "v2_mps",  "v3_mps",  "v4_mps",  "v5_mps",  "v6_mps",  "v7_mps",  "v8_mps",
    "v9_mps", "v10_mps", "v11_mps", "v12_mps", "v13_mps", "v14_mps", "v15_mps", "v16_mps"};

const ll_ode_problem ll_ode_spring_chain = {.name = "spring_chain",
                                            .help = "Sixteen masses between stiff springs.",
                                            .source = "closed form, a sum of modes",
                                            .params = &ll_ode_spring_chain_table,
                                            .system = system_of,
                                            .duration = 1,
                                            .start = start,
                                            .components = components,
                                            .exact = exact,
                                            .energy = energy};
