/* A system's own loops give the bits of the general ones; extrapolation leads to the published solutions. */
#include <math.h>

#include "ode/core/problem.h"
#include "ode/harness.h"
#include "support/near.h"

typedef struct made {
    const ll_ode_problem *problem;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_ode ode;
    double y0[LL_ODE_DIM_MAX];
} made;

static void make(made *m, const ll_ode_problem *problem)
{
    m->problem = problem;
    ll_param_defaults(problem->params, m->params);
    if (problem->prepare != NULL)
        problem->prepare(m->params);
    problem->system(m->params, &m->ode);
    problem->start(m->params, m->y0);
}

static setting solved(const made *m, const char *method, double tolerance)
{
    ll_ode_control control = {.t_end = m->problem->duration, .tolerance = tolerance};
    setting s = begin(method, &m->ode, m->y0, &control);
    while (step(&s) == LL_ODE_RUNNING)
        ;
    assert_int_equal(s.run->state, LL_ODE_FINISHED);
    return s;
}

static void own_loops_have_the_bits_of_the_general_ones(void **state)
{
    (void)state;
    static const char *const methods[] = {"extrapolated_midpoint", "extrapolated_leapfrog", "dop853",
                                          "dopri5", "tsit5"};
    int compared = 0;
    for (int p = 0; ll_ode_problems[p] != NULL; p++)
        for (size_t i = 0; i < sizeof methods / sizeof methods[0]; i++) {
            made m;
            make(&m, ll_ode_problems[p]);
            ll_status fits = ll_ode_method_fits(ll_ode_method_find(methods[i]), &m.ode);
            if (m.ode.kernels == NULL || ll_failed(&fits))
                continue;
            setting own = solved(&m, methods[i], 1e-6);
            m.ode.kernels = NULL;
            setting general = solved(&m, methods[i], 1e-6);
            assert_int_equal(own.run->counters.steps, general.run->counters.steps);
            assert_int_equal(own.run->counters.evaluations, general.run->counters.evaluations);
            if (memcmp(ll_ode_y(own.run), ll_ode_y(general.run), (size_t)m.ode.dim * sizeof(double)) != 0)
                fail_msg("%s of %s", methods[i], m.problem->name);
            end(&own);
            end(&general);
            compared++;
        }
    assert_in_range(compared, 70, 200);
}

static void reaches(const char *problem, const char *method, double wanted)
{
    made m;
    make(&m, ll_ode_problem_find(problem));
    setting s = solved(&m, method, 1e-14);
    double reference[LL_ODE_DIM_MAX], most = 0, size = 0;
    if (m.problem->exact == NULL || !m.problem->exact(m.params, m.problem->duration, reference))
        memcpy(reference, m.problem->reference, (size_t)m.ode.dim * sizeof(double));
    for (int i = 0; i < m.ode.dim; i++) {
        most = larger(most, fabs(ll_ode_y(s.run)[i] - reference[i]));
        size = larger(size, fabs(reference[i]));
    }
    if (!(most / size <= wanted))
        fail_msg("%s by %s: error %.3g, wanted %.3g", problem, method, most / size, wanted);
    end(&s);
}

static void both_reach_the_published_solutions(void **state)
{
    (void)state;
    static const char *const positions[] = {"kepler",   "henon_heiles", "pendulum", "elastic_pendulum",
                                            "pleiades", "figure_eight", "forced",   "spring_chain"};
    static const char *const others[] = {"double_pendulum", "tennis_racket", "euler_top",    "brusselator",
                                         "lotka_volterra",  "damped",        "drag_vertical"};
    for (size_t i = 0; i < sizeof positions / sizeof positions[0]; i++) {
        reaches(positions[i], "extrapolated_leapfrog", 1e-10);
        reaches(positions[i], "extrapolated_midpoint", 1e-10);
    }
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        reaches(others[i], "extrapolated_midpoint", 1e-10);
    /* Forces that are magnetic, of the frame or of a field. Arenstorf's floor is 1.4e-11, and rounding is
     * amplified as much as that of the start. */
    reaches("lorentz", "extrapolated_leapfrog", 1e-12);
    reaches("arenstorf", "extrapolated_leapfrog", 1e-9);
    reaches("arenstorf", "extrapolated_midpoint", 1e-9);
}

/* A charge in a field along (1, 2, 2) / 3 of strength 1.5: a helix, with a closed form. */
static void helix_a(const void *params, double t, const double *q, const double *v, double *a)
{
    (void)params, (void)t, (void)q;
    static const double b[3] = {0.5, 1, 1};
    for (int i = 0; i < 3; i++)
        a[i] = v[(i + 1) % 3] * b[(i + 2) % 3] - v[(i + 2) % 3] * b[(i + 1) % 3];
}

static void helix_parts(const void *params, double t, const double *q, double *e, double *b)
{
    (void)params, (void)t, (void)q;
    e[0] = e[1] = e[2] = 0;
    b[0] = 0.5;
    b[1] = b[2] = 1;
}

static void a_helix_in_space(void **state)
{
    (void)state;
    static const ll_ode helix = {.dim = 6,
                                 .acceleration = helix_a,
                                 .magnetic = helix_parts,
                                 .velocity_dependent = true,
                                 .autonomous = true};
    static const double y0[6] = {0, 0, 0, 1, 0.5, -2}, axis[3] = {1. / 3, 2. / 3, 2. / 3};
    double T = 10, w = 1.5, along = 0, y[6];
    for (int i = 0; i < 3; i++)
        along += y0[3 + i] * axis[i];
    solve("extrapolated_leapfrog", &helix, y0, T, 0, 1e-13, y);
    double boris[6];
    solve("boris", &helix, y0, T, 100000, 0, boris);
    for (int i = 0; i < 3; i++) {
        /* v turns about the axis: v = along axis + (v0 - along axis) cos wt + (v0 x axis) sin wt. */
        double cross = y0[3 + (i + 1) % 3] * axis[(i + 2) % 3] - y0[3 + (i + 2) % 3] * axis[(i + 1) % 3];
        double across = y0[3 + i] - along * axis[i];
        double v = along * axis[i] + across * cos(w * T) + cross * sin(w * T);
        double q = along * axis[i] * T + (across * sin(w * T) + cross * (1 - cos(w * T))) / w;
        assert_near(y[3 + i], v, 1e-11);
        assert_near(y[i], q, 1e-11);
        assert_near(boris[3 + i], v, 1e-7);
        assert_near(boris[i], q, 1e-7);
    }
}

/* Between the steps the answer is a shorter step's: as good as the ends. */
static void dense_output_is_as_good_as_the_steps(void **state)
{
    (void)state;
    made m;
    make(&m, ll_ode_problem_find("kepler"));
    static const char *const methods[] = {"extrapolated_midpoint", "extrapolated_leapfrog"};
    for (int i = 0; i < 2; i++) {
        ll_ode_control control = {.t_end = 10, .tolerance = 1e-12};
        setting s = begin(methods[i], &m.ode, m.y0, &control);
        int64_t evaluations = 0;
        for (int k = 1; k <= 1000; k++) {
            double t = 10. * k / 1000, y[4], exact[4];
            ll_ode_advance(s.run, s.method, s.ode, t);
            evaluations = s.run->counters.evaluations;
            ll_ode_sample(s.run, s.method, s.ode, t, y);
            assert_int_equal(s.run->counters.evaluations, evaluations);
            m.problem->exact(m.params, t, exact);
            for (int j = 0; j < 4; j++)
                assert_near(y[j], exact[j], 1e-9);
        }
        end(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_loops_have_the_bits_of_the_general_ones),
        cmocka_unit_test(both_reach_the_published_solutions),
        cmocka_unit_test(a_helix_in_space),
        cmocka_unit_test(dense_output_is_as_good_as_the_steps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
