/* Work-precision series of integrators with errors known in closed form. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "experiment/advise/work_precision_run.h"
#include "sim/motion/motion_lab.h"
#include "support/near.h"

/* A clock that advances by a millisecond at each read. */
static int64_t ticks;

static int64_t counting_clock(void)
{
    return ++ticks * 1000000;
}

static ll_work_precision_request order_of(const char *name, void *params)
{
    const ll_ode_problem *p = ll_ode_problem_find(name);
    assert_non_null(p);
    ll_param_defaults(p->params, params);
    return (ll_work_precision_request){.problem = p, .params = params, .now_ns = counting_clock};
}

/* Euler's position error in free fall is a t dt / 2: 15 dt at 3 s. */
static void eulers_error_is_known(void **state)
{
    (void)state;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision refinement_levels[LL_WORK_PRECISION_LEVELS_MAX];
    int count;
    ll_work_precision_request order = order_of("free_fall", params);
    ll_status status =
        ll_work_precision_series(&order, ll_ode_method_find("explicit_euler"), refinement_levels, &count);
    assert_false(ll_failed(&status));
    assert_true(count >= 15);
    for (int k = 0; k < count; k++) {
        double dt = 3.0 / 16 / (1 << k);
        assert_true(refinement_levels[k].setting == dt && refinement_levels[k].status == LL_RUN_OK);
        assert_int_equal(refinement_levels[k].counters.steps, 16 << k);
        assert_near(refinement_levels[k].e_final, 15 * dt, 1e-9);
        assert_near(refinement_levels[k].e_max, 15 * dt, 1e-9);
        assert_true(k == 0 ? refinement_levels[k].order != refinement_levels[k].order
                           : fabs(refinement_levels[k].order - 1) < 1e-4);
        assert_near(refinement_levels[k].cpu_min_s, 0.001, 1e-12);
        assert_near(refinement_levels[k].cpu_median_s, 0.001, 1e-12);
        assert_true(refinement_levels[k].drift_max > 0); /* it lags: v is exact, s is not */
    }
}

static void tolerances_go_down_by_tens(void **state)
{
    (void)state;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision refinement_levels[LL_WORK_PRECISION_LEVELS_MAX];
    int count;
    ll_work_precision_request order = order_of("kepler", params);
    ll_status status =
        ll_work_precision_series(&order, ll_ode_method_find("dop853"), refinement_levels, &count);
    assert_false(ll_failed(&status));
    assert_int_equal(count, 13);
    for (int k = 0; k < count; k++)
        assert_near(refinement_levels[k].setting / pow(10, -2 - k), 1, 1e-12);
    assert_true(refinement_levels[8].e_max < 1e-7 && refinement_levels[12].e_max < 1e-11 &&
                refinement_levels[0].e_max > 1e-4);
    assert_true(refinement_levels[12].counters.evaluations > 3 * refinement_levels[0].counters.evaluations);
}

static void divergence_and_unsupported_methods_are_reported(void **state)
{
    (void)state;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision r;
    ll_work_precision_request order = order_of("stiff_pendulum", params);
    ll_status status = ll_work_precision_level(&order, ll_ode_method_find("rk4"), 1.0 / 60, &r);
    assert_false(ll_failed(&status));
    assert_int_equal(r.status, LL_RUN_DIVERGED);
    assert_true(r.reason == LL_ODE_NOT_FINITE || r.reason == LL_ODE_BLEW_UP);
    assert_true(isnan(r.e_max) && isnan(r.e_final) && isnan(r.e_l2) && isnan(r.drift_max) &&
                r.counters.steps > 0);
    status = ll_work_precision_level(&order, ll_ode_method_find("boris"), 0.01, &r);
    assert_int_equal(status.code, LL_BAD_INPUT);
    status = ll_work_precision_level(&order, ll_ode_method_find("rk4"), 0, &r);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "dt");
}

/* Above the stability limit a method grows without bound, but its final values may be finite. The limit of
 * velocity Verlet is omega dt = 2. */
static void finite_blow_ups_have_no_error_and_no_order(void **state)
{
    (void)state;
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision refinement_levels[LL_WORK_PRECISION_LEVELS_MAX];
    int count, failed = 0;
    ll_work_precision_request order = order_of("oscillator", params);
    ll_status status = ll_param_set(order.problem->params, params, "omega", "6", false);
    assert_false(ll_failed(&status));
    order.duration = 40;
    status =
        ll_work_precision_series(&order, ll_ode_method_find("velocity_verlet"), refinement_levels, &count);
    assert_false(ll_failed(&status));
    for (int k = 0; k < count; k++) {
        bool stable = 6 * refinement_levels[k].setting < 2;
        assert_int_equal(refinement_levels[k].status, stable ? LL_RUN_OK : LL_RUN_DIVERGED);
        assert_true(stable == isfinite(refinement_levels[k].e_max) &&
                    stable == isfinite(refinement_levels[k].drift_per_s));
        bool small = k > 0 && refinement_levels[k - 1].e_max < refinement_levels[k].size / 10 &&
                     refinement_levels[k].e_max < refinement_levels[k].size / 10;
        assert_true(isfinite(refinement_levels[k].order) == small);
        failed += !stable;
    }
    assert_int_equal(failed, 3); /* 2.5, 1.25 and 0.625 s */
}

static ll_work_precision refinement_level_of(const char *problem, double duration, const char *method,
                                             double setting)
{
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision r;
    ll_work_precision_request order = order_of(problem, params);
    if (order.problem->prepare)
        order.problem->prepare(params);
    order.duration = duration;
    ll_status status = ll_work_precision_level(&order, ll_ode_method_find(method), setting, &r);
    assert_false(ll_failed(&status));
    return r;
}

/* Two runs of a double pendulum diverge by a factor of e in about a second: after half a minute 14 digits are
 * lost, and later times cannot be measured. With an exact solution there is no such limit. */
static void chaos_is_predictable_for_a_while(void **state)
{
    (void)state;
    ll_work_precision r = refinement_level_of("double_pendulum", 40, "dop853", 1e-13);
    assert_int_equal(r.status, LL_RUN_OK);
    assert_true(r.predictable_s > 10 && r.predictable_s < 35);
    assert_true(isnan(r.e_final) && r.uncertainty > 1e-9 && r.uncertainty < 0.1);
    r = refinement_level_of("double_pendulum", 4, "rk4", 0.01);
    assert_true(isnan(r.predictable_s) && r.e_max > 1e-6 && r.uncertainty < 1e-9 && r.uncertainty > 0);
    r = refinement_level_of("oscillator", 40, "rk4", 0.1);
    assert_true(isnan(r.predictable_s) && r.uncertainty == 0 && r.e_final > 0);
}

/* Errors of methods as accurate as the references are unknown. */
static void errors_below_the_uncertainty_are_not_known(void **state)
{
    (void)state;
    int unknown = 0;
    for (double tolerance = 1e-9; tolerance > 5e-15; tolerance /= 10) {
        ll_work_precision r = refinement_level_of("pleiades", 2.5, "dop853", tolerance);
        assert_true(r.uncertainty > 1e-15 && (isnan(r.e_max) || r.e_max > r.uncertainty));
        unknown += isnan(r.e_max);
    }
    assert_true(unknown >= 1 && unknown <= 4);
}

/* At levels with the smallest steps rounding dominates: no order is reported there, though the solution is
 * known, and reported orders are the method's. */
static void orders_are_reported_above_rounding(void **state)
{
    (void)state;
    static const char *const methods[] = {"rk4", "yoshida6", "yoshida8", "ab4", "implicit_midpoint"};
    for (int k = 0; k < 5; k++) {
        _Alignas(8) char params[LL_ODE_PARAMS_MAX];
        ll_work_precision refinement_levels[LL_WORK_PRECISION_LEVELS_MAX];
        int count, told = 0;
        ll_work_precision_request order = order_of("oscillator", params);
        order.duration = 7;
        const ll_ode_method *method = ll_ode_method_find(methods[k]);
        ll_status status = ll_work_precision_series(&order, method, refinement_levels, &count);
        assert_false(ll_failed(&status));
        for (int n = 0; n < count; n++) {
            if (isnan(refinement_levels[n].order))
                continue;
            told++;
            if (!(refinement_levels[n].e_max >= 1e-3) &&
                !(fabs(refinement_levels[n].order - method->order) < 0.5))
                fail_msg("%s: order %g at an error of %g", methods[k], refinement_levels[n].order,
                         refinement_levels[n].e_max);
        }
        assert_true(told >= 2);
    }
}

/* Both ways of measuring a method agree: the same numbers for the same run. */
static void a_refinement_level_equals_a_motions_metrics(void **state)
{
    (void)state;
    static const struct {
        const char *problem, *method, *setting;
        double value, duration;
    } cases[] = {{"kepler", "dopri5", "tolerance", 1e-7, 9},
                 {"robertson", "radau5", "tolerance", 1e-6, 11},
                 {"double_pendulum", "rk4", "dt_s", 0.005, 6},
                 {"bouncing_ball", "dop853", "tolerance", 1e-8, 1.5},
                 {"hires", "trapezoid", "dt_s", 0.25, 50}};
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        char text[512];
        ll_work_precision r =
            refinement_level_of(cases[k].problem, cases[k].duration, cases[k].method, cases[k].value);
        snprintf(text, sizeof text,
                 "\"problem\":\"%s\",\"duration_s\":%.17g,\"methods\":[{\"method\":\"%s\",\"%s\":%.17g}]",
                 cases[k].problem, cases[k].duration, cases[k].method, cases[k].setting, cases[k].value);
        cJSON *metrics = lab_run(text);
        const cJSON *m = lab_method(metrics, 0);
        const struct {
            const char *name;
            double value;
        } same[] = {{"e_final", r.e_final},
                    {"e_max", r.e_max},
                    {"e_l2", r.e_l2},
                    {"e_final_weighted", r.e_final_weighted},
                    {"e_max_weighted", r.e_max_weighted},
                    {"e_l2_weighted", r.e_l2_weighted}};
        assert_true(isfinite(r.e_max) && r.status == LL_RUN_OK);
        for (size_t n = 0; n < sizeof same / sizeof same[0]; n++) {
            double told = lab_number(m, same[n].name);
            if (!(fabs(told - same[n].value) <= 1e-4 * fabs(told) + 1e-13))
                fail_msg("%s: %s is %.12g of a motion, %.12g of a level", cases[k].problem, same[n].name,
                         told, same[n].value);
        }
        cJSON_Delete(metrics);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eulers_error_is_known),
        cmocka_unit_test(tolerances_go_down_by_tens),
        cmocka_unit_test(divergence_and_unsupported_methods_are_reported),
        cmocka_unit_test(finite_blow_ups_have_no_error_and_no_order),
        cmocka_unit_test(chaos_is_predictable_for_a_while),
        cmocka_unit_test(errors_below_the_uncertainty_are_not_known),
        cmocka_unit_test(orders_are_reported_above_rounding),
        cmocka_unit_test(a_refinement_level_equals_a_motions_metrics),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
