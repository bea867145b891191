/* Runs until the mean is known: when they stop. test_until_coverage.c: the coverage of the final interval. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/spec/until.h"
#include "support/near.h"

static ll_status parse(const char *until, int repeats, ll_experiment **e)
{
    char text[600];
    snprintf(
        text, sizeof text,
        "{\"scenario\":\"race\",\"repeats\":%d,\"until\":{%s},\"metrics\":[\"players.0.remote_error_m.mean\","
        "\"players.0.remote_error_m.max\"]}",
        repeats, until);
    cJSON *json = cJSON_Parse(text);
    ll_status status = ll_experiment_parse(json, "scenarios", NULL, e);
    cJSON_Delete(json);
    return status;
}

static ll_experiment *experiment(const char *until, int repeats)
{
    ll_experiment *e;
    ll_status status = parse(until, repeats, &e);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    return e;
}

static void looks_double(void **state)
{
    (void)state;
    ll_experiment *e = experiment("\"half_width\":0.1,\"least\":10", 100); /* 10, 20, 40, 80, 100 */
    assert_int_equal(ll_until_checks(e), 5);
    assert_near(ll_experiment_interval_request(e, 0, 0, NAN).error, 0.05 / 1.5, 1e-15);
    ll_experiment_free(e);
    e = experiment("", 100);
    assert_true(ll_until_checks(e) == 1 && !ll_until_is_set(e));
    ll_experiment_free(e);
    e = experiment("\"relative\":0.5,\"least\":20", 20);
    assert_int_equal(ll_until_checks(e), 1);
    ll_experiment_free(e);
}

static void bad_rules_are_reported(void **state)
{
    (void)state;
    static const struct {
        const char *until, *field, *words;
    } cases[] = {{"\"half_width\":-1", "until.half_width", "-1"},
                 {"\"relative\":1.5", "until.relative", "1.5"},
                 {"\"relative\":0.1,\"least\":4", "until.least", "4"},
                 {"\"relative\":0.1,\"least\":50", "until.least", "at most repeats, which is 40"},
                 {"\"relative\":0.1,\"metric\":\"tick\"", "until.metric", "one of the metrics"},
                 {"\"relative\":0.1,\"metric\":\"players.0.remote_error_m.max\"", "until.metric",
                  "depends on rare runs"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        ll_experiment *e = NULL;
        ll_status status = parse(cases[i].until, 40, &e);
        if (status.code != LL_BAD_INPUT || strcmp(status.field, cases[i].field) != 0 ||
            !strstr(status.text, cases[i].words))
            fail_msg("%s gives %s: %s", cases[i].until, status.field, status.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(looks_double),
        cmocka_unit_test(bad_rules_are_reported),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
