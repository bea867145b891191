/* A session is its log: the same log gives the same state, whether it is paced, replayed, restored or
 * forked. */
#include "library/library.h"
#include "session/harness.h"

#include "session/frame.h"
#include "support/near.h"

static ll_session *open_session(lines *log)
{
    cJSON *json;
    ll_session *s;
    must(ll_scenario_load("scenarios", "race", &json));
    must(ll_session_create(json, 7, log ? keep_line : NULL, log, &s));
    cJSON_Delete(json);
    return s;
}

static ll_status control(ll_session *s, ll_time wall, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_session_control(s, wall, json);
    cJSON_Delete(json);
    return status;
}

static ll_status patch(ll_session *s, const char *text)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_session_patch(s, 0, json);
    cJSON_Delete(json);
    return status;
}

/* A run with commands at ticks 100, 200, 250 and 400. */
static void play_story(ll_session *s)
{
    const ll_action full = {.axis = {1, 0}}, half = {.axis = {0.5f, 0}};
    must(ll_session_run_to(s, 100));
    must(patch(s, "{\"players\":{\"0\":{\"lag_ms\":40,\"control\":\"person\"}}}"));
    must(ll_session_input(s, 0, 0, &full));
    must(ll_session_run_to(s, 200));
    must(patch(s, "{\"players\":[{},{\"prediction\":true,\"link\":{\"up\":{\"loss_pct\":5}}}]}"));
    must(ll_session_run_to(s, 250));
    must(ll_session_input(s, 0, 0, &half));
    must(ll_session_run_to(s, 400));
    must(patch(s, "{\"server.update_hz\":10}"));
    must(ll_session_run_to(s, 600));
}

static void same_hash_in_one_go_and_in_pieces(void **state)
{
    (void)state;
    ll_session *a = open_session(NULL), *b = open_session(NULL);
    must(ll_session_run_to(a, 600));
    for (int64_t t = 1; t <= 600; t += 7)
        must(ll_session_run_to(b, t));
    must(ll_session_run_to(b, 600));
    assert_int_equal(ll_session_hash(a), ll_session_hash(b));
    ll_session_destroy(a);
    ll_session_destroy(b);
}

static void paced_is_unpaced(void **state)
{
    (void)state;
    ll_session *a = open_session(NULL), *b = open_session(NULL);
    ll_time wall = 123456789;
    must(control(a, wall, "{\"op\":\"play\"}"));
    for (int i = 0; i < 150; i++) { /* an uneven 10 s at speed 1, then the rest at speed 4 */
        wall += (i % 3) * 7 * LL_MS + 60 * LL_MS;
        ll_session_advance(a, wall, 1000);
    }
    must(control(a, wall, "{\"op\":\"speed\",\"speed\":4}"));
    while (ll_session_get_info(a).status == LL_SESSION_PLAYING)
        ll_session_advance(a, wall += 16 * LL_MS, 1000);
    assert_int_equal(ll_session_get_info(a).status, LL_SESSION_ENDED);
    must(ll_session_run_to(b, 3600));
    assert_int_equal(ll_session_hash(a), ll_session_hash(b));
    ll_session_destroy(a);
    ll_session_destroy(b);
}

static void advance_is_bounded_and_catches_up(void **state)
{
    (void)state;
    ll_session *s = open_session(NULL);
    must(control(s, 0, "{\"op\":\"play\"}"));
    assert_int_equal(ll_session_advance(s, 10 * LL_SECOND, 100), 500);
    assert_int_equal(ll_session_get_info(s).tick, 100);
    assert_int_equal(ll_session_advance(s, 10 * LL_SECOND, 1000), 0);
    assert_int_equal(ll_session_get_info(s).tick, 600);
    ll_session_destroy(s);
}

static void play_until_a_tick_pauses_there(void **state)
{
    (void)state;
    ll_session *s = open_session(NULL), *t = open_session(NULL);
    must(control(s, 0, "{\"op\":\"play\",\"until_tick\":19}"));
    assert_int_equal(ll_session_advance(s, LL_SECOND / 10, 1000), 0);
    assert_int_equal(ll_session_get_info(s).status, LL_SESSION_PLAYING);
    must(control(s, LL_SECOND / 10, "{\"op\":\"speed\",\"speed\":2}")); /* keeps the stop */
    assert_int_equal(ll_session_advance(s, 10 * LL_SECOND, 5), 8);      /* 6 + 5 of 19 */
    assert_int_equal(ll_session_advance(s, 10 * LL_SECOND, 1000), 0);
    assert_int_equal(ll_session_get_info(s).tick, 19);
    assert_int_equal(ll_session_get_info(s).status, LL_SESSION_PAUSED);
    must(ll_session_run_to(t, 19));
    assert_int_equal(ll_session_hash(s), ll_session_hash(t));
    static const char *const passed[] = {"{\"op\":\"play\",\"until_tick\":19}",
                                         "{\"op\":\"play\",\"until_tick\":3601}"};
    for (int i = 0; i < 2; i++) {
        ll_status status = control(s, 0, passed[i]);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_string_equal(status.field, "until_tick");
    }
    must(control(s, 0, "{\"op\":\"play\",\"until_tick\":30}"));
    must(control(s, 0, "{\"op\":\"play\"}")); /* without a stop */
    ll_session_advance(s, LL_SECOND, 1000);
    assert_true(ll_session_get_info(s).tick > 30);
    ll_session_destroy(s);
    ll_session_destroy(t);
}

static void seeking_gives_the_same_states(void **state)
{
    (void)state;
    uint64_t hash[601];
    ll_session *s = open_session(NULL), *t = open_session(NULL);
    play_story(s);
    uint64_t end = ll_session_hash(s);
    must(control(s, 0, "{\"op\":\"seek\",\"tick\":0}"));
    for (int64_t k = 0; k <= 600; k++) {
        must(ll_session_run_to(s, k));
        hash[k] = ll_session_hash(s);
    }
    assert_int_equal(hash[600], end);
    assert_int_equal(ll_session_get_info(s).head_tick, 600);
    const int64_t order[] = {600, 599, 250, 251, 100, 99, 400, 0, 1, 200, 600};
    for (size_t i = 0; i < sizeof order / sizeof order[0]; i++) {
        char op[64];
        snprintf(op, sizeof op, "{\"op\":\"seek\",\"tick\":%d}", (int)order[i]);
        must(control(s, 0, op));
        assert_int_equal(ll_session_hash(s), hash[order[i]]);
    }
    must(control(s, 0, "{\"op\":\"step\",\"ticks\":-1}"));
    assert_int_equal(ll_session_hash(s), hash[599]);
    must(control(s, 0, "{\"op\":\"step\"}"));
    assert_int_equal(ll_session_hash(s), hash[600]);
    play_story(t);
    for (int64_t k = 0; k <= 600; k += 50) {
        ll_session *copy;
        cJSON *json;
        char want[17];
        must(ll_session_copy(t, k, &copy));
        must(ll_session_run_to(copy, k));
        json = ll_session_state(copy);
        ll_session_destroy(copy);
        snprintf(want, sizeof want, "%016llx", (unsigned long long)hash[k]);
        assert_string_equal(cJSON_GetObjectItem(json, "hash")->valuestring, want);
        cJSON_Delete(json);
    }
    assert_int_equal(ll_session_get_info(t).tick, 600);
    ll_session_destroy(s);
    ll_session_destroy(t);
}

static void restored_forked_and_parked_sessions_are_the_same(void **state)
{
    (void)state;
    lines *log = calloc(1, sizeof *log), *whole = calloc(1, sizeof *whole),
          *copied = calloc(1, sizeof *copied);
    ll_session *s = open_session(log), *restored, *from_log, *fork;
    play_story(s);
    uint64_t hash = ll_session_hash(s);

    must(ll_session_restore(log->text, log->size, NULL, NULL, &restored));
    assert_true(ll_session_get_info(restored).parked);
    assert_int_equal(ll_session_get_info(restored).tick,
                     400); /* the tick of the last command; later ticks are not logged */
    must(ll_session_run_to(restored, 600));
    assert_int_equal(ll_session_hash(restored), hash);

    ll_session_log(s, keep_line, whole);
    must(ll_session_restore(whole->text, whole->size, NULL, NULL, &from_log));
    assert_int_equal(ll_session_get_info(from_log).tick, 600);
    assert_int_equal(ll_session_hash(from_log), hash);

    must(ll_session_fork(s, keep_line, copied, &fork));
    assert_int_equal(ll_session_hash(fork), hash);
    must(ll_session_run_to(fork, 900));
    must(ll_session_run_to(s, 900));
    assert_int_equal(ll_session_hash(fork), ll_session_hash(s));
    must(patch(fork, "{\"players.0.lag_ms\":500}"));
    must(ll_session_run_to(fork, 1000));
    must(ll_session_run_to(s, 1000));
    assert_true(ll_session_hash(fork) != ll_session_hash(s));

    hash = ll_session_hash(s);
    assert_true(ll_session_bytes(s) <= 1024 * 1024); /* with more than 15 s of history */
    cJSON *cost = ll_session_cost(s);
    double announced = cJSON_GetObjectItem(cost, "parked_bytes")->valuedouble;
    cJSON_Delete(cost);
    ll_session_park(s);
    assert_true(ll_session_get_info(s).parked);
    assert_true(ll_session_bytes(s) <= 64 * 1024);
    assert_true((double)ll_session_bytes(s) == announced);
    assert_int_equal(ll_session_hash(s), hash);
    assert_false(ll_session_get_info(s).parked);
    ll_session_destroy(s);
    ll_session_destroy(restored);
    ll_session_destroy(from_log);
    ll_session_destroy(fork);
    free(log);
    free(whole);
    free(copied);
}

static void command_before_the_head_drops_later_ones(void **state)
{
    (void)state;
    lines *log = calloc(1, sizeof *log);
    ll_session *s = open_session(log), *t = open_session(NULL), *restored;
    play_story(s);
    must(control(s, 0, "{\"op\":\"seek\",\"tick\":150}"));
    must(patch(s, "{\"players.1.lag_ms\":300}"));
    assert_int_equal(ll_session_get_info(s).head_tick, 150);
    must(ll_session_run_to(s, 500));

    const ll_action full = {.axis = {1, 0}};
    must(ll_session_run_to(t, 100));
    must(patch(t, "{\"players\":{\"0\":{\"lag_ms\":40,\"control\":\"person\"}}}"));
    must(ll_session_input(t, 0, 0, &full));
    must(ll_session_run_to(t, 150));
    must(patch(t, "{\"players.1.lag_ms\":300}"));
    must(ll_session_run_to(t, 500));
    assert_int_equal(ll_session_hash(s), ll_session_hash(t));

    must(ll_session_restore(log->text, log->size, NULL, NULL, &restored));
    must(ll_session_run_to(restored, 500));
    assert_int_equal(ll_session_hash(restored), ll_session_hash(s));
    ll_session_destroy(s);
    ll_session_destroy(t);
    ll_session_destroy(restored);
    free(log);
}

static void restart_keeps_parameters_and_reset_does_not(void **state)
{
    (void)state;
    lines *log = calloc(1, sizeof *log);
    ll_session *s = open_session(log), *fresh = open_session(NULL), *restored;
    uint64_t first;
    must(patch(s, "{\"players.1.lag_ms\":77}"));
    for (int i = 0; i < 3; i++) {
        must(control(s, 0, "{\"op\":\"restart\"}"));
        assert_int_equal(ll_session_get_info(s).tick, 0);
        must(ll_session_run_to(s, 300));
        if (i == 0)
            first = ll_session_hash(s);
        assert_int_equal(ll_session_hash(s), first);
    }
    must(ll_session_run_to(fresh, 300));
    assert_true(ll_session_hash(fresh) != first);
    must(ll_session_restore(log->text, log->size, NULL, NULL, &restored));
    must(ll_session_run_to(restored, 300));
    assert_int_equal(ll_session_hash(restored), first);
    must(control(s, 0, "{\"op\":\"restart\",\"reset\":true}"));
    must(ll_session_run_to(s, 300));
    assert_int_equal(ll_session_hash(s), ll_session_hash(fresh));
    ll_session_destroy(s);
    ll_session_destroy(fresh);
    ll_session_destroy(restored);
    free(log);
}

static void bad_commands_change_nothing(void **state)
{
    (void)state;
    static const char *const patches[] = {
        "{\"players\":{\"0\":{\"lag_ms\":-1}}}",
        "{\"players\":{\"0\":{\"lag_ms\":1e999}}}",
        "{\"players\":{\"9\":{\"lag_ms\":1}}}",
        "{\"players\":[{\"lag_ms\":5},{\"lag_ms\":5000}]}",
        "{\"players\":[{}]}",
        "{\"nope\":1}",
        "{\"server\":{\"update_hz\":\"fast\"}}",
        "{\"server\":{\"sync\":\"maybe\"}}",
        "[]",
        "3",
    };
    static const char *const not_live[] = {"{\"seed\":2}", "{\"game\":\"cannon\"}", "{\"tick_hz\":30}"};
    static const char *const controls[] = {
        "{}",
        "{\"op\":\"fly\"}",
        "{\"op\":3}",
        "{\"op\":\"seek\"}",
        "{\"op\":\"seek\",\"tick\":-1}",
        "{\"op\":\"seek\",\"tick\":99999}",
        "{\"op\":\"seek\",\"tick\":1,\"time_s\":1}",
        "{\"op\":\"speed\",\"speed\":0}",
        "{\"op\":\"speed\",\"speed\":11}",
        "{\"op\":\"step\",\"ticks\":1.5}",
        "{\"op\":\"pause\",\"now\":true}",
    };
    lines *log = calloc(1, sizeof *log);
    ll_session *s = open_session(log);
    const ll_action wild = {.axis = {1.5f, 0}}, fine = {.axis = {1, 0}};
    must(ll_session_run_to(s, 100));
    uint64_t hash = ll_session_hash(s);
    size_t size = log->size;
    for (size_t i = 0; i < sizeof patches / sizeof patches[0]; i++) {
        ll_status status = patch(s, patches[i]);
        assert_int_equal(status.code, LL_BAD_INPUT);
        assert_true(strlen(status.text) > 10);
    }
    for (size_t i = 0; i < sizeof not_live / sizeof not_live[0]; i++)
        assert_int_equal(patch(s, not_live[i]).code, LL_CONFLICT);
    for (size_t i = 0; i < sizeof controls / sizeof controls[0]; i++)
        assert_int_equal(control(s, 0, controls[i]).code, LL_BAD_INPUT);
    assert_int_equal(ll_session_input(s, 0, 0, &fine).code,
                     LL_CONFLICT); /* the player is controlled by a script */
    assert_int_equal(ll_session_input(s, 0, 0, &wild).code, LL_BAD_INPUT);
    assert_int_equal(ll_session_input(s, 0, 2, &fine).code, LL_BAD_INPUT);
    assert_int_equal(ll_session_hash(s), hash);
    assert_int_equal(log->size, size);
    ll_session_destroy(s);
    free(log);
}

static void bad_logs_are_refused(void **state)
{
    (void)state;
    static const char *const logs[] = {
        "",
        "\n",
        "{}",
        "nonsense",
        "{\"op\":\"set\",\"tick\":1}",
        "{\"op\":\"create\",\"laglab_log\":2,\"scenario\":{\"kind\":\"netgame\",\"players\":[{}]}}",
        "{\"op\":\"create\",\"laglab_log\":1,\"scenario\":{}}",
    };
    static const char header[] =
        "{\"op\":\"create\",\"laglab_log\":1,\"scenario\":{\"kind\":\"netgame\",\"players\":[{}]}}\n";
    static const char *const tails[] = {
        "{\"op\":\"fly\",\"tick\":1}",
        "{\"op\":\"set\"}",
        "{\"op\":\"set\",\"tick\":1e9,\"values\":{}}",
        "{\"op\":\"set\",\"tick\":5,\"values\":{\"players.0.lag_ms\":-4}}",
        "{\"op\":\"set\",\"tick\":5,\"values\":{\"seed\":4}}",
        "{\"op\":\"set\",\"tick\":5,\"values\":3}",
        "{\"op\":\"input\",\"tick\":5,\"player\":99,\"axes\":[0,0],\"buttons\":0}",
        "{\"op\":\"input\",\"tick\":5,\"player\":0,\"axes\":[0],\"buttons\":0}",
        "{\"op\":\"input\",\"tick\":5,\"player\":0,\"axes\":[0,-1e999],\"buttons\":0}",
        "{\"op\":\"input\",\"tick\":5,\"player\":0,\"axes\":[1.1,0],\"buttons\":0}",
        "{\"op\":\"input\",\"tick\":5,\"player\":0,\"axes\":[1,0],\"buttons\":7e12}",
        "{\"op\":\"input\",\"tick\":1e30,\"player\":0,\"axes\":[1,0],\"buttons\":0}",
        "{\"op\":\"input\",\"tick\":5,\"player\":-1e12,\"axes\":[1,0],\"buttons\":0}",
        ("{\"op\":\"head\",\"tick\":9}\n{\"op\":\"input\",\"tick\":8,\"player\":0,\"axes\":[0,0],\"buttons\":"
         "0}\n{\"op\":\"set\",\"tick\":5,\"values\":{\"players.0.lag_ms\":4}}"),
    };
    ll_session *s;
    for (size_t i = 0; i < sizeof logs / sizeof logs[0]; i++) {
        assert_int_equal(ll_session_restore(logs[i], strlen(logs[i]), NULL, NULL, &s).code, LL_BAD_INPUT);
        assert_null(s);
    }
    for (size_t i = 0; i < sizeof tails / sizeof tails[0]; i++) {
        char log[1024];
        snprintf(log, sizeof log, "%s%s", header, tails[i]);
        ll_status status = ll_session_restore(log, strlen(log), NULL, NULL, &s);
        assert_true(ll_failed(&status));
        assert_null(s);
    }
}

/* Values that are only valid together: a patch of several values is one change. */
static void values_of_a_patch_are_applied_together(void **state)
{
    (void)state;
    lines *log = calloc(1, sizeof *log);
    ll_session *s = open_session(log), *restored;
    must(patch(s, "{\"players.0.lag_ms\":1000}"));
    must(ll_session_run_to(s, 10));
    must(patch(
        s, "{\"players\":{\"0\":{\"link\":{\"up\":{\"delay_ms\":1000,\"jitter_ms\":100}},\"lag_ms\":50}}}"));
    must(ll_session_run_to(s, 20));
    must(patch(s, "{\"players.0.lag_ms\":1000,\"players.0.link.up.delay_ms\":0}"));
    must(ll_session_run_to(s, 30));
    must(ll_session_restore(log->text, log->size, NULL, NULL, &restored));
    must(ll_session_run_to(restored, 30));
    assert_int_equal(ll_session_hash(restored), ll_session_hash(s));
    ll_session_destroy(s);
    ll_session_destroy(restored);
    free(log);
}

/* Each change of a log is checked with the values that earlier changes set. */
static void changes_of_a_log_are_checked_in_their_order(void **state)
{
    (void)state;
    static const char header[] =
        "{\"op\":\"create\",\"laglab_log\":1,\"scenario\":{\"kind\":\"netgame\",\"players\":[{}]}}\n";
    static const char lag[] = "{\"op\":\"set\",\"tick\":5,\"values\":{\"players.0.lag_ms\":1000}}\n";
    static const char no_lag[] = "{\"op\":\"set\",\"tick\":6,\"values\":{\"players.0.lag_ms\":0}}\n";
    static const char delay[] =
        "{\"op\":\"set\",\"tick\":7,\"values\":{\"players.0.link.up.delay_ms\":1000}}\n";
    static const char back[] = "{\"op\":\"rewind\",\"tick\":4}\n",
                      past[] = "{\"op\":\"rewind\",\"tick\":5}\n";
    const struct {
        const char *lines[4];
        bool good;
    } logs[] = {{{lag, delay}, false},
                {{lag, no_lag, delay}, true},
                {{lag, back, delay}, true},
                {{lag, past, delay}, false},
                {{delay}, true},
                {{lag, no_lag, past, delay}, false}};
    for (size_t i = 0; i < sizeof logs / sizeof logs[0]; i++) {
        char log[1024];
        ll_session *s;
        snprintf(log, sizeof log, "%s", header);
        for (int k = 0; k < 4 && logs[i].lines[k]; k++)
            strcat(log, logs[i].lines[k]);
        assert_int_equal(ll_session_restore(log, strlen(log), NULL, NULL, &s).code,
                         logs[i].good ? LL_OK : LL_BAD_INPUT);
        if (logs[i].good)
            must(ll_session_run_to(s, 20));
        ll_session_destroy(s);
    }
}

/* The block has the size of the header's scenario, so a restart with another scenario must be refused. */
static void log_that_restarts_another_scenario_is_refused(void **state)
{
    (void)state;
    static const char header[] = "{\"op\":\"create\",\"laglab_log\":1,\"scenario\":{\"kind\":\"netgame\","
                                 "\"duration_s\":4,\"players\":[{}]}}\n";
    static const char *const others[] = {
        "\"duration_s\":4,\"players\":[{},{},{},{},{},{},{},{}]",
        "\"duration_s\":4,\"tick_hz\":30,\"players\":[{}]",
        "\"duration_s\":40,\"players\":[{}]",
        "\"duration_s\":4,\"game\":\"gambetta\",\"players\":[{}]",
    };
    static const char same[] = "\"duration_s\":4,\"server\":{\"update_hz\":5},\"players\":[{\"lag_ms\":77}]";
    char log[1024];
    ll_session *s;
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++) {
        snprintf(log, sizeof log, "%s{\"op\":\"restart\",\"scenario\":{\"kind\":\"netgame\",%s}}\n", header,
                 others[i]);
        assert_int_equal(ll_session_restore(log, strlen(log), NULL, NULL, &s).code, LL_BAD_INPUT);
        assert_null(s);
    }
    snprintf(log, sizeof log, "%s{\"op\":\"restart\",\"scenario\":{\"kind\":\"netgame\",%s}}\n", header,
             same);
    must(ll_session_restore(log, strlen(log), NULL, NULL, &s));
    must(ll_session_run_to(s, 30));
    ll_session_destroy(s);
}

/* An input in a log for a player that does not exist, or is not controlled by a person, must not reach the
 * engine. */
static void log_with_an_impossible_input_runs(void **state)
{
    (void)state;
    static const char log[] =
        "{\"op\":\"create\",\"laglab_log\":1,\"scenario\":{\"kind\":\"netgame\",\"players\":[{}]}}\n"
        "{\"op\":\"input\",\"tick\":5,\"player\":7,\"axes\":[1,0],\"buttons\":0}\n";
    ll_session *s;
    must(ll_session_restore(log, strlen(log), NULL, NULL, &s));
    must(ll_session_run_to(s, 60));
    ll_session_destroy(s);
}

static double latest_event(ll_session *s)
{
    ll_buffer json = {0};
    ll_frame *frame;
    ll_frame_state none = {0}, last = {0};
    ll_row_set space = {0};
    ll_record_request request = {.channels = 1 << LL_CHANNEL_LANES, .anew = true, .from_event = LL_NO_EVENT};
    double latest = 0;
    cJSON *o, *e;
    must(ll_frame_take(s, &request, 1, &last, &space, &frame));
    ll_frame_delivery to = {
        .state = &none, .channels = request.channels, .jump = true, .format = LL_FRAME_JSON};
    ll_frame_write(frame, &to, &json);
    ll_frame_state_clear(&last);
    ll_row_set_free(&space);
    ll_frame_release(frame);
    o = cJSON_ParseWithLength(json.bytes, json.size);
    cJSON_ArrayForEach(e, cJSON_GetObjectItem(o, "events"))
    {
        double begin = cJSON_GetObjectItem(e, "begin_s")->valuedouble;
        latest = larger(latest, begin);
    }
    cJSON_Delete(o);
    free(json.bytes);
    return latest;
}

/* After a seek back there are no events of later ticks. */
static void frames_hold_no_events_of_the_future(void **state)
{
    (void)state;
    ll_session *s = open_session(NULL);
    must(ll_session_run_to(s, 300));
    assert_true(latest_event(s) > 4.9 && latest_event(s) <= 5);
    must(control(s, 0, "{\"op\":\"seek\",\"tick\":60}"));
    assert_true(latest_event(s) > 0.9 && latest_event(s) <= 1);
    must(control(s, 0, "{\"op\":\"restart\"}"));
    assert_true(latest_event(s) == 0);
    ll_session_destroy(s);
}

static void count_text(void *context, const char *text, size_t length)
{
    int *newlines = context;
    for (size_t i = 0; i < length; i++)
        *newlines += text[i] == '\n';
}

static void trace_has_a_row_per_tick(void **state)
{
    (void)state;
    int newlines = 0;
    ll_session *s = open_session(NULL);
    must(ll_session_run_to(s, 300));
    must(ll_session_trace(s, 100, 300, count_text, &newlines));
    assert_int_equal(newlines, 202);
    assert_int_equal(ll_session_trace(s, 0, 301, count_text, &newlines).code, LL_BAD_INPUT);
    ll_session_destroy(s);
}

static ll_status parse_list(int values)
{
    char *text = malloc((size_t)values * 2 + 1);
    cJSON *json;
    assert_non_null(text);
    for (int i = 0; i < values - 1; i++)
        memcpy(text + 1 + 2 * i, "7,", 2);
    text[0] = '[';
    text[2 * (values - 1)] = ']';
    ll_status status = ll_json_parse(text, (size_t)(2 * values - 1), &json);
    assert_int_equal(ll_failed(&status) ? 0 : values - 1, cJSON_GetArraySize(json));
    cJSON_Delete(json);
    free(text);
    return status;
}

static void json_has_a_bounded_number_of_values(void **state)
{
    (void)state;
    must(parse_list(LL_JSON_VALUES));
    ll_status status = parse_list(LL_JSON_VALUES + 1);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_non_null(strstr(status.text, "at most 100000 values"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(same_hash_in_one_go_and_in_pieces),
        cmocka_unit_test(paced_is_unpaced),
        cmocka_unit_test(advance_is_bounded_and_catches_up),
        cmocka_unit_test(play_until_a_tick_pauses_there),
        cmocka_unit_test(seeking_gives_the_same_states),
        cmocka_unit_test(restored_forked_and_parked_sessions_are_the_same),
        cmocka_unit_test(command_before_the_head_drops_later_ones),
        cmocka_unit_test(restart_keeps_parameters_and_reset_does_not),
        cmocka_unit_test(bad_commands_change_nothing),
        cmocka_unit_test(bad_logs_are_refused),
        cmocka_unit_test(values_of_a_patch_are_applied_together),
        cmocka_unit_test(changes_of_a_log_are_checked_in_their_order),
        cmocka_unit_test(log_that_restarts_another_scenario_is_refused),
        cmocka_unit_test(log_with_an_impossible_input_runs),
        cmocka_unit_test(frames_hold_no_events_of_the_future),
        cmocka_unit_test(trace_has_a_row_per_tick),
        cmocka_unit_test(json_has_a_bounded_number_of_values),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
