/* Taylor series: the coefficients satisfy each problem's equations, the order is that of the tolerance, and
 * the solutions are the published ones. */
#include <math.h>

#include "base/rng.h"
#include "ode/core/problem.h"
#include "ode/core/series.h"
#include "ode/harness.h"
#include "support/near.h"

typedef struct made {
    const ll_ode_problem *problem;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_ode ode;
    double y0[LL_ODE_DIM_MAX];
} made;

static void make(made *m, const char *name)
{
    m->problem = ll_ode_problem_find(name);
    assert_non_null(m->problem);
    ll_param_defaults(m->problem->params, m->params);
    if (m->problem->prepare != NULL)
        m->problem->prepare(m->params);
    m->problem->system(m->params, &m->ode);
    m->problem->start(m->params, m->y0);
}

static int stride_of(const ll_ode *ode)
{
    return (ode->dim + 1) / 2 * 2;
}

/* ---- coefficients ---- */

/* y and y' by the series at h, in long double: rounding of the sums does not hide a wrong coefficient. */
static void sum(const ll_ode *ode, const double *series, int order, double h, double *y, double *slope)
{
    int stride = stride_of(ode);
    for (int i = 0; i < ode->dim; i++) {
        long double value = 0, derivative = 0;
        for (int k = order; k >= 0; k--) {
            derivative = derivative * (long double)h + value;
            value = value * (long double)h + (long double)series[k * stride + i];
        }
        y[i] = (double)value;
        slope[i] = (double)derivative;
    }
}

static double size_of(const double *x, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = larger(most, fabs(x[i]));
    return most;
}

/* The largest difference of y' from f(y) over the steps h, h / 2 and -h, where h makes the last coefficient
 * negligible. A coefficient k that is wrong by a part shows by that part of k c_k h^(k-1). */
static void the_series_satisfies_the_equations(const made *m, double t, const double *y0)
{
    enum { ORDER = LL_SERIES_ORDER };
    double series[LL_SERIES_TERMS * LL_ODE_DIM_MAX] = {0};
    int dim = m->ode.dim, stride = stride_of(&m->ode);
    memcpy(series, y0, (size_t)dim * sizeof *series);
    m->ode.series(m->ode.params, t, ORDER, series);
    double h = 1, scale = 0, f[LL_ODE_DIM_MAX], y[LL_ODE_DIM_MAX], slope[LL_ODE_DIM_MAX];
    ll_ode_eval(&m->ode, t, y0, f);
    scale = size_of(f, dim);
    for (int k = ORDER - 2; k <= ORDER; k++) {
        double last = size_of(series + k * stride, dim);
        if (last > 0)
            h = smaller(h, pow(1e-14 * scale / (k * last), 1. / (k - 1)));
    }
    for (int way = 0; way < 3; way++) {
        double at = way == 0 ? h : way == 1 ? h / 2 : -h;
        sum(&m->ode, series, ORDER, at, y, slope);
        ll_ode_eval(&m->ode, t + at, y, f);
        for (int i = 0; i < dim; i++)
            if (!(fabs(slope[i] - f[i]) <= 1e-11 * scale))
                fail_msg("%s: component %d at h = %g: slope %.17g, f %.17g", m->problem->name, i, at,
                         slope[i], f[i]);
    }
}

static const char *const smooth[] = {
    "free_fall",    "jerk",          "forced",      "oscillator",       "damped",         "drag_vertical",
    "drag_2d",      "lorentz",       "pendulum",    "kepler",           "henon_heiles",   "double_pendulum",
    "spring_chain", "arenstorf",     "pleiades",    "elastic_pendulum", "stiff_pendulum", "figure_eight",
    "euler_top",    "tennis_racket", "brusselator", "lotka_volterra",   "bouncing_ball"};
enum { SMOOTH = sizeof smooth / sizeof smooth[0] };

/* At the start, and at states and times about it. */
static void coefficients(void **state)
{
    (void)state;
    uint64_t draws = 0;
    for (int i = 0; i < SMOOTH; i++) {
        made m;
        make(&m, smooth[i]);
        assert_non_null(m.ode.series);
        for (int n = 0; n < 40; n++) {
            double y[LL_ODE_DIM_MAX], t = n == 0 ? 0 : 3 * ll_rng_unit(18, 0, draws++);
            for (int c = 0; c < m.ode.dim; c++)
                y[c] = m.y0[c] + (n == 0 ? 0 : 0.2 * (ll_rng_unit(18, 0, draws++) - 0.5));
            if (strcmp(smooth[i], "drag_vertical") == 0)
                y[1] += 20; /* where |v| is smooth: falling, for a second before and after */
            the_series_satisfies_the_equations(&m, t, y);
        }
    }
}

/* cos and its derivatives over k!. The terms of a product of three are up to 3^k / k! together,
 * and so is their rounding. */
static void coefficients_of_a_circle(void **state)
{
    (void)state;
    made m;
    make(&m, "kepler");
    double series[LL_SERIES_TERMS * 4] = {1, 0, 0, 1}, factorial = 1;
    m.ode.series(m.ode.params, 0, LL_SERIES_ORDER, series);
    for (int k = 1; k <= LL_SERIES_ORDER; k++) {
        static const double turn[4] = {1, 0, -1, 0};
        factorial *= k;
        double want[4] = {turn[k % 4], turn[(k + 3) % 4], turn[(k + 1) % 4], turn[k % 4]};
        for (int i = 0; i < 4; i++)
            assert_near(series[4 * k + i] * factorial, want[i], 1e-15 * pow(3, k));
    }
}

/* ---- order ---- */

/* Steps of dt, shorter than the tolerance would allow: the tolerance only chooses the order. */
static double error_at(double tolerance, double T, int n)
{
    made m;
    make(&m, "pendulum");
    ll_ode_control control = {.t_end = T, .tolerance = tolerance, .first_step = T / n, .largest_step = T / n};
    setting s = begin("taylor", &m.ode, m.y0, &control);
    double exact[2], most = 0;
    while (step(&s) == LL_ODE_RUNNING || s.run->state == LL_ODE_FINISHED) {
        m.problem->exact(m.params, s.run->t, exact);
        most = larger(most, hypot(ll_ode_y(s.run)[0] - exact[0], ll_ode_y(s.run)[1] - exact[1]));
        if (s.run->state == LL_ODE_FINISHED)
            break;
    }
    assert_int_equal(s.run->counters.steps, n);
    assert_int_equal(s.run->counters.rejected, 0);
    end(&s);
    return most;
}

static void the_order_is_that_of_the_tolerance(void **state)
{
    (void)state;
    static const struct {
        double tolerance;
        int order, coarse, fine;
    } known[] = {{0.1, 4, 200, 800}, {1e-3, 6, 100, 300}, {1e-5, 9, 70, 140}, {1e-7, 12, 60, 100}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double coarse = error_at(known[i].tolerance, 5, known[i].coarse),
               fine = error_at(known[i].tolerance, 5, known[i].fine);
        double seen = log(coarse / fine) / log((double)known[i].fine / known[i].coarse);
        if (!(fabs(seen - known[i].order) < 0.6))
            fail_msg("tolerance %g: observed order %.2f, not %d (%g, %g)", known[i].tolerance, seen,
                     known[i].order, coarse, fine);
    }
}

static void a_tolerance_chooses_the_number_of_coefficients(void **state)
{
    (void)state;
    static const struct {
        double tolerance;
        int order; /* 2 - 0.65 ln(tolerance), whole, at least 4 */
    } known[] = {{0.1, 4}, {1e-2, 4}, {1e-4, 7}, {1e-8, 13}, {1e-12, 19}, {1e-15, 24}};
    made m;
    make(&m, "kepler");
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double y[4];
        ll_ode_counters c = solve("taylor", &m.ode, m.y0, 10, 0, known[i].tolerance, y);
        assert_int_equal(c.evaluations, c.steps * known[i].order);
        assert_int_equal(c.rejected, 0);
    }
}

/* ---- solutions ---- */

static double error_of(const made *m, double tolerance)
{
    double y[LL_ODE_DIM_MAX], want[LL_ODE_DIM_MAX], most = 0;
    solve("taylor", &m->ode, m->y0, m->problem->duration, 0, tolerance, y);
    if (m->problem->exact == NULL || !m->problem->exact(m->params, m->problem->duration, want))
        memcpy(want, m->problem->reference, (size_t)m->ode.dim * sizeof *want);
    for (int i = 0; i < m->ode.dim; i++)
        most = larger(most, fabs(y[i] - want[i]));
    return most / larger(size_of(want, m->ode.dim), 1e-3); /* the ball comes to rest at 0 */
}

static void solutions_are_the_published_ones(void **state)
{
    (void)state;
    for (int i = 0; i < SMOOTH; i++) {
        made m;
        make(&m, smooth[i]);
        bool sensitive = strcmp(smooth[i], "arenstorf") == 0; /* its floor is 1.4e-11 */
        double fine = error_of(&m, 1e-14), coarse = error_of(&m, 1e-6);
        if (!(fine < (sensitive ? 1e-9 : 1e-11)) || !(coarse < (sensitive ? 1 : 1e-2)))
            fail_msg("%s: %g at a tolerance of 1e-14, %g at 1e-6", smooth[i], fine, coarse);
    }
}

/* Forwards and back; the series serves both directions. */
static void backwards(void **state)
{
    (void)state;
    made m;
    make(&m, "henon_heiles");
    double y[4], back[4];
    solve("taylor", &m.ode, m.y0, 20, 0, 1e-14, y);
    ll_ode_control control = {.t0 = 20, .t_end = 0, .tolerance = 1e-14};
    setting s = begin("taylor", &m.ode, y, &control);
    ll_ode_advance(s.run, s.method, s.ode, 0);
    memcpy(back, ll_ode_y(s.run), sizeof back);
    end(&s);
    for (int i = 0; i < 4; i++)
        assert_near(back[i], m.y0[i], 1e-12);
}

static void dense_output_is_as_good_as_the_steps(void **state)
{
    (void)state;
    made m;
    make(&m, "kepler");
    ll_ode_control control = {.t_end = 10, .tolerance = 1e-12};
    setting s = begin("taylor", &m.ode, m.y0, &control);
    for (int k = 1; k <= 1000; k++) {
        double t = 10. * k / 1000, y[4], exact[4];
        ll_ode_advance(s.run, s.method, s.ode, t);
        int64_t evaluations = s.run->counters.evaluations;
        ll_ode_sample(s.run, s.method, s.ode, t, y);
        assert_int_equal(s.run->counters.evaluations, evaluations);
        m.problem->exact(m.params, t, exact);
        for (int j = 0; j < 4; j++)
            assert_near(y[j], exact[j], 1e-9);
    }
    end(&s);
}

/* ---- what it does not serve ---- */

static void refused(const char *problem, const char *path, const char *value)
{
    made m;
    make(&m, problem);
    if (path != NULL) {
        ll_status set = ll_param_set(m.problem->params, m.params, path, value, false);
        assert_false(ll_failed(&set));
        m.problem->system(m.params, &m.ode);
    }
    ll_status status = ll_ode_method_fits(ll_ode_method_find("taylor"), &m.ode);
    assert_true(ll_failed(&status));
    assert_string_equal(status.field, "method");
    assert_non_null(strstr(status.text, "smooth"));
}

static void problems_that_are_not_smooth_are_refused(void **state)
{
    (void)state;
    refused("coulomb", NULL, NULL);
    refused("coulomb_naive", NULL, NULL);
    refused("penalty_floor", NULL, NULL);
    refused("van_der_pol", NULL, NULL);
    refused("drag_2d", "vx0", "0");        /* at rest at the apex: the root is not smooth there */
    refused("drag_vertical", "v0", "-10"); /* v |v| is not smooth at the apex */
}

/* y' = y^2 from 1: the pole at t = 1 lets the steps shrink until time no longer resolves them. */
static void pole_series(const void *params, double t, int order, double *row)
{
    (void)params, (void)t;
    for (int k = 0; k < order; k++) {
        double square = 0;
        for (int j = 0; j <= k; j++)
            square += row[2 * j] * row[2 * (k - j)];
        row[2 * k + 2] = square / (k + 1);
    }
}

static void pole_f(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = y[0] * y[0];
}

static void a_pole_ends_the_run(void **state)
{
    (void)state;
    const ll_ode ode = {.dim = 1, .autonomous = true, .f = pole_f, .series = pole_series};
    ll_ode_control control = {.t_end = 2, .tolerance = 1e-10};
    setting s = begin("taylor", &ode, (const double[]){1}, &control);
    ll_ode_advance(s.run, s.method, s.ode, 0.9);
    assert_near(ll_ode_y(s.run)[0] * (1 - s.run->t), 1, 1e-8);
    ll_ode_advance(s.run, s.method, s.ode, 2);
    assert_int_equal(s.run->state, LL_ODE_DIVERGED);
    assert_true(s.run->failed_t > 0.99 && s.run->failed_t < 1.01);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(coefficients),
        cmocka_unit_test(coefficients_of_a_circle),
        cmocka_unit_test(the_order_is_that_of_the_tolerance),
        cmocka_unit_test(a_tolerance_chooses_the_number_of_coefficients),
        cmocka_unit_test(solutions_are_the_published_ones),
        cmocka_unit_test(backwards),
        cmocka_unit_test(dense_output_is_as_good_as_the_steps),
        cmocka_unit_test(problems_that_are_not_smooth_are_refused),
        cmocka_unit_test(a_pole_ends_the_run),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
