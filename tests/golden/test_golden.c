/* Golden scenarios: the hash at the end of each, and the metrics that its `expect` names, with every compiler
 * and optimisation. `test_golden golden --update` rewrites the table; `test_golden golden 1/2` runs the first
 * of two parts of the scenarios, so that two cores share them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"
#include "support/golden.h"

#define TABLE "tests/golden/hashes.csv"

static int part, parts = 1;

static bool mine(int row)
{
    return row % parts == part;
}

static void measure(const char *id, char line[GOLDEN_LINE_MAX])
{
    ll_status status = golden_line(id, line);
    if (ll_failed(&status))
        fail_msg("%s: %s", id, status.text);
}

static FILE *open_table(const char *mode)
{
    FILE *f = fopen(TABLE, mode);
    if (!f)
        fail_msg("cannot open %s", TABLE);
    return f;
}

static void results_are_golden(void **state)
{
    (void)state;
    char want[GOLDEN_LINE_MAX], got[GOLDEN_LINE_MAX], id[64];
    int rows = 0, wrong = 0;
    FILE *f = open_table("r");
    assert_non_null(fgets(want, sizeof want, f)); /* header */
    while (fgets(want, sizeof want, f)) {
        if (!mine(rows++))
            continue;
        want[strcspn(want, "\n")] = '\0';
        assert_int_equal(sscanf(want, "%63[^,]", id), 1);
        measure(id, got);
        if (strcmp(want, got) != 0) {
            print_error("%s\n  instead of\n%s\n", got, want);
            wrong++;
        }
    }
    fclose(f);
    assert_true(rows >= 12);
    assert_int_equal(wrong, 0);
}

/* Fills the stack where the variables of the functions called next will be with `byte`. */
static __attribute__((noinline)) void paint_stack(int byte)
{
    char stack[1 << 17];
    memset(stack, byte, sizeof stack);
    __asm__ volatile("" ::"r"(stack) : "memory");
}

static uint64_t hash_on(const char *id, int byte)
{
    cJSON *json;
    ll_session *s;
    ll_status status = ll_scenario_load("scenarios", id, &json);
    assert_false(ll_failed(&status));
    status = ll_session_create(json, -1, NULL, NULL, &s);
    assert_false(ll_failed(&status));
    int64_t end = ll_session_get_info(s).end_tick;
    for (int64_t tick = 1; tick <= (end < 90 ? end : 90); tick++) {
        paint_stack(byte);
        ll_session_run_to(s, tick);
    }
    uint64_t hash = ll_session_hash(s);
    ll_session_destroy(s);
    cJSON_Delete(json);
    return hash;
}

/* A variable that is read before it is written would carry bytes of the stack into the state. */
static void nothing_is_left_to_chance(void **state)
{
    (void)state;
    cJSON *list, *item;
    int row = 0;
    ll_status status = ll_scenario_list("scenarios", &list);
    assert_false(ll_failed(&status));
    cJSON_ArrayForEach(item, list)
    {
        const char *id = cJSON_GetObjectItem(item, "id")->valuestring;
        if (mine(row++) && hash_on(id, 0) != hash_on(id, 0xa5))
            fail_msg("%s reads uninitialised memory", id);
    }
    cJSON_Delete(list);
}

/* Each scenario of the library has a row. */
static void every_scenario_is_in_the_table(void **state)
{
    (void)state;
    cJSON *list, *item;
    static char text[1 << 17];
    FILE *f = open_table("r");
    size_t n = fread(text, 1, sizeof text - 1, f);
    text[n] = '\0';
    fclose(f);
    ll_status status = ll_scenario_list("scenarios", &list);
    assert_false(ll_failed(&status));
    cJSON_ArrayForEach(item, list)
    {
        char start[160];
        snprintf(start, sizeof start, "\n%s,", cJSON_GetObjectItem(item, "id")->valuestring);
        if (!strstr(text, start))
            fail_msg("%s has no golden hash; add it by test_golden golden --update", start + 1);
    }
    cJSON_Delete(list);
}

static void update(void)
{
    cJSON *list, *item;
    FILE *f = open_table("w");
    ll_status status = ll_scenario_list("scenarios", &list);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
    fprintf(f, "scenario,tick,hash,activity\n");
    cJSON_ArrayForEach(item, list)
    {
        char line[GOLDEN_LINE_MAX];
        measure(cJSON_GetObjectItem(item, "id")->valuestring, line);
        fprintf(f, "%s\n", line);
    }
    fclose(f);
    cJSON_Delete(list);
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "--update") == 0) {
        update();
        return 0;
    }
    if (argc > 1) {
        assert_int_equal(sscanf(argv[1], "%d/%d", &part, &parts), 2);
        assert_in_range(part--, 1, parts);
    }
    const struct CMUnitTest tests[] = {cmocka_unit_test(results_are_golden),
                                       cmocka_unit_test(nothing_is_left_to_chance),
                                       cmocka_unit_test(every_scenario_is_in_the_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
