/* Tables of metrics: what they write, what a path finds in them, and which tables are refused. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "record/metric.h"
#include "session/kinds.h"
#include "support/table_valid.h"

#define BOX(X)                                                                                               \
    X(text, name, NULL, label, "of the box", "It has none: left out.")                                       \
    X(number, width_m, "m", width, "of the box", "It is not known.")                                         \
    X(signed_number, drift_m, "m", -width / 4, "of the box", "It is not known.")                             \
    X(count, hits, NULL, INT64_C(3), "so far", NULL)                                                         \
    X(events, hitches, NULL, 2U, "so far", NULL)                                                             \
    X(flag, open, NULL, width > 1, "whether it is", NULL)                                                    \
    X(numbers, corner, "m", ll_metric_numbers(corner, 2), "x, y", "It is not known.")                        \
    X(distribution, way_m, "m", ((ll_metric_reading){.parts = {1, 2, 3, 4, 5, NAN, 7}}), "of the box", NULL) \
    X(gauge, lead_ms, "ms", ((ll_metric_reading){.parts = {1, 2, 3, 4}}), "of the box", NULL)                \
    X(latency, felt_ms, "ms", ((ll_metric_reading){.parts = {1, 2, 3, 4, 5, 6, 7, 0.5}}), "of the box",      \
      NULL)                                                                                                  \
    X(by_name, sides, "m", ((ll_metric_reading){.number = 2, .numbers = sides, .names = side_names}),        \
      "of the box", NULL)

static const char *const side_names[] = {"left", "right"};
static const double sides[] = {8, NAN};

#define SHELF(X) X(number, height_m, "m", 2, "of the shelf", NULL)

static const ll_metric_table box_table = {
    .path = "boxes.*", .also = "side_by_side.*", .help = "A box.", LL_METRICS_FROM(BOX)};
static const ll_metric_table shelf_table = {.path = "", .help = "All.", LL_METRICS_FROM(SHELF)};
static const ll_metric_table *const tables[] = {&shelf_table, &box_table, NULL};

static void writes(const char *label, double width, const double *corner, const char *wanted)
{
    cJSON *o = cJSON_CreateObject();
    LL_METRICS_PUT(o, &box_table, BOX);
    char *text = cJSON_PrintUnformatted(o);
    assert_string_equal(text, wanted);
    free(text);
    cJSON_Delete(o);
}

static void fields_are_written_in_order(void **state)
{
    (void)state;
    const double corner[] = {0.5, INFINITY};
    writes("lid", 2, corner,
           "{\"name\":\"lid\",\"width_m\":2,\"drift_m\":-0.5,\"hits\":3,\"hitches\":2,\"open\":true,"
           "\"corner\":[0.5,null],\"way_m\":{\"mean\":1,\"rms\":2,\"p50\":3,\"p95\":4,\"p99\":5,\"max\":null,"
           "\"count\":7},\"lead_ms\":{\"mean\":1,\"min\":2,\"max\":3,\"count\":4},\"felt_ms\":{\"mean\":1,"
           "\"rms\":2,\"p50\":3,\"p95\":4,\"p99\":5,\"max\":6,\"count\":7,\"lost_ratio\":0.5},\"sides\":{"
           "\"left\":8,\"right\":null}}");
    writes(NULL, NAN, NULL,
           "{\"width_m\":null,\"drift_m\":null,\"hits\":3,\"hitches\":2,\"open\":false,"
           "\"corner\":[null,null],\"way_m\":{\"mean\":1,\"rms\":2,\"p50\":3,\"p95\":4,\"p99\":5,"
           "\"max\":null,\"count\":7},\"lead_ms\":{\"mean\":1,\"min\":2,\"max\":3,\"count\":4},\"felt_ms\":{"
           "\"mean\":1,\"rms\":2,\"p50\":3,\"p95\":4,\"p99\":5,\"max\":6,\"count\":7,\"lost_ratio\":0.5},"
           "\"sides\":{\"left\":8,\"right\":null}}");
}

/* All 17 digits that a number takes, or the 15 of cJSON. */
static void numbers_have_their_digits(void **state)
{
    (void)state;
    ll_metric_table one = {.path = "", .help = "x", .fields = box_table.fields + 1, .count = 1};
    const ll_metric_reading third = ll_metric_number(0.1 + 0.2);
    for (int i = 0; i < 2; i++) {
        cJSON *o = cJSON_CreateObject();
        one.short_numbers = i == 1;
        ll_metrics_put(o, &one, &third);
        char *text = cJSON_PrintUnformatted(o);
        assert_string_equal(text, i == 0 ? "{\"width_m\":0.30000000000000004}" : "{\"width_m\":0.3}");
        free(text);
        cJSON_Delete(o);
    }
}

static const char *found(const char *path)
{
    const ll_metric_field *field = ll_metric_find(tables, path);
    return field != NULL ? field->name : "";
}

static void paths_find_their_field(void **state)
{
    (void)state;
    assert_string_equal(found("height_m"), "height_m");
    assert_string_equal(found("boxes.0.width_m"), "width_m");
    assert_string_equal(found("boxes.lid.way_m.p95"), "way_m");
    assert_string_equal(found("boxes.12.corner.1"), "corner");
    assert_string_equal(found("side_by_side.1.boxes.0.drift_m"), "drift_m");
    const char *const none[] = {"",
                                "boxes",
                                "boxes.0",
                                "width_m",
                                "boxes.0.width",
                                "boxes.0.width_m.mean",
                                "boxes..hits",
                                "boxes.0.0.hits",
                                "side_by_side.0.height_m",
                                "height_mm",
                                "boxes.0.width_mm"};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        if (ll_metric_find(tables, none[i]) != NULL)
            fail_msg("%s", none[i]);
    assert_true(ll_metric_find(tables, "boxes.0.drift_m")->is_signed);
    assert_false(ll_metric_find(tables, "boxes.0.hits")->rare);
    assert_true(ll_metric_find(tables, "boxes.0.hitches")->rare);
}

static void refused(const ll_metric_table *table)
{
    const ll_metric_table *const some[] = {table, NULL};
    assert_int_equal(metrics_valid(some).code, LL_BAD_INPUT);
}

static void bad_tables_are_refused(void **state)
{
    (void)state;
    assert_int_equal(metrics_valid(tables).code, LL_OK);
    const ll_metric_field good = box_table.fields[1];
    ll_metric_field fields[] = {good, good};
    ll_metric_table t = {.path = "x", .help = "x", .fields = fields, .count = 1};
    const ll_metric_table *const twice[] = {&t, &t, NULL};
    assert_int_equal(metrics_valid(twice).code, LL_BAD_INPUT);
    t.count = 2;
    refused(&t);
    t.count = 1;
    fields[0].name = "Width";
    refused(&t);
    fields[0] = good;
    fields[0].help = "";
    refused(&t);
    fields[0] = good;
    fields[0].unit = "";
    refused(&t);
    fields[0] = box_table.fields[0];
    fields[0].is_signed = true;
    refused(&t);
    fields[0] = good;
    t.help = NULL;
    refused(&t);
}

static void tables_of_the_kinds_are_sound(void **state)
{
    (void)state;
    for (int k = 0; ll_sim_kinds[k]; k++) {
        ll_status status = metrics_valid(ll_sim_kinds[k]->metric_tables);
        if (ll_failed(&status))
            fail_msg("%s: %s", ll_sim_kinds[k]->name, status.text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(fields_are_written_in_order), cmocka_unit_test(numbers_have_their_digits),
        cmocka_unit_test(paths_find_their_field), cmocka_unit_test(bad_tables_are_refused),
        cmocka_unit_test(tables_of_the_kinds_are_sound)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
