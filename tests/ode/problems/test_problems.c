/* The problems against themselves: a solution by formula must have the system's slope and the published
 * values, a Jacobian must be that of the system, an energy must stay, and a reference must be where
 * integration leads. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "ode/core/measure.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"
#include "support/near.h"

typedef struct made {
    const ll_ode_problem *problem;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_ode ode;
} made;

static void prepare(made *m)
{
    if (m->problem->prepare)
        m->problem->prepare(m->params);
    m->problem->system(m->params, &m->ode);
}

/* The problem with its defaults, then `path=value`, NULL-terminated. */
static made make(const char *name, const char *const *sets)
{
    made m = {.problem = ll_ode_problem_find(name)};
    assert_non_null(m.problem);
    assert_true(m.problem->params->size <= sizeof m.params);
    ll_param_defaults(m.problem->params, m.params);
    for (; sets && *sets; sets += 2) {
        ll_status status = ll_param_set(m.problem->params, m.params, sets[0], sets[1], false);
        assert_false(ll_failed(&status));
    }
    prepare(&m);
    return m;
}

/* `m` was copied: its system points to the parameters of the original. */
static const made *settled(made *m)
{
    prepare(m);
    return m;
}

static void tables_are_sound(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_ode_problems[n]; n++) {
        const ll_ode_problem *p = ll_ode_problems[n];
        ll_status status = ll_param_table_valid(p->params);
        if (ll_failed(&status))
            fail_msg("%s: %s", p->name, status.text);
        made m = make(p->name, NULL);
        settled(&m);
        assert_string_equal(p->params->name, p->name);
        assert_true(m.ode.dim > 0 && m.ode.dim <= LL_ODE_DIM_MAX && p->duration > 0);
        assert_true(m.ode.f != NULL || m.ode.acceleration != NULL);
        assert_true(p->exact != NULL || p->reference != NULL);
        for (int i = 0; i < m.ode.dim; i++)
            assert_non_null(p->components[i]);
        for (int i = 0; i < n; i++)
            assert_string_not_equal(p->name, ll_ode_problems[i]->name);
    }
    assert_int_equal(n, 31);
    assert_null(ll_ode_problem_find("kepler2"));
}

/* ---- exact solutions ---- */

/* |dy/dt - f| by central differences of order 6, over the scale of f. */
static double slope_error(const made *m, double t, double h)
{
    static const double weight[] = {3.0 / 4, -3.0 / 20, 1.0 / 60};
    double y[LL_ODE_DIM_MAX], f[LL_ODE_DIM_MAX], a[LL_ODE_DIM_MAX], b[LL_ODE_DIM_MAX],
        d[LL_ODE_DIM_MAX] = {0};
    double worst = 0, scale = 1;
    assert_true(m->problem->exact(m->params, t, y));
    ll_ode_eval(&m->ode, t, y, f);
    for (int k = 0; k < 3; k++) {
        m->problem->exact(m->params, t + (k + 1) * h, a);
        m->problem->exact(m->params, t - (k + 1) * h, b);
        for (int i = 0; i < m->ode.dim; i++)
            d[i] += weight[k] * (a[i] - b[i]) / h;
    }
    for (int i = 0; i < m->ode.dim; i++) {
        worst = larger(worst, fabs(d[i] - f[i]));
        scale = larger(scale, fabs(f[i]));
    }
    return worst / scale;
}

static void has_the_slope(const char *name, const char *const *sets, double t_end, double h)
{
    made m = make(name, sets);
    settled(&m);
    double y[LL_ODE_DIM_MAX], start[LL_ODE_DIM_MAX];
    m.problem->start(m.params, start);
    assert_true(m.problem->exact(m.params, 0, y));
    for (int i = 0; i < m.ode.dim; i++)
        assert_near(y[i], start[i], 1e-14);
    for (int k = 1; k < 50; k++) {
        double error = slope_error(&m, t_end * k / 50 + 1e-3 * h, h);
        if (!(error <= 2e-9))
            fail_msg("%s at %g: slope off by %g", name, t_end * k / 50, error);
    }
}

#define SETS(...) ((const char *const[]){__VA_ARGS__, NULL})

static void formulas_solve_their_systems(void **state)
{
    (void)state;
    static const char *const smooth[] = {"free_fall",     "jerk",    "forced",   "oscillator", "damped",
                                         "drag_vertical", "lorentz", "pendulum", "kepler"};
    for (size_t i = 0; i < sizeof smooth / sizeof smooth[0]; i++)
        has_the_slope(smooth[i], NULL, 10, 1e-3);
    has_the_slope("damped", SETS("zeta", "1", "v0", "3"), 10, 1e-3);
    has_the_slope("damped", SETS("zeta", "5", "v0", "-2"), 10, 1e-3);
    has_the_slope("oscillator", SETS("omega", "7", "v0", "3"), 10, 1e-4);
    has_the_slope("drag_vertical", SETS("v0", "-40"), 2.9, 1e-3);
    has_the_slope("drag_vertical", SETS("v0", "20"), 9, 1e-3);
    has_the_slope("kepler", SETS("e", "0.9"), 20, 2e-5);
    has_the_slope("kepler", SETS("e", "0"), 20, 1e-3);
    has_the_slope("pendulum", SETS("theta0", "3.1"), 10, 1e-3);
    has_the_slope("pendulum", SETS("theta0", "-0.5"), 10, 1e-3);
    has_the_slope("lorentz", SETS("b", "3", "speed", "2"), 10, 1e-3);
    has_the_slope("free_fall", SETS("v0", "-4"), 3, 1e-3);
    has_the_slope("drag_2d", SETS("kd", "0"), 7.9, 1e-3);
    has_the_slope("spring_chain", NULL, 1, 1e-4);
    has_the_slope("prothero_robinson", SETS("lambda", "10"), 10, 1e-3);
}

/* Values with more digits than a double, from reference_values. */
static void formulas_give_the_published_values(void **state)
{
    (void)state;
    static const struct {
        const char *name, *set, *to;
        double t;
        int component;
        double value, tolerance;
    } known[] = {
        {"free_fall", NULL, NULL, 3, 0, 45, 0},
        {"jerk", NULL, NULL, 2, 0, 8, 0},
        {"forced", NULL, NULL, 10, 0, 1.8390715290764524523, 4e-16},
        {"oscillator", NULL, NULL, 10, 0, -0.83907152907645245226, 2e-16},
        {"oscillator", NULL, NULL, 10, 1, 0.5440211108893698134, 2e-16},
        {"damped", NULL, NULL, 10, 0, -0.3368516805904133628, 4e-16},
        {"damped", NULL, NULL, 10, 1, 0.18534570698460589892, 4e-16},
        {"drag_vertical", NULL, NULL, 4, 0, 67.383063156845515, 3e-14},
        {"drag_vertical", NULL, NULL, 4, 1, 28.867959136324793909, 1e-14},
        {"drag_vertical", "v0", "-40", 3.0090987538164299258, 0, -51.899533837845040893, 5e-14},
        {"drag_vertical", "v0", "-40", 6.4523702815284622369, 1, 26.666666666666666667, 5e-14},
        {"drag_vertical", "v0", "-40", 6.4523702815284622369, 0, 0, 1e-13},
        {"pendulum", NULL, NULL, 10, 0, 0.51543622699413608293, 1e-14},
        {"pendulum", NULL, NULL, 10, 1, 5.0719318194344523706, 3e-14},
        {"kepler", NULL, NULL, 10, 0, -1.5350235919098136943, 2e-14},
        {"kepler", NULL, NULL, 10, 3, -0.47918775820321956529, 2e-14},
        {"kepler", "e", "0.9", 20, 0, -1.2952662509875743677, 3e-14},
        {"kepler", "e", "0.9", 20, 1, 0.40039389637923215273, 3e-14},
        {"kepler", "e", "0.5", 20, 2, -0.95950837303807273563, 2e-14},
        {"lorentz", NULL, NULL, 10, 0, -0.5440211108893698134, 2e-16},
        {"lorentz", NULL, NULL, 10, 1, -1.8390715290764524523, 4e-16},
        {"spring_chain", NULL, NULL, 1, 7, -0.22014152250899499533, 3e-14},
        {"spring_chain", NULL, NULL, 1, 0, -0.027435949526902343358, 3e-14},
        {"prothero_robinson", NULL, NULL, 10, 0, -0.83907152907645245226, 2e-16},
        {"coulomb", NULL, NULL, 1.5, 0, 2.25, 0},
        {"coulomb", NULL, NULL, 5, 0, 2.25, 0},
        {"bouncing_ball", NULL, NULL, 1.5, 0, 0, 0},
        {"penalty_floor", NULL, NULL, 0.90440649987992834297, 0, 1, 1e-12},
    };
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        double y[LL_ODE_DIM_MAX];
        made m = make(known[i].name, known[i].set ? SETS(known[i].set, known[i].to) : NULL);
        assert_true(m.problem->exact(m.params, known[i].t, y));
        double error = fabs(y[known[i].component] - known[i].value);
        if (!(error <= known[i].tolerance))
            fail_msg("%s component %d at %g: off by %g", known[i].name, known[i].component, known[i].t,
                     error);
    }
}

/* Impacts at t1 (1 + 2 sum e^j), the last at t1 (1 + e) / (1 - e). */
static void the_ball_bounces_at_its_times(void **state)
{
    (void)state;
    static const struct {
        const char *e;
        double t;
    } impacts[] = {{"0.5", 0.44721359549995793928},
                   {"0.5", 1.2857390870623790754},
                   {"0.9", 3.215555194363797575},
                   {"0.9", 5.3783835370904465687}};
    for (size_t i = 0; i < sizeof impacts / sizeof impacts[0]; i++) {
        made m = make("bouncing_ball", SETS("e", impacts[i].e));
        double before[2], after[2];
        m.problem->exact(m.params, impacts[i].t - 1e-9, before);
        m.problem->exact(m.params, impacts[i].t + 1e-9, after);
        assert_true(before[1] < 0 && after[1] > 0);
        assert_true(before[0] > 0 && before[0] < 1e-8 && after[0] > 0 && after[0] < 1e-8);
        assert_near(after[1] / -before[1], strtod(impacts[i].e, NULL), 1e-6);
    }
    double y[2];
    made m = make("bouncing_ball", SETS("e", "0.9"));
    m.problem->exact(m.params, 8.49, y);
    assert_true(y[0] > 0 || y[1] != 0);
    m.problem->exact(m.params, 8.4970583144992008464, y);
    assert_true(y[0] == 0 && y[1] == 0);
}

/* ---- Jacobians ---- */

static void jacobians_are_of_the_system(void **state)
{
    (void)state;
    int tried = 0;
    for (int n = 0; ll_ode_problems[n]; n++) {
        made m = make(ll_ode_problems[n]->name, NULL);
        settled(&m);
        if (!m.ode.jacobian)
            continue;
        int dim = m.ode.dim;
        double y[LL_ODE_DIM_MAX], j[64 * 64], up[LL_ODE_DIM_MAX], down[LL_ODE_DIM_MAX];
        assert_true(dim <= 64);
        m.problem->start(m.params, y);
        for (int i = 0; i < dim; i++)
            y[i] += 0.01 * (i + 1);
        for (int i = 0; i < dim * dim; i++)
            j[i] = 1e9; /* all must be written */
        m.ode.jacobian(m.params, 0.3, y, j);
        for (int c = 0; c < dim; c++) {
            double was = y[c], h = 1e-5;
            y[c] = was + h;
            ll_ode_eval(&m.ode, 0.3, y, up);
            y[c] = was - h;
            ll_ode_eval(&m.ode, 0.3, y, down);
            y[c] = was;
            for (int r = 0; r < dim; r++) {
                double slope = (up[r] - down[r]) / (2 * h), scale = larger(fabs(slope), fabs(up[r]) / 10 + 1);
                if (!is_near(slope, j[r * dim + c], 1e-5 * scale))
                    fail_msg("%s: df%d/dy%d is %g, not %g", m.problem->name, r, c, slope, j[r * dim + c]);
            }
        }
        tried++;
    }
    assert_int_equal(tried, 10);
}

/* What a system says of itself is so: methods leave out df/dt, or forces of velocities. */
static void systems_depend_on_what_they_say(void **state)
{
    (void)state;
    int timed = 0;
    for (int n = 0; ll_ode_problems[n]; n++) {
        made m = make(ll_ode_problems[n]->name, NULL);
        settled(&m);
        double y[LL_ODE_DIM_MAX], first[LL_ODE_DIM_MAX], later[LL_ODE_DIM_MAX];
        m.problem->start(m.params, y);
        for (int i = 0; i < m.ode.dim; i++)
            y[i] += 0.01 * (i + 1);
        bool changes = false;
        ll_ode_eval(&m.ode, 0, y, first);
        for (int k = 1; k <= 8; k++) {
            ll_ode_eval(&m.ode, 0.37 * k, y, later);
            changes = changes || memcmp(first, later, (size_t)m.ode.dim * sizeof *y) != 0;
        }
        if (changes == m.ode.autonomous)
            fail_msg("%s: f %s with t", m.problem->name, changes ? "changes" : "does not change");
        timed += changes;
        if (!m.ode.acceleration)
            continue;
        changes = false;
        for (int k = 0; k < 2; k++) { /* the direction counts, too */
            for (int i = m.ode.dim / 2; i < m.ode.dim; i++)
                y[i] = -1.1 * y[i];
            ll_ode_eval(&m.ode, 0, y, later);
            changes = changes || memcmp(first + m.ode.dim / 2, later + m.ode.dim / 2,
                                        (size_t)(m.ode.dim / 2) * sizeof *y) != 0;
        }
        if (changes != m.ode.velocity_dependent)
            fail_msg("%s: the acceleration %s with the velocity", m.problem->name,
                     changes ? "changes" : "does not change");
    }
    assert_true(timed >= 2);
}

/* ---- measuring ---- */

/* What was in memory before, as of another run, does not count. */
static void a_measure_starts_from_nothing(void **state)
{
    (void)state;
    for (int n = 0; ll_ode_problems[n]; n++) {
        made m = make(ll_ode_problems[n]->name, NULL);
        settled(&m);
        const int dim = m.ode.dim;
        double y[LL_ODE_DIM_MAX], each[LL_ODE_ROWS * LL_ODE_DIM_MAX];
        ll_ode_measure measure;
        memset(&measure, 0x5a, sizeof measure);
        for (int i = 0; i < LL_ODE_ROWS * dim; i++)
            each[i] = 1e9;
        m.problem->start(m.params, y);
        ll_ode_measure_start(&measure, each, m.problem, &m.ode, y);
        for (int row = 0; row < LL_ODE_ROWS; row++)
            for (int i = 0; i < dim; i++)
                assert_true(each[row * dim + i] == (row == LL_ODE_SIZE ? fabs(y[i]) : 0));
        ll_ode_measure_at(&measure, each, &m.ode, 1, 1, y, y, true);
        assert_true(measure.error == 0 && measure.error_max == 0 && measure.drift_max == 0);
        assert_true(ll_ode_measure_rms(&measure) == 0);
    }
}

/* ---- integration ---- */

static double *run_to(const made *m, const char *method, double t, double tolerance)
{
    static double y[LL_ODE_DIM_MAX];
    const ll_ode_method *how = ll_ode_method_find(method);
    assert_non_null(how);
    ll_ode_run *run = malloc(ll_ode_run_size(how, &m->ode));
    m->problem->start(m->params, y);
    ll_ode_control control = {.t_end = t, .tolerance = tolerance};
    ll_status status = ll_ode_start(run, how, &m->ode, &control, y);
    assert_false(ll_failed(&status));
    assert_int_equal(ll_ode_advance(run, how, &m->ode, t), LL_ODE_FINISHED);
    memcpy(y, ll_ode_y(run), (size_t)m->ode.dim * sizeof *y);
    free(run);
    return y;
}

/* Those of which a general explicit method is capable. The stiff ones are for tests of stiff methods. */
static void integration_leads_to_the_solution(void **state)
{
    (void)state;
    for (int n = 0; ll_ode_problems[n]; n++) {
        const ll_ode_problem *p = ll_ode_problems[n];
        if (p->stiff || strcmp(p->name, "coulomb_naive") == 0)
            continue;
        made m = make(p->name, NULL);
        settled(&m);
        double want[LL_ODE_DIM_MAX], scale = 1, worst = 0;
        if (p->reference)
            memcpy(want, p->reference, (size_t)m.ode.dim * sizeof *want);
        else
            assert_true(p->exact(m.params, p->duration, want));
        const double *got = run_to(&m, "dopri5", p->duration, 1e-13);
        for (int i = 0; i < m.ode.dim; i++) {
            worst = larger(worst, fabs(got[i] - want[i]));
            scale = larger(scale, fabs(want[i]));
        }
        /* An error in a force or a start would show in the first digits; how exact methods are is tested with
         * them. */
        if (!(worst <= 1e-6 * scale))
            fail_msg("%s: off by %g", p->name, worst);
    }
}

static void energies_stay(void **state)
{
    (void)state;
    int tried = 0;
    for (int n = 0; ll_ode_problems[n]; n++) {
        const ll_ode_problem *p = ll_ode_problems[n];
        if (!p->energy || p->stiff)
            continue;
        double start[LL_ODE_DIM_MAX];
        made m = make(p->name, NULL);
        settled(&m);
        p->start(m.params, start);
        double before = p->energy(m.params, 0, start);
        double after = p->energy(m.params, p->duration / 3, run_to(&m, "dopri5", p->duration / 3, 1e-12));
        if (!(fabs(after - before) <= 1e-8 * larger(1, fabs(before))))
            fail_msg("%s: energy from %g to %g", p->name, before, after);
        tried++;
    }
    assert_int_equal(tried, 14);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_are_sound),
        cmocka_unit_test(formulas_solve_their_systems),
        cmocka_unit_test(formulas_give_the_published_values),
        cmocka_unit_test(the_ball_bounces_at_its_times),
        cmocka_unit_test(jacobians_are_of_the_system),
        cmocka_unit_test(systems_depend_on_what_they_say),
        cmocka_unit_test(a_measure_starts_from_nothing),
        cmocka_unit_test(integration_leads_to_the_solution),
        cmocka_unit_test(energies_stay),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
