/* Changes of real scenarios' parameters in every order: rules that connect rows, presets, variants, arrays
 * whose elements start as another row says. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "library/library.h"
#include "session/scenario.h"

enum { SETS = 5 };

typedef struct combination {
    const char *scenario;
    const char *sets[SETS]; /* in one order the first two broke a rule or gave another result */
} combination;

#define UP "players.0.link.up."

static const combination combinations[] = {
    {"race", {UP "reorder_pct=7", UP "jitter_ms=3", UP "reorder_gap=4"}},
    {"race", {UP "reorder_gap=3", UP "reorder_pct=2", UP "rate_kbps=90", "players.1.lag_ms=33"}},
    {"race", {UP "loss_model=state", UP "p31_pct=30", UP "p32_pct=70", UP "p13_pct=4"}},
    {"race", {UP "spike_length_ms=900", UP "spike_every_ms=1000", UP "spike_add_ms=40"}},
    {"race", {UP "blackout_every_ms=500", UP "blackout_length_ms=501", UP "blackout_length_ms=499"}},
    {"race", {UP "jitter_ms=9", "players.0.link.preset=lte_4g", "players.0.link.down.mtu_bytes=600"}},
    {"race",
     {"players.0.link.preset=tunnel", "players.0.lag_ms=700", UP "delay_ms=400", UP "jitter_ms=20",
      "players.0.link.down.delay_ms=10"}},
    {"race", {"server.update_hz=50", "server.sync=lockstep", "tick_hz=50"}},
    {"race",
     {"players.2.link.preset=dsl", "players=[{},{},{}]", "players.2.link.up.loss_pct=4", "players.2.name=7"}},
    {"race",
     {"players.0.dejitter_ms=450", "players.0.lag_ms=900", "players.0.dejitter=arrival",
      "players.0.lag_ms=700", "params.laps=4"}},
    {"rigid/column",
     {"side_by_side=[{\"solver\":{\"iterations\":3}},{}]", "solver.method=pgs",
      "side_by_side.1.solver.substeps=7", "solver.substeps=5"}},
};

static cJSON *written(const combination *c, const int *order, int n, ll_status *status)
{
    cJSON *json;
    ll_scenario s = {0};
    const char *sets[SETS];
    for (int i = 0; i < n; i++)
        sets[i] = c->sets[order[i]];
    *status = ll_scenario_load("scenarios", c->scenario, &json);
    assert_string_equal(status->text, "");
    *status = ll_scenario_parse(json, &s);
    assert_string_equal(status->text, "");
    cJSON_Delete(json);
    *status = ll_param_put(s.kind->table, s.config, sets, n);
    if (!ll_failed(status))
        *status = ll_param_check(s.kind->table, s.config);
    json = ll_param_write(s.kind->table, s.config);
    ll_scenario_free(&s);
    return json;
}

static bool repeated(const combination *c, int i)
{
    size_t length = strcspn(c->sets[i], "=") + 1;
    for (int k = 0; k < SETS && c->sets[k]; k++)
        if (k != i && strncmp(c->sets[k], c->sets[i], length) == 0)
            return true;
    return false;
}

/* Every rotation, forward and reverse; a path given twice keeps its order. */
static void in_every_order(const combination *c)
{
    int n = 0, order[SETS];
    while (n < SETS && c->sets[n])
        n++;
    char *first = NULL;
    for (int turn = 0; turn < 2 * n; turn++) {
        bool back = turn >= n;
        for (int i = 0; i < n; i++)
            order[i] = back ? (2 * n - 1 - i + turn) % n : (i + turn) % n;
        for (int i = 0; i < n; i++) /* the last of two of one path must stay the last */
            for (int k = i + 1; k < n; k++)
                if (repeated(c, order[i]) && repeated(c, order[k]) && order[i] > order[k]) {
                    int swap = order[i];
                    order[i] = order[k];
                    order[k] = swap;
                }
        ll_status status;
        cJSON *json = written(c, order, n, &status);
        char *text = cJSON_PrintUnformatted(json);
        if (ll_failed(&status))
            fail_msg("%s first: %s", c->sets[order[0]], status.text);
        if (!first)
            first = strdup(text);
        else if (strcmp(first, text) != 0)
            fail_msg("%s: %s first differs from %s first", c->scenario, c->sets[order[0]], c->sets[0]);
        cJSON_free(text);
        cJSON_Delete(json);
    }
    free(first);
}

static void the_order_does_not_matter(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof combinations / sizeof combinations[0]; i++)
        in_every_order(&combinations[i]);
}

/* A combination that breaks a rule is rejected in every order. */
static void rules_still_hold(void **state)
{
    (void)state;
    static const combination wrong[] = {
        {"race", {UP "reorder_pct=7", UP "order=fifo", UP "delay_ms=20"}},
        {"race", {UP "p31_pct=31", UP "loss_model=state", UP "p32_pct=70"}},
        {"race", {UP "mtu_bytes=20", UP "delay_ms=20"}},
        {"race", {"server.update_hz=60", "server.sync=lockstep", "tick_hz=50"}},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        for (int turn = 0; turn < 3; turn++) {
            int n = wrong[i].sets[2] ? 3 : 2, order[SETS];
            for (int k = 0; k < n; k++)
                order[k] = (k + turn) % n;
            ll_status status;
            cJSON_Delete(written(&wrong[i], order, n, &status));
            assert_int_equal(status.code, LL_BAD_INPUT);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_order_does_not_matter),
        cmocka_unit_test(rules_still_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
