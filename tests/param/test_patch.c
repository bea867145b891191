#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

/* The changes that were told, as "path=value path=value". */
typedef struct tape {
    char text[600];
    int refuse_at; /* the call that fails; 0 is none */
    int calls;
} tape;

static ll_status record(void *context, const char *path, const char *value)
{
    tape *t = context;
    size_t used = strlen(t->text);
    snprintf(t->text + used, sizeof t->text - used, "%s%s=%s", used > 0 ? " " : "", path, value);
    return ++t->calls == t->refuse_at ? ll_error(LL_LIMIT, "the log is full") : ll_ok();
}

static ll_status patch(const char *text, sample *s, tape *t)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_param_patch(&sample_table, json, s, t == NULL ? NULL : record, t);
    cJSON_Delete(json);
    return status;
}

static void elements_are_addressed_in_three_ways(void **state)
{
    (void)state;
    static const char *const ways[] = {
        "{\"members\":{\"1\":{\"lag_ms\":250,\"up\":{\"order\":\"unordered\"}}}}",
        "{\"members\":[{},{\"lag_ms\":250,\"up\":{\"order\":\"unordered\"}}]}",
        "{\"members.1.lag_ms\":250,\"members.1.up.order\":\"unordered\"}",
        "{\"members\":{\"1.lag_ms\":250,\"1\":{\"up.order\":\"unordered\"}}}",
        "{\"members.1\":{\"lag_ms\":250,\"up\":{\"order\":\"unordered\"}}}",
    };
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        sample s, want;
        sample_two(&s);
        memcpy(&want, &s, sizeof s);
        want.members[1].lag_ms = 250;
        want.members[1].up.order = 0;
        tape t = {0};
        assert_status(patch(ways[i], &s, &t), LL_OK, "", "");
        assert_memory_equal(&s, &want, sizeof s);
        assert_string_equal(t.text, "members.1.lag_ms=250 members.1.up.order=\"unordered\"");
    }
}

static void changes_are_told_in_order_as_json(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    tape t = {0};
    assert_status(
        patch("{\"loud\":true,\"ratio\":0.1,\"members\":[{\"name\":\"a \\\"b\\\"\"},{\"tries\":3.0}],"
              "\"level\":0.30000000000000004}",
              &s, &t),
        LL_OK, "", "");
    assert_string_equal(t.text, "loud=true ratio=0.1 members.0.name=\"a \\\"b\\\"\" members.1.tries=3 "
                                "level=0.30000000000000004");
}

/* A change that is told can be done again by ll_param_set: replay rests on it. */
static ll_status do_again(void *context, const char *path, const char *value)
{
    return ll_param_set(&sample_table, context, path, value, true);
}

static void changes_told_lead_to_the_same_object(void **state)
{
    (void)state;
    static const char *const patches[] = {
        "{\"params\":{\"height_m\":7},\"shape\":\"box\",\"level\":0.7}",
        "{\"members.0.lag_ms\":77.25,\"members.0.up.jitter_ms\":77}",
        "{\"shape\":\"point\"}",
        "{\"members\":[{\"name\":\"\xc3\xa4\\u20ac\"},{\"name\":\"true\"}]}",
    };
    for (size_t i = 0; i < sizeof patches / sizeof patches[0]; i++) {
        sample s, again;
        sample_two(&s);
        memcpy(&again, &s, sizeof s);
        cJSON *json = cJSON_Parse(patches[i]);
        assert_status(ll_param_patch(&sample_table, json, &s, do_again, &again), LL_OK, "", "");
        cJSON_Delete(json);
        assert_memory_equal(&s, &again, sizeof s);
    }
}

/* The choice comes after the params that belong to it. */
static void a_variant_may_come_before_its_choice(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    tape t = {0};
    assert_status(patch("{\"params\":{\"width_m\":5},\"shape\":\"box\"}", &s, &t), LL_OK, "", "");
    assert_int_equal(s.shape, 1);
    assert_true(s.params.box.width == 5 && s.params.box.height == 3);
    assert_string_equal(t.text, "shape=\"box\" params.width_m=5");
}

static void the_same_choice_keeps_the_variant(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_status(patch("{\"params.radius_m\":5}", &s, NULL), LL_OK, "", "");
    assert_status(patch("{\"shape\":\"circle\"}", &s, NULL), LL_OK, "", "");
    assert_true(s.params.circle.radius == 5);
}

/* In each, something right stands before what is wrong. */
static void a_patch_is_all_or_nothing(void **state)
{
    (void)state;
    static const struct {
        const char *json;
        ll_code code;
        const char *field, *text;
    } cases[] = {
        {"{\"loud\":true,\"level\":0.5,\"members\":{\"1\":{\"lag_ms\":5000}}}", LL_BAD_INPUT,
         "members.1.lag_ms", "members.1.lag_ms: must be 0 to 1000 ms; got 5000"},
        {"{\"loud\":true,\"seed\":8}", LL_CONFLICT, "seed", "seed cannot be changed while a session runs"},
        {"{\"loud\":true,\"members.0.down.order\":\"unordered\"}", LL_CONFLICT, "members.0.down.order",
         "members.0.down.order cannot be changed while a session runs"},
        {"{\"loud\":true,\"level\":null}", LL_BAD_INPUT, "level", "level cannot be removed; got null"},
        {"{\"loud\":true,\"members\":null}", LL_BAD_INPUT, "members", "members cannot be removed; got null"},
        {"{\"loud\":true,\"members\":[{}]}", LL_BAD_INPUT, "members",
         "members has 2 elements and a patch must give as many; got 1"},
        {"{\"loud\":true,\"members\":[{},{},{}]}", LL_BAD_INPUT, "members",
         "members has 2 elements and a patch must give as many; got 3"},
        {"{\"loud\":true,\"members\":{\"2\":{}}}", LL_BAD_INPUT, "members.2",
         "members.2 does not exist: the index in members must be 0 to 1"},
        {"{\"loud\":true,\"members\":{\"-1\":{}}}", LL_BAD_INPUT, "members.-1",
         "members.-1 does not exist: the index in members must be 0 to 1"},
        {"{\"loud\":true,\"members\":{\"01\":{}}}", LL_BAD_INPUT, "members.01",
         "members.01 does not exist: the index in members must be 0 to 1"},
        {"{\"loud\":true,\"members.99999999999.lag_ms\":1}", LL_BAD_INPUT, "members.99999999999",
         "members.99999999999 does not exist: the index in members must be 0 to 1"},
        {"{\"loud\":true,\"members.1.lagms\":1}", LL_BAD_INPUT, "members.1.lagms",
         "members.1.lagms is unknown; did you mean lag_ms?"},
        {"{\"loud\":true,\"level.x\":1}", LL_BAD_INPUT, "level.x", "level.x is unknown: it has no members"},
        {"{\"loud\":true,\"members\":7}", LL_BAD_INPUT, "members",
         "members: must be an array or an object; got 7"},
        {"{\"loud\":true,\"members.1\":[]}", LL_BAD_INPUT, "members.1",
         "members.1: must be an object; got an array"},
        {"{\"loud\":true,\"level\":0.5,\"level\":0.6}", LL_BAD_INPUT, "level", "level is given twice"},
        {"{\"loud\":true,\"params\":{},\"params\":{}}", LL_BAD_INPUT, "params", "params is given twice"},
        {"{\"loud\":true,\"members.1.lag_ms\":30,\"members\":{\"1\":{\"lag_ms\":30}}}", LL_BAD_INPUT,
         "members.1.lag_ms", "members.1.lag_ms is given twice"},
        {"{\"loud\":true,\"members.1.up.jitter_ms\":21}", LL_BAD_INPUT, "members.1.up.jitter_ms",
         "members.1.up.jitter_ms: must be at most the lag"},
        {"{\"loud\":true,\"shape\":\"box\",\"params\":{\"radius_m\":1}}", LL_BAD_INPUT, "params.radius_m",
         "params.radius_m is unknown; known are width_m, height_m"},
        {"[]", LL_BAD_INPUT, "", "sample: must be an object; got an array"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sample s, before;
        sample_two(&s);
        memcpy(&before, &s, sizeof s);
        tape t = {0};
        assert_status(patch(cases[i].json, &s, &t), cases[i].code, cases[i].field, cases[i].text);
        assert_memory_equal(&s, &before, sizeof s);
        assert_int_equal(t.calls, 0); /* nothing is told of a patch that is refused */
    }
}

/* Together they are within the rule, one after the other they would not be. */
static void rules_look_at_the_whole_patch(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_status(patch("{\"members.0.up.jitter_ms\":100,\"members.0.lag_ms\":100}", &s, NULL), LL_OK, "",
                  "");
    assert_status(patch("{\"members.0.lag_ms\":5,\"members.0.up.jitter_ms\":1}", &s, NULL), LL_OK, "", "");
}

static void a_refused_change_stops_the_walk(void **state)
{
    (void)state;
    sample s, before;
    sample_two(&s);
    memcpy(&before, &s, sizeof s);
    tape t = {.refuse_at = 2};
    assert_status(patch("{\"loud\":true,\"level\":0.5,\"ratio\":1}", &s, &t), LL_LIMIT, "",
                  "the log is full");
    assert_memory_equal(&s, &before, sizeof s);
    assert_int_equal(t.calls, 2);
}

static void an_empty_patch_changes_nothing(void **state)
{
    (void)state;
    sample s, before;
    sample_two(&s);
    memcpy(&before, &s, sizeof s);
    tape t = {0};
    assert_status(patch("{\"members\":[{},{\"up\":{}}],\"params\":{}}", &s, &t), LL_OK, "", "");
    assert_memory_equal(&s, &before, sizeof s);
    assert_int_equal(t.calls, 0);
}

/* The walk ends at the first name that is wrong: a large patch of a stranger is not slow. */
static void a_long_patch_is_refused_at_once(void **state)
{
    (void)state;
    cJSON *json = cJSON_CreateObject();
    for (int i = 0; i < 200000; i++)
        cJSON_AddItemToObjectCS(json, i % 2 == 0 ? "no_such_name" : "members", cJSON_CreateNumber(1));
    sample s;
    sample_two(&s);
    ll_status status = ll_param_patch(&sample_table, json, &s, NULL, NULL);
    assert_int_equal(status.code, LL_BAD_INPUT);
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elements_are_addressed_in_three_ways),
        cmocka_unit_test(changes_are_told_in_order_as_json),
        cmocka_unit_test(changes_told_lead_to_the_same_object),
        cmocka_unit_test(a_variant_may_come_before_its_choice),
        cmocka_unit_test(the_same_choice_keeps_the_variant),
        cmocka_unit_test(a_patch_is_all_or_nothing),
        cmocka_unit_test(rules_look_at_the_whole_patch),
        cmocka_unit_test(a_refused_change_stops_the_walk),
        cmocka_unit_test(an_empty_patch_changes_nothing),
        cmocka_unit_test(a_long_patch_is_refused_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
