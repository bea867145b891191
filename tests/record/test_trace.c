/* Columns of traces: names and values come from the same rows. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "record/trace.h"
#include "session/kinds.h"
#include "support/table_valid.h"

static const char *const sides[] = {"left", "right"};

#define ROOM(X) X(number, height_m, "m", 2.5, "of the room", NULL)
#define BOX(X)                                                                                               \
    X(count, hits, NULL, 3 + i, "so far", NULL)                                                              \
    X(by_name, side, "m", ((ll_metric_reading){.number = 2, .numbers = widths, .names = sides}), "a side",   \
      NULL)                                                                                                  \
    X(flag, open, NULL, i == 1, "whether it is", NULL)

static const ll_metric_table room = {.path = "", .help = "All.", LL_METRICS_FROM(ROOM)};
static const ll_metric_table box = {.path = "box_*_", .help = "A box.", LL_METRICS_FROM(BOX)};

static void put(ll_trace_line *trace)
{
    const double widths[] = {8, 9};
    LL_TRACE_PUT(trace, &room, 0, ROOM);
    for (int i = 0; i < 2; i++)
        LL_TRACE_PUT(trace, &box, i, BOX);
    snprintf(trace->prefix, sizeof trace->prefix, "other_");
    LL_TRACE_PUT(trace, &room, 0, ROOM);
}

static void names_and_values_agree(void **state)
{
    (void)state;
    static const char *const wanted[] = {"height_m",   "box_0_hits",    "box_0_left", "box_0_right",
                                         "box_0_open", "box_1_hits",    "box_1_left", "box_1_right",
                                         "box_1_open", "other_height_m"};
    static const double numbers[] = {2.5, 3, 8, 9, 0, 4, 8, 9, 1, 2.5};
    static char names[LL_TRACE_COLUMNS_MAX][LL_TRACE_NAME_MAX];
    double values[LL_TRACE_COLUMNS_MAX];
    ll_trace_line header = {.names = names}, line = {.values = values};
    put(&header);
    put(&line);
    assert_int_equal(header.count, sizeof wanted / sizeof wanted[0]);
    assert_int_equal(line.count, header.count);
    for (int i = 0; i < header.count; i++) {
        assert_string_equal(names[i], wanted[i]);
        assert_true(values[i] == numbers[i]);
    }
}

static void tables_of_all_kinds_are_sound(void **state)
{
    (void)state;
    for (int i = 0; ll_sim_kinds[i]; i++) {
        ll_status status = metrics_valid(ll_sim_kinds[i]->trace_tables);
        assert_string_equal(status.text, "");
        assert_non_null(ll_sim_kinds[i]->trace_tables[0]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(names_and_values_agree),
                                       cmocka_unit_test(tables_of_all_kinds_are_sound)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
