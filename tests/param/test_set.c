#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

static ll_status set(sample *s, const char *path, const char *value)
{
    return ll_param_set(&sample_table, s, path, value, false);
}

static void values_are_json_or_bare(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_status(set(&s, "members.1.lag_ms", "2.5e2"), LL_OK, "", "");
    assert_true(s.members[1].lag_ms == 250);
    assert_status(set(&s, "shape", "box"), LL_OK, "", "");
    assert_int_equal(s.shape, 1);
    assert_status(set(&s, "shape", "\"point\""), LL_OK, "", "");
    assert_int_equal(s.shape, 2);
    assert_status(set(&s, "loud", "true"), LL_OK, "", "");
    assert_true(s.loud);
    assert_status(set(&s, "members.0.name", "a b"), LL_OK, "", "");
    assert_string_equal(s.members[0].name, "a b");
    assert_status(set(&s, "members.0.name", "123"), LL_OK, "", "");
    assert_string_equal(s.members[0].name, "123");
    assert_status(set(&s, "members.0.name", "true"), LL_OK, "", "");
    assert_string_equal(s.members[0].name, "true");
    assert_status(set(&s, "members.0.name", "\"\\u00e4\""), LL_OK, "", "");
    assert_string_equal(s.members[0].name, "\xc3\xa4");
    assert_status(set(&s, "members.0.name", "\"half"), LL_OK, "", ""); /* no JSON, so it is the text */
    assert_string_equal(s.members[0].name, "\"half");
}

static void rows_that_are_not_live(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_status(ll_param_set(&sample_table, &s, "seed", "9", true), LL_CONFLICT, "seed",
                  "seed cannot be changed while a session runs");
    assert_status(set(&s, "seed", "9"), LL_OK, "", "");
    assert_int_equal(s.seed, 9);
    assert_status(ll_param_set(&sample_table, &s, "level", "0.5", true), LL_OK, "", "");
}

static void objects_are_merged_and_arrays_replaced(void **state)
{
    (void)state;
    sample s;
    sample_two(&s);
    assert_status(set(&s, "members.1", "{\"tries\":4,\"up\":{\"order\":\"unordered\"}}"), LL_OK, "", "");
    assert_true(s.members[1].tries == 4 && s.members[1].up.order == 0 && s.members[1].lag_ms == 20);
    assert_status(set(&s, "members", "[{\"lag_ms\":1},{\"lag_ms\":2},{\"lag_ms\":3}]"), LL_OK, "", "");
    assert_int_equal(s.count, 3);
    assert_true(s.members[2].lag_ms == 3 && s.members[1].tries == 0);
    assert_status(set(&s, "members", "[{\"lag_ms\":1},{\"lag_ms\":2000}]"), LL_BAD_INPUT, "members.1.lag_ms",
                  "members.1.lag_ms: must be 0 to 1000 ms; got 2000");
    assert_int_equal(s.count, 3);
}

static void errors_leave_the_object(void **state)
{
    (void)state;
    static const struct {
        const char *path, *value, *field, *text;
    } cases[] = {
        {"members.1.lag_ms", "fast", "members.1.lag_ms", "members.1.lag_ms: must be a number; got \"fast\""},
        {"members.1.lag_ms", "", "members.1.lag_ms", "members.1.lag_ms: must be a number; got \"\""},
        {"members.1.lag_ms", "5 6", "members.1.lag_ms", "members.1.lag_ms: must be a number; got \"5 6\""},
        {"members.1.lag_ms", "nan", "members.1.lag_ms", "members.1.lag_ms: must be a number; got \"nan\""},
        {"members.1.lag_ms", "null", "members.1.lag_ms", "members.1.lag_ms cannot be removed; got null"},
        {"members.1.tries", "2.5", "members.1.tries",
         "members.1.tries: must be a whole number from -2 to 9; got 2.5"},
        {"shape", "boxx", "shape", "shape: must be one of circle, box, point; got \"boxx\""},
        {"loud", "yes", "loud", "loud: must be true or false; got \"yes\""},
        {"members.7.lag_ms", "5", "members.7",
         "members.7 does not exist: the index in members must be 0 to 1"},
        {"levle", "5", "levle", "levle is unknown; did you mean level?"},
        {"", "5", "",
         "the empty name is unknown; known are seed, shape, params, ratio, level, members, loud"},
        {"members..lag_ms", "5", "members.", "members. does not exist: the index in members must be 0 to 1"},
        {"level.", "5", "level.", "level. is unknown: it has no members"},
        {"members.1", "5", "members.1", "members.1: must be an object; got 5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        sample s, before;
        sample_two(&s);
        memcpy(&before, &s, sizeof s);
        assert_status(set(&s, cases[i].path, cases[i].value), LL_BAD_INPUT, cases[i].field, cases[i].text);
        assert_memory_equal(&s, &before, sizeof s);
    }
}

static void find_reaches_members(void **state)
{
    (void)state;
    sample s;
    void *found = NULL;
    sample_two(&s);
    const ll_param *row = ll_param_find(&sample_table, &s, "members.1.up.order", &found);
    assert_non_null(row);
    assert_string_equal(row->name, "order");
    assert_ptr_equal(found, &s.members[1].up.order);
    row = ll_param_find(&sample_table, &s, "params.radius_m", &found);
    assert_ptr_equal(row, &circle_rows[0]);
    assert_ptr_equal(found, &s.params.circle.radius);
    row = ll_param_find(&sample_table, &s, "members.1", &found);
    assert_string_equal(row->name, "members");
    assert_ptr_equal(found, &s.members[1]);
    static const char *const none[] = {
        "",    ".",     "members.2.lag_ms", "members.one", "params.width_m", "seed.x", "members.1.", "Seed",
        "see", "seeds", "members.+1"};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        assert_null(ll_param_find(&sample_table, &s, none[i], &found));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_json_or_bare),
        cmocka_unit_test(rows_that_are_not_live),
        cmocka_unit_test(objects_are_merged_and_arrays_replaced),
        cmocka_unit_test(errors_leave_the_object),
        cmocka_unit_test(find_reaches_members),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
