/* A failed session is the same failure live, parked, restored, forked and copied, since the log has it. */
#include "session/harness.h"

static ll_session *open_drop(lines *log)
{
    cJSON *json = cJSON_Parse("{\"kind\":\"fluid\",\"scene\":\"drop\",\"duration_s\":2,"
                              "\"solver\":{\"method\":\"dfsph\",\"relaxation\":0.4}}");
    ll_session *s;
    must(ll_session_create(json, 5, log ? keep_line : NULL, log, &s));
    cJSON_Delete(json);
    return s;
}

/* A live change that makes the method diverge. */
static void spoil(ll_session *s, int64_t tick)
{
    cJSON *patch = cJSON_Parse("{\"solver\":{\"relaxation\":1.3}}");
    must(ll_session_run_to(s, tick));
    must(ll_session_patch(s, 0, patch));
    cJSON_Delete(patch);
}

static void order(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    must(ll_session_control(s, 0, json));
    cJSON_Delete(json);
}

static void assert_same_failure(ll_session *a, ll_session *b)
{
    ll_session_info x = ll_session_get_info(a), y = ll_session_get_info(b);
    assert_int_equal(x.status, LL_SESSION_FAILED);
    assert_int_equal(y.status, LL_SESSION_FAILED);
    assert_int_equal(x.tick, y.tick);
    assert_int_equal(x.head_tick, y.head_tick);
    assert_true(ll_session_hash(a) == ll_session_hash(b));
    assert_int_equal(ll_session_failed_at(a), ll_session_failed_at(b));
    assert_string_equal(ll_session_error(a)->text, ll_session_error(b)->text);
}

/* Runs until the failure; `log` gets all lines. */
static ll_session *failed_session(lines *log)
{
    ll_session *s = open_drop(log);
    spoil(s, 5);
    ll_status status = ll_session_run_to(s, 100);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_int_equal(ll_session_get_info(s).status, LL_SESSION_FAILED);
    assert_in_range(ll_session_get_info(s).tick, 5, 99);
    assert_non_null(strstr(log->text, "{\"op\":\"fail\""));
    return s;
}

static void test_how_it_is_driven_does_not_matter(void **state)
{
    (void)state;
    lines a_log = {.size = 0};
    ll_session *a = failed_session(&a_log), *b = open_drop(NULL), *c = open_drop(NULL);
    spoil(b, 5);
    for (int64_t tick = 6; ll_session_get_info(b).status != LL_SESSION_FAILED; tick++)
        ll_session_run_to(b, tick);
    spoil(c, 5);
    order(c, "{\"op\":\"play\"}");
    for (ll_time wall = 0; ll_session_get_info(c).status != LL_SESSION_FAILED; wall += 23 * LL_MS)
        ll_session_advance(c, wall, 2);
    assert_same_failure(a, b);
    assert_same_failure(a, c);
    ll_session_destroy(a);
    ll_session_destroy(b);
    ll_session_destroy(c);
}

static void test_log_fork_and_sleep_keep_it(void **state)
{
    (void)state;
    lines log = {.size = 0}, all = {.size = 0}, copied = {.size = 0};
    ll_session *s = failed_session(&log), *restored, *again, *fork, *of_fork;
    must(ll_session_restore(log.text, log.size, NULL, NULL, &restored));
    assert_int_equal(ll_session_get_info(restored).status, LL_SESSION_FAILED);
    assert_same_failure(s, restored);
    ll_session_log(s, keep_line, &all);
    must(ll_session_restore(all.text, all.size, NULL, NULL, &again));
    assert_same_failure(s, again);
    must(ll_session_fork(s, keep_line, &copied, &fork));
    assert_same_failure(s, fork);
    must(ll_session_restore(copied.text, copied.size, NULL, NULL, &of_fork));
    assert_same_failure(s, of_fork);
    ll_session_park(fork);
    assert_int_equal(ll_session_get_info(fork).status, LL_SESSION_FAILED);
    assert_same_failure(s, fork);
    ll_session *all_of_them[] = {s, restored, again, fork, of_fork};
    for (size_t i = 0; i < 5; i++)
        ll_session_destroy(all_of_them[i]);
}

/* A change before the failure drops it; so does the log. */
static void test_a_change_before_it_takes_it_back(void **state)
{
    (void)state;
    lines log = {.size = 0};
    ll_session *s = failed_session(&log), *restored;
    order(s, "{\"op\":\"seek\",\"tick\":5}");
    assert_int_equal(ll_session_get_info(s).status, LL_SESSION_PAUSED);
    cJSON *patch = cJSON_Parse("{\"solver\":{\"relaxation\":0.5}}");
    must(ll_session_patch(s, 0, patch));
    cJSON_Delete(patch);
    assert_int_equal(ll_session_failed_at(s), -1);
    must(ll_session_run_to(s, 30));
    must(ll_session_restore(log.text, log.size, NULL, NULL, &restored));
    assert_int_equal(ll_session_get_info(restored).status, LL_SESSION_PAUSED);
    must(ll_session_run_to(restored, 30));
    assert_true(ll_session_hash(s) == ll_session_hash(restored));
    ll_session_destroy(s);
    ll_session_destroy(restored);
}

/* The failure is logged only once, also when a replay fails again. */
static void test_failure_is_logged_once(void **state)
{
    (void)state;
    lines log = {.size = 0};
    ll_session *s = failed_session(&log);
    order(s, "{\"op\":\"seek\",\"tick\":2}");
    assert_null(ll_session_error(s));
    lines written = {.size = 0};
    ll_session_log(s, keep_line, &written);
    char reason[400]; /* before it comes again, the log has it whole */
    snprintf(reason, sizeof reason, "%s", strstr(log.text, "{\"op\":\"fail\""));
    reason[strcspn(reason, "\n")] = '\0';
    assert_non_null(strstr(written.text, reason));
    assert_int_equal(ll_session_run_to(s, 90).code, LL_DIVERGED);
    int told = 0;
    for (const char *at = log.text; (at = strstr(at, "{\"op\":\"fail\"")); at++)
        told++;
    assert_int_equal(told, 1);
    ll_session_destroy(s);
}

/* A session may stand at the tick after which it failed without having failed again. */
static void test_position_of_a_failure(void **state)
{
    (void)state;
    lines log = {.size = 0};
    ll_session *s = failed_session(&log), *restored;
    int64_t tick = ll_session_failed_at(s);
    for (int more = 0; more < 3; more++) {
        must(ll_session_restore(log.text, log.size, NULL, NULL, &restored));
        ll_session_set_position(restored, 0,
                                &(ll_session_position){.tick = more < 2 ? tick + more : -1, .head = tick});
        assert_int_equal(ll_session_get_info(restored).tick, tick);
        assert_int_equal(ll_session_get_info(restored).status,
                         more > 0 ? LL_SESSION_FAILED : LL_SESSION_PAUSED);
        assert_int_equal(ll_session_hash(restored) == ll_session_hash(s), more > 0);
        if (more == 0)
            assert_int_equal(ll_session_run_to(restored, 90).code, LL_DIVERGED);
        assert_true(ll_session_hash(restored) == ll_session_hash(s));
        ll_session_destroy(restored);
    }
    ll_session_destroy(s);
}

/* The log of another version, or an edited one: its failure does not come again. */
static void test_a_failure_that_does_not_come_is_dropped(void **state)
{
    (void)state;
    static const char edited[] = "{\"op\":\"create\",\"laglab_log\":1,\"scenario\":{\"kind\":\"netgame\","
                                 "\"duration_s\":4,\"players\":[{}]}}\n"
                                 "{\"op\":\"fail\",\"tick\":33,\"detail\":\"no number\"}";
    lines log = {.size = 0}, heard = {.size = 0}, all = {.size = 0};
    keep_line(&log, edited, sizeof edited - 1);
    ll_session *s, *restored, *again;
    must(ll_session_restore(log.text, log.size, keep_line, &heard, &s));
    assert_int_equal(ll_session_get_info(s).status, LL_SESSION_FAILED);
    assert_int_equal(ll_session_get_info(s).tick, 33);
    must(ll_session_run_to(s, 33)); /* it does not fail before its tick ... */
    must(ll_session_run_to(s, 57)); /* ... nor after it */
    assert_int_equal(ll_session_failed_at(s), -1);
    ll_session_log(s, keep_line, &all);
    assert_null(strstr(all.text, "fail"));
    must(ll_session_restore(all.text, all.size, NULL, NULL, &restored));
    assert_int_equal(ll_session_get_info(restored).tick, 57);
    const char *later = strchr(heard.text, '\n') + 1; /* a stored log: what was there, then what was heard */
    keep_line(&log, later, strlen(later) - 1);
    must(ll_session_restore(log.text, log.size, NULL, NULL, &again));
    ll_session *both[] = {restored, again};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(ll_session_get_info(both[i]).status, LL_SESSION_PAUSED);
        must(ll_session_run_to(both[i], 57));
        assert_true(ll_session_hash(both[i]) == ll_session_hash(s));
        ll_session_destroy(both[i]);
    }
    ll_session_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_how_it_is_driven_does_not_matter),
        cmocka_unit_test(test_log_fork_and_sleep_keep_it),
        cmocka_unit_test(test_a_change_before_it_takes_it_back),
        cmocka_unit_test(test_failure_is_logged_once),
        cmocka_unit_test(test_position_of_a_failure),
        cmocka_unit_test(test_a_failure_that_does_not_come_is_dropped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
