/* The observed order of every method: the slope of the largest error of a trajectory over the step, by least
 * squares over the asymptotic range. The largest error, and ends that are no multiple of a period: the final
 * error at a period or at a lucky time lies about the order. */
#include <math.h>
#include <stdio.h>

#include "ode/core/problem.h"
#include "ode/harness.h"
#include "support/near.h"

enum { SAMPLES = 64 };

typedef struct made {
    const ll_ode_problem *problem;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_ode ode;
} made;

static void make(made *m, const char *name)
{
    m->problem = ll_ode_problem_find(name);
    assert_non_null(m->problem);
    ll_param_defaults(m->problem->params, m->params);
    if (m->problem->prepare != NULL)
        m->problem->prepare(m->params);
    m->problem->system(m->params, &m->ode);
    m->ode.event_count = 0;
}

/* Adaptive methods are held at the step by their limits. */
static ll_ode_control at_step(const ll_ode_method *method, double T, int n)
{
    double dt = T / n;
    /* An iteration ends by the tolerance. */
    double tolerance = strcmp(method->name, "radau5") == 0 ? smaller(0.1, 1000 * pow(dt, 6)) : 0.1;
    if (method->adaptive)
        return (ll_ode_control){.t_end = T, .tolerance = tolerance, .first_step = dt, .largest_step = dt};
    return (ll_ode_control){.t_end = T, .dt = dt};
}

static double distance(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum);
}

/* The largest error at 64 or more of n steps; infinite when the method failed or took others. */
static double largest_error(const made *m, const char *name, double T, int n)
{
    double y0[LL_ODE_DIM_MAX], exact[LL_ODE_DIM_MAX], most = 0;
    int every = n < 2 * SAMPLES ? 1 : n / SAMPLES;
    m->problem->start(m->params, y0);
    ll_ode_control control = at_step(ll_ode_method_find(name), T, n);
    setting s = begin(name, &m->ode, y0, &control);
    for (int i = 1; step(&s) != LL_ODE_DIVERGED; i++) {
        if (i % every == 0) {
            assert_true(m->problem->exact(m->params, s.run->t, exact));
            most = larger(most, distance(ll_ode_y(s.run), exact, m->ode.dim));
        }
        if (s.run->state == LL_ODE_FINISHED)
            break;
    }
    bool whole = s.run->state == LL_ODE_FINISHED && s.run->counters.steps == n;
    end(&s);
    return whole ? most : (double)INFINITY;
}

/* From errors below `high` down to `low`: below `high` the next term of the error no longer matters. */
static double observed_order(const made *m, const char *name, double high, double low)
{
    enum { LEAST = 3, MOST = 1 << 20 };
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    int points = 0;
    for (double steps = LEAST; steps <= MOST; steps *= 1.189207115002721) {
        double error = largest_error(m, name, m->problem->duration, (int)steps);
        if (error > high)
            continue;
        if (error < low)
            break;
        double x = log((int)steps), y = -log(error);
        sx += x, sy += y, sxx += x * x, sxy += x * y;
        points++;
    }
    if (points < 3)
        return 99; // fail_msg("%s on %s: %d points only", name, m->problem->name, points);
    return (points * sxy - sx * sy) / (points * sxx - sx * sx);
}

static void shows(const char *problem, const char *method, double order, double high, double low)
{
    made m;
    make(&m, problem);
    double seen = observed_order(&m, method, high, low), tolerance = order <= 2 ? 0.15 : 0.3;
    if (!(fabs(seen - order) <= tolerance))
        fail_msg("%s on %s: observed order %.3f, not %g", method, problem, seen, order);
}

typedef struct known {
    const char *method;
    double order;
    double high, low; /* range of errors */
} known;

/* Ranges that serve most problems; sizes are about 1. */
static const known usual[] = {
    {"explicit_euler", 1, 2e-2, 2e-3},
    {"semi_implicit_euler", 1, 1e-2, 1e-3},
    {"implicit_euler", 1, 2e-2, 2e-3},
    {"implicit_midpoint", 2, 1e-3, 5e-5},
    {"trapezoid", 2, 1e-3, 5e-5},
    {"stormer_verlet", 2, 1e-3, 2e-5},
    {"verlet_time_corrected", 2, 1e-3, 2e-5},
    {"verlet_improved", 2, 1e-3, 2e-5},
    {"velocity_verlet", 2, 1e-3, 2e-5},
    {"velocity_verlet_predicted", 2, 1e-3, 2e-5},
    {"leapfrog_kdk", 2, 1e-3, 2e-5},
    {"leapfrog_dkd", 2, 1e-3, 2e-5},
    {"ruth3", 3, 1e-3, 1e-8},
    {"yoshida4", 4, 1e-4, 1e-9},
    {"yoshida6", 6, 1e-5, 1e-10},
    {"yoshida8", 8, 1e-5, 1e-11},
    {"rk2", 2, 1e-3, 2e-5},
    {"ralston", 2, 1e-3, 2e-5},
    {"rk3", 3, 1e-3, 1e-8},
    {"rk4", 4, 1e-4, 1e-9},
    {"ab2", 2, 1e-3, 2e-5},
    {"ab3", 3, 1e-4, 1e-8},
    {"ab4", 4, 1e-6, 1e-11},
    {"bs32", 3, 1e-3, 1e-8},
    {"dopri5", 5, 1e-5, 1e-10},
    {"tsit5", 5, 1e-8, 1e-11},
    {"dop853", 8, 1e-6, 1e-12},
    {"rodas4", 4, 1e-4, 1e-9},
    {"rodas5p", 5, 1e-5, 1e-10},
    {"radau5", 5, 1e-5, 1e-9},
    {"extrapolated_midpoint", 8, 1e-6, 1e-11},
    {"extrapolated_leapfrog", 8, 1e-6, 1e-11},
    {"taylor", 4, 1e-4, 1e-9},
};

/* What a problem shows instead. An order of 0: it shows none in reach. */
static const struct {
    const char *problem;
    known as;
} unusual[] = {
    {"kepler", {"explicit_euler", 0, 0, 0}}, /* a million steps leave an error of 0.1 */
    {"kepler", {"implicit_euler", 0, 0, 0}},
    {"kepler",
     {"ruth3", 4, 1e-3, 1e-8}},      /* its third-order error stays bounded, the fourth-order one grows */
    {"kepler", {"dop853", 0, 0, 0}}, /* two terms of its error meet above the rounding */
    {"kepler", {"extrapolated_leapfrog", 8, 1e-7, 1e-11}},
    {"pendulum", {"ralston", 2, 1e-4, 1e-6}},
    {"pendulum", {"rk2", 2, 1e-4, 1e-6}},
    {"pendulum", {"rk4", 4, 3e-9, 1e-12}},    /* crossing zero above */
    {"pendulum", {"taylor", 4, 1e-7, 1e-10}}, /* likewise */
    {"pendulum", {"rodas4", 5, 1e-4, 1e-9}},  /* likewise */
    {"pendulum", {"dop853", 9, 1e-6, 1e-11}}, /* the next term is larger */
    {"pendulum", {"extrapolated_midpoint", 9, 1e-6, 1e-11}},
    {"pendulum", {"extrapolated_leapfrog", 9, 1e-6, 1e-11}},
    {"oscillator", {"rodas5p", 6, 1e-5, 1e-10}}, /* of order 6 on linear systems */
    {"forced", {"rk3", 4, 1e-3, 1e-8}},          /* Simpson's rule on a force of time alone */
};

static known expected(const char *problem, const known *row)
{
    for (size_t i = 0; i < sizeof unusual / sizeof unusual[0]; i++)
        if (strcmp(unusual[i].problem, problem) == 0 && strcmp(unusual[i].as.method, row->method) == 0)
            return unusual[i].as;
    return *row;
}

static void orders_on(const char *problem)
{
    for (size_t i = 0; i < sizeof usual / sizeof usual[0]; i++) {
        known k = expected(problem, &usual[i]);
        if (k.order > 0)
            shows(problem, k.method, k.order, k.high, k.low);
    }
}

static void on_the_oscillator(void **state)
{
    (void)state;
    orders_on("oscillator");
    shows("oscillator", "radau9", 9, 1e-4, 1e-12);
    shows("oscillator", "radau13", 13, 1, 1e-12);
}

static void on_a_force_of_time(void **state)
{
    (void)state;
    orders_on("forced");
}

static void on_the_pendulum(void **state)
{
    (void)state;
    orders_on("pendulum");
}

static void on_an_orbit(void **state)
{
    (void)state;
    orders_on("kepler");
}

/* Forces that depend on the velocity: the order that is left. Yoshida's coefficients do not help, Boris's
 * rotation and a predicted velocity do. */
static void on_forces_of_velocity(void **state)
{
    (void)state;
    static const char *const problems[] = {"damped", "drag_vertical", "lorentz"};
    static const known left[] = {
        {"explicit_euler", 1, 2e-2, 2e-3},
        {"semi_implicit_euler", 1, 2e-2, 2e-3},
        {"implicit_euler", 1, 2e-2, 2e-3},
        {"stormer_verlet", 1, 1e-2, 1e-3},
        {"verlet_time_corrected", 1, 1e-2, 1e-3},
        {"verlet_improved", 1, 1e-2, 1e-3},
        {"velocity_verlet", 1, 1e-2, 1e-3},
        {"velocity_verlet_predicted", 2, 1e-3, 2e-5},
        {"leapfrog_kdk", 1, 1e-2, 1e-3},
        {"leapfrog_dkd", 1, 1e-2, 1e-3},
        {"ruth3", 1, 1e-2, 1e-3},
        {"yoshida4", 1, 1e-2, 1e-3},
        {"yoshida6", 1, 1e-2, 1e-3},
        {"yoshida8", 1, 1e-2, 1e-3},
        {"rk2", 2, 1e-3, 2e-5},
        {"implicit_midpoint", 2, 1e-3, 5e-5},
        {"trapezoid", 2, 1e-3, 5e-5},
        {"ab2", 2, 1e-3, 2e-5},
        {"ab4", 4, 1e-6, 1e-10},
        {"rk4", 4, 1e-5, 1e-9},
        {"dopri5", 5, 1e-6, 1e-10},
        {"taylor", 4, 1e-5, 1e-9},
    };
    for (size_t p = 0; p < sizeof problems / sizeof problems[0]; p++)
        for (size_t i = 0; i < sizeof left / sizeof left[0]; i++)
            shows(problems[p], left[i].method, left[i].order, left[i].high, left[i].low);
    for (size_t i = 0; i < sizeof left / sizeof left[0]; i++) { /* and that is what the table tells */
        made m;
        make(&m, "damped");
        assert_int_equal(ll_ode_order(ll_ode_method_find(left[i].method), &m.ode), (int)left[i].order);
    }
    shows("lorentz", "boris", 2, 1e-3, 1e-6);
    shows("lorentz", "extrapolated_leapfrog", 8, 1e-6, 1e-12);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(on_the_oscillator),     cmocka_unit_test(on_a_force_of_time),
        cmocka_unit_test(on_the_pendulum),       cmocka_unit_test(on_an_orbit),
        cmocka_unit_test(on_forces_of_velocity),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
