/* Lists that must follow the order of a table. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "netcode/state/client.h"
#include "session/kinds.h"
#include "session/scenario.h"
#include "sim/core/scenario_rows.h"

static void lists_follow_their_tables(void **state)
{
    (void)state;
    int n = 0;
    for (; ll_syncs[n]; n++) {
        assert_true(ll_syncs[n]->due && ll_syncs[n]->step && ll_syncs[n]->take && ll_syncs[n]->compose);
        assert_true(ll_syncs[n]->receive && ll_syncs[n]->tick && ll_syncs[n]->display);
        assert_true(ll_syncs[n]->interpolate || ll_syncs[n]->display != ll_client_display);
        /* a mode whose clients wait for snapshots needs repeated ones, and a mode with clients' own worlds
         * needs to send the world */
        assert_true(!ll_syncs[n]->answers || ll_syncs[n]->waits);
        assert_true((ll_syncs[n]->start != NULL) == (ll_syncs[n]->observe != NULL));
    }
    for (n = 0; ll_sim_kinds[n]; n++)
        assert_string_equal(ll_sim_kinds[n]->name, ll_sim_kind_names[n]);
    assert_null(ll_sim_kind_names[n]);
}

/* What a simulation that fails has at hand is the tick of the failure, whether it ran to there in one go or
 * tick by tick. A motion does not fail: its methods do, each by itself. */
static void a_failure_leaves_the_block_at_its_tick(void **state)
{
    (void)state;
    static const char *const failing[] = {
        "{\"kind\":\"rigid\",\"duration_s\":20,\"gravity\":[0,0],\"bodies\":["
        "{},{\"velocity\":[1000000,0],\"position\":[990000000,10]}]}",
        "{\"kind\":\"fluid\",\"scene\":\"taylor_green\",\"params\":{\"n\":32},"
        "\"solver\":{\"substeps\":1},\"hz\":2,\"duration_s\":5}"};
    for (size_t i = 0; i < sizeof failing / sizeof failing[0]; i++) {
        cJSON *json = cJSON_Parse(failing[i]);
        ll_scenario scenario = {0};
        ll_status status = ll_scenario_parse(json, &scenario);
        assert_string_equal(status.text, "");
        const ll_sim_kind *kind = scenario.kind;
        size_t size = kind->size(scenario.config);
        void *whole = malloc(size), *ticks = malloc(size);
        status = kind->init(whole, scenario.config);
        assert_false(ll_failed(&status));
        memcpy(ticks, whole, size);
        ll_status failed = kind->advance(whole, 20 * LL_SECOND, NULL, NULL, NULL, NULL);
        assert_int_equal(failed.code, LL_DIVERGED);
        ll_freq freq = kind->tick_freq(scenario.config);
        int64_t tick = 0;
        do
            status = kind->advance(ticks, ll_tick_time(++tick, freq), NULL, NULL, NULL, NULL);
        while (!ll_failed(&status));
        assert_true(i > 0 || tick > 2);
        assert_string_equal(status.text, failed.text);
        assert_int_equal(kind->hash(ticks), kind->hash(whole));
        free(whole);
        free(ticks);
        ll_scenario_free(&scenario);
        cJSON_Delete(json);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(lists_follow_their_tables),
                                       cmocka_unit_test(a_failure_leaves_the_block_at_its_tick)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
