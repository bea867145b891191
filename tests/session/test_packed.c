/* A parked session keeps its configurations packed: everything that can be read of it is as before. */
#include "session/harness.h"

#include "library/library.h"

static ll_session *make(const char *id)
{
    cJSON *scenario = NULL;
    ll_session *session = NULL;
    must(ll_scenario_load("scenarios", id, &scenario));
    must(ll_session_create(scenario, 12345, NULL, NULL, &session));
    cJSON_Delete(scenario);
    return session;
}

static char *params_of(ll_session *s)
{
    cJSON *json = ll_session_params(s);
    char *text = cJSON_PrintUnformatted(json);
    cJSON_Delete(json);
    return text;
}

static void change(ll_session *s, const char *patch)
{
    cJSON *json = cJSON_Parse(patch);
    must(ll_session_patch(s, 0, json));
    cJSON_Delete(json);
}

static void reads_the_same(ll_session *s)
{
    static lines before, after, again;
    ll_session_info was = ll_session_get_info(s);
    char *title = strdup(was.title), *params = params_of(s);
    uint64_t hash = ll_session_hash(s);
    before.size = after.size = again.size = 0;
    ll_session_log(s, keep_line, &before);
    cJSON *cost = ll_session_cost(s);
    double announced = cJSON_GetObjectItem(cost, "parked_bytes")->valuedouble;
    cJSON_Delete(cost);

    ll_session_park(s);
    ll_session_info is = ll_session_get_info(s);
    assert_true(is.parked);
    assert_string_equal(is.title, title);
    assert_int_equal(is.seed, was.seed);
    assert_int_equal(ll_session_bytes(s), announced);
    ll_session_log(s, keep_line, &after); /* while it is parked */
    assert_string_equal(after.text, before.text);
    ll_session_park(s); /* again: what was read is packed once more */
    assert_int_equal(ll_session_bytes(s), announced);
    char *packed_params = params_of(s);
    assert_string_equal(packed_params, params);
    ll_session_park(s);
    ll_session *copy = NULL;
    must(ll_session_copy(s, was.tick, &copy));
    must(ll_session_run_to(copy, was.tick));
    assert_int_equal(ll_session_hash(copy), hash);
    ll_session_destroy(copy);
    ll_session_park(s);
    assert_int_equal(ll_session_hash(s), hash); /* wakes it */
    ll_session_log(s, keep_line, &again);
    assert_string_equal(again.text, before.text);
    ll_session_park(s);
    free(packed_params);
    free(params);
    free(title);
}

static void parked_sessions_read_the_same(void **state)
{
    (void)state;
    static const char *const ids[] = {"race",         "eight",         "rifle",
                                      "motion/orbit", "rigid/pyramid", "fluid/hydrostatic"};
    for (size_t i = 0; i < sizeof ids / sizeof *ids; i++) {
        ll_session *s = make(ids[i]);
        must(ll_session_run_to(s, 5));
        reads_the_same(s);
        ll_session_destroy(s);
    }
}

/* All three configurations differ: that of the scenario, of a restart, and the present one. */
static void each_configuration_is_kept(void **state)
{
    (void)state;
    ll_session *s = make("race");
    must(ll_session_run_to(s, 60));
    change(s, "{\"players.0.lag_ms\":321}");
    cJSON *restart = cJSON_Parse("{\"op\":\"restart\"}");
    must(ll_session_control(s, 0, restart));
    cJSON_Delete(restart);
    must(ll_session_run_to(s, 60));
    change(s, "{\"players.1.lag_ms\":77}");
    must(ll_session_run_to(s, 90));
    reads_the_same(s);
    cJSON *reset = cJSON_Parse("{\"op\":\"restart\",\"reset\":true}");
    must(ll_session_control(s, 0, reset));
    cJSON_Delete(reset);
    ll_session *fresh = make("race");
    char *params = params_of(s), *wanted = params_of(fresh);
    assert_string_equal(params, wanted);
    free(params);
    free(wanted);
    ll_session_destroy(fresh);
    ll_session_destroy(s);
}

static void a_parked_race_is_small(void **state)
{
    (void)state;
    ll_session *s = make("race");
    must(ll_session_run_to(s, 600));
    ll_session_park(s);
    printf("%zu bytes\n", ll_session_bytes(s));
    assert_true(ll_session_bytes(s) <= 3072);
    ll_session_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parked_sessions_read_the_same),
        cmocka_unit_test(each_configuration_is_kept),
        cmocka_unit_test(a_parked_race_is_small),
    };
    return cmocka_run_group_tests_name("packed", tests, NULL, NULL);
}
