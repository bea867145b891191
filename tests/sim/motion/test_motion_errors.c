/* Meaning of the errors: they are of every step, for any ticks; small components count in the weighted ones;
 * and where a solution starts without energy, its drift still has a scale. */
#include "motion_lab.h"
#include "ode/core/problem.h"
#include "ode/core/run.h"
#include "support/near.h"

/* ---- ticks do not change the errors ---- */

static bool same(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

static void measures_do_not_depend_on_ticks(void **state)
{
    (void)state;
    static const char *const motions[] = {
        "\"problem\":\"kepler\",\"params\":{\"e\":0.97},\"duration_s\":11,\"methods\":[{\"method\":"
        "\"dopri5\","
        "\"tolerance\":1e-7},{\"method\":\"yoshida6\",\"dt_s\":0.0007},{\"method\":\"rk4\",\"dt_s\":0.004}]",
        "\"problem\":\"double_pendulum\",\"duration_s\":27,\"methods\":[{\"method\":\"rk4\",\"dt_s\":0.013},"
        "{\"method\":\"tsit5\",\"tolerance\":1e-9},{\"method\":\"implicit_midpoint\",\"dt_s\":0.2}]",
        "\"problem\":\"henon_heiles\",\"reverse\":true,\"duration_s\":50,\"methods\":[{\"method\":\"rk4\","
        "\"dt_s\":0.21},{\"method\":\"radau5\",\"tolerance\":1e-7},{\"method\":\"leapfrog_kdk\",\"dt_s\":0.1}"
        "]",
        "\"problem\":\"bouncing_ball\",\"params\":{\"e\":0.7},\"duration_s\":2.2,\"methods\":[{\"method\":"
        "\"explicit_euler\",\"dt_s\":0.003},{\"method\":\"dop853\",\"tolerance\":1e-9},{\"method\":\"rk2\","
        "\"dt_s\":0.05}]",
        "\"problem\":\"oscillator\",\"duration_s\":9,\"methods\":[{\"method\":\"ab2\",\"steps\":\"frame\"},"
        "{\"method\":\"rk4\",\"precision\":\"float\",\"dt_s\":0.1},{\"method\":\"rk2\",\"dt_s\":0.1,"
        "\"clock\":"
        "\"float\"}]"};
    static const char *const names[] = {"e_final",
                                        "e_max",
                                        "e_l2",
                                        "e_max_weighted",
                                        "e_l2_weighted",
                                        "e_final_weighted",
                                        "diverged_t_s",
                                        "energy_drift_max",
                                        "energy_drift_per_s"};
    static const char *const rates[] = {"1", "17", "640"};
    for (size_t k = 0; k < sizeof motions / sizeof motions[0]; k++) {
        cJSON *first = NULL;
        for (int rate = 0; rate < 3; rate++) {
            char text[1024];
            snprintf(text, sizeof text, "\"tick_hz\":%s,%s", rates[rate], motions[k]);
            cJSON *metrics = lab_run(text);
            first = first ? first : metrics;
            for (int i = 0; i < 3; i++)
                for (size_t n = 0; n < sizeof names / sizeof names[0]; n++) {
                    double a = lab_number(lab_method(first, i), names[n]);
                    double b = lab_number(lab_method(metrics, i), names[n]);
                    if (!same(a, b))
                        fail_msg("motion %zu, method %d: %s is %.17g at 1 Hz, %.17g at %s Hz", k, i, names[n],
                                 a, b, rates[rate]);
                }
            assert_true(same(lab_number(first, "solution_uncertainty_max"),
                             lab_number(metrics, "solution_uncertainty_max")));
            assert_true(
                same(lab_number(first, "predictable_until_s"), lab_number(metrics, "predictable_until_s")));
            if (metrics != first)
                cJSON_Delete(metrics);
        }
        cJSON_Delete(first);
    }
}

/* ---- a second implementation ---- */

typedef struct naive {
    double at_ends, at_four, at_forty; /* the largest error */
} naive;

/* dopri5's own steps and dense output against Kepler's equation, without the kind motion. */
static naive by_hand(const char *e, double duration, double tolerance)
{
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    const ll_ode_problem *p = ll_ode_problem_find("kepler");
    const ll_ode_method *method = ll_ode_method_find("dopri5");
    ll_ode ode;
    double y[4], want[4];
    naive found = {0, 0, 0};
    ll_param_defaults(p->params, params);
    ll_status status = ll_param_set(p->params, params, "e", e, false);
    assert_false(ll_failed(&status));
    if (p->prepare)
        p->prepare(params);
    p->system(params, &ode);
    p->start(params, y);
    ll_ode_run *run = malloc(ll_ode_run_size(method, &ode));
    ll_ode_control control = {.t_end = duration, .tolerance = tolerance};
    status = ll_ode_start(run, method, &ode, &control, y);
    assert_false(ll_failed(&status));
    while (run->state == LL_ODE_RUNNING) {
        ll_ode_step(run, method, &ode);
        for (int k = 1; k <= 40; k++) {
            double t = k == 40 ? run->t : run->t_last + (run->t - run->t_last) * k / 40, sum = 0;
            ll_ode_sample(run, method, &ode, t, y);
            assert_true(p->exact(params, t, want));
            for (int i = 0; i < 4; i++)
                sum += (y[i] - want[i]) * (y[i] - want[i]);
            found.at_forty = larger(found.at_forty, sqrt(sum));
            if (k % 10 == 0)
                found.at_four = larger(found.at_four, sqrt(sum));
            if (k == 40)
                found.at_ends = larger(found.at_ends, sqrt(sum));
        }
    }
    free(run);
    return found;
}

static void the_largest_error_is_of_every_step(void **state)
{
    (void)state;
    static const char *const eccentric[] = {"0.2", "0.75", "0.95", "0.993"};
    for (int k = 0; k < 4; k++) {
        char text[512];
        naive want = by_hand(eccentric[k], 13, 3e-8);
        snprintf(text, sizeof text,
                 "\"problem\":\"kepler\",\"params\":{\"e\":%s},\"duration_s\":13,\"tick_hz\":2,\"methods\":[{"
                 "\"method\":\"dopri5\",\"tolerance\":3e-8}]",
                 eccentric[k]);
        cJSON *metrics = lab_run(text);
        double got = lab_number(lab_method(metrics, 0), "e_max");
        if (!(fabs(got / want.at_four - 1) < 1e-9))
            fail_msg("e %s: %.12g, by hand %.12g", eccentric[k], got, want.at_four);
        assert_true(got >= want.at_ends &&
                    got > 0.8 * want.at_forty); /* little is missed between the times */
        cJSON_Delete(metrics);
    }
}

/* ---- weighted errors ---- */

/* Free fall by Euler: the position is off by a t dt / 2, of a t^2 / 2 in all; the velocity is right. */
static void weighted_errors_are_those_of_the_closed_form(void **state)
{
    (void)state;
    cJSON *metrics =
        lab_run("\"problem\":\"free_fall\",\"duration_s\":4,\"methods\":[{\"method\":"
                "\"explicit_euler\",\"dt_s\":0.04},{\"method\":\"semi_implicit_euler\",\"dt_s\":0.1}]");
    for (int i = 0; i < 2; i++) {
        const cJSON *m = lab_method(metrics, i);
        double dt = i ? 0.1 : 0.04, squares = 0;
        for (int k = 1; k * dt < 4 + dt / 2; k++)
            squares += pow(k * dt * dt / 16, 2) * dt / 4;
        assert_near(lab_number(m, "e_max_weighted"), dt / 4, 1e-12);
        assert_near(lab_number(m, "e_final_weighted"), dt / 4, 1e-12);
        assert_near(lab_number(m, "e_l2_weighted"), sqrt(squares), 1e-12);
        assert_near(lab_number(m, "e_max"), 20 * dt, 1e-10);
        /* It starts without energy: its gain is relative to m v^2 / 2 at the end. */
        assert_near(lab_number(m, "energy_drift_max"), dt / 4, 1e-12);
        assert_near(lab_number(m, "energy_drift_final"), (i ? -1 : 1) * dt / 4, 1e-12);
    }
    cJSON_Delete(metrics);
}

/* Robertson's second substance has a concentration of about 1e-5: a method that gives none of it, or twice as
 * much, for a second has small Euclidean errors. */
static void small_components_count(void **state)
{
    (void)state;
    cJSON *metrics =
        lab_run("\"problem\":\"robertson\",\"duration_s\":30,\"methods\":[{\"method\":"
                "\"implicit_midpoint\",\"dt_s\":0.05},{\"method\":\"radau5\",\"tolerance\":1e-7}]");
    const cJSON *rings = lab_method(metrics, 0), *good = lab_method(metrics, 1);
    assert_true(lab_number(rings, "e_max") < 1e-4 && lab_number(rings, "e_max_weighted") > 0.5);
    assert_true(lab_number(rings, "e_l2_weighted") > 0.05 && lab_number(rings, "e_final_weighted") < 0.01);
    assert_true(lab_number(good, "e_max") < 1e-5 && lab_number(good, "e_max_weighted") < 0.05);
    cJSON_Delete(metrics);
}

/* ---- beyond the end ---- */

/* A fixed step may pass the duration; the solution there is that of a run which ends there. */
static void the_solution_continues_with_the_last_step(void **state)
{
    (void)state;
    cJSON *metrics =
        lab_run("\"problem\":\"henon_heiles\",\"duration_s\":7,\"methods\":[{\"method\":"
                "\"velocity_verlet\",\"dt_s\":0.9},{\"method\":\"implicit_midpoint\",\"dt_s\":4}]");
    cJSON *longer[2] = {lab_run("\"problem\":\"henon_heiles\",\"duration_s\":7.2,\"methods\":[{\"method\":"
                                "\"dop853\",\"tolerance\":1e-13}]"),
                        lab_run("\"problem\":\"henon_heiles\",\"duration_s\":8,\"methods\":[{\"method\":"
                                "\"dop853\",\"tolerance\":1e-13}]")};
    for (int i = 0; i < 2; i++) {
        assert_near(lab_number(lab_method(metrics, i), "t_s"), (i ? 8 : 7.2), 1e-12);
        for (int k = 0; k < 4; k++)
            assert_near(lab_state(lab_method(metrics, i), "solution", k),
                        lab_state(lab_method(longer[i], 0), "state", k), 1e-10);
        cJSON_Delete(longer[i]);
    }
    cJSON_Delete(metrics);
}

/* ---- nulls ---- */

static const char *notice(const cJSON *metrics, int i)
{
    const cJSON *item = cJSON_GetArrayItem(cJSON_GetObjectItem(metrics, "notices"), i);
    return item ? item->valuestring : "";
}

static void notices_name_unknown_errors(void **state)
{
    (void)state;
    cJSON *m = lab_run(
        "\"problem\":\"double_pendulum\",\"duration_s\":33,\"methods\":[{\"method\":\"rk4\",\"dt_s\":0.02}]");
    assert_true(isnan(lab_number(lab_method(m, 0), "e_final")));
    assert_non_null(strstr(notice(m, 0), "known until predictable_until_s, 2"));
    assert_string_equal(notice(m, 1), "");
    cJSON_Delete(m);
    m = lab_run("\"problem\":\"henon_heiles\",\"duration_s\":3,\"methods\":[{\"method\":\"rk4\",\"dt_s\":0.1}"
                ",{\"method\":"
                "\"dop853\",\"tolerance\":1e-15}]");
    bool known = !isnan(lab_number(lab_method(m, 1), "e_max"));
    assert_false(isnan(lab_number(lab_method(m, 0), "e_max")));
    assert_false(known);
    assert_non_null(
        strstr(notice(m, 0), "methods.1, dop853, is nearer to the solution than its uncertainty"));
    assert_string_equal(notice(m, 1), "");
    cJSON_Delete(m);
    m = lab_run(
        "\"problem\":\"oscillator\",\"duration_s\":3,\"methods\":[{\"method\":\"rk4\",\"dt_s\":0.1}]");
    assert_string_equal(notice(m, 0), "");
    cJSON_Delete(m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measures_do_not_depend_on_ticks),
        cmocka_unit_test(the_largest_error_is_of_every_step),
        cmocka_unit_test(weighted_errors_are_those_of_the_closed_form),
        cmocka_unit_test(small_components_count),
        cmocka_unit_test(the_solution_continues_with_the_last_step),
        cmocka_unit_test(notices_name_unknown_errors),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
