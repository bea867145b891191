/* Transitions: seeking and waking run in pieces, can be stopped in between, and end in the same state as when
 * they run at once. */
#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"

static void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static ll_session *open_session(const char *name)
{
    cJSON *json;
    ll_session *s;
    must(ll_scenario_load("scenarios", name, &json));
    must(ll_session_create(json, 11, NULL, NULL, &s));
    cJSON_Delete(json);
    return s;
}

static void begin(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    must(ll_session_begin_control(s, 0, json));
    cJSON_Delete(json);
}

static uint64_t hash_at(const char *name, int64_t tick)
{
    ll_session *s = open_session(name);
    must(ll_session_run_to(s, tick));
    uint64_t hash = ll_session_hash(s);
    ll_session_destroy(s);
    return hash;
}

static void test_seeks_in_pieces(void **state)
{
    (void)state;
    static const int64_t targets[] = {700, 431, 432, 3, 0, 1200};
    static const int64_t pieces[] = {1, 7, 64};
    for (size_t p = 0; p < 3; p++) {
        ll_session *s = open_session("race");
        for (size_t i = 0; i < 6; i++) {
            char text[64];
            snprintf(text, sizeof text, "{\"op\":\"seek\",\"tick\":%lld}", (long long)targets[i]);
            begin(s, text);
            for (int64_t left = ll_session_due(s, 0), now; left > 0; left = now) {
                assert_true(ll_session_get_info(s).seeking);
                now = ll_session_continue(s, pieces[p]);
                assert_true(now == left - (left < pieces[p] ? left : pieces[p]));
            }
            assert_false(ll_session_get_info(s).seeking);
            assert_int_equal(ll_session_get_info(s).tick, targets[i]);
            assert_true(ll_session_hash(s) == hash_at("race", targets[i]));
        }
        ll_session_destroy(s);
    }
}

/* A change during a seek takes effect at the tick that was reached, and ends the seek. */
static void test_a_change_ends_a_seek(void **state)
{
    (void)state;
    ll_session *s = open_session("race");
    begin(s, "{\"op\":\"seek\",\"tick\":900}");
    ll_session_continue(s, 250);
    cJSON *patch = cJSON_Parse("{\"players\":{\"0\":{\"lag_ms\":77}}}");
    ll_status status = ll_session_patch(s, 0, patch);
    must(status);
    cJSON_Delete(patch);
    ll_session_info info = ll_session_get_info(s);
    assert_false(info.seeking);
    assert_int_equal(info.tick, 250);
    assert_int_equal(info.head_tick, 250);
    assert_int_equal(info.status, LL_SESSION_PAUSED);
    ll_session_destroy(s);
}

static void test_a_pause_ends_a_seek(void **state)
{
    (void)state;
    ll_session *s = open_session("race");
    must(ll_session_run_to(s, 800));
    begin(s, "{\"op\":\"seek\",\"tick\":500}");
    ll_session_continue(s, 120);
    begin(s, "{\"op\":\"pause\"}");
    assert_int_equal(ll_session_get_info(s).tick, 120);
    assert_int_equal(ll_session_get_info(s).head_tick, 800);
    assert_true(ll_session_hash(s) == hash_at("race", 120));
    ll_session_destroy(s);
}

/* While waking, a session reports its parked status, and can be parked again. */
static void test_waking_in_pieces(void **state)
{
    (void)state;
    ll_session *s = open_session("rigid/pyramid");
    must(ll_session_run_to(s, 233));
    ll_session_park(s);
    for (int round = 0; round < 2; round++) {
        must(ll_session_begin_wake(s));
        ll_session_continue(s, 90);
        ll_session_info info = ll_session_get_info(s);
        assert_true(info.parked);
        assert_int_equal(info.tick, 233);
        assert_int_equal(info.head_tick, 233);
        if (round == 0)
            ll_session_park(s);
    }
    while (ll_session_continue(s, 10) > 0)
        ;
    assert_false(ll_session_get_info(s).parked);
    assert_int_equal(ll_session_get_info(s).tick, 233);
    assert_true(ll_session_hash(s) == hash_at("rigid/pyramid", 233));
    ll_session_destroy(s);
}

static bool three_times(void *context)
{
    return (*(int *)context)++ < 3;
}

static int64_t slow_clock(void)
{
    static int64_t now;
    return now += 3000000; /* every piece takes long */
}

static void count_bytes(void *context, const char *text, size_t length)
{
    (void)text;
    *(size_t *)context += length;
}

static void test_an_interrupt_reports_progress(void **state)
{
    (void)state;
    ll_session *s = open_session("race"), *copy;
    int asked = 0;
    size_t bytes = 0;
    ll_interrupt interrupt = {three_times, slow_clock, &asked};
    must(ll_session_run_to(s, 400));
    must(ll_session_copy(s, 400, &copy));
    ll_status status = ll_session_write_trace(copy, 300, 400, &interrupt, count_bytes, &bytes);
    assert_int_equal(status.code, LL_INTERRUPTED);
    assert_non_null(strstr(status.text, "of 300"));
    assert_int_equal(asked, 4);
    ll_session_destroy(copy);
    ll_session_destroy(s);
}

/* A fork copies the present state, which must be the one that its log gives. */
static void test_a_fork_is_as_its_log(void **state)
{
    (void)state;
    static const char *const names[] = {"race", "crates", "rigid/pyramid", "fluid/cavity", "deterministic"};
    for (size_t i = 0; i < 5; i++) {
        ll_session *s = open_session(names[i]), *fork;
        must(ll_session_run_to(s, 90));
        must(ll_session_fork(s, NULL, NULL, &fork));
        uint64_t hash = ll_session_hash(fork);
        must(ll_session_run_to(fork, 130));
        must(ll_session_run_to(s, 130));
        assert_true(ll_session_hash(fork) == ll_session_hash(s));
        must(ll_session_run_to(fork, 90));
        assert_true(ll_session_hash(fork) == hash);
        ll_session_destroy(fork);
        ll_session_destroy(s);
    }
}

static int64_t page_faults(void)
{
    struct rusage usage;
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    return usage.ru_minflt;
}

static bool always(void *context)
{
    (void)context;
    return true;
}

static int64_t no_time(void)
{
    return 0;
}

static int64_t tick_on_a_copy(ll_session *s)
{
    ll_interrupt interrupt = {always, no_time, NULL};
    ll_background_tick *tick;
    must(ll_session_begin_background_tick(s, 0, &tick));
    assert_non_null(tick);
    ll_background_tick_run(tick, &interrupt);
    return ll_session_end_background_tick(s, tick, 0);
}

static int64_t tick_or_restore(ll_session *s)
{
    ll_interrupt interrupt = {always, no_time, NULL};
    bool interrupted;
    ll_session_set_interrupt(s, &interrupt);
    int64_t due = ll_session_advance_or_restore(s, 0, 1, &interrupted);
    ll_session_set_interrupt(s, NULL);
    assert_false(interrupted);
    return due;
}

/* Ticks on a copy of a large state: the pages of the copy are not requested again for each. */
static void test_a_copy_keeps_its_pages(void **state)
{
    (void)state;
    int64_t (*const ways[])(ll_session *) = {tick_on_a_copy, tick_or_restore};
    uint64_t wanted = hash_at("crates", 140);
    mallopt(M_MMAP_THRESHOLD, 128 << 10); /* as in the daemon */
    for (size_t i = 0; i < 2; i++) {
        ll_session *s = open_session("crates");
        must(ll_session_run_to(s, 20));
        begin(s, "{\"op\":\"seek\",\"tick\":140}");
        ways[i](s);
        int64_t before = page_faults(), pages = (int64_t)ll_session_bytes(s) / 4096;
        while (ways[i](s) > 0)
            ;
        int64_t faults = page_faults() - before;
        printf("%lld faults in 119 ticks of a session of %lld pages\n", (long long)faults, (long long)pages);
#ifndef __SANITIZE_ADDRESS__ /* which keeps what is freed */
        assert_true(faults < pages);
#endif
        assert_true(ll_session_hash(s) == wanted);
        ll_session_destroy(s);
    }
}

static bool begins_a_tick(ll_session *s, ll_time wall)
{
    ll_background_tick *tick;
    must(ll_session_begin_background_tick(s, wall, &tick));
    ll_background_tick_free(tick);
    return tick != NULL;
}

/* Of a paused session, before the time of the next tick, and of a parked session. */
static void test_a_tick_that_is_not_due_does_not_begin(void **state)
{
    (void)state;
    ll_session *s = open_session("crates");
    must(ll_session_run_to(s, 20));
    assert_false(begins_a_tick(s, LL_SECOND));
    begin(s, "{\"op\":\"play\"}");
    assert_false(begins_a_tick(s, 0));
    assert_true(begins_a_tick(s, LL_SECOND));
    ll_session_park(s);
    assert_false(begins_a_tick(s, LL_SECOND));
    ll_session_destroy(s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_seeks_in_pieces),
        cmocka_unit_test(test_a_change_ends_a_seek),
        cmocka_unit_test(test_a_pause_ends_a_seek),
        cmocka_unit_test(test_waking_in_pieces),
        cmocka_unit_test(test_an_interrupt_reports_progress),
        cmocka_unit_test(test_a_fork_is_as_its_log),
        cmocka_unit_test(test_a_copy_keeps_its_pages),
        cmocka_unit_test(test_a_tick_that_is_not_due_does_not_begin),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
