/* Kind motion: the paper's figures, errors against closed forms, and changes that count from the start. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "session/scenario.h"
#include "session/session.h"

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
        assert_true(fabs(component(s, i, 0) - want[i]) < (i % 4 == 3 ? 5.1e-5 : 1e-12));
    assert_true(fabs(metric(s, 3, "t_s") - 3.003) < 1e-12);
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
    assert_true(fabs(metric(s, 0, "e_final") - 0.15) < 1e-11 && fabs(metric(s, 0, "e_max") - 0.15) < 1e-11);
    assert_true(fabs(metric(s, 1, "e_final") - 0.3) < 1e-11);
    /* root mean square of 0.05 t over t = 0.01 ... 3 */
    double squares = 0;
    for (int k = 1; k <= 300; k++)
        squares += pow(0.05 * k / 100, 2);
    assert_true(fabs(metric(s, 0, "e_l2") - sqrt(squares / 300)) < 1e-11);
    assert_true(metric(s, 0, "steps") == 300 && metric(s, 0, "evaluations") == 300);
    assert_true(metric(s, 1, "steps") == 150);
    ll_session_destroy(s);
}

/* Where there is no formula the reference run must lead to the published value. */
static void references_by_integration_are_published(void **state)
{
    (void)state;
    ll_session *s = open_text("{\"kind\":\"motion\",\"problem\":\"pleiades\",\"duration_s\":3,\"methods\":["
                              "{\"method\":\"dopri5\",\"tolerance\":1e-9}]}");
    run_to_end(s);
    cJSON *report;
    const cJSON *m = metrics_of(s, 0, &report), *solution = cJSON_GetObjectItem(m, "solution");
    assert_true(fabs(cJSON_GetArrayItem(solution, 0)->valuedouble - 0.370613914397051290) < 1e-10);
    assert_true(fabs(cJSON_GetArrayItem(solution, 7)->valuedouble - -3.94343758551739206) < 1e-10);
    assert_true(number(m, "e_final") > 1e-9 && number(m, "e_final") < 1e-3);
    cJSON_Delete(report);
    ll_session_destroy(s);
}

/* A duration that is no multiple of a tick: an adaptive method ends there to the digit. */
static void runs_end_at_their_duration(void **state)
{
    (void)state;
    ll_session *s = open_text(
        "{\"kind\":\"motion\",\"problem\":\"arenstorf\",\"duration_s\":17.0652165601579625,\"methods\":["
        "{\"method\":\"dop853\",\"tolerance\":1e-12},{\"method\":\"velocity_verlet_predicted\",\"dt_s\":0.01}"
        "]}");
    run_to_end(s);
    assert_true(metric(s, 0, "t_s") == 17.0652165601579625);
    assert_true(fabs(component(s, 0, 0) - 0.994) < 1e-6 && fabs(component(s, 0, 1)) < 1e-6); /* it closes */
    assert_true(metric(s, 1, "t_s") >= 17.0652165601579625 && metric(s, 1, "e_max") > 0.1);
    ll_session_destroy(s);
}

static void patch(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    must(ll_session_patch(s, 0, json));
    cJSON_Delete(json);
}

/* A change counts from the start: the same as a run that began with it. */
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
    assert_true(metric(a, 1, "steps") == 1000 && metric(a, 2, "steps") == 0);
    cJSON *report;
    assert_string_equal(cJSON_GetObjectItem(metrics_of(a, 2, &report), "status")->valuestring, "off");
    cJSON_Delete(report);
    ll_session_destroy(a);
    ll_session_destroy(b);
}

static void blow_ups_are_told(void **state)
{
    (void)state;
    ll_session *s = open_id("motion/stiff_spring");
    run_to_end(s);
    cJSON *report;
    const cJSON *m = metrics_of(s, 0, &report);
    assert_string_equal(cJSON_GetObjectItem(m, "status")->valuestring, "diverged");
    assert_non_null(strstr(cJSON_GetObjectItem(m, "reason")->valuestring, "not finite"));
    assert_true(number(m, "diverged_t_s") > 0 && number(m, "diverged_t_s") < 5);
    m = cJSON_GetArrayItem(cJSON_GetObjectItem(cJSON_GetObjectItem(report, "metrics"), "methods"), 4);
    assert_string_equal(cJSON_GetObjectItem(m, "status")->valuestring, "ok");
    cJSON_Delete(report);
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
        cmocka_unit_test(blow_ups_are_told),
        cmocka_unit_test(bad_input_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
