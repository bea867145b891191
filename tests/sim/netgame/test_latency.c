/* Latencies of changes of controls: felt, confirmed and seen, compared with a naive count. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "session/kinds.h"
#include "sim/netgame/readings.h"
#include "support/near.h"

/* Without prediction a change is felt and confirmed at the same display, after a round trip and the
 * documented waits. */
static void unpredicted_changes_are_felt_when_they_are_sure(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.prediction=false", "players.0.lag_ms=120", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 25, NULL);
    ll_summary felt = summary(&s, 0, LL_METRIC_INPUT_LATENCY),
               sure = summary(&s, 0, LL_METRIC_CONFIRMED_LATENCY),
               seen = summary(&s, 0, LL_METRIC_SEEN_LATENCY);
    assert_true(felt.count > 10 && felt.mean == sure.mean && felt.max == sure.max);
    assert_true(felt.mean > 240 && felt.max < 240 + 1000 / 30.0 + 2 * 1000 / 60.0 + 0.01);
    double lag = s.game->config.players[1].lag_ms;
    assert_true(seen.mean > 120 + lag && seen.count >= felt.count - 2);
    scene_close(&s);
}

enum { TICKS = 1500, INPUTS = TICKS + 1 /* numbered from 1 */, FROM = 120 /* the warm-up */ };

/* What can be seen at the end of each tick of a run: one display per tick. */
typedef struct history_of_ticks {
    double drawn[TICKS][2], real[TICKS][2]; /* player 0's own entity; `real` by the server's step */
    int64_t of[TICKS], step[TICKS], latest[TICKS];
    uint32_t count;         /* inputs made */
    ll_action made[INPUTS]; /* by number */
    int64_t meant[INPUTS], made_at[INPUTS];
    bool accepted[INPUTS];
    double other_shows[TICKS]; /* ms: server time of player 0's entity on the screen of player 1 */
    int64_t other_heard[TICKS];
} history_of_ticks;

static void note_input_result(void *context, const void *row)
{
    const ll_event *e = row;
    history_of_ticks *d = context;
    if (e->type == LL_EVENT_INPUT_RESULT && e->player == 0 && e->number < INPUTS)
        d->accepted[e->number] |= e->outcome == LL_OUTCOME_APPLIED;
}

static void write_up(history_of_ticks *d, const scene *s, int k)
{
    ll_client *c = ll_netgame_client(s->game, 0), *other = ll_netgame_client(s->game, 1);
    const ll_server *server = ll_netgame_server(s->game);
    const ll_entity *own = &ll_client_rendered(c)->entity[0],
                    *real = &ll_server_world_const(server)->entity[0];
    d->drawn[k][0] = own->x, d->drawn[k][1] = own->y;
    d->real[server->step][0] = real->x, d->real[server->step][1] = real->y;
    d->of[k] = c->predicting ? c->prediction.tick : c->latest.tick;
    d->step[k] = server->step;
    d->latest[k] = c->latest.tick;
    d->other_shows[k] = ll_to_ms(ll_client_draw_infos(other)[0].time);
    d->other_heard[k] = other->latest.tick;
    while (d->count < c->inputs.seq) {
        uint32_t seq = ++d->count;
        assert_true(seq < INPUTS);
        d->made[seq] = ll_client_pending(c, seq)->action;
        d->meant[seq] = c->inputs.tick - (int64_t)(c->inputs.seq - seq);
        d->made_at[seq] = k;
    }
}

/* From tick FROM on: a display each, compared now, or as the last of its tick. */
static void count_views(const history_of_ticks *d, const ll_client_metrics *in)
{
    int64_t count = 0, last = d->step[TICKS - 1];
    double sum = 0, most = 0, lead_ms = 0;
    for (int k = FROM; k < TICKS; k++) {
        bool superseded = d->of[k] > d->step[k] && k + 1 < TICKS && d->of[k + 1] == d->of[k];
        if (d->of[k] > last || superseded)
            continue;
        double x = d->drawn[k][0] - d->real[d->of[k]][0], y = d->drawn[k][1] - d->real[d->of[k]][1];
        double error = sqrt(x * x + y * y);
        count++;
        sum += error;
        most = larger(most, error);
        lead_ms += (double)(d->of[k] - k) * 1000 / 60;
    }
    ll_summary reported = ll_histogram_summary(&in->histogram[LL_METRIC_OWN_TIMELINE_ERROR]);
    assert_int_equal(reported.count, count);
    assert_near(reported.mean, sum / (double)count, 1e-12);
    assert_true(reported.max == most);
    assert_near(in->rendered_views.leads_ms.sum, lead_ms, 1e-3);
}

static void count_one(double *sum, int64_t *count, int64_t from, int64_t to)
{
    *count += to < TICKS;
    *sum += to < TICKS ? (double)(to - from) * 1000 / 60 : 0;
}

static void count_changes(const history_of_ticks *d, const ll_client_metrics *in, bool predicts)
{
    double sum[3] = {0};
    int64_t count[3] = {0}, lost = 0;
    for (uint32_t seq = 2; seq <= d->count; seq++) {
        const ll_action *a = &d->made[seq], *b = &d->made[seq - 1];
        int64_t at = d->made_at[seq], sure = at, seen = at, tick = d->meant[seq];
        if (at < FROM || tick > d->step[TICKS - 1] || (a->axis[0] == b->axis[0] && a->axis[1] == b->axis[1]))
            continue;
        lost += !d->accepted[seq];
        if (!d->accepted[seq])
            continue;
        while (sure < TICKS && d->latest[sure] < tick)
            sure++;
        while (seen < TICKS &&
               (d->other_heard[seen] < tick || d->other_shows[seen] + 1e-3 < (double)tick * 1000 / 60))
            seen++;
        count_one(&sum[0], &count[0], at, predicts ? at : sure);
        count_one(&sum[1], &count[1], at, sure);
        count_one(&sum[2], &count[2], at, seen);
    }
    for (int i = 0; i < 3; i++) {
        ll_summary reported = ll_histogram_summary(&in->histogram[i]);
        assert_int_equal(reported.never, lost);
        assert_int_equal(reported.count, count[i] + lost);
        assert_true(count[i] > 5);
        assert_near(reported.mean, sum[i] / (double)count[i], 1e-3);
    }
}

static void count_again(const char *scenario, const char *const *sets)
{
    scene s = scene_open(scenario, sets);
    history_of_ticks *d = calloc(1, sizeof *d);
    const ll_recorder recorder = {.record = note_input_result, .context = d};
    const ll_client_metrics *in = ll_netgame_client_metrics(s.game, 0);
    for (int k = 0; k < TICKS; k++) {
        ll_status status =
            ll_sim_netgame.advance(s.game, ll_tick_time(k, 60000), &recorder, NULL, NULL, NULL);
        assert_false(ll_failed(&status));
        write_up(d, &s, k);
    }
    count_views(d, in);
    count_changes(d, in, s.game->config.players[0].prediction);
    free(d);
    scene_close(&s);
}

/* Views, leads and changes, counted again from the ends of ticks alone; with contacts, losses and plain
 * prediction, whose views have errors. */
static void a_naive_count_agrees(void **state)
{
    (void)state;
    static const char *const loss[] = {"0", "35"}, *const on[] = {"false", "true"};
    for (int i = 0; i < 8; i++) {
        char lossy[48], prediction[48], reconciliation[56];
        snprintf(lossy, sizeof lossy, "players.0.link.up.loss_pct=%s", loss[i & 1]);
        snprintf(prediction, sizeof prediction, "players.0.prediction=%s", on[i >> 1 & 1]);
        snprintf(reconciliation, sizeof reconciliation, "players.0.reconciliation=%s", on[i >> 2 & 1]);
        const char *const sets[] = {lossy,
                                    prediction,
                                    reconciliation,
                                    "players.0.redundancy=0",
                                    "players.0.lag_ms=91.3",
                                    "players.0.clock_phase=0",
                                    "players.1.clock_phase=0",
                                    NULL};
        count_again("contact", sets);
        count_again("race", sets);
    }
}

/* From 5 s on; measurement starts after the last acknowledgement. */
static void a_dead_uplink_loses_every_change(void **state)
{
    (void)state;
    static const char *const syncs[] = {"server.sync=free", "server.sync=gambetta"};
    for (int i = 0; i < 2; i++)
        for (int predicted = 0; predicted < 2; predicted++) {
            const char *const sets[] = {syncs[i],
                                        "players.0.link.up.blackout_at_ms=5000",
                                        "players.0.link.up.blackout_length_ms=60000",
                                        "warmup_s=6",
                                        predicted ? "players.0.prediction=true"
                                                  : "players.0.prediction=false",
                                        NULL};
            scene s = scene_open(i == 0 ? "race" : "gambetta", sets);
            scene_run(&s, 25, NULL);
            cJSON *m = ll_netgame_metrics(s.game);
            assert_true(value(m, "players.0.input_latency_ms.lost_ratio") == 1);
            assert_true(value(m, "players.0.seen_latency_ms.lost_ratio") == 1);
            assert_true(value(m, "players.0.input_latency_ms.count") > 0);
            assert_true(is_null(m, "players.0.input_latency_ms.p50") &&
                        is_null(m, "players.0.input_latency_ms.mean"));
            assert_true(value(m, "players.0.ack_rtt_ms.count") == 0 &&
                        is_null(m, "players.0.ack_rtt_ms.mean"));
            const cJSON *v = at(m, "players.0.inputs.results");
            assert_true(value(v, "late") == 0 && value(v, "refused") == 0 && value(v, "applied") <= 301);
            assert_true(value(v, "lost") > 100 &&
                        value(v, "made") == value(v, "lost") + value(v, "applied") + value(v, "open"));
            assert_true(value(m, "players.1.input_latency_ms.lost_ratio") == 0);
            cJSON_Delete(m);
            scene_close(&s);
        }
}

/* Independent losses without redundancy: the same share of changes and of inputs is lost. */
static void changes_are_lost_as_inputs_are(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.link.up.loss_pct=40", "players.0.redundancy=0", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 400, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    const cJSON *v = at(m, "players.0.inputs.results");
    double inputs = value(v, "made"), n = value(m, "players.0.confirmed_latency_ms.count");
    assert_true(n > 50);
    assert_near(value(v, "lost") / inputs, 0.4, 4 * sqrt(0.24 / inputs));
    assert_near(value(m, "players.0.confirmed_latency_ms.lost_ratio"), 0.4, 4 * sqrt(0.24 / n));
    assert_near(value(m, "players.0.ack_rtt_ms.count") / (inputs - 120), 0.6, 0.02);
    cJSON_Delete(m);
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unpredicted_changes_are_felt_when_they_are_sure),
        cmocka_unit_test(a_naive_count_agrees),
        cmocka_unit_test(a_dead_uplink_loses_every_change),
        cmocka_unit_test(changes_are_lost_as_inputs_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
