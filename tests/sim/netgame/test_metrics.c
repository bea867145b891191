/* The metrics of a netgame, compared with their definitions. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "sim/netgame/readings.h"
#include "support/near.h"

/* ---- a clean link ---- */

/* The view is always right for its tick: also a predicted one, at any lag, in every sync mode. */
static void clean_views_are_true_at_their_tick(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free",          "lockstep", "gambetta",
                                        "deterministic", "rollback", "lockstep_pipelined"};
    static const double lags[] = {0, 8.4, 61.7, 249, 1000};
    for (size_t i = 0; i < sizeof syncs / sizeof syncs[0]; i++)
        for (size_t k = 0; k < 2 * sizeof lags / sizeof lags[0]; k++) {
            char sync[40], lag[40], prediction[40], reconciliation[40];
            const char *on = k & 1 ? "true" : "false";
            snprintf(sync, sizeof sync, "server.sync=%s", syncs[i]);
            snprintf(lag, sizeof lag, "players.0.lag_ms=%g", lags[k / 2]);
            snprintf(prediction, sizeof prediction, "players.0.prediction=%s", on);
            snprintf(reconciliation, sizeof reconciliation, "players.0.reconciliation=%s", on);
            const char *const sets[] = {sync, lag, prediction, reconciliation, NULL};
            scene s = scene_open(i == 2 ? "gambetta" : "race", sets);
            scene_run(&s, 12, NULL);
            ll_summary error = summary(&s, 0, LL_METRIC_OWN_TIMELINE_ERROR);
            assert_true(error.count > 10 && error.max == 0);
            const ll_running_stats *lead = &ll_netgame_client_metrics(s.game, 0)->rendered_views.leads_ms;
            assert_int_equal(lead->count, error.count);
            if (i == 0) /* prediction leads the server; without it the view lags */
                assert_true(k & 1 ? lead->min > lags[k / 2] : lead->max <= -lags[k / 2]);
            assert_int_equal(ll_netgame_client_metrics(s.game, 0)->rendered_views.voided, 0);
            scene_close(&s);
        }
}

/* Plain prediction is reset by every snapshot: its view is wrong for the tick that it claims. */
static void prediction_alone_errs_at_its_tick(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.reconciliation=false", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 20, NULL);
    assert_true(summary(&s, 0, LL_METRIC_OWN_TIMELINE_ERROR).max > 0.001);
    scene_close(&s);
}

/* Views of ticks that a resync skips are void. */
static void views_of_skipped_ticks_are_void(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.lag_ms=200", "players.0.prediction=true",
                                "players.0.reconciliation=true", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 5, NULL);
    assert_int_equal(ll_netgame_client_metrics(s.game, 0)->rendered_views.voided, 0);
    ll_client_metrics_resync(ll_netgame_client_metrics(s.game, 0));
    int64_t voided = ll_netgame_client_metrics(s.game, 0)->rendered_views.voided;
    assert_true(voided >= 12 && voided <= 15); /* 200 ms and the slack, at 60 Hz */
    scene_close(&s);
}

/* ---- age of information ---- */

/* d + (T/2)(1+p)/(1-p). A snapshot arrives half a frame before the frame that applies it, which is the mean
 * for random phases. */
static void age_grows_with_loss(void **state)
{
    (void)state;
    static const int loss_pct[] = {0, 10, 30, 60};
    for (int i = 0; i < 4; i++) {
        char loss[48];
        snprintf(loss, sizeof loss, "players.0.link.down.loss_pct=%d", loss_pct[i]);
        const char *const sets[] = {loss, "players.0.lag_ms=108.333333", "server.update_hz=20",
                                    "players.0.clock_phase=0", NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 600, NULL);
        double p = loss_pct[i] / 100.0, wait = 25 * (1 + p) / (1 - p);
        double mean = summary(&s, 0, LL_METRIC_AGE_OF_INFORMATION).mean;
        assert_near(mean - 108.333333, wait, (i == 0 ? 0.1 : 0.06 * wait));
        scene_close(&s);
    }
}

/* One second per second. */
static void age_grows_through_a_blackout(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.link.down.blackout_at_ms=4000",
                                "players.0.link.down.blackout_length_ms=60000", "players.0.lag_ms=50", NULL};
    static const char *const syncs[] = {"server.sync=free", "server.sync=gambetta"};
    for (int i = 0; i < 2; i++) {
        const char *const all[] = {syncs[i], sets[0], sets[1], sets[2], NULL};
        scene s = scene_open(i == 0 ? "race" : "gambetta", all);
        const ll_client_metrics *in = ll_netgame_client_metrics(s.game, 0);
        scene_run(&s, 6, NULL);
        double before = in->last.age_of_information;
        scene_run(&s, 9, NULL);
        assert_true(before > 1900);
        assert_near(in->last.age_of_information - before, 3000, 17);
        scene_close(&s);
    }
}

/* ---- results of inputs ---- */

enum { SEQS = 16384 };

typedef struct result_counter {
    uint8_t outcome[SEQS]; /* bits: 1 accepted 2 refused 4 late */
} result_counter;

static void hear(void *context, const void *row)
{
    const ll_event *e = row;
    result_counter *w = context;
    if (e->type != LL_EVENT_INPUT_RESULT || e->number >= SEQS)
        return;
    w[e->player].outcome[e->number] |= (uint8_t)(e->outcome == LL_OUTCOME_APPLIED   ? 1
                                                 : e->outcome == LL_OUTCOME_REFUSED ? 2
                                                                                    : 4);
}

static double draw(uint64_t seed, uint64_t what, double from, double to)
{
    return from + (to - from) * ll_rng_unit(seed, what, 0);
}

/* The sum of the results at every tick, and an independent count of the results at the end. */
static void check_player(const scene *s, int player, const result_counter *w)
{
    const ll_input_history *input_history = &ll_netgame_client_metrics(s->game, player)->input_history;
    const ll_client *c = ll_netgame_client(s->game, player);
    int64_t late = 0, refused = 0, accepted = 0, never = 0;
    for (uint32_t seq = 1; seq <= c->inputs.seq; seq++) {
        late += (w->outcome[seq] & 5) == 4;
        refused += (w->outcome[seq] & 7) == 2;
        accepted += w->outcome[seq] & 1;
        never += w->outcome[seq] == 0;
    }
    const int64_t *n = input_history->count;
    assert_int_equal(ll_input_history_made_count(input_history), c->inputs.seq);
    assert_int_equal(n[LL_INPUT_CAME_LATE], late);
    assert_true(n[LL_INPUT_WAS_APPLIED] <= accepted && n[LL_INPUT_WAS_REFUSED] <= refused);
    assert_int_equal(n[LL_INPUT_WAS_APPLIED] + n[LL_INPUT_WAS_REFUSED] + n[LL_INPUT_WAS_LOST] +
                         n[LL_INPUT_IS_OPEN],
                     accepted + refused + never);
    assert_true(n[LL_INPUT_WAS_LOST] <= never);
    if (ll_netgame_sync(s->game)->waits || ll_netgame_sync(s->game)->observe)
        assert_true(n[LL_INPUT_CAME_LATE] == 0 && n[LL_INPUT_WAS_LOST] == 0);
}

static void results_balance_at_every_tick(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "lockstep", "gambetta", "deterministic", "rollback"};
    static const char *const cheats[] = {"none",      "none",       "none",    "rate",
                                         "magnitude", "lag_switch", "teleport"};
    int64_t all[LL_INPUT_RESULT_KINDS] = {0};
    for (uint64_t seed = 1; seed <= 80; seed++) {
        char sync[48], lag[48], loss[48], jitter[48], redundancy[48], cheat[48], update[48], dead[64];
        snprintf(sync, sizeof sync, "server.sync=%s", syncs[seed % 5]);
        snprintf(lag, sizeof lag, "players.0.lag_ms=%.1f", draw(seed, 1, 0, 300));
        snprintf(loss, sizeof loss, "players.0.link.up.loss_pct=%.0f", draw(seed, 2, 0, 60));
        snprintf(jitter, sizeof jitter, "players.0.link.up.jitter_ms=%.1f", draw(seed, 3, 0, 100));
        snprintf(redundancy, sizeof redundancy, "players.0.redundancy=%d", (int)draw(seed, 4, 0, 4));
        snprintf(cheat, sizeof cheat, "players.1.cheat=%s", cheats[(int)draw(seed, 5, 0, 7)]);
        snprintf(update, sizeof update, "server.update_hz=%d", (int)draw(seed, 6, 2, 60));
        snprintf(dead, sizeof dead, "players.1.link.up.blackout_length_ms=%.0f", draw(seed, 7, 0, 3000));
        const char *const sets[] = {
            sync, lag, loss, jitter, redundancy, cheat, update, dead, "server.timeout_s=0", NULL};
        scene s = scene_open(seed % 5 == 2 ? "gambetta" : "race", sets);
        result_counter *w = calloc(2, sizeof *w);
        const ll_recorder recorder = {.record = hear, .context = w};
        for (int tick = 1; tick <= 600; tick++) {
            scene_run(&s, tick / 60.0, &recorder);
            for (int p = 0; p < 2; p++) {
                const ll_input_history *input_history = &ll_netgame_client_metrics(s.game, p)->input_history;
                int64_t sum = 0;
                for (int v = 0; v < LL_INPUT_RESULT_KINDS; v++) {
                    assert_true(input_history->count[v] >= 0);
                    sum += input_history->count[v];
                }
                assert_int_equal(sum,
                                 ll_netgame_client(s.game, p)->inputs.seq); /* a result replaces another */
            }
        }
        for (int p = 0; p < 2; p++) {
            check_player(&s, p, &w[p]);
            for (int v = 0; v < LL_INPUT_RESULT_KINDS; v++)
                all[v] += ll_netgame_client_metrics(s.game, p)->input_history.count[v];
        }
        free(w);
        scene_close(&s);
    }
    for (int v = 0; v < LL_INPUT_RESULT_KINDS; v++)
        assert_true(all[v] > 50); /* every result occurs */
}

/* ---- null ---- */

/* Before the warm-up is over nothing has been counted, and no metric is 0 instead of null. */
static void metrics_without_counts_are_null(void **state)
{
    (void)state;
    scene s = scene_open("race", NULL);
    scene_run(&s, 0.5, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    for (int i = 0; i < LL_METRICS; i++) {
        char path[96];
        static const char *const fields[] = {"mean", "rms", "p50", "p95", "p99", "max"};
        for (size_t k = 0; k < sizeof fields / sizeof fields[0]; k++) {
            snprintf(path, sizeof path, "players.0.%s.%s", ll_metric_rows[i].name, fields[k]);
            assert_true(is_null(m, path));
        }
        snprintf(path, sizeof path, "players.0.%s.count", ll_metric_rows[i].name);
        assert_true(value(m, path) == 0);
    }
    static const char *const none[] = {"players.0.input_latency_ms.lost_ratio",
                                       "players.0.own_lead_ms.mean",
                                       "players.0.visible_correction_px.max",
                                       "players.0.corrections_per_s",
                                       "players.0.buffer.held_ratio",
                                       "players.0.buffer.time_scale.min",
                                       "players.0.smoothness.freeze_ratio",
                                       "players.0.smoothness.animation_error_px.rms",
                                       "players.0.inconsistency.server.time_ratio",
                                       "server.fairness.view_age_ms.jain",
                                       "server.rounding_m.p50"};
    for (size_t i = 0; i < sizeof none / sizeof none[0]; i++)
        if (!is_null(m, none[i]))
            fail_msg("%s is not null", none[i]);
    assert_true(value(m, "players.0.corrections") == 0); /* a count is a number */
    cJSON_Delete(m);
    scene_close(&s);
}

/* ---- fairness, waits ---- */

/* The measured delay of a link counts: here on average twice the configured one. */
static void fairness_goes_by_the_realised_round_trip(void **state)
{
    (void)state;
    const char *const sets[] = {"players=[{\"lag_ms\":40},{\"lag_ms\":40}]",
                                "players.1.link.up.spike_length_ms=60000",
                                "players.1.link.up.spike_add_ms=80", "server.update_hz=60", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 20, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    double spread = value(m, "players.1.input_latency_ms.mean") - value(m, "players.0.input_latency_ms.mean");
    assert_true(spread > 60);
    double round_trips[2];
    for (int i = 0; i < 2; i++) {
        char up[64], down[64];
        snprintf(up, sizeof up, "players.%d.link_up.delay_mean_ms", i);
        snprintf(down, sizeof down, "players.%d.link_down.delay_mean_ms", i);
        round_trips[i] = value(m, up) + value(m, down);
    }
    double apart = round_trips[1] - round_trips[0];
    assert_true(apart > 70 && apart < 80.001);
    assert_near(value(m, "server.fairness.input_latency_ms.per_ms_of_round_trip"), spread / apart, 1e-9);
    cJSON_Delete(m);
    scene_close(&s);
}

static void a_wait_that_has_not_ended_counts(void **state)
{
    (void)state;
    static const char *const syncs[] = {"server.sync=lockstep", "server.sync=deterministic"};
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {syncs[i], "players.1.link.up.blackout_at_ms=6000",
                                    "players.1.link.up.blackout_length_ms=60000", "server.timeout_s=0", NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 8, NULL);
        cJSON *a = ll_netgame_metrics(s.game);
        scene_run(&s, 10.25, NULL); /* it is not yet given up */
        cJSON *b = ll_netgame_metrics(s.game);
        assert_near(value(b, "server.stalled_s") - value(a, "server.stalled_s"), 2.25, 1e-9);
        cJSON_Delete(a);
        cJSON_Delete(b);
        scene_close(&s);
    }
}

/* ---- notices ---- */

/* Those of `scenario` at `until_s`, one per line. */
static void read_notices(const char *scenario, const char *const *sets, double until_s, char *out,
                         size_t size)
{
    scene s = scenario[0] == '{' ? scene_make(scenario, sets) : scene_open(scenario, sets);
    scene_run(&s, until_s, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    const cJSON *notices = at(m, "notices"), *item;
    assert_true(cJSON_IsArray(notices));
    out[0] = '\0';
    cJSON_ArrayForEach(item, notices)
        snprintf(out + strlen(out), size - strlen(out), "%s\n", item->valuestring);
    cJSON_Delete(m);
    scene_close(&s);
}

static void notices_explain_null_metrics(void **state)
{
    (void)state;
    static const char alone[] =
        "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":9,\"players\":[{\"name\":"
        "\"Ada\",\"control\":\"person\"}]}";
    static const char idle[] =
        "{\"kind\":\"netgame\",\"game\":\"race\",\"players\":[{},{\"control\":\"person\"},{},"
        "{\"control\":\"person\"}]}";
    static const char deaf[] =
        "{\"kind\":\"netgame\",\"game\":\"race\",\"players\":[{\"link\":{\"down\":{\"loss_pct\":"
        "100}}},{}]}";
    static const struct {
        const char *scenario;
        const char *sets[3];
        double until_s;
        const char *reported[3]; /* all lines, each with these words */
    } cases[] = {
        {"race", {"duration_s=7"}, 7, {NULL}},
        {"race",
         {"duration_s=3.5", "warmup_s=3.5"},
         3.5,
         {"duration_s, 3.5 s, is not longer than warmup_s, 3.5 s"}},
        {"race", {"duration_s=1.25"}, 1, {"duration_s, 1.25 s, is not longer than warmup_s, 2 s"}},
        {"race", {"warmup_s=4"}, 2.5, {"from warmup_s, 4 s, on; it is 2.5 s"}},
        {"race", {"warmup_s=0"}, 0, {NULL}},
        {alone, {NULL}, 9, {"Ada did not change the controls", "Ada had no other player in view"}},
        {idle, {NULL}, 6, {"B and D did not change the controls"}},
        {deaf, {NULL}, 6, {"A never joined"}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[1200], *line = text;
        read_notices(cases[i].scenario, cases[i].sets, cases[i].until_s, text, sizeof text);
        for (int k = 0; cases[i].reported[k]; k++) {
            char *end = strchr(line, '\n');
            if (!end)
                fail_msg("case %zu lacks \"%s\"", i, cases[i].reported[k]);
            *end = '\0';
            if (!strstr(line, cases[i].reported[k]))
                fail_msg("case %zu: \"%s\" is not in \"%s\"", i, cases[i].reported[k], line);
            line = end + 1;
        }
        if (*line)
            fail_msg("case %zu also has: %s", i, line);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clean_views_are_true_at_their_tick),
        cmocka_unit_test(prediction_alone_errs_at_its_tick),
        cmocka_unit_test(views_of_skipped_ticks_are_void),
        cmocka_unit_test(age_grows_with_loss),
        cmocka_unit_test(age_grows_through_a_blackout),
        cmocka_unit_test(results_balance_at_every_tick),
        cmocka_unit_test(metrics_without_counts_are_null),
        cmocka_unit_test(fairness_goes_by_the_realised_round_trip),
        cmocka_unit_test(a_wait_that_has_not_ended_counts),
        cmocka_unit_test(notices_explain_null_metrics),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
