/* A run that observes only what some metrics need: the same run, with the same values of these metrics. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/session.h"
#include "support/stride.h"

/* One of each kind of game, sync mode and weapon, and one with a cheat. */
static const char *const scenarios[] = {
    "race",     "eight",    "crates",      "cannon",     "rifle",
    "gambetta", "rollback", "cheat_speed", "desync_ulp", "lockstep_pipelined"};

static ll_session *open_scenario(const char *id)
{
    cJSON *json;
    ll_session *s = NULL;
    ll_status status = ll_scenario_load("scenarios", id, &json);
    if (!ll_failed(&status))
        status = ll_session_create(json, -1, NULL, NULL, &s);
    if (ll_failed(&status))
        fail_msg("%s: %s", id, status.text);
    cJSON_Delete(json);
    return s;
}

static void run(ll_session *s)
{
    ll_status status = ll_session_run_to(s, 260);
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static cJSON *metrics_after(const char *id, const char *path, uint64_t *hash)
{
    ll_session *s = open_scenario(id);
    if (path)
        ll_session_observe_only(s, &path, path[0] != '\0');
    run(s);
    *hash = ll_session_hash(s);
    cJSON *report = ll_session_metrics(s), *metrics = cJSON_DetachItemFromObject(report, "metrics");
    cJSON_Delete(report);
    ll_session_destroy(s);
    return metrics;
}

/* The value at the path. */
static const cJSON *at(const cJSON *metrics, const char *path)
{
    char name[64];
    for (const cJSON *item = metrics; item; path++) {
        size_t length = strcspn(path, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, path);
        item = cJSON_IsArray(item) ? cJSON_GetArrayItem(item, atoi(name))
                                   : cJSON_GetObjectItemCaseSensitive(item, name);
        path += length;
        if (!*path)
            return item;
    }
    return NULL;
}

typedef struct comparison {
    const char *scenario;
    const cJSON *all;
    uint64_t hash;
    int compared, other, nulls;
} comparison;

/* A metric that needs less than everything, measured alone. */
static void compare_alone(comparison *c, const char *path)
{
    uint64_t hash;
    cJSON *metrics = metrics_after(c->scenario, path, &hash);
    if (hash != c->hash)
        fail_msg("%s: with %s alone the hash differs", c->scenario, path);
    const cJSON *want = at(c->all, path), *got = at(metrics, path);
    assert_non_null(want);
    if (!cJSON_Compare(want, got, true)) {
        char *all = cJSON_PrintUnformatted(want), *alone = cJSON_PrintUnformatted(got);
        print_error("%s: %s is %s among all metrics, and %s alone\n", c->scenario, path, all, alone);
        cJSON_free(all);
        cJSON_free(alone);
        c->other++;
    }
    c->compared++;
    c->nulls += cJSON_IsNull(want);
    cJSON_Delete(metrics);
}

/* Of the objects below `item`, those of the second player and all of the run itself. */
static void compare_below(comparison *c, const cJSON *item, const char *path)
{
    const cJSON *child;
    int i = 0;
    cJSON_ArrayForEach(child, item)
    {
        char below[160], index[12];
        snprintf(index, sizeof index, "%d", i++);
        const char *name = cJSON_IsArray(item) ? index : child->string;
        snprintf(below, sizeof below, "%s%s%s", path, path[0] ? "." : "", name);
        if (strcmp(path, "players") == 0 && i != 2)
            continue;
        if (strcmp(below, "notices") == 0 || strcmp(below, "expect") == 0)
            continue;
        bool deeper = cJSON_IsObject(child) && !cJSON_HasObjectItem(child, "count");
        if (deeper || strcmp(below, "players") == 0)
            compare_below(c, child, below);
        else if (!cJSON_IsArray(item) || strcmp(path, "players") == 0)
            compare_alone(c, below);
    }
}

static void each_metric_alone_is_the_same(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i += LL_TEST_STRIDE) {
        comparison c = {.scenario = scenarios[i]};
        cJSON *all = metrics_after(scenarios[i], NULL, &c.hash);
        c.all = all;
        compare_below(&c, all, "");
        cJSON_Delete(all);
        assert_int_equal(c.other, 0);
        assert_true(c.compared > 80);
        assert_true(c.nulls < c.compared / 2);
    }
}

/* Nothing asked for: the hash of every tick is that of a run that observes everything. */
static void the_run_is_the_same(void **state)
{
    (void)state;
    const char *none = "";
    for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i++) {
        ll_session *all = open_scenario(scenarios[i]), *some = open_scenario(scenarios[i]);
        ll_session_observe_only(some, &none, 0);
        for (int64_t tick = 1; tick <= 600; tick++) {
            ll_session_run_to(all, tick);
            ll_session_run_to(some, tick);
            if (ll_session_hash(all) != ll_session_hash(some))
                fail_msg("%s: tick %lld differs", scenarios[i], (long long)tick);
        }
        ll_session_destroy(all);
        ll_session_destroy(some);
    }
}

/* What is not asked for is indeed not measured: otherwise the tests above would compare nothing. */
static void the_rest_is_not_measured(void **state)
{
    (void)state;
    uint64_t hash;
    cJSON *metrics = metrics_after("race", "players.0.bandwidth.up_bytes_per_s", &hash);
    assert_true(cJSON_IsNull(at(metrics, "players.0.remote_error_m.mean")));
    assert_true(cJSON_IsNull(at(metrics, "players.0.input_latency_ms.mean")));
    assert_true(at(metrics, "players.0.bandwidth.up_bytes_per_s")->valuedouble > 0);
    cJSON_Delete(metrics);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_metric_alone_is_the_same),
        cmocka_unit_test(the_run_is_the_same),
        cmocka_unit_test(the_rest_is_not_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
