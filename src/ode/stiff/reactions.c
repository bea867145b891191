/* Non-stiff reactions and populations: the Brusselator; Lotka and Volterra's predators and prey. */
#include "ode/core/problem_rows.h"
#include "ode/core/series.h"

typedef struct brusselator {
    double a, b;
} brusselator;

static const ll_param brusselator_rows[] = {
    LL_ODE_PARAM(brusselator, a, NULL, 0.01, 100, 1, "Inflow."),
    LL_ODE_PARAM(brusselator, b, NULL, 0, 100, 3, "Second constant; it oscillates above 1 + a^2."),
};
LL_ODE_TABLE(ll_ode_brusselator_table, "brusselator", "Parameters of the Brusselator.", brusselator_rows,
             brusselator);

LL_ODE_RHS(brusselator_f, 2, {
    const brusselator *c = p;
    real u = y[0], v = y[1], react = u * u * v;
    dy[0] = c->a + react - (c->b + 1) * u;
    dy[1] = c->b * u - react;
})

static const struct ll_ode_kernels brusselator_kernels = {LL_ODE_KERNELS(brusselator_f)};

/* Lanes are u^2 and the reaction u^2 v. */
static void brusselator_series(const void *p, double t, int order, double *row)
{
    (void)t;
    const brusselator *c = p;
    ll_term left[LL_SERIES_TERMS], right[LL_SERIES_TERMS];
    for (int k = 0; k < order; k++, row += 2) {
        double u = row[0], v = row[1], over = ll_series_inverse[k + 1];
        right[k] = (ll_term){u, v};
        left[k] = ll_term_of(u);
        ll_term even = {0}, odd = {0};
        int j = 1;
        for (; j + 1 < k; j += 2) {
            even += left[j] * right[k - j];
            odd += left[j + 1] * right[k - j - 1];
        }
        if (j < k)
            even += left[j] * right[k - j];
        even += odd;
        double square = k == 0 ? u * u : even[0] + 2 * (left[0][0] * u);
        left[k][1] = square;
        double react = k == 0 ? square * v : even[1] + (left[0][1] * v + square * right[0][1]);
        row[2] = ((k == 0 ? c->a : 0) + react - (c->b + 1) * u) * over;
        row[3] = (c->b * u - react) * over;
    }
}

static void brusselator_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .params = p,
                    .f = brusselator_f,
                    .series = brusselator_series,
                    .kernels = &brusselator_kernels};
}

static void brusselator_start(const void *p, double *y)
{
    (void)p;
    y[0] = 1.5;
    y[1] = 3;
}

static const double brusselator_reference[] = {0.498637071268347849, 4.59678034945201118};
static const char *const brusselator_components[] = {"u", "v"};

const ll_ode_problem ll_ode_brusselator = {.name = "brusselator",
                                           .help = "An oscillating reaction.",
                                           .source = "Hairer, Norsett and Wanner I, section I.16",
                                           .params = &ll_ode_brusselator_table,
                                           .system = brusselator_system,
                                           .duration = 20,
                                           .start = brusselator_start,
                                           .components = brusselator_components,
                                           .reference = brusselator_reference,
                                           .floor = 1e-15};

typedef struct hunters {
    double growth, catch_rate, death, gain;
} hunters;

static const ll_param hunter_rows[] = {
    LL_ODE_PARAM(hunters, growth, "1/s", 0, 100, 1.5, "Growth rate of the prey."),
    LL_ODE_PARAM(hunters, catch_rate, "1/s", 0, 100, 1, "Prey caught per predator."),
    LL_ODE_PARAM(hunters, death, "1/s", 0, 100, 3, "Death rate of the predators."),
    LL_ODE_PARAM(hunters, gain, "1/s", 0, 100, 1, "Growth rate of the predators per prey."),
};
LL_ODE_TABLE(ll_ode_lotka_volterra_table, "lotka_volterra", "Parameters of predators and prey.", hunter_rows,
             hunters);

LL_ODE_RHS(hunter_f, 2, {
    const hunters *c = p;
    real prey = y[0], hunter = y[1];
    dy[0] = c->growth * prey - c->catch_rate * prey * hunter;
    dy[1] = c->gain * prey * hunter - c->death * hunter;
})

static const struct ll_ode_kernels hunter_kernels = {LL_ODE_KERNELS(hunter_f)};

/* The sum of the product is symmetric in both: half of its terms, one in each lane, and the middle one. */
static void hunter_series(const void *p, double t, int order, double *row)
{
    (void)t;
    const hunters *c = p;
    ll_term y[LL_SERIES_TERMS], swapped[LL_SERIES_TERMS];
    for (int k = 0; k < order; k++, row += 2) {
        double prey = row[0], hunter = row[1], over = ll_series_inverse[k + 1];
        y[k] = (ll_term){prey, hunter};
        swapped[k] = ll_term_swapped(y[k]);
        ll_term sum = {0};
        for (int j = 0; 2 * j < k; j++)
            sum += y[j] * swapped[k - j];
        double met = sum[0] + sum[1] + (k % 2 == 0 ? y[k / 2][0] * y[k / 2][1] : 0);
        row[2] = (c->growth * prey - c->catch_rate * met) * over;
        row[3] = (c->gain * met - c->death * hunter) * over;
    }
}

static void hunter_system(const void *p, ll_ode *ode)
{
    *ode = (ll_ode){.dim = 2,
                    .autonomous = true,
                    .params = p,
                    .f = hunter_f,
                    .series = hunter_series,
                    .kernels = &hunter_kernels};
}

static void hunter_start(const void *p, double *y)
{
    (void)p;
    y[0] = y[1] = 1;
}

static const double hunter_reference[] = {1.02634476757508932, 0.909691078136041618};
static const char *const hunter_components[] = {"prey", "hunters"};

const ll_ode_problem ll_ode_lotka_volterra = {.name = "lotka_volterra",
                                              .help = "Predators and prey.",
                                              .source = "SciMLBenchmarks; binary128 reference",
                                              .params = &ll_ode_lotka_volterra_table,
                                              .system = hunter_system,
                                              .duration = 10,
                                              .start = hunter_start,
                                              .components = hunter_components,
                                              .reference = hunter_reference,
                                              .floor = 1e-15};
