/* The observed order of every row of the table of methods is the row's: the slope of the largest error of a
 * trajectory over the step, by least squares over the asymptotic range. The largest error, and ends that are
 * no multiple of a period: the final error at a period or at a lucky time lies about the order. */
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
        return NAN; /* too few to see one */
    return (points * sxy - sx * sy) / (points * sxx - sx * sx);
}

typedef struct range {
    double high, low; /* of errors */
} range;

/* In which an order shows, by that number, where nothing else is said; the sizes of the problems are about 1.
 */
static const range ranges[] = {
    [1] = {1e-2, 1e-3},  [2] = {1e-3, 2e-5},  [3] = {1e-3, 1e-8},  [4] = {1e-4, 1e-9}, [5] = {1e-5, 1e-10},
    [6] = {1e-5, 1e-10}, [8] = {1e-6, 1e-11}, [9] = {1e-4, 1e-12}, [13] = {1, 1e-12},
};

/* What a method (on one problem; NULL: on any) shows instead. An order of 0: the row's. NONE: none in reach.
 */
enum { NONE = -1 };
static const struct {
    const char *method, *problem;
    int order;
    range within;
} unusual[] = {
    {"explicit_euler", NULL, 0, {2e-2, 2e-3}},
    {"implicit_euler", NULL, 0, {2e-2, 2e-3}},
    {"ab4", NULL, 0, {1e-6, 1e-11}},
    {"tsit5", NULL, 0, {1e-8, 1e-11}},
    {"explicit_euler", "kepler", NONE, {0, 0}}, /* a million steps leave an error of 0.1 */
    {"implicit_euler", "kepler", NONE, {0, 0}},
    {"ruth3",
     "kepler",
     4,
     {1e-3, 1e-8}},                     /* its third-order error stays bounded, the fourth-order one grows */
    {"dop853", "kepler", NONE, {0, 0}}, /* two terms of its error meet above the rounding */
    {"extrapolated_leapfrog", "kepler", 0, {1e-7, 1e-11}},
    {"ralston", "pendulum", 0, {1e-4, 1e-6}},
    {"rk4", "pendulum", 0, {3e-9, 1e-12}},    /* crossing zero above */
    {"taylor", "pendulum", 0, {1e-7, 1e-10}}, /* likewise */
    {"rodas4", "pendulum", 5, {1e-4, 1e-9}},  /* likewise */
    {"dop853", "pendulum", 9, {1e-6, 1e-11}}, /* the next term is larger */
    {"extrapolated_midpoint", "pendulum", 9, {1e-6, 1e-11}},
    {"extrapolated_leapfrog", "pendulum", 9, {1e-6, 1e-11}},
    {"rk3", "forced", 4, {1e-3, 1e-8}},          /* Simpson's rule on a force of time alone */
    {"rodas5p", "oscillator", 6, {1e-5, 1e-10}}, /* of order 6 on linear systems */
    {"rodas5p", "damped", 6, {1e-5, 1e-10}},
    {"rodas5p", "lorentz", 6, {1e-5, 1e-10}},
    {"radau9", "pendulum", NONE, {0, 0}}, /* the iteration ends by the tolerance, above its error */
    {"radau9", "kepler", NONE, {0, 0}},
    {"radau13", "forced", NONE, {0, 0}}, /* exact to the rounding after a few steps */
    {"radau13", "damped", NONE, {0, 0}},
    {"radau13", "pendulum", NONE, {0, 0}},
    {"radau13", "kepler", NONE, {0, 0}},
    {"dop853", "drag_vertical", NONE, {0, 0}}, /* |v| v is not smooth at the highest point */
    {"rodas4", "drag_vertical", NONE, {0, 0}},
    {"radau5", "drag_vertical", NONE, {0, 0}},
    {"radau9", "drag_vertical", NONE, {0, 0}},
    {"radau13", "drag_vertical", NONE, {0, 0}},
};

static bool is_of(size_t row, const char *method, const char *problem)
{
    return strcmp(unusual[row].method, method) == 0 &&
           (unusual[row].problem == NULL || strcmp(unusual[row].problem, problem) == 0);
}

/* Of order 0 is what does not converge: a small step does not help. */
static void does_not_converge(const made *m, const char *name)
{
    assert_at_least(name, largest_error(m, name, m->problem->duration, 1 << 14), 0.1);
}

/* Whether it was measured. */
static bool shows(const made *m, const ll_ode_method *method)
{
    int order = ll_ode_order(method, &m->ode);
    range within = {0};
    for (size_t i = 0; i < sizeof unusual / sizeof unusual[0]; i++)
        if (is_of(i, method->name, m->problem->name)) {
            order = unusual[i].order ? unusual[i].order : order;
            within = unusual[i].within;
        }
    if (order == NONE)
        return false;
    if (order == 0) {
        does_not_converge(m, method->name);
        return true;
    }
    if (within.high == 0 && order < (int)(sizeof ranges / sizeof ranges[0]))
        within = ranges[order];
    if (within.high == 0)
        fail_msg("%s: no range of errors for its order %d", method->name, order);
    double seen = observed_order(m, method->name, within.high, within.low);
    if (!is_near(seen, order, order <= 2 ? 0.15 : 0.3))
        fail_msg("%s on %s: observed order %.3f, not %d", method->name, m->problem->name, seen, order);
    return true;
}

static int measured[100]; /* on how many problems, by row of the table */

static void orders_on(const char *problem)
{
    made m;
    make(&m, problem);
    for (int i = 0; ll_ode_methods[i]; i++) {
        ll_status fits = ll_ode_method_fits(ll_ode_methods[i], &m.ode);
        assert_true(i < (int)(sizeof measured / sizeof measured[0]));
        if (!ll_failed(&fits))
            measured[i] += shows(&m, ll_ode_methods[i]);
    }
}

static void on_the_oscillator(void **state)
{
    (void)state;
    orders_on("oscillator");
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
static void on_damping(void **state)
{
    (void)state;
    orders_on("damped");
}

static void on_drag(void **state)
{
    (void)state;
    orders_on("drag_vertical");
}

static void on_a_magnetic_force(void **state)
{
    (void)state;
    orders_on("lorentz");
}

/* The tests above have left none out, and what is unusual is of methods that there are. */
static void each_row_is_measured(void **state)
{
    (void)state;
    for (int i = 0; ll_ode_methods[i]; i++)
        if (measured[i] == 0)
            fail_msg("%s shows its order on no problem", ll_ode_methods[i]->name);
    for (size_t i = 0; i < sizeof unusual / sizeof unusual[0]; i++)
        assert_non_null(ll_ode_method_find(unusual[i].method));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(on_the_oscillator),   cmocka_unit_test(on_a_force_of_time),
        cmocka_unit_test(on_the_pendulum),     cmocka_unit_test(on_an_orbit),
        cmocka_unit_test(on_damping),          cmocka_unit_test(on_drag),
        cmocka_unit_test(on_a_magnetic_force), cmocka_unit_test(each_row_is_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
