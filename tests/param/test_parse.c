#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

static void defaults_fill_every_row(void **state)
{
    (void)state;
    sample s;
    memset(&s, 0xa5, sizeof s);
    ll_param_defaults(&sample_table, &s);
    assert_int_equal(s.seed, 7);
    assert_int_equal(s.shape, 0);
    assert_true(s.params.circle.radius == 1);
    assert_true(s.ratio == 0 && s.level == 0.3 && !s.loud);
    assert_int_equal(s.count, 0);
}

/* Configurations are hashed as they lie in memory. */
static void equal_configurations_are_equal_bytes(void **state)
{
    (void)state;
    sample a, b;
    memset(&a, 0xa5, sizeof a);
    memset(&b, 0x5a, sizeof b);
    sample_two(&a);
    ll_param_defaults(&sample_table, &b);
    ll_status s =
        sample_parse("{\"shape\":\"box\",\"params\":{\"height_m\":9},"
                     "\"members\":[{\"lag_ms\":1,\"name\":\"longlong\"},{\"lag_ms\":2},{\"lag_ms\":3}]}",
                     &b);
    assert_int_equal(s.code, LL_OK);
    s = sample_parse("{\"shape\":\"circle\",\"members\":[{\"lag_ms\":10},{\"lag_ms\":20,\"name\":\"ben\"}]}",
                     &b);
    assert_int_equal(s.code, LL_OK);
    assert_memory_equal(&a, &b, sizeof a);
}

static void every_type_is_read(void **state)
{
    (void)state;
    sample s;
    ll_param_defaults(&sample_table, &s);
    ll_status status =
        sample_parse("{\"params\":{\"width_m\":4},\"loud\":true,\"seed\":9007199254740991,\"shape\":\"box\","
                     "\"ratio\":-1.5e-300,"
                     "\"members\":[{\"name\":\"Zo\xc3\xab\",\"lag_ms\":1000,\"ready\":false,\"tries\":-2,"
                     "\"up\":{\"order\":\"unordered\",\"jitter_ms\":0.25}},{\"lag_ms\":0}]}",
                     &s);
    assert_string_equal(status.text, "");
    assert_int_equal(s.seed, 9007199254740991);
    assert_int_equal(s.shape, 1);
    assert_true(s.params.box.width == 4 && s.params.box.height == 3); /* though `params` came first */
    assert_true(s.ratio == -1.5e-300 && s.loud);
    assert_int_equal(s.count, 2);
    const member *m = &s.members[0];
    assert_string_equal(m->name, "Zo\xc3\xab");
    assert_true(m->lag_ms == 1000 && !m->ready && m->tries == -2 && m->up.order == 0 &&
                m->up.jitter_ms == 0.25);
    assert_true(m->down.order == 1 && m->down.jitter_ms == 0);
    m = &s.members[1];
    assert_string_equal(m->name, "anna");
    assert_true(m->lag_ms == 0 && m->ready && m->up.order == 1);
}

static void what_is_not_given_stays(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    s.level = 0.8;
    assert_int_equal(sample_parse(SAMPLE_TWO, &s).code, LL_OK);
    assert_true(s.level == 0.8);
}

/* A choice that is given starts its variant anew, also when it is the same as before. */
static void a_choice_brings_its_defaults(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    s.params.circle.radius = 5;
    assert_int_equal(sample_parse("{\"members\":[{\"lag_ms\":1}],\"params\":{}}", &s).code, LL_OK);
    assert_true(s.params.circle.radius == 5);
    assert_int_equal(sample_parse("{\"members\":[{\"lag_ms\":1}],\"shape\":\"circle\"}", &s).code, LL_OK);
    assert_true(s.params.circle.radius == 1);
}

/* An array is what the document says, and nothing of what was there. */
static void arrays_are_replaced(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    s.members[0].tries = 5;
    assert_int_equal(sample_parse("{\"members\":[{\"lag_ms\":3}]}", &s).code, LL_OK);
    assert_int_equal(s.count, 1);
    assert_int_equal(s.members[0].tries, 0);
    member none = {0};
    assert_memory_equal(&s.members[1], &none, sizeof none);
}

/* Each document is wrong in one way; the object must stay as it was, whatever was right before the error. */
static void errors_name_place_range_and_value(void **state)
{
    (void)state;
    static const struct {
        const char *json, *field, *text;
    } cases[] = {
        {"{\"members\":[{\"lag_ms\":1},{\"lag_ms\":5000}]}", "members.1.lag_ms",
         "members.1.lag_ms: must be 0 to 1000 ms; got 5000"},
        {"{\"members\":[{\"lag_ms\":-0.1}]}", "members.0.lag_ms",
         "members.0.lag_ms: must be 0 to 1000 ms; got -0.1"},
        {"{\"members\":[{\"lag_ms\":1e999}]}", "members.0.lag_ms",
         "members.0.lag_ms: must be 0 to 1000 ms; got inf"},
        {"{\"ratio\":-1e999,\"members\":[{\"lag_ms\":1}]}", "ratio", "ratio: must be finite; got -inf"},
        {"{\"level\":0.95,\"members\":[{\"lag_ms\":1}]}", "level", "level: must be 0.1 to 0.9; got 0.95"},
        {"{\"members\":[{\"lag_ms\":\"10\"}]}", "members.0.lag_ms",
         "members.0.lag_ms: must be a number; got \"10\""},
        {"{\"members\":[{\"lag_ms\":null}]}", "members.0.lag_ms",
         "members.0.lag_ms: must be a number; got null"},
        {"{\"members\":[{\"lag_ms\":[]}]}", "members.0.lag_ms",
         "members.0.lag_ms: must be a number; got an array"},
        {"{\"members\":[{\"lag_ms\":1,\"tries\":1.5}]}", "members.0.tries",
         "members.0.tries: must be a whole number from -2 to 9; got 1.5"},
        {"{\"members\":[{\"lag_ms\":1,\"tries\":10}]}", "members.0.tries",
         "members.0.tries: must be a whole number from -2 to 9; got 10"},
        {"{\"members\":[{\"lag_ms\":1,\"tries\":true}]}", "members.0.tries",
         "members.0.tries: must be a whole number; got true"},
        {"{\"seed\":9007199254740992,\"members\":[{\"lag_ms\":1}]}", "seed",
         "seed: must be a whole number from 0 to 9007199254740991; got 9007199254740992"},
        {"{\"members\":[{\"lag_ms\":1,\"ready\":1}]}", "members.0.ready",
         "members.0.ready: must be true or false; got 1"},
        {"{\"shape\":\"Box\",\"members\":[{\"lag_ms\":1}]}", "shape",
         "shape: must be one of circle, box, point; got \"Box\""},
        {"{\"shape\":1,\"members\":[{\"lag_ms\":1}]}", "shape",
         "shape: must be one of circle, box, point; got 1"},
        {"{\"members\":[{\"lag_ms\":1,\"name\":\"\"}]}", "members.0.name",
         "members.0.name: must be a text of 1 to 8 bytes; got 0"},
        {"{\"members\":[{\"lag_ms\":1,\"name\":\"ninebytes\"}]}", "members.0.name",
         "members.0.name: must be a text of 1 to 8 bytes; got 9"},
        {"{\"members\":[{\"lag_ms\":1,\"name\":5}]}", "members.0.name",
         "members.0.name: must be a text; got 5"},
        {"{\"members\":[{\"lag_ms\":1,\"name\":\"a\\nb\"}]}", "members.0.name",
         "members.0.name: must be valid UTF-8 without control characters; got 0x0a at byte 1"},
        {"{\"members\":[{\"lag_ms\":1,\"up\":3}]}", "members.0.up", "members.0.up: must be an object; got 3"},
        {"{\"members\":{\"0\":{}}}", "members", "members: must be an array; got an object"},
        {"{\"members\":[]}", "members", "members: must have 1 to 3 elements; got 0"},
        {"{\"members\":[{},{},{},{}]}", "members", "members: must have 1 to 3 elements; got 4"},
        {"{\"members\":[7]}", "members.0", "members.0: must be an object; got 7"},
        {"{}", "members", "members is missing"},
        {"{\"members\":[{\"lag_ms\":1},{}]}", "members.1.lag_ms", "members.1.lag_ms is missing"},
        {"{\"members\":[{\"lag_ms\":1,\"lag_ms\":2}]}", "members.0.lag_ms",
         "members.0.lag_ms is given twice"},
        {"{\"members\":[{\"lag_ms\":1,\"lagms\":2}]}", "members.0.lagms",
         "members.0.lagms is unknown; did you mean lag_ms?"},
        {"{\"members\":[{\"Lag_ms\":2}]}", "members.0.Lag_ms",
         "members.0.Lag_ms is unknown; did you mean lag_ms?"},
        {"{\"members\":[{\"lag\":2}]}", "members.0.lag", "members.0.lag is unknown; did you mean lag_ms?"},
        {"{\"ratoi\":2}", "ratoi", "ratoi is unknown; did you mean ratio?"},
        {"{\"members\":[{\"lag_ms\":1,\"up\":{\"colour\":2}}]}", "members.0.up.colour",
         "members.0.up.colour is unknown; known are jitter_ms, order"},
        {"{\"params\":{\"width_m\":2},\"members\":[{\"lag_ms\":1}]}", "params.width_m",
         "params.width_m is unknown; known are radius_m"},
        {"{\"shape\":\"point\",\"params\":{\"x\":1},\"members\":[{\"lag_ms\":1}]}", "params.x",
         "params.x is unknown: it has no members"},
        {"{\"members\":[{\"lag_ms\":1,\"up\":{\"jitter_ms\":2}}]}", "members.0.up.jitter_ms",
         "members.0.up.jitter_ms: must be at most the lag"},
        {"[]", "", "sample: must be an object; got an array"},
        {"5", "", "sample: must be an object; got 5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sample s, before;
        sample_two(&s);
        memcpy(&before, &s, sizeof s);
        assert_status(sample_parse(cases[i].json, &s), LL_BAD_INPUT, cases[i].field, cases[i].text);
        assert_memory_equal(&s, &before, sizeof s);
    }
}

static void a_number_that_is_none_is_refused(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    cJSON *json = cJSON_Parse(SAMPLE_TWO);
    cJSON_AddItemToObject(json, "level", cJSON_CreateNumber((double)NAN)); /* no JSON text can say this */
    ll_status status = ll_param_parse(&sample_table, json, &s);
    cJSON_Delete(json);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "level");
}

static void texts_must_be_utf8(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "\x80",
        "\xc3",
        "\xc3(",
        "\xc0\xaf",
        "\xc1\xbf",
        "\xe2\x82",
        "\xe0\x9f\xbf",
        "\xed\xa0\x80",
        "\xf0\x8f\xbf\xbf",
        "\xf4\x90\x80\x80",
        "\xf5\x80\x80\x80",
        "\xff",
        "\x7f",
        "\x1f",
        "\xc2\x80",
        "\xc2\x9f",
        "ok\xe2\x82",
    };
    static const char *const good[] = {"a",
                                       "\xc2\xa0",
                                       "\xdf\xbf",
                                       "\xe0\xa0\x80",
                                       "\xed\x9f\xbf",
                                       "\xee\x80\x80",
                                       "\xef\xbf\xbd",
                                       "\xf0\x90\x80\x80",
                                       "\xf4\x8f\xbf\xbf",
                                       "~ z"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        sample s;
        char text[100];
        sample_two(&s);
        snprintf(text, sizeof text, "{\"members\":[{\"lag_ms\":1,\"name\":\"%s\"}]}", bad[i]);
        ll_status status = sample_parse(text, &s);
        assert_string_equal(status.field, "members.0.name");
        assert_non_null(strstr(status.text, "valid UTF-8"));
    }
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++) {
        sample s;
        char text[100];
        sample_two(&s);
        snprintf(text, sizeof text, "{\"members\":[{\"lag_ms\":1,\"name\":\"%s\"}]}", good[i]);
        assert_int_equal(sample_parse(text, &s).code, LL_OK);
        assert_string_equal(s.members[0].name, good[i]);
    }
}

/* A stranger's key goes into a sentence that is shown and logged. */
static void strange_keys_are_made_printable(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_status(sample_parse("{\"a\\u001b[31m\xff\":1}", &s), LL_BAD_INPUT, "a?[31m?",
                  "a?[31m? is unknown; known are seed, shape, params, ratio, level, members, loud");
    char text[4000] = "{\"";
    memset(text + 2, 'k', 3000);
    strcpy(text + 3002, "\":1}");
    ll_status status = sample_parse(text, &s);
    assert_true(strlen(status.field) < 60);
    assert_non_null(strstr(status.text, "kkk... is unknown"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_fill_every_row),
        cmocka_unit_test(equal_configurations_are_equal_bytes),
        cmocka_unit_test(every_type_is_read),
        cmocka_unit_test(what_is_not_given_stays),
        cmocka_unit_test(a_choice_brings_its_defaults),
        cmocka_unit_test(arrays_are_replaced),
        cmocka_unit_test(errors_name_place_range_and_value),
        cmocka_unit_test(a_number_that_is_none_is_refused),
        cmocka_unit_test(texts_must_be_utf8),
        cmocka_unit_test(strange_keys_are_made_printable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
