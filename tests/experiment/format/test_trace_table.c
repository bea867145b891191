/* Traces as tables: of a part of a run they have the rows of that part, events each once, and no more rows
 * than are allowed. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include "experiment/fixture.h"
#include "experiment/format/trace_table.h"

enum { TICKS = 240, COLUMNS_MAX = 80 };

static ll_session *session_of(void)
{
    ll_session *session;
    cJSON *json = cJSON_Parse("{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":4,\"players\":["
                              "{\"lag_ms\":150,\"lane\":0,\"prediction\":true,\"reconciliation\":true,"
                              "\"link\":{\"up\":{\"loss_pct\":10}}},"
                              "{\"lag_ms\":100,\"lane\":0,\"script\":\"steady\"}]}");
    assert_non_null(json);
    must(ll_session_create(json, 3, NULL, NULL, &session));
    must(ll_session_run_to(session, TICKS));
    cJSON_Delete(json);
    return session;
}

/* Number of rows, the ticks of the first and the last, and the sum of all numbers in them. */
typedef struct summary {
    int64_t rows, first, last;
    double sum;
} summary;

static ll_status read_all(ll_session *session, const ll_trace_request *request, summary *s)
{
    ll_session *copy = NULL;
    ll_trace_table *made = NULL;
    ll_cell cells[COLUMNS_MAX];
    *s = (summary){.first = -1};
    must(ll_session_copy(session, request->to, &copy));
    ll_status status = ll_trace_table_new(copy, request, &made);
    if (!ll_failed(&status)) {
        const ll_table *table = ll_trace_table_get(made);
        assert_in_range(table->column_count, 3, COLUMNS_MAX);
        while (table->next(table->context, cells, &status)) {
            s->last = (int64_t)cells[1].number;
            s->first = s->rows++ == 0 ? s->last : s->first;
            for (int i = 0; i < table->column_count; i++)
                s->sum += table->columns[i].type == LL_CELL_TEXT || cells[i].null ? 0 : cells[i].number;
        }
    }
    ll_trace_table_free(made);
    ll_session_destroy(copy);
    return status;
}

static void parts_of_a_trace_are_the_whole(void **state)
{
    (void)state;
    static const char *const records[] = {NULL, "entities", "events", "packets", "corrections"};
    ll_session *session = session_of();
    for (size_t i = 0; i < sizeof records / sizeof records[0]; i++) {
        summary whole, early, late;
        ll_trace_request request = {.of = records[i], .name = "of", .to = TICKS};
        must(read_all(session, &request, &whole));
        request.to = 99;
        must(read_all(session, &request, &early));
        request.from = 100;
        request.to = TICKS;
        must(read_all(session, &request, &late));
        assert_true(whole.rows > 0);
        assert_int_equal(early.rows + late.rows, whole.rows);
        assert_true(early.rows == 0 || early.last <= 99);
        assert_true(late.rows == 0 || late.first >= 100);
        assert_float_equal(early.sum + late.sum, whole.sum,
                           1e-6 * (1 + (whole.sum < 0 ? -whole.sum : whole.sum)));
    }
    ll_session_destroy(session);
}

static void more_rows_than_allowed_are_an_error(void **state)
{
    (void)state;
    summary s;
    ll_session *session = session_of();
    ll_trace_request request = {.name = "of", .to = TICKS, .rows_max = TICKS + 1};
    must(read_all(session, &request, &s));
    assert_int_equal(s.rows, TICKS + 1);
    request.rows_max = TICKS;
    ll_status status = read_all(session, &request, &s);
    assert_string_equal(status.text, "a trace must have at most 240 rows; has more by tick 239");
    ll_session_destroy(session);
}

static void an_unknown_record_is_named(void **state)
{
    (void)state;
    ll_session *session = session_of();
    ll_status status = ll_trace_table_check(session, "of", "nothing");
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_non_null(strstr(status.text, "of: must be one of events, packets, corrections, views, entities"));
    assert_non_null(strstr(status.text, "; got nothing"));
    ll_session_destroy(session);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_of_a_trace_are_the_whole),
        cmocka_unit_test(more_rows_than_allowed_are_an_error),
        cmocka_unit_test(an_unknown_record_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
