/* Stiff reactions: Robertson's three substances, the Oregonator, and HIRES. */
#include "ode/core/problem_rows.h"

static void clear(int n, double *j)
{
    for (int i = 0; i < n * n; i++)
        j[i] = 0;
}

/* ---- Robertson ---- */

typedef struct robertson {
    double k1, k2, k3;
} robertson;

static const ll_param robertson_rows[] = {
    LL_ODE_PARAM(robertson, k1, "1/s", 0, 1e3, 0.04, "Slow reaction."),
    LL_ODE_PARAM(robertson, k2, "1/s", 0, 1e12, 3e7, "Fastest reaction."),
    LL_ODE_PARAM(robertson, k3, "1/s", 0, 1e12, 1e4, "Fast reaction."),
};
LL_ODE_TABLE(ll_ode_robertson_table, "robertson", "Parameters of Robertson's reaction.", robertson_rows,
             robertson);

static void robertson_f(const void *p, double t, const double *y, double *dy)
{
    (void)t;
    const robertson *c = p;
    double slow = c->k1 * y[0], fast = c->k3 * y[1] * y[2], fastest = c->k2 * y[1] * y[1];
    dy[0] = fast - slow;
    dy[1] = slow - fast - fastest;
    dy[2] = fastest;
}

static void robertson_jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t;
    const robertson *c = p;
    clear(3, j);
    j[0] = -c->k1;
    j[1] = c->k3 * y[2];
    j[2] = c->k3 * y[1];
    j[3] = c->k1;
    j[4] = -c->k3 * y[2] - 2 * c->k2 * y[1];
    j[5] = -c->k3 * y[1];
    j[7] = 2 * c->k2 * y[1];
}

static void robertson_system(const void *p, ll_ode *ode)
{
    *ode =
        (ll_ode){.dim = 3, .autonomous = true, .params = p, .f = robertson_f, .jacobian = robertson_jacobian};
}

static void robertson_start(const void *p, double *y)
{
    (void)p;
    y[0] = 1;
    y[1] = y[2] = 0;
}

static const double robertson_reference[] = {0.715827068719405090, 9.18553476455776390e-6,
                                             0.284163745745830352};
static const char *const robertson_components[] = {"a", "b", "c"};

const ll_ode_problem ll_ode_robertson = {
    .name = "robertson",
    .help = "Three substances whose reaction rates differ by nine orders of magnitude.",
    .source = "Robertson 1966; Test Set for IVP Solvers",
    .stiff = true,
    .params = &ll_ode_robertson_table,
    .system = robertson_system,
    .duration = 40,
    .start = robertson_start,
    .components = robertson_components,
    .reference = robertson_reference,
    .floor = 1e-15};

/* ---- Oregonator ---- */

typedef struct oregonator {
    double s, w, q;
} oregonator;

static const ll_param oregonator_rows[] = {
    LL_ODE_PARAM(oregonator, s, NULL, 0.01, 1e4, 77.27, "First constant."),
    LL_ODE_PARAM(oregonator, w, NULL, 0, 100, 0.161, "Second constant."),
    LL_ODE_PARAM(oregonator, q, NULL, 0, 1, 8.375e-6, "Third constant."),
};
LL_ODE_TABLE(ll_ode_oregonator_table, "oregonator", "Parameters of the Oregonator.", oregonator_rows,
             oregonator);

static void oregonator_f(const void *p, double t, const double *y, double *dy)
{
    (void)t;
    const oregonator *c = p;
    dy[0] = c->s * (y[1] + y[0] * (1 - c->q * y[0] - y[1]));
    dy[1] = (y[2] - (1 + y[0]) * y[1]) / c->s;
    dy[2] = c->w * (y[0] - y[2]);
}

static void oregonator_jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t;
    const oregonator *c = p;
    clear(3, j);
    j[0] = c->s * (1 - 2 * c->q * y[0] - y[1]);
    j[1] = c->s * (1 - y[0]);
    j[3] = -y[1] / c->s;
    j[4] = -(1 + y[0]) / c->s;
    j[5] = 1 / c->s;
    j[6] = c->w;
    j[8] = -c->w;
}

static void oregonator_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){
        .dim = 3, .autonomous = true, .params = p, .f = oregonator_f, .jacobian = oregonator_jacobian};
}

static void oregonator_start(const void *p, double *y)
{
    (void)p;
    y[0] = 1;
    y[1] = 2;
    y[2] = 3;
}

static const double oregonator_reference[] = {1.00081487031852272, 1228.17852154988798, 132.055494284650829};

const ll_ode_problem ll_ode_oregonator = {
    .name = "oregonator",
    .help = "The Belousov-Zhabotinskii reaction: bursts between long pauses.",
    .source = "Field and Noyes 1974; Test Set for IVP Solvers",
    .stiff = true,
    .params = &ll_ode_oregonator_table,
    .system = oregonator_system,
    .duration = 360,
    .start = oregonator_start,
    .components = robertson_components,
    .reference = oregonator_reference,
    .floor = 6e-13};

/* ---- HIRES ---- */

typedef struct hires {
    double k;
} hires;

static const ll_param hires_rows[] = {
    LL_ODE_PARAM(hires, k, NULL, 0, 1e6, 280, "Rate of the fast reaction.")};
LL_ODE_TABLE(ll_ode_hires_table, "hires", "Parameters of the response to light.", hires_rows, hires);

static void hires_f(const void *p, double t, const double *y, double *dy)
{
    (void)t;
    double fast = ((const hires *)p)->k * y[5] * y[7];
    dy[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
    dy[1] = 1.71 * y[0] - 8.75 * y[1];
    dy[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
    dy[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
    dy[4] = -1.745 * y[4] + 0.43 * y[5] + 0.43 * y[6];
    dy[5] = -fast + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
    dy[6] = fast - 1.81 * y[6];
    dy[7] = -dy[6];
}

static void hires_jacobian(const void *p, double t, const double *y, double *j)
{
    (void)t;
    double k = ((const hires *)p)->k;
    clear(8, j);
    j[0] = -1.71, j[1] = 0.43, j[2] = 8.32;
    j[8] = 1.71, j[9] = -8.75;
    j[18] = -10.03, j[19] = 0.43, j[20] = 0.035;
    j[25] = 8.32, j[26] = 1.71, j[27] = -1.12;
    j[36] = -1.745, j[37] = 0.43, j[38] = 0.43;
    j[43] = 0.69, j[44] = 1.71, j[45] = -k * y[7] - 0.43, j[46] = 0.69, j[47] = -k * y[5];
    j[53] = k * y[7], j[54] = -1.81, j[55] = k * y[5];
    j[61] = -j[53], j[62] = 1.81, j[63] = -j[55];
}

static void hires_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 8, .autonomous = true, .params = p, .f = hires_f, .jacobian = hires_jacobian};
}

static void hires_start(const void *p, double *y)
{
    (void)p;
    for (int i = 0; i < 8; i++)
        y[i] = 0;
    y[0] = 1;
    y[7] = 0.0057;
}

static const double hires_reference[] = {
    0.000737131257332566781, 0.000144248572631618466, 0.0000588872974096757501, 0.00117565134328314915,
    0.00238635619883133047,  0.00623896825274279579,  0.00284999839518576866,   0.00285000160481423134};
static const char *const hires_components[] = {"y1", "y2", "y3", "y4", "y5", "y6", "y7", "y8"};

const ll_ode_problem ll_ode_hires = {.name = "hires",
                                     .help = "A plant's response to light: eight substances.",
                                     .source = "Schaefer 1975; Test Set for IVP Solvers",
                                     .stiff = true,
                                     .params = &ll_ode_hires_table,
                                     .system = hires_system,
                                     .duration = 321.8122,
                                     .start = hires_start,
                                     .components = hires_components,
                                     .reference = hires_reference,
                                     .floor = 2e-13};
