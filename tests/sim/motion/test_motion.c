/* Kind motion: the paper's figures, errors against closed forms, and changes that take effect from the
 * start. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"
#include "support/near.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static ll_session *open_text(const char *text)
{
    cJSON *json = cJSON_Parse(text);
    ll_session *s;
    assert_non_null(json);
    must(ll_session_create(json, -1, NULL, NULL, &s));
    cJSON_Delete(json);
    return s;
}

static ll_session *open_id(const char *id)
{
    cJSON *json;
    ll_session *s;
    must(ll_scenario_load("scenarios", id, &json));
    must(ll_session_create(json, -1, NULL, NULL, &s));
    cJSON_Delete(json);
    return s;
}

static void run_to_end(ll_session *s)
{
    must(ll_session_run_to(s, ll_session_get_info(s).end_tick));
}

static double number(const cJSON *o, const char *name)
{
    const cJSON *item = cJSON_GetObjectItem(o, name);
    return item && !cJSON_IsNull(item) ? item->valuedouble : NAN;
}

/* The metrics of method `i`; the caller deletes `*report`. */
static const cJSON *metrics_of(ll_session *s, int i, cJSON **report)
{
    *report = ll_session_metrics(s);
    return cJSON_GetArrayItem(cJSON_GetObjectItem(cJSON_GetObjectItem(*report, "metrics"), "methods"), i);
}

static double metric(ll_session *s, int i, const char *name)
{
    cJSON *report;
    double value = number(metrics_of(s, i, &report), name);
    cJSON_Delete(report);
    return value;
}

static double component(ll_session *s, int i, int k)
{
    cJSON *report;
    double value =
        cJSON_GetArrayItem(cJSON_GetObjectItem(metrics_of(s, i, &report), "state"), k)->valuedouble;
    cJSON_Delete(report);
    return value;
}

/* Figure 4 at t = 3 s, and at 3.003 s for the last: a t^2 / 2 +- a t dt / 2. */
static void figure_4_is_the_table(void **state)
{
    (void)state;
    static const double want[] = {52.5, 49.5, 46.5, 45.585541, 37.5, 40.5, 43.5, 44.5945};
    ll_session *s = open_id("paper/fig04");
    run_to_end(s);
    for (int i = 0; i < 8; i++)
        assert_near(component(s, i, 0), want[i], (i % 4 == 3 ? 5.1e-5 : 1e-12));
    assert_near(metric(s, 3, "t_s"), 3.003, 1e-12);
    ll_session_destroy(s);
}

/* The error of both Eulers on free fall is a t dt / 2, in the position alone. */
static void errors_are_those_of_the_closed_form(void **state)
{
    (void)state;
    ll_session *s = open_text(
        "{\"kind\":\"motion\",\"problem\":\"free_fall\",\"duration_s\":3,\"tick_hz\":100,\"methods\":["
        "{\"method\":\"explicit_euler\",\"dt_s\":0.01},{\"method\":\"semi_implicit_euler\",\"dt_s\":0.02}]}");
    run_to_end(s);
    assert_near(metric(s, 0, "e_final"), 0.15, 1e-11);
    assert_near(metric(s, 0, "e_max"), 0.15, 1e-11);
    assert_near(metric(s, 1, "e_final"), 0.3, 1e-11);
    /* root mean square of 0.05 t over t = 0.01 ... 3 */
    double squares = 0;
    for (int k = 1; k <= 300; k++)
        squares += pow(0.05 * k / 100, 2);
    assert_near(metric(s, 0, "e_l2"), sqrt(squares / 300), 1e-11);
    assert_true(metric(s, 0, "steps") == 300 && metric(s, 0, "evaluations") == 300);
    assert_true(metric(s, 1, "steps") == 150);
    ll_session_destroy(s);
}

/* Where there is no formula the reference run must reach the published value. */
static void references_by_integration_are_published(void **state)
{
    (void)state;
    ll_session *s = open_text("{\"kind\":\"motion\",\"problem\":\"pleiades\",\"duration_s\":3,\"methods\":["
                              "{\"method\":\"dopri5\",\"tolerance\":1e-9}]}");
    run_to_end(s);
    cJSON *report;
    const cJSON *m = metrics_of(s, 0, &report), *solution = cJSON_GetObjectItem(m, "solution");
    assert_near(cJSON_GetArrayItem(solution, 0)->valuedouble, 0.370613914397051290, 1e-10);
    assert_near(cJSON_GetArrayItem(solution, 7)->valuedouble, -3.94343758551739206, 1e-10);
    assert_true(number(m, "e_final") > 1e-9 && number(m, "e_final") < 1e-3);
    cJSON_Delete(report);
    ll_session_destroy(s);
}

/* A duration that is no multiple of a tick: an adaptive method ends there exactly. */
static void runs_end_at_their_duration(void **state)
{
    (void)state;
    ll_session *s = open_text(
        "{\"kind\":\"motion\",\"problem\":\"arenstorf\",\"duration_s\":17.0652165601579625,\"methods\":["
        "{\"method\":\"dop853\",\"tolerance\":1e-12},{\"method\":\"velocity_verlet_predicted\",\"dt_s\":0.01}"
        "]}");
    run_to_end(s);
    assert_true(metric(s, 0, "t_s") == 17.0652165601579625);
    assert_near(component(s, 0, 0), 0.994, 1e-6);
    assert_near(component(s, 0, 1), 0, 1e-6); /* it closes */
    assert_true(metric(s, 1, "t_s") >= 17.0652165601579625 && metric(s, 1, "e_max") > 0.1);
    ll_session_destroy(s);
}

static void patch(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    must(ll_session_patch(s, 0, json));
    cJSON_Delete(json);
}

/* A change takes effect from the start: the same as a run that started with it. */
static void changes_count_from_the_start(void **state)
{
    (void)state;
    ll_session *a = open_id("motion/orbit"), *b = open_id("motion/orbit");
    must(ll_session_run_to(a, 300));
    patch(a, "{\"methods.1.dt_s\":0.02,\"params.e\":0.8,\"methods.0.method\":\"yoshida8\",\"methods.2."
             "shown\":false}");
    patch(b, "{\"methods.1.dt_s\":0.02,\"params.e\":0.8,\"methods.0.method\":\"yoshida8\",\"methods.2."
             "shown\":false}");
    must(ll_session_run_to(b, 300));
    assert_true(ll_session_hash(a) == ll_session_hash(b));
    run_to_end(a);
    assert_true(metric(a, 1, "steps") == 1000 && isnan(metric(a, 2, "steps")));
    cJSON *report;
    assert_string_equal(cJSON_GetObjectItem(metrics_of(a, 2, &report), "status")->valuestring, "off");
    cJSON_Delete(report);
    ll_session_destroy(a);
    ll_session_destroy(b);
}

static void blow_ups_are_reported(void **state)
{
    (void)state;
    ll_session *s = open_id("motion/stiff_spring");
    run_to_end(s);
    cJSON *report;
    const cJSON *m = metrics_of(s, 0, &report);
    assert_string_equal(cJSON_GetObjectItem(m, "status")->valuestring, "diverged");
    assert_non_null(strstr(cJSON_GetObjectItem(m, "reason")->valuestring, "exceeded ten times the scale"));
    assert_true(number(m, "diverged_t_s") > 0 && number(m, "diverged_t_s") < 5);
    assert_true(isnan(number(m, "e_max")) && isnan(number(m, "e_final")) && isnan(number(m, "e_l2")));
    assert_true(isnan(number(m, "energy_drift_max")) && number(m, "evaluations") > 0);
    assert_true(cJSON_IsNull(cJSON_GetArrayItem(cJSON_GetObjectItem(m, "state"), 0)));
    m = cJSON_GetArrayItem(cJSON_GetObjectItem(cJSON_GetObjectItem(report, "metrics"), "methods"), 4);
    assert_string_equal(cJSON_GetObjectItem(m, "status")->valuestring, "ok");
    cJSON_Delete(report);
    ll_session_destroy(s);
}

/* Checks that the method's run ends with the status, and if it is not `ok`, with a reason and without
 * errors. */
static void ends(const char *what, const char *status)
{
    static const char *const errors[] = {"e_final", "e_max", "e_l2"};
    char text[512];
    snprintf(text, sizeof text, "{\"kind\":\"motion\",%s}", what);
    ll_session *s = open_text(text);
    run_to_end(s);
    cJSON *report;
    const cJSON *m = metrics_of(s, 0, &report);
    const char *reported = cJSON_GetObjectItem(m, "status")->valuestring;
    bool ok = strcmp(status, "ok") == 0;
    if (strcmp(reported, status) != 0)
        fail_msg("%s: %s, e_max %g, not %s", what, reported, number(m, "e_max"), status);
    assert_true(ok == (cJSON_GetObjectItem(m, "reason") == NULL));
    for (int i = 0; i < 3; i++)
        assert_true(ok == isfinite(number(m, errors[i])));
    cJSON_Delete(report);
    ll_session_destroy(s);
}

/* An undamped oscillation beyond its limit of stability grows by a known factor per step; below it the same
 * method is bounded. An error below the scale of the problem is no failure. */
static void finite_values_beyond_all_bounds_are_failures(void **state)
{
    (void)state;
#define OSCILLATOR(omega, method, dt)                                                                        \
    "\"problem\":\"oscillator\",\"params\":{\"omega\":" omega                                                \
    "},\"duration_s\":30,\"methods\":[{\"method\":\"" method "\",\"dt_s\":" dt "}]"
    ends(OSCILLATOR("7", "velocity_verlet", "0.29"), "diverged"); /* omega dt = 2.03 */
    ends(OSCILLATOR("7", "velocity_verlet", "0.27"), "ok");       /* 1.89 */
    ends(OSCILLATOR("30", "rk4", "0.1"), "diverged");             /* 3 > 2.828 */
    ends(OSCILLATOR("30", "rk4", "0.09"), "ok");
    ends(OSCILLATOR("2", "explicit_euler", "0.1"), "diverged"); /* grows by (1.04)^150 */
    ends(OSCILLATOR("2", "explicit_euler", "0.01"), "ok");      /* by (1.0004)^1500, 1.8 */
    ends(OSCILLATOR("2", "implicit_euler", "0.1"), "ok");       /* decays */
    ends("\"problem\":\"kepler\",\"params\":{\"e\":0.995},\"duration_s\":7,\"methods\":[{\"method\":"
         "\"leapfrog_kdk\",\"dt_s\":0.02}]",
         "diverged");
    ends("\"problem\":\"kepler\",\"params\":{\"e\":0.995},\"duration_s\":7,\"methods\":[{\"method\":"
         "\"dop853\",\"tolerance\":1e-10}]",
         "ok");
    ends("\"problem\":\"penalty_floor\",\"duration_s\":5,\"methods\":[{\"method\":\"semi_implicit_euler\","
         "\"dt_s\":0.02}]",
         "diverged");
    ends("\"problem\":\"van_der_pol\",\"params\":{\"mu\":50},\"duration_s\":5,\"methods\":[{\"method\":"
         "\"rk4\",\"dt_s\":0.05}]",
         "diverged");
    ends("\"problem\":\"pendulum\",\"duration_s\":5,\"methods\":[{\"method\":\"rk4\",\"shown\":false}]",
         "off");
}

static double reported(ll_session *s, const char *name)
{
    cJSON *report = ll_session_metrics(s);
    double value = number(cJSON_GetObjectItem(report, "metrics"), name);
    cJSON_Delete(report);
    return value;
}

/* Two solutions of a double pendulum with 14 digits diverge after about twenty seconds: from there on no
 * error is known. An error below the difference of the two references is unknown too. */
static void errors_are_reported_while_the_solution_is_known(void **state)
{
    (void)state;
    ll_session *s =
        open_text("{\"kind\":\"motion\",\"problem\":\"double_pendulum\",\"duration_s\":36,\"methods\":["
                  "{\"method\":\"rk4\",\"dt_s\":0.004},{\"method\":\"dop853\",\"tolerance\":1e-14}]}");
    must(ll_session_run_to(s, 240));
    double early = metric(s, 0, "e_final");
    assert_true(isnan(reported(s, "predictable_until_s")) && reported(s, "solution_uncertainty_max") < 1e-9);
    assert_true(early > reported(s, "solution_uncertainty_max") && isnan(metric(s, 1, "e_max")));
    run_to_end(s);
    double until = reported(s, "predictable_until_s"), doubt = reported(s, "solution_uncertainty_max");
    assert_true(until > 12 && until < 33 && doubt > 1e-6 && doubt < 0.1);
    assert_true(isnan(metric(s, 0, "e_final")) && isnan(metric(s, 1, "e_final")));
    assert_true(metric(s, 0, "e_max") > early && metric(s, 0, "energy_drift_max") > 0);
    ll_session_destroy(s);
    s = open_text("{\"kind\":\"motion\",\"problem\":\"pendulum\",\"duration_s\":30,\"methods\":["
                  "{\"method\":\"rk4\",\"dt_s\":0.01}]}");
    run_to_end(s);
    assert_true(reported(s, "solution_uncertainty_max") == 0 && isnan(reported(s, "predictable_until_s")));
    ll_session_destroy(s);
}

/* ---- time stepping ---- */

/* Frames of 1/60 and 1/30 s in turn, to the nanosecond: figures of the reference page. */
static void frames_as_steps_break_verlet(void **state)
{
    (void)state;
    static const struct {
        double place, within;
    } known[] = {{50, 1e-6}, {45.166667, 1e-6}, {45, 1e-11}, {45, 1e-11}, {45, 1e-10}};
    ll_session *s = open_id("motion/variable_steps");
    run_to_end(s);
    for (int i = 0; i < 5; i++)
        assert_near(component(s, i, 0), known[i].place, known[i].within);
    assert_true(metric(s, 0, "steps") == 120 && metric(s, 0, "frames") == 120);
    ll_session_destroy(s);
}

/* With an accumulator, frames of random length give bitwise the result of a fixed step. */
static void saved_up_frames_are_fixed_steps(void **state)
{
    (void)state;
    ll_session *s = open_id("motion/accumulator");
    run_to_end(s);
    double steps = metric(s, 1, "steps"), behind = 60 - metric(s, 1, "t_s");
    char text[256];
    assert_true(behind >= 0 && behind < 0.03 + 0.01); /* at most a frame and a step */
    assert_true(metric(s, 0, "steps") == metric(s, 0, "frames") && metric(s, 1, "e_max") < 0.16);
    assert_true(metric(s, 0, "e_max") > 1 && metric(s, 3, "energy_drift_max") < 0.01);
    snprintf(text, sizeof text,
             "{\"kind\":\"motion\",\"problem\":\"oscillator\",\"params\":{\"omega\":5},\"duration_s\":%g,"
             "\"methods\":[{\"method\":\"stormer_verlet\",\"dt_s\":0.01}]}",
             steps / 100);
    ll_session *fixed = open_text(text);
    run_to_end(fixed);
    assert_true(metric(fixed, 0, "steps") == steps);
    assert_true(component(fixed, 0, 0) == component(s, 1, 0) && component(fixed, 0, 1) == component(s, 1, 1));
    ll_session_destroy(fixed);
    ll_session_destroy(s);
}

/* Another seed gives other frames, the same seed the same. */
static void random_frames_are_the_seeds(void **state)
{
    (void)state;
    ll_session *s[3];
    for (int i = 0; i < 3; i++) {
        cJSON *json;
        must(ll_scenario_load("scenarios", "motion/accumulator", &json));
        must(ll_session_create(json, i == 2 ? 8 : 7, NULL, NULL, &s[i]));
        cJSON_Delete(json);
        must(ll_session_run_to(s[i], 600)); /* later the frames of some seeds make it blow up */
    }
    assert_true(component(s[0], 0, 0) == component(s[1], 0, 0));
    assert_true(component(s[0], 0, 0) != 0);
    assert_true(component(s[0], 0, 0) != component(s[2], 0, 0));
    for (int i = 0; i < 3; i++)
        ll_session_destroy(s[i]);
}

/* An hour by a clock in single precision: 2.79 s late; with compensation exact to the last digit. */
static void float_clocks_are_late(void **state)
{
    (void)state;
    ll_session *s = open_id("motion/clock_drift");
    run_to_end(s);
    assert_near(metric(s, 1, "clock_error_s"), -2.79, 0.005);
    assert_true(metric(s, 1, "e_max") > 1);
    assert_near(metric(s, 2, "clock_error_s"), 0, 0x1p-12);
    assert_true(metric(s, 2, "e_max") < 0.01);
    assert_true(isnan(metric(s, 0, "clock_error_s")) && metric(s, 0, "e_max") < 1e-4);
    assert_true(metric(s, 1, "t_s") == 3600 && metric(s, 1, "steps") == 216000);
    ll_session_destroy(s);
}

/* A body at rest makes no steps; its clock continues. A located stop is within a step of the clock. */
static void clocks_go_on_at_rest(void **state)
{
    (void)state;
    ll_session *s = open_text("{\"kind\":\"motion\",\"problem\":\"coulomb\",\"duration_s\":5,\"methods\":["
                              "{\"method\":\"velocity_verlet\",\"dt_s\":0.04,\"clock\":\"compensated\"},"
                              "{\"method\":\"velocity_verlet\",\"steps\":\"frame\"}]}");
    run_to_end(s);
    for (int i = 0; i < 2; i++)
        assert_true(metric(s, i, "events") == 1 && metric(s, i, "e_max") < 1e-6 &&
                    fabs(metric(s, i, "t_s") - 5) < 0.04);
    ll_session_destroy(s);
}

/* Numbers are 2^-10, 2^-7 and 2^-4 m apart there, and so are the body's positions. */
static void far_places_are_coarse(void **state)
{
    (void)state;
    ll_session *s = open_id("motion/far_from_origin");
    run_to_end(s);
    for (int i = 1; i <= 3; i++) {
        double spacing = metric(s, i, "ulp_m"), x = component(s, i, 0);
        assert_true(spacing == pow(2, 3 * i - 13) && x == spacing * round(x / spacing));
        assert_true(fabs(metric(s, i, "e_max") / metric(s, 4, "e_max") - 1) > 0.05);
    }
    assert_near(metric(s, 0, "e_max") / metric(s, 4, "e_max"), 1, 1e-4);
    assert_true(metric(s, 3, "e_max") > 1);
    ll_session_destroy(s);
}

/* A million steps forward and a million back. */
static void the_lattice_returns_bitwise(void **state)
{
    (void)state;
    ll_session *s = open_text("{\"kind\":\"motion\",\"problem\":\"pendulum\",\"duration_s\":2000,"
                              "\"reverse\":true,\"tick_hz\":1,\"methods\":["
                              "{\"method\":\"verlet_lattice\",\"dt_s\":0.001},"
                              "{\"method\":\"velocity_verlet\",\"dt_s\":0.001},"
                              "{\"method\":\"semi_implicit_euler\",\"dt_s\":0.001}]}");
    must(ll_session_run_to(s, 1000));
    assert_true(metric(s, 0, "t_s") == 1000 && metric(s, 0, "steps") == 1000000);
    run_to_end(s);
    assert_true(metric(s, 0, "t_s") == 0 && metric(s, 0, "steps") == 2000000);
    assert_true(component(s, 0, 0) == 2 && component(s, 0, 1) == 0 && metric(s, 0, "e_final") == 0);
    assert_true(metric(s, 1, "e_final") > 0 && metric(s, 1, "e_final") < 1e-6);
    assert_true(metric(s, 2, "e_final") > 0.01);
    ll_session_destroy(s);
}

/* Where there is no formula the reference is reversed too, and adaptive methods also run back. */
static void references_turn_too(void **state)
{
    (void)state;
    ll_session *s = open_text("{\"kind\":\"motion\",\"problem\":\"henon_heiles\",\"duration_s\":40,"
                              "\"reverse\":true,\"methods\":[{\"method\":\"dop853\",\"tolerance\":1e-12},"
                              "{\"method\":\"leapfrog_kdk\",\"dt_s\":0.07}]}");
    run_to_end(s);
    assert_true(metric(s, 0, "t_s") == 0 && metric(s, 0, "e_max") < 1e-9);
    assert_near(component(s, 0, 0), 0.1, 1e-9);
    assert_near(component(s, 0, 3), 0.5, 1e-9);
    /* The reversal is at the end of a step, after 20.02 s. */
    assert_true(metric(s, 1, "steps") == 572);
    assert_near(metric(s, 1, "t_s"), 0, 1e-12);
    assert_true(metric(s, 1, "e_max") < 0.02 && metric(s, 1, "e_final") < 1e-12);
    ll_session_destroy(s);
}

static void bad_input_is_named(void **state)
{
    (void)state;
    static const char *const bad[][2] = {
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"rk4\",\"dt_s\":0}]", "methods.0.dt_s"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"rk4\",\"dt_s\":-1}]", "methods.0.dt_s"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"rk4\"},{\"method\":\"rk4\",\"dt_s\":40}]",
         "methods.1.dt_s"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"rk4\",\"dt_s\":1e-8}]", "methods.0.dt_s"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"rk5\"}]", "methods.0.method"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"boris\"}]", "methods.0.method"},
        {"\"problem\":\"hires\",\"methods\":[{\"method\":\"velocity_verlet\"}]", "methods.0.method"},
        {"\"problem\":\"nothing\",\"methods\":[{\"method\":\"rk4\"}]", "problem"},
        {"\"problem\":\"pendulum\",\"methods\":[]", "methods"},
        {"\"problem\":\"pendulum\",\"params\":{\"omega\":1},\"methods\":[{\"method\":\"rk4\"}]",
         "params.omega"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"dopri5\",\"steps\":\"frame\"}]",
         "methods.0.steps"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"dopri5\",\"clock\":\"float\"}]",
         "methods.0.clock"},
        {"\"problem\":\"pendulum\",\"reverse\":true,\"methods\":[{\"method\":\"rk4\",\"steps\":\"frame\"}]",
         "methods.0.steps"},
        {"\"problem\":\"pendulum\",\"reverse\":true,\"methods\":[{\"method\":\"rk4\",\"clock\":\"float\"}]",
         "methods.0.clock"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"rk4\",\"origin_offset_m\":10}]",
         "methods.0.origin_offset_m"},
        {"\"problem\":\"hires\",\"methods\":[{\"method\":\"rk4\",\"origin_offset_m\":1,\"precision\":"
         "\"float\"}]",
         "methods.0.origin_offset_m"},
        {"\"problem\":\"pendulum\",\"methods\":[{\"method\":\"dopri5\",\"tolerance\":0}]",
         "methods.0.tolerance"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        char text[512];
        ll_session *s;
        snprintf(text, sizeof text, "{\"kind\":\"motion\",\"duration_s\":10,%s}", bad[i][0]);
        cJSON *json = cJSON_Parse(text);
        ll_status status = ll_session_create(json, -1, NULL, NULL, &s);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, bad[i][1]);
        cJSON_Delete(json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figure_4_is_the_table),
        cmocka_unit_test(errors_are_those_of_the_closed_form),
        cmocka_unit_test(references_by_integration_are_published),
        cmocka_unit_test(runs_end_at_their_duration),
        cmocka_unit_test(changes_count_from_the_start),
        cmocka_unit_test(blow_ups_are_reported),
        cmocka_unit_test(finite_values_beyond_all_bounds_are_failures),
        cmocka_unit_test(errors_are_reported_while_the_solution_is_known),
        cmocka_unit_test(frames_as_steps_break_verlet),
        cmocka_unit_test(saved_up_frames_are_fixed_steps),
        cmocka_unit_test(random_frames_are_the_seeds),
        cmocka_unit_test(float_clocks_are_late),
        cmocka_unit_test(clocks_go_on_at_rest),
        cmocka_unit_test(far_places_are_coarse),
        cmocka_unit_test(the_lattice_returns_bitwise),
        cmocka_unit_test(references_turn_too),
        cmocka_unit_test(bad_input_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
