/* Implicit methods on stiff problems, over ladders of steps and of tolerances: each run is right to the order
 * of its method, or has failed. What a step of a one-stage method ought to give is known from a second, slow
 * implementation: the solution of its equations that grows out of the state as the step grows from 0. */
#include <math.h>
#include <stdio.h>

#include "ode/core/problem.h"
#include "ode/harness.h"
#include "support/near.h"

typedef struct stiff {
    const char *problem, *set[2]; /* a parameter and its value; NULL: as they are */
    double T;
    double coarse, fine; /* steps of the ladder */
    bool amounts;        /* of which there cannot be less than none */
} stiff;

static const stiff cases[] = {
    {"robertson", {NULL, NULL}, 25, 1, 0.0004, true},   {"van_der_pol", {"mu", "8"}, 17, 0.1, 0.0001, false},
    {"van_der_pol", {"mu", "200"}, 60, 1, 0.01, false}, {"oregonator", {NULL, NULL}, 15, 0.5, 0.002, true},
    {"hires", {NULL, NULL}, 60, 4, 0.02, true},
};

enum { CASES = sizeof cases / sizeof cases[0], DIM = 16 };

typedef struct made {
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_ode ode;
    double start[DIM];
} made;

static void make(made *m, const stiff *c)
{
    const ll_ode_problem *p = ll_ode_problem_find(c->problem);
    assert_non_null(p);
    ll_param_defaults(p->params, m->params);
    if (c->set[0]) {
        ll_status status = ll_param_set(p->params, m->params, c->set[0], c->set[1], false);
        assert_false(ll_failed(&status));
    }
    if (p->prepare)
        p->prepare(m->params);
    p->system(m->params, &m->ode);
    assert_true(m->ode.dim <= DIM);
    p->start(m->params, m->start);
}

/* ---- the slow implementation ---- */

static void gauss(int n, double a[DIM][DIM + 1])
{
    for (int k = 0; k < n; k++) {
        int best = k;
        for (int i = k; i < n; i++)
            best = fabs(a[i][k]) > fabs(a[best][k]) ? i : best;
        for (int j = 0; j <= n; j++) {
            double other = a[k][j];
            a[k][j] = a[best][j];
            a[best][j] = other;
        }
        for (int i = 0; i < n; i++)
            for (int j = n; j >= k && i != k; j--)
                a[i][j] -= a[i][k] / a[k][k] * a[k][j];
    }
    for (int i = 0; i < n; i++)
        a[i][n] /= a[i][i];
}

/* One full Newton step of z = base + w f(z), with central differences; the size of the change in parts. */
static double newton(const ll_ode *ode, double t, const double *base, double w, double *z)
{
    int n = ode->dim;
    double a[DIM][DIM + 1], f[DIM], up[DIM], down[DIM], moved[DIM], most = 0;
    ll_ode_eval(ode, t, z, f);
    for (int j = 0; j < n; j++) {
        double step = 1e-6 * larger(fabs(z[j]), 1e-6);
        for (int i = 0; i < n; i++)
            moved[i] = z[i] + (i == j ? step : 0);
        ll_ode_eval(ode, t, moved, up);
        moved[j] = z[j] - step;
        ll_ode_eval(ode, t, moved, down);
        for (int i = 0; i < n; i++)
            a[i][j] = (i == j) - w * (up[i] - down[i]) / (2 * step);
    }
    for (int i = 0; i < n; i++)
        a[i][n] = base[i] + w * f[i] - z[i];
    gauss(n, a);
    for (int i = 0; i < n; i++) {
        z[i] += a[i][n];
        most = larger(most, fabs(a[i][n]) / (fabs(z[i]) + 1e-9));
    }
    return most;
}

/* In 200 parts from nothing to the whole step. */
static bool slow_step(const ll_ode *ode, const char *method, double t, double h, double *y)
{
    enum { PARTS = 200 };
    bool euler = method[9] == 'e', trapezoid = method[0] == 't';
    double f[DIM], base[DIM], z[DIM], w = euler ? h : h / 2, at = t + (euler || trapezoid ? h : h / 2);
    ll_ode_eval(ode, t, y, f);
    for (int i = 0; i < ode->dim; i++)
        z[i] = y[i];
    for (int k = 1; k <= PARTS; k++) {
        double s = (double)k / PARTS, change = 1;
        for (int i = 0; i < ode->dim; i++)
            base[i] = y[i] + (trapezoid ? s * w * f[i] : 0);
        for (int i = 0; i < 20 && change > 1e-12; i++)
            change = newton(ode, at, base, s * w, z);
        if (!(change < 1e-6))
            return false;
    }
    for (int i = 0; i < ode->dim; i++)
        y[i] = euler || trapezoid ? z[i] : 2 * z[i] - y[i];
    return true;
}

static const char *const one_stage[] = {"implicit_euler", "implicit_midpoint", "trapezoid"};

/* Both from the same start, step by step, until one of them fails or the steps are enough. */
static void compare(const stiff *c, const char *method, double dt)
{
    enum { STEPS = 120 };
    made m;
    double y[DIM];
    make(&m, c);
    memcpy(y, m.start, sizeof y);
    ll_ode_control control = {.t_end = c->T, .dt = dt};
    setting s = begin(method, &m.ode, m.start, &control);
    for (int k = 0; k < STEPS && k * dt < c->T - dt; k++) {
        bool known = slow_step(&m.ode, method, k * dt, dt, y);
        if (step(&s) == LL_ODE_DIVERGED || !known)
            break;
        for (int i = 0; i < m.ode.dim; i++) {
            double got = ll_ode_y(s.run)[i];
            if (!(fabs(got - y[i]) <= 1e-7 * fabs(y[i]) + 1e-12))
                fail_msg("%s, %s, dt %g: step %d, component %d is %.15g, not %.15g", c->problem, method, dt,
                         k + 1, i, got, y[i]);
            y[i] = got; /* what is compared is each step, not what small differences grow to */
        }
    }
    end(&s);
}

static void steps_are_those_of_the_slow_implementation(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++)
        for (int k = 0; k < 3; k++)
            for (double dt = cases[c].coarse; dt >= cases[c].fine; dt /= 3.3)
                compare(&cases[c], one_stage[k], dt);
}

/* ---- orders ---- */

static double distance(const double *a, const double *b, int n)
{
    double most = 0;
    for (int i = 0; i < n; i++)
        most = larger(most, fabs(a[i] - b[i]) / (fabs(b[i]) + 1e-6));
    return most;
}

/* By two methods of different families, which agree. */
static void reference(const stiff *c, made *m, double *y)
{
    double other[DIM];
    make(m, c);
    solve("radau13", &m->ode, m->start, c->T, 0, 1e-13, y);
    solve("rodas5p", &m->ode, m->start, c->T, 0, 1e-12, other);
    assert_true(distance(other, y, m->ode.dim) < 1e-7);
}

/* The relative error at T; NAN of a run that failed. Methods that damp what is stiff keep amounts above 0. */
static double error_of(const stiff *c, made *m, const char *method, double dt, double tolerance,
                       const double *wanted)
{
    ll_ode_control control = {.t_end = c->T, .dt = dt, .tolerance = tolerance, .absolute = 1e-3 * tolerance};
    setting s = begin(method, &m->ode, m->start, &control);
    bool damps = s.method->adaptive || method[9] == 'e';
    double error = NAN, least = c->amounts && damps ? -1e-3 : -INFINITY;
    while (step(&s) == LL_ODE_RUNNING)
        for (int i = 0; i < m->ode.dim; i++)
            if (!(ll_ode_y(s.run)[i] >= least))
                fail_msg("%s, %s, %g: %g at %g s", c->problem, method, dt, ll_ode_y(s.run)[i], s.run->t);
    if (s.run->state == LL_ODE_FINISHED)
        error = distance(ll_ode_y(s.run), wanted, m->ode.dim);
    end(&s);
    return error;
}

static void ladders_of_steps_show_the_order_or_fail(void **state)
{
    (void)state;
    for (int c = 0; c < CASES; c++) {
        made m;
        double wanted[DIM];
        reference(&cases[c], &m, wanted);
        for (int k = 0; k < 3; k++) {
            double before = NAN, error = NAN, order = NAN, steps = ceil(cases[c].T / cases[c].coarse);
            for (; cases[c].T / steps >= cases[c].fine; steps *= 2) {
                before = error;
                error = error_of(&cases[c], &m, one_stage[k], cases[c].T / steps, 0, wanted);
                order = log2(before / error);
            }
            int want = ll_ode_method_find(one_stage[k])->order;
            if (!(fabs(order - want) < 0.25) && !(error < 1e-8))
                fail_msg("%s %s: order %g at an error of %g, not %d", cases[c].problem, one_stage[k], order,
                         error, want);
        }
    }
}

static void tolerances_are_kept_or_the_run_fails(void **state)
{
    (void)state;
    static const char *const methods[] = {"rodas4", "rodas5p", "radau5", "radau9", "radau13"};
    for (int c = 0; c < CASES; c++) {
        made m;
        double wanted[DIM];
        reference(&cases[c], &m, wanted);
        for (size_t k = 0; k < sizeof methods / sizeof methods[0]; k++)
            for (double tolerance = 1e-4; tolerance > 1e-11; tolerance *= 0.1) {
                double error = error_of(&cases[c], &m, methods[k], 0, tolerance, wanted);
                if (!isnan(error) && !(error <= 1e4 * tolerance))
                    fail_msg("%s %s: %g at a tolerance of %g", cases[c].problem, methods[k], error,
                             tolerance);
            }
    }
}

/* y' = y^2: y = 1 / (1 - t) has no value beyond 1 s. z = y + h z^2 has two solutions, or none: the one that
 * is meant is the smaller. */
static void square(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = y[0] * y[0];
}

static void a_step_without_solution_fails(void **state)
{
    (void)state;
    static const ll_ode ode = {.dim = 1, .autonomous = true, .f = square};
    static const double one[1] = {1};
    for (double h = 0.01; h < 1; h *= 1.3) {
        ll_ode_control control = {.t_end = 10, .dt = h};
        setting s = begin("implicit_euler", &ode, one, &control);
        ll_ode_state after = step(&s);
        assert_int_equal(after, h <= 0.25 ? LL_ODE_RUNNING : LL_ODE_DIVERGED);
        if (h <= 0.25)
            assert_near(ll_ode_y(s.run)[0] / ((1 - sqrt(1 - 4 * h)) / (2 * h)), 1, 1e-9);
        else
            assert_int_equal(ll_ode_run_status(s.run), LL_RUN_FAILED);
        end(&s);
    }
}

/* y' = 5 y grows; beyond h = 1/5 implicit Euler's equation gives a value of the other sign. */
static void growth(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = 5 * y[0];
}

static void a_step_beyond_growth_fails(void **state)
{
    (void)state;
    static const ll_ode ode = {.dim = 1, .autonomous = true, .f = growth};
    static const double one[1] = {1};
    for (int k = 0; k < 2; k++) {
        ll_ode_control control = {.t_end = 10, .dt = k ? 0.21 : 0.19};
        setting s = begin("implicit_euler", &ode, one, &control);
        assert_int_equal(step(&s), k ? LL_ODE_DIVERGED : LL_ODE_RUNNING);
        end(&s);
    }
}

/* A floor of springs, stiff at the step: f has a kink where the body touches. It comes to rest at g / k, by
 * closed form, and the step that touches first is that of a linear system. */
static void kinked(const void *params, double t, const double *y, double *dy)
{
    (void)params, (void)t;
    dy[0] = y[1];
    dy[1] = -9 + (y[0] < 0 ? -70000 * y[0] : 0);
}

static void a_kink_is_no_failure(void **state)
{
    (void)state;
    static const ll_ode ode = {.dim = 2, .autonomous = true, .f = kinked};
    static const double start[2] = {0.7, -0.3};
    for (int k = 0; k < 3; k++)
        for (double h = 0.0023; h < 0.1; h *= 1.21) {
            ll_ode_control control = {.t_end = 40, .dt = h};
            setting s = begin(one_stage[k], &ode, start, &control);
            while (step(&s) == LL_ODE_RUNNING)
                ;
            if (s.run->state != LL_ODE_FINISHED)
                fail_msg("%s at %g fails at %g s", one_stage[k], h, s.run->failed_t);
            if (k == 0 && !(fabs(ll_ode_y(s.run)[0] + 9. / 70000) < 1e-9))
                fail_msg("at %g it rests at %g", h, ll_ode_y(s.run)[0]);
            end(&s);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(steps_are_those_of_the_slow_implementation),
        cmocka_unit_test(ladders_of_steps_show_the_order_or_fail),
        cmocka_unit_test(tolerances_are_kept_or_the_run_fails),
        cmocka_unit_test(a_step_without_solution_fails),
        cmocka_unit_test(a_step_beyond_growth_fails),
        cmocka_unit_test(a_kink_is_no_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
