#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "param/sample.h"

static cJSON *schema;

static int make(void **state)
{
    (void)state;
    schema = ll_param_schema(&sample_table);
    return schema == NULL;
}

static int drop(void **state)
{
    (void)state;
    cJSON_Delete(schema);
    return 0;
}

/* The text of what stands at a path such as `properties/seed`. */
static void assert_at(const char *path, const char *want)
{
    char names[200];
    snprintf(names, sizeof names, "%s", path);
    const cJSON *at = schema;
    for (char *name = strtok(names, "/"); name != NULL; name = strtok(NULL, "/")) {
        at = cJSON_IsArray(at) ? cJSON_GetArrayItem(at, atoi(name))
                               : cJSON_GetObjectItemCaseSensitive(at, name);
        assert_non_null(at);
    }
    char *text = cJSON_PrintUnformatted(at);
    assert_string_equal(text, want);
    free(text);
}

static void values_have_type_range_default_unit(void **state)
{
    (void)state;
    assert_at("properties/seed",
              "{\"type\":\"integer\",\"minimum\":0,\"maximum\":9007199254740991,\"default\":7,"
              "\"description\":\"Seed.\",\"x-live\":false}");
    assert_at("properties/level", "{\"type\":\"number\",\"minimum\":0.1,\"maximum\":0.9,\"default\":0.3,"
                                  "\"description\":\"Level.\",\"x-live\":true}");
    assert_at("properties/ratio",
              "{\"type\":\"number\",\"default\":0,\"description\":\"Any number.\",\"x-live\":true}");
    assert_at("properties/loud",
              "{\"type\":\"boolean\",\"default\":false,\"description\":\"Loud.\",\"x-live\":true}");
    assert_at("properties/shape",
              "{\"type\":\"string\",\"enum\":[\"circle\",\"box\",\"point\"],\"default\":\"circle\","
              "\"description\":\"Shape.\",\"x-live\":true}");
    assert_at("$defs/wire/properties/jitter_ms",
              "{\"type\":\"number\",\"minimum\":0,\"maximum\":500,\"default\":0,\"description\":\"Jitter.\","
              "\"x-unit\":\"ms\",\"x-live\":true}");
    assert_at("$defs/wire/properties/order/default", "\"fifo\"");
    assert_at("$defs/member/properties/name",
              "{\"type\":\"string\",\"minLength\":1,\"maxLength\":8,"
              "\"pattern\":\"^[^\\\\u0000-\\\\u001f\\\\u007f-\\\\u009f]*$\",\"default\":\"anna\","
              "\"description\":\"Name.\",\"x-live\":true}");
    /* what must be given has no default */
    assert_at(
        "$defs/member/properties/lag_ms",
        "{\"type\":\"number\",\"minimum\":0,\"maximum\":1000,\"description\":\"Lag.\",\"x-unit\":\"ms\","
        "\"x-live\":true}");
}

static void nested_tables_are_definitions(void **state)
{
    (void)state;
    assert_at("$schema", "\"https://json-schema.org/draft/2020-12/schema\"");
    assert_at("title", "\"sample\"");
    assert_at("description", "\"A sample.\"");
    assert_at("type", "\"object\"");
    assert_at("additionalProperties", "false");
    assert_at("required", "[\"members\"]");
    assert_at("properties/members", "{\"type\":\"array\",\"minItems\":1,\"maxItems\":3,"
                                    "\"items\":{\"$ref\":\"#/$defs/member\"},\"description\":\"Members.\","
                                    "\"x-live\":true}");
    assert_at("$defs/member/required", "[\"lag_ms\"]");
    assert_at("$defs/member/additionalProperties", "false");
    assert_at("$defs/member/description", "\"A member.\"");
    assert_at("$defs/member/properties/up",
              "{\"$ref\":\"#/$defs/wire\",\"description\":\"Up.\",\"x-live\":true}");
    assert_at("$defs/member/properties/down/x-live", "false");
    assert_null(cJSON_GetObjectItemCaseSensitive(cJSON_GetObjectItem(schema, "$defs"), "wire_2"));
}

static void variants_are_tied_to_their_choice(void **state)
{
    (void)state;
    assert_at("properties/params",
              "{\"anyOf\":[{\"$ref\":\"#/$defs/circle\"},{\"$ref\":\"#/$defs/box\"},{\"type\":\"object\","
              "\"maxProperties\":0}],\"description\":\"The shape's own.\",\"x-live\":true}");
    /* the circle is the default: it also holds where no shape is named */
    assert_at("allOf/0", "{\"if\":{\"properties\":{\"shape\":{\"const\":\"circle\"}}},"
                         "\"then\":{\"properties\":{\"params\":{\"$ref\":\"#/$defs/circle\"}}}}");
    assert_at("allOf/1", "{\"if\":{\"properties\":{\"shape\":{\"const\":\"box\"}},\"required\":[\"shape\"]},"
                         "\"then\":{\"properties\":{\"params\":{\"$ref\":\"#/$defs/box\"}}}}");
    assert_at("allOf/2",
              "{\"if\":{\"properties\":{\"shape\":{\"const\":\"point\"}},\"required\":[\"shape\"]},"
              "\"then\":{\"properties\":{\"params\":{\"type\":\"object\",\"maxProperties\":0}}}}");
}

static void two_tables_of_one_name_are_told_apart(void **state)
{
    (void)state;
    static const ll_param_table other = {
        .name = "wire", .help = "Another.", .rows = circle_rows, .count = 1, .size = sizeof(circle)};
    static const ll_param rows[] = {
        {.name = "a", .type = LL_PARAM_OBJECT, .child = &wire_table, .help = "A."},
        {.name = "b", .type = LL_PARAM_OBJECT, .offset = sizeof(wire), .child = &other, .help = "B."},
    };
    static const ll_param_table both = {
        .name = "both", .help = "Both.", .rows = rows, .count = 2, .size = sizeof(wire) + sizeof(circle)};
    cJSON *json = ll_param_schema(&both);
    char *text = cJSON_PrintUnformatted(json);
    assert_non_null(strstr(text, "\"b\":{\"$ref\":\"#/$defs/wire_2\""));
    assert_non_null(strstr(text, "\"wire_2\":{\"description\":\"Another.\""));
    free(text);
    cJSON_Delete(json);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_have_type_range_default_unit),
        cmocka_unit_test(nested_tables_are_definitions),
        cmocka_unit_test(variants_are_tied_to_their_choice),
        cmocka_unit_test(two_tables_of_one_name_are_told_apart),
    };
    return cmocka_run_group_tests(tests, make, drop);
}
