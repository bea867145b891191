/* What a session has in memory: only what someone will read. */
#include "harness.h"

#include <unistd.h>

#include "library/library.h"
#include "session/records.h"

static cJSON *scenario_of(const char *id)
{
    cJSON *json;
    must(ll_scenario_load("scenarios", id, &json));
    return json;
}

static ll_session *open_hosted(const char *id)
{
    ll_session *s;
    cJSON *json = scenario_of(id);
    must(ll_session_create(json, -1, NULL, NULL, &s));
    cJSON_Delete(json);
    return s;
}

static ll_session *open_forward(const char *id)
{
    ll_session *s;
    ll_scenario scenario = {0};
    cJSON *json = scenario_of(id);
    must(ll_scenario_parse(json, &scenario));
    must(ll_session_open_forward(&scenario, NULL, &s));
    cJSON_Delete(json);
    return s;
}

static double cost_of(const ll_session *s, const char *name)
{
    cJSON *cost = ll_session_cost(s);
    const cJSON *bytes = cJSON_GetObjectItem(cost, name);
    assert_non_null(bytes);
    double value = bytes->valuedouble;
    cJSON_Delete(cost);
    return value;
}

static const double ring = LL_EVENT_RING * 48.0;

/* The ring was 70 % of a free fall's memory. */
static void only_kinds_with_events_have_a_ring(void **state)
{
    (void)state;
    static const char *const quiet[] = {"motion/free_fall", "motion/orbit", "rigid/pyramid",
                                        "fluid/rotation"};
    for (size_t i = 0; i < sizeof quiet / sizeof quiet[0]; i++) {
        ll_session *s = open_hosted(quiet[i]);
        must(ll_session_run_to(s, 2));
        assert_true(cost_of(s, "event_bytes") == 0);
        ll_session_destroy(s);
    }
    ll_session *s = open_hosted("race");
    assert_true(cost_of(s, "event_bytes") == ring);
    ll_session_park(s);
    assert_true(cost_of(s, "event_bytes") == 0);
    cJSON_Delete(ll_session_params(s)); /* reads the configuration, wakes nothing */
    assert_true(cost_of(s, "event_bytes") == 0);
    ll_session_hash(s);
    assert_true(cost_of(s, "event_bytes") == ring);
    ll_session_destroy(s);

    s = open_hosted("motion/free_fall");
    assert_true(ll_session_bytes(s) < 48 * 1024);
    ll_session_destroy(s);
}

/* A run forward has neither events nor checkpoints, and the same states and metrics. */
static void a_run_forward_has_its_state_only(void **state)
{
    (void)state;
    static const char *const ids[] = {"race", "rifle", "lockstep_pipelined", "motion/orbit", "rigid/pyramid"};
    for (size_t i = 0; i < sizeof ids / sizeof ids[0]; i++) {
        ll_session *all = open_hosted(ids[i]), *s = open_forward(ids[i]);
        int64_t end = ll_session_get_info(s).end_tick;
        must(ll_session_run_to(all, end));
        must(ll_session_run_to(s, end));
        assert_true(cost_of(s, "event_bytes") == 0);
        assert_true(cost_of(s, "checkpoint_bytes") == 0);
        assert_true(cost_of(all, "checkpoint_bytes") > 0);
        assert_true(cost_of(all, "block_bytes") == cost_of(s, "block_bytes"));
        assert_true(ll_session_hash(s) == ll_session_hash(all));
        cJSON *wanted = ll_session_metrics(all), *got = ll_session_metrics(s);
        char *wanted_text = cJSON_Print(wanted), *got_text = cJSON_Print(got);
        assert_string_equal(got_text, wanted_text);
        cJSON_free(wanted_text);
        cJSON_free(got_text);
        cJSON_Delete(wanted);
        cJSON_Delete(got);
        must(ll_session_run_to(s, end / 2)); /* back: from the start */
        must(ll_session_run_to(all, end / 2));
        assert_true(ll_session_hash(s) == ll_session_hash(all));
        ll_session_destroy(all);
        ll_session_destroy(s);
    }
}

/* One that no one watches may still go back. */
static void an_unwatched_session_has_checkpoints_only(void **state)
{
    (void)state;
    ll_session *all = open_hosted("race"), *s;
    ll_scenario scenario = {0};
    cJSON *json = scenario_of("race");
    int64_t end = ll_session_get_info(all).end_tick;
    must(ll_scenario_parse(json, &scenario));
    must(ll_session_open_unwatched(&scenario, &s));
    must(ll_session_run_to(all, end));
    must(ll_session_run_to(s, end));
    assert_true(cost_of(s, "event_bytes") == 0);
    assert_true(cost_of(s, "checkpoint_bytes") == cost_of(all, "checkpoint_bytes"));
    must(ll_session_run_to(all, end / 2));
    must(ll_session_run_to(s, end / 2));
    assert_true(ll_session_hash(s) == ll_session_hash(all));
    ll_session_destroy(all);
    ll_session_destroy(s);
    cJSON_Delete(json);
}

/* A copy is read once, from its start to its end. Events are for who asks for them. */
static void a_copy_has_events_when_it_is_asked_for_them(void **state)
{
    (void)state;
    ll_session *s = open_hosted("race"), *copy;
    int64_t end = ll_session_get_info(s).end_tick;
    must(ll_session_run_to(s, end));
    for (int asked = 0; asked < 2; asked++) {
        must(ll_session_copy(s, end, &copy));
        if (asked)
            ll_session_keep_events(copy);
        must(ll_session_run_to(copy, end));
        assert_true(cost_of(copy, "event_bytes") == (asked ? ring : 0));
        assert_true(cost_of(copy, "checkpoint_bytes") == 0);
        assert_true(ll_session_hash(copy) == ll_session_hash(s));
        assert_true(ll_session_bytes(copy) <= ll_session_awake_bytes(copy));
        ll_session_destroy(copy);
    }
    ll_session_destroy(s);
}

/* A fork of a run without events records those that come. */
static void a_fork_keeps_the_events_that_come(void **state)
{
    (void)state;
    ll_session *s = open_forward("race"), *fork;
    must(ll_session_run_to(s, 100));
    must(ll_session_fork(s, NULL, NULL, &fork));
    assert_true(cost_of(fork, "event_bytes") == ring);
    must(ll_session_run_to(s, 600));
    must(ll_session_run_to(fork, 600));
    assert_true(ll_session_hash(fork) == ll_session_hash(s));
    ll_session_destroy(fork);
    ll_session_destroy(s);
}

/* The rows of `cost`: parts of the block are within it, the others add up with what is not listed. */
static void cost_shows_each_part(void **state)
{
    (void)state;
    static const struct {
        const char *id;
        double histories; /* of the ground truth: 512 steps, each a time and places of 16 bytes */
    } runs[] = {{"race", 512 * (8 + 2 * 16) + 16},
                {"eight", 512 * (8 + 8 * 16) + 16},
                {"rifle", 0},
                {"motion/orbit", 0},
                {"rigid/pyramid", 0},
                {"fluid/rotation", 0}};
    for (size_t i = 0; i < sizeof runs / sizeof runs[0]; i++) {
        ll_session *s = open_hosted(runs[i].id);
        must(ll_session_run_to(s, 2));
        double block = cost_of(s, "block_bytes"), metrics = cost_of(s, "metric_bytes"),
               histories = cost_of(s, "history_bytes"),
               parts = block + cost_of(s, "checkpoint_bytes") + cost_of(s, "event_bytes") +
                       cost_of(s, "log_bytes");
        if (runs[i].histories > 0)
            assert_true(histories == runs[i].histories);
        assert_true(metrics + histories < block);
        assert_true(strncmp(runs[i].id, "fluid", 5) == 0 ? metrics == 0 : metrics > 0);
        assert_true(parts < cost_of(s, "bytes"));
        ll_session_park(s);
        assert_true(cost_of(s, "block_bytes") == 0 && cost_of(s, "metric_bytes") == 0);
        ll_session_destroy(s);
    }
}

static void ignore(void *context, const char *text, size_t length)
{
    (void)context;
    (void)text;
    (void)length;
}

/* A trace costs a copy of the state, while it is written; without one there is none. */
static void a_trace_costs_a_copy(void **state)
{
    (void)state;
    ll_session *s = open_forward("race");
    must(ll_session_run_to(s, 600));
    double bytes = cost_of(s, "bytes");
    assert_true(cost_of(s, "trace_bytes") == 0);
    must(ll_session_trace(s, 0, 600, ignore, NULL));
    assert_true(cost_of(s, "trace_bytes") > cost_of(s, "block_bytes"));
    assert_true(cost_of(s, "trace_bytes") <= bytes);
    assert_true(cost_of(s, "bytes") == bytes);
    ll_session_destroy(s);
}

/* Bytes of memory that the process has. */
static int64_t resident(void)
{
    long all = 0, held = 0;
    FILE *f = fopen("/proc/self/statm", "r");
    assert_non_null(f);
    assert_int_equal(fscanf(f, "%ld %ld", &all, &held), 2);
    fclose(f);
    return (int64_t)held * sysconf(_SC_PAGESIZE);
}

/* Small states were blocks of malloc between others that stayed: parking many sessions gave nothing back. */
static void parked_sessions_leave_no_holes(void **state)
{
    enum { SESSIONS = 600 };
    ll_session *s[SESSIONS];
    (void)state;
#if defined(__SANITIZE_ADDRESS__)
    skip(); /* every block is malloc's there */
#endif
    ll_session_destroy(open_hosted("motion/free_fall"));
    int64_t before = resident();
    for (int i = 0; i < SESSIONS; i++)
        s[i] = open_hosted("motion/free_fall");
    assert_true(resident() - before > SESSIONS * 32 * 1024);
    for (int i = 0; i < SESSIONS; i++)
        ll_session_park(s[i]);
    assert_true(resident() - before < SESSIONS * 8 * 1024);
    for (int i = 0; i < SESSIONS; i++)
        ll_session_destroy(s[i]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_kinds_with_events_have_a_ring),
        cmocka_unit_test(a_run_forward_has_its_state_only),
        cmocka_unit_test(an_unwatched_session_has_checkpoints_only),
        cmocka_unit_test(a_copy_has_events_when_it_is_asked_for_them),
        cmocka_unit_test(a_fork_keeps_the_events_that_come),
        cmocka_unit_test(cost_shows_each_part),
        cmocka_unit_test(a_trace_costs_a_copy),
        cmocka_unit_test(parked_sessions_leave_no_holes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
