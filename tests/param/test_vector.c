/* Pairs, lists of points and of numbers: read, written, refused, described. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "param/param.h"

typedef struct body {
    double place[2];
    double corners[4][2];
    int32_t count, numbers;
    double list[3];
} body;

static const ll_param rows[] = {
    {.name = "place",
     .type = LL_PARAM_VECTOR,
     .offset = offsetof(body, place),
     .min = -5,
     .max = 5,
     .vector = {1, -2},
     .unit = "m",
     .live = true,
     .help = "Where."},
    {.name = "corners",
     .type = LL_PARAM_POINTS,
     .offset = offsetof(body, corners),
     .max = 4,
     .default_value = 10,
     .count_offset = offsetof(body, count),
     .help = "What."},
    {.name = "list",
     .type = LL_PARAM_NUMBERS,
     .offset = offsetof(body, list),
     .max = 3,
     .vector = {-1, 100},
     .count_offset = offsetof(body, numbers),
     .unit = "ms",
     .help = "How many."},
};

static const ll_param_table table = {
    .name = "body", .help = "A body.", .rows = rows, .count = 3, .size = sizeof(body)};

static ll_status parse(const char *text, body *b)
{
    cJSON *json = cJSON_Parse(text);
    ll_param_defaults(&table, b);
    ll_status status = ll_param_parse(&table, json, b);
    cJSON_Delete(json);
    return status;
}

static void defaults_and_values_are_read_and_written(void **state)
{
    (void)state;
    body b;
    ll_status status = ll_param_table_valid(&table);
    assert_false(ll_failed(&status));
    status = parse("{}", &b);
    assert_false(ll_failed(&status));
    assert_true(b.place[0] == 1 && b.place[1] == -2 && b.count == 0);
    status = parse("{\"place\":[0.1,5],\"corners\":[[0,0],[10,0.25],[0,-10]]}", &b);
    assert_false(ll_failed(&status));
    assert_true(b.place[0] == 0.1 && b.place[1] == 5);
    assert_true(b.count == 3 && b.corners[1][0] == 10 && b.corners[1][1] == 0.25 && b.corners[2][1] == -10);
    cJSON *json = ll_param_write(&table, &b);
    char *text = cJSON_PrintUnformatted(json);
    assert_string_equal(text, "{\"place\":[0.1,5],\"corners\":[[0,0],[10,0.25],[0,-10]],\"list\":[]}");
    cJSON_free(text);
    cJSON_Delete(json);
}

static void numbers_are_read_and_written(void **state)
{
    (void)state;
    body b, once;
    ll_status status = parse("{\"list\":[1,-1,0.1]}", &b);
    assert_false(ll_failed(&status));
    assert_true(b.numbers == 3 && b.list[0] == 1 && b.list[1] == -1 && b.list[2] == 0.1);
    cJSON *json = ll_param_write(&table, &b);
    char *text = cJSON_PrintUnformatted(json);
    assert_string_equal(text, "{\"place\":[1,-2],\"corners\":[],\"list\":[1,-1,0.1]}");
    cJSON_free(text);
    cJSON_Delete(json);
    status = ll_param_set(&table, &b, "list", "[7]", false); /* the same bytes as if read at once */
    assert_false(ll_failed(&status));
    status = parse("{\"list\":[7]}", &once);
    assert_false(ll_failed(&status));
    assert_memory_equal(&b, &once, sizeof b);
}

static void what_does_not_fit_is_refused(void **state)
{
    (void)state;
    static const char *const wrong[][2] = {
        {"{\"place\":[1]}", "place: must be a pair [x, y] of numbers from -5 to 5 m; got an array"},
        {"{\"place\":[6, 1e30]}", "place: must be a pair [x, y] of numbers from -5 to 5 m; got [6, 1e+30]"},
        {"{\"list\":[1,2,3,4]}", "list: must have at most 3 numbers; got 4"},
        {"{\"list\":[1,101]}", "list.1: must be -1 to 100 ms; got 101"},
        {"{\"list\":[1,1e999]}", "list.1: must be"},
        {"{\"list\":[\"1\"]}", "list.0: must be a number; got \"1\""},
        {"{\"list\":7}", "list: must be an array of numbers; got 7"},
        {"{\"place\":[1,2,3]}", "place: must be a pair"},
        {"{\"place\":[1,6]}", "place: must be a pair"},
        {"{\"place\":[1,1e999]}", "place: must be a pair"},
        {"{\"place\":\"here\"}", "place: must be a pair [x, y] of numbers from -5 to 5 m; got \"here\""},
        {"{\"corners\":[[0,0],[11,0]]}",
         "corners: must be an array of pairs [x, y] of numbers from -10 to 10"},
        {"{\"corners\":[[0,0],[0,0],[0,0],[0,0],[0,0]]}", "corners: must have at most 4 points; got 5"},
        {"{\"corners\":{}}", "corners: must be an array of points"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        body b;
        ll_status status = parse(wrong[i][0], &b);
        assert_int_equal(status.code, LL_BAD_INPUT);
        if (strstr(status.text, wrong[i][1]) != status.text)
            fail_msg("%s: %s", wrong[i][0], status.text);
        assert_true(b.place[0] == 1 && b.count == 0);
    }
}

static void a_pair_is_set_and_patched_as_one_value(void **state)
{
    (void)state;
    body b;
    ll_param_defaults(&table, &b);
    ll_status status = ll_param_set(&table, &b, "place", "[3,4]", true);
    assert_false(ll_failed(&status));
    assert_true(b.place[0] == 3 && b.place[1] == 4);
    status = ll_param_set(&table, &b, "corners", "[[1,2]]", true);
    assert_int_equal(status.code, LL_CONFLICT);
    status = ll_param_set(&table, &b, "corners", "[[1,2]]", false);
    assert_false(ll_failed(&status));
    assert_true(b.count == 1 && b.corners[0][1] == 2);
}

static void the_schema_tells_their_form(void **state)
{
    (void)state;
    cJSON *schema = ll_param_schema(&table);
    const cJSON *properties = cJSON_GetObjectItem(schema, "properties");
    char *text = cJSON_PrintUnformatted(cJSON_GetObjectItem(properties, "place"));
    assert_string_equal(text,
                        "{\"type\":\"array\",\"minItems\":2,\"maxItems\":2,\"items\":{\"type\":\"number\","
                        "\"minimum\":-5,\"maximum\":5},\"default\":[1,-2],\"description\":\"Where.\","
                        "\"x-unit\":\"m\",\"x-live\":true}");
    cJSON_free(text);
    text = cJSON_PrintUnformatted(cJSON_GetObjectItem(properties, "corners"));
    assert_string_equal(text,
                        "{\"type\":\"array\",\"minItems\":0,\"maxItems\":4,\"items\":{\"type\":\"array\","
                        "\"minItems\":2,\"maxItems\":2,\"items\":{\"type\":\"number\",\"minimum\":-10,"
                        "\"maximum\":10}},\"description\":\"What.\",\"x-live\":false}");
    cJSON_free(text);
    cJSON_Delete(schema);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_and_values_are_read_and_written),
        cmocka_unit_test(numbers_are_read_and_written),
        cmocka_unit_test(what_does_not_fit_is_refused),
        cmocka_unit_test(a_pair_is_set_and_patched_as_one_value),
        cmocka_unit_test(the_schema_tells_their_form),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
