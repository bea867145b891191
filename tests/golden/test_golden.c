/* Golden scenarios: the hash at the end of each, on every compiler and optimisation. `test_golden --update`
 * writes the table anew. */
#include <inttypes.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "session/scenario.h"
#include "session/session.h"

#define TABLE "tests/golden/hashes.csv"

typedef struct row {
    char scenario[64];
    int64_t seed, tick;
    uint64_t hash;
    double moved; /* the precondition: so far the first player has come, so that something did happen */
} row;

static row measure(const char *id, int64_t seed, int64_t tick)
{
    row r = {.seed = seed, .tick = tick};
    cJSON *json;
    ll_session *s = NULL;
    snprintf(r.scenario, sizeof r.scenario, "%s", id);
    ll_status status = ll_scenario_load("scenarios", id, &json);
    if (!ll_failed(&status))
        status = ll_session_create(json, seed, NULL, NULL, &s);
    if (!ll_failed(&status))
        status = ll_session_run_to(s, tick);
    if (ll_failed(&status))
        fail_msg("%s: %s", id, status.text);
    r.hash = ll_session_hash(s);
    cJSON *state = ll_session_state(s);
    cJSON *entity = cJSON_GetArrayItem(
        cJSON_GetObjectItem(cJSON_GetObjectItem(cJSON_GetObjectItem(state, "state"), "server"), "entities"),
        0);
    r.moved = cJSON_GetObjectItem(entity, "x")->valuedouble;
    cJSON_Delete(state);
    ll_session_destroy(s);
    cJSON_Delete(json);
    return r;
}

static FILE *open_table(const char *mode)
{
    FILE *f = fopen(TABLE, mode);
    if (!f)
        fail_msg("cannot open %s", TABLE);
    return f;
}

static void hashes_are_golden(void **state)
{
    (void)state;
    char line[256];
    int rows = 0, wrong = 0;
    FILE *f = open_table("r");
    assert_non_null(fgets(line, sizeof line, f)); /* header */
    while (fgets(line, sizeof line, f)) {
        row want = {0};
        assert_int_equal(sscanf(line, "%63[^,],%" SCNd64 ",%" SCNd64 ",%" SCNx64 ",%lf", want.scenario,
                                &want.seed, &want.tick, &want.hash, &want.moved),
                         5);
        row got = measure(want.scenario, want.seed, want.tick);
        if (got.hash != want.hash) {
            print_error("%s seed %" PRId64 " tick %" PRId64 ": %016" PRIx64 " instead of %016" PRIx64 "\n",
                        want.scenario, want.seed, want.tick, got.hash, want.hash);
            wrong++;
        }
        assert_true(got.moved > 0.5 || got.moved < -0.5);
        rows++;
    }
    fclose(f);
    assert_true(rows >= 12);
    assert_int_equal(wrong, 0);
}

/* Each scenario of the library has a row. */
static void every_scenario_is_in_the_table(void **state)
{
    (void)state;
    cJSON *list, *item;
    char text[16384];
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
            fail_msg("%s has no golden hash; add it by test_golden --update", start + 1);
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
    fprintf(f, "scenario,seed,tick,hash,first_entity_x_m\n");
    cJSON_ArrayForEach(item, list)
    {
        row r = measure(cJSON_GetObjectItem(item, "id")->valuestring, 7, 480);
        fprintf(f, "%s,%" PRId64 ",%" PRId64 ",%016" PRIx64 ",%.17g\n", r.scenario, r.seed, r.tick, r.hash,
                r.moved);
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
    const struct CMUnitTest tests[] = {cmocka_unit_test(hashes_are_golden),
                                       cmocka_unit_test(every_scenario_is_in_the_table)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
