/* Snapshots in whole games: what a codec changes, by how much, and what it does not. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

static ll_summary summary(const scene *s, int player, ll_metric metric)
{
    return ll_histogram_summary(&ll_netgame_client_metrics(s->game, player)->histogram[metric]);
}

static const ll_snapshot_cost *cost(const scene *s, int player)
{
    return &ll_netgame_server(s->game)->client_slots[player].counts.sent;
}

static double per_state(const scene *s, int player)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(s->game, player);
    return (double)in->traffic.bytes[LL_MESSAGE_SNAPSHOT] / (double)in->traffic.messages[LL_MESSAGE_SNAPSHOT];
}

static bool same_world(const scene *a, const scene *b)
{
    const ll_world *w = ll_server_world(ll_netgame_server(a->game));
    return memcmp(w, ll_server_world(ll_netgame_server(b->game)), ll_world_size(w)) == 0;
}

#define ALL_ON(p)                                                                                            \
    "players." p ".prediction=true", "players." p ".reconciliation=true", "players." p ".interpolation=true"

/* The own entity is sent bitwise: where no cars touch, prediction stays exact and the server's world is the
 * same with every encoding. The others are at most half a step per axis further off. */
static void a_codec_changes_only_the_drawn_others(void **state)
{
    (void)state;
    const double step = 0.1;
    const char *const full[] = {ALL_ON("0"), ALL_ON("1"), NULL};
    const char *const quantised[] = {ALL_ON("0"), ALL_ON("1"), "server.snapshot_encoding=quantised",
                                     "server.quantum_m=0.1", NULL};
    const char *const delta[] = {ALL_ON("0"), ALL_ON("1"), "server.snapshot_encoding=delta",
                                 "server.quantum_m=0.1", NULL};
    const char *const *const ways[] = {full, quantised, delta};
    scene s[3];
    for (int i = 0; i < 3; i++) {
        s[i] = scene_open("race", ways[i]);
        scene_run(&s[i], 40, NULL);
        assert_true(same_world(&s[0], &s[i]));
        for (int p = 0; p < 2; p++) {
            assert_int_equal(ll_netgame_client_metrics(s[i].game, p)->corrections.count, 0);
            assert_int_equal(ll_netgame_client(s[i].game, p)->snapshots.unreadable, 0);
            double added = summary(&s[i], p, LL_METRIC_TIMELINE_ERROR).max -
                           summary(&s[0], p, LL_METRIC_TIMELINE_ERROR).max;
            assert_true(added <= step / 2 + 1e-9);
            assert_true(i == 0 || added > step / 4); /* and it is visible */
        }
    }
    assert_true(per_state(&s[1], 0) < 0.5 * per_state(&s[0], 0) && per_state(&s[2], 0) < per_state(&s[1], 0));
    for (int i = 0; i < 3; i++)
        scene_close(&s[i]);
}

/* Delta contains the same as quantised: everything that follows is the same, with crates too. */
static void delta_equals_quantised(void **state)
{
    (void)state;
    const char *const quantised[] = {"server.snapshot_encoding=quantised", NULL};
    scene a = scene_open("crates_delta", NULL), b = scene_open("crates_delta", quantised);
    scene_run(&a, 30, NULL);
    scene_run(&b, 30, NULL);
    assert_true(same_world(&a, &b));
    for (int p = 0; p < 2; p++) {
        const ll_world *w = ll_client_rendered(ll_netgame_client(a.game, p));
        assert_memory_equal(w, ll_client_rendered(ll_netgame_client(b.game, p)), ll_world_size(w));
        ll_client_metrics *x = ll_netgame_client_metrics(a.game, p),
                          *y = ll_netgame_client_metrics(b.game, p);
        assert_int_equal(x->corrections.count, y->corrections.count);
        assert_memory_equal(x->histogram, y->histogram, sizeof x->histogram);
        assert_true(cost(&a, p)->unchanged * 10 > cost(&a, p)->entities * 7);
        assert_int_equal(cost(&a, p)->resting, cost(&b, p)->resting);
        assert_true(per_state(&a, p) < 0.5 * per_state(&b, p));
    }
    scene_close(&a);
    scene_close(&b);
}

/* Rounding errors: along a lane they are uniform in half a step to either side, so their mean is a quarter of
 * a step, their root mean square step / sqrt(12), and their quantile q is q / 2 of a step. Of n values the
 * mean has a standard error of step / sqrt(48 n); buckets are a 64th of a step wide. */
static void rounding_is_uniform(void **state)
{
    (void)state;
    const double step = 0.004;
    const char *const sets[] = {
        ALL_ON("0"),           ALL_ON("1"), "server.snapshot_encoding=quantised", "server.quantum_m=0.004",
        "server.update_hz=60", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 25, NULL);
    ll_summary r = ll_rounding_summary(ll_server_baseline_history(ll_netgame_server(s.game)));
    double n = (double)r.count, error = step / sqrt(48 * n);
    assert_true(n > 2500);
    assert_near(r.mean, step / 4, 3 * error);
    assert_near(r.rms, step / sqrt(12), 3 * error);
    assert_true(r.max <= step / 2 * (1 + 1e-6) && r.max > 0.499 * step);
    assert_near(r.p50, step / 4, step / 64 + 3 * error);
    assert_near(r.p95, 0.475 * step, step / 64);
    scene_close(&s);
}

/* A fifth lost, others overtaken or doubled: every received snapshot is decoded, and nearly all of it is
 * differences. */
static void snapshots_over_a_bad_link_are_decoded(void **state)
{
    (void)state;
    scene s = scene_open("snapshot_loss", NULL);
    scene_run(&s, 60, NULL);
    const ll_link_stats *link = ll_link_get_stats(ll_netgame_down(s.game, 0));
    assert_true(link->lost > 300 && link->reordered > 100 && link->duplicated > 100);
    assert_int_equal(ll_netgame_client(s.game, 0)->snapshots.unreadable, 0);
    assert_true(ll_netgame_client(s.game, 0)->snapshots.stale > 100);
    assert_true((double)cost(&s, 0)->whole <
                0.01 * (double)ll_netgame_client_metrics(s.game, 0)->traffic.messages[LL_MESSAGE_SNAPSHOT]);
    scene_close(&s);
}

/* A snapshot longer than the MTU is sent as fragments, each with its headers, and is lost with any of them:
 * full snapshots are lost more often than deltas on the same link. */
static void long_states_travel_as_fragments(void **state)
{
    (void)state;
    static const int mtus[] = {1200, 500, 0};
    const double p = 0.04;
    for (int i = 0; i < 3; i++) {
        char mtu[64];
        snprintf(mtu, sizeof mtu, "players.0.link.down.mtu_bytes=%d", mtus[i]);
        const char *const sets[] = {"server.snapshot_encoding=full", "players.0.link.down.rate_kbps=0",
                                    "players.0.link.down.loss_pct=4", mtu, NULL};
        tape t = {0};
        ll_recorder r = tape_recorder(&t);
        scene s = scene_open("crates_200", sets);
        scene_run(&s, 40, &r);
        const ll_client_metrics *in = ll_netgame_client_metrics(s.game, 0);
        const ll_link_stats *link = ll_link_get_stats(ll_netgame_down(s.game, 0));
        int bytes = (int)per_state(&s, 0), n = mtus[i] ? (bytes + mtus[i] - 1) / mtus[i] : 1;
        int headers = 28 + (n > 1 ? 4 : 0);
        assert_true(bytes > 10000);
        assert_int_equal(in->traffic.packets[LL_MESSAGE_SNAPSHOT],
                         n * in->traffic.messages[LL_MESSAGE_SNAPSHOT]);
        assert_int_equal(in->traffic.wire_bytes[LL_MESSAGE_SNAPSHOT] - in->traffic.bytes[LL_MESSAGE_SNAPSHOT],
                         headers * in->traffic.packets[LL_MESSAGE_SNAPSHOT]);
        double lost = 1 - pow(1 - p, n), messages = 0,
               gone = 0; /* of snapshots: answers to pings are short */
        for (size_t k = 0; k < t.count; k++) {
            const ll_event *e = &t.events[k];
            messages += e->type == LL_EVENT_SNAPSHOT && e->player == 0;
            gone += e->type == LL_EVENT_SNAPSHOT && e->player == 0 && e->fate == LL_FATE_LOST;
        }
        assert_true(messages >= 40 * 30 - 1);
        assert_near(gone / messages, lost, 4 * sqrt(lost * (1 - lost) / messages));
        assert_near(ll_link_loss_pct(link) / 100, p, 4 * sqrt(p * (1 - p) / (double)link->sent));
        scene_close(&s);
        tape_free(&t);
    }
}

/* The bytes on the link are the encoded ones: a rate that is enough for deltas overflows with full
 * snapshots. */
static void the_link_carries_the_encoded_bytes(void **state)
{
    (void)state;
    /* scope `own`: a predicted entity has no age, but would count in the mean */
    const char *const thin_sets[] = {"players.0.prediction_scope=own", "players.1.prediction_scope=own",
                                     NULL},
                      *const full[] = {"server.snapshot_encoding=full", thin_sets[0], thin_sets[1], NULL};
    scene a = scene_open("crates_200", thin_sets), b = scene_open("crates_200", full);
    scene_run(&a, 30, NULL);
    scene_run(&b, 30, NULL);
    for (int p = 0; p < 2; p++) {
        const ll_link_stats *thin = ll_link_get_stats(ll_netgame_down(a.game, p)),
                            *fat = ll_link_get_stats(ll_netgame_down(b.game, p));
        assert_int_equal(thin->queue_drops, 0);
        assert_true(fat->queue_drops > 500);
        assert_true(fat->bytes > 50 * thin->bytes);
        assert_true(per_state(&a, p) < 256e3 / 8 / 30 / 4);
        assert_true(summary(&b, p, LL_METRIC_VIEW_AGE).mean > 400 + summary(&a, p, LL_METRIC_VIEW_AGE).mean);
        assert_true(summary(&b, p, LL_METRIC_VIEW_AGE).max > 600 + summary(&a, p, LL_METRIC_VIEW_AGE).max);
    }
    scene_close(&a);
    scene_close(&b);
}

/* In every sync mode with snapshots, and with changes of the codec during a run, the game continues. */
static void a_codec_may_change_while_it_runs(void **state)
{
    (void)state;
    const char *const syncs[] = {"server.sync=free", "server.sync=lockstep_pipelined", "server.sync=gambetta",
                                 "server.sync=lockstep"};
    for (size_t i = 0; i < 4; i++) {
        double way = i < 3 ? 10 : 0.1; /* m in 2 s: stop and wait makes four steps of 1/30 s in them */
        const char *const sets[] = {syncs[i], ALL_ON("0"), "players.0.script=steady",
                                    "players.1.script=steady", NULL};
        scene s = scene_open("race", sets);
        double t = 4, last = 0;
        scene_run(&s, t, NULL);
        for (int k = 1; k <= 9; k++) {
            ll_netgame_config config = scene_config(s.game);
            config.server.snapshot = k % 3;
            config.server.quantum_m = k % 2 ? 0.002 : 0.05;
            s.scenario.kind->change(s.game, &config, s.game->now);
            scene_run(&s, t += 2, NULL);
            double x = ll_server_world(ll_netgame_server(s.game))->entity[0].x,
                   seen = ll_client_rendered(ll_netgame_client(s.game, 1))->entity[0].x;
            assert_true(x > last + way && x - seen < 16 * 0.6);
            last = x;
        }
        assert_int_equal(ll_netgame_client(s.game, 0)->snapshots.unreadable, 0);
        scene_close(&s);
    }
}

/* A pushing player is corrected at every push in scope `own`, and hardly in scope `contacts`: by less than a
 * tenth of it. */
static void scopes_differ_by_corrections_of_pushes(void **state)
{
    (void)state;
    const char *const exact[] = {"players.0.clock_phase=0", "players.1.clock_phase=0", NULL};
    scene s = scene_open("crates", exact);
    scene_run(&s, 60, NULL);
    ll_summary own = summary(&s, 0, LL_METRIC_CORRECTION), contacts = summary(&s, 1, LL_METRIC_CORRECTION);
    assert_true(own.count > 500 && own.rms > 0.05);
    assert_true(contacts.count < own.count / 10 && contacts.max < own.rms / 10);
    scene_close(&s);
    double own_m = 0, contacts_m = 0;
    for (int seed = 1; seed <= 8; seed++) { /* clocks of any phase */
        char draws[24];
        snprintf(draws, sizeof draws, "seed=%d", seed);
        const char *const sets[] = {draws, NULL};
        s = scene_open("crates", sets);
        scene_run(&s, 60, NULL);
        own = summary(&s, 0, LL_METRIC_CORRECTION);
        contacts = summary(&s, 1, LL_METRIC_CORRECTION);
        assert_true(own.count > 500 && own.rms > 0.05);
        assert_true(contacts.count < own.count / 5);
        own_m += (double)own.count * own.mean;
        contacts_m += contacts.count > 0 ? (double)contacts.count * contacts.mean : 0;
        scene_close(&s);
    }
    assert_true(contacts_m < own_m / 100); /* a tenth as many, by a tenth */
}

/* Of what a thread has made for one game, nothing comes into another: games that are advanced in turn by
 * single ticks, as a daemon does it, have the states of games that run alone. Where lockstep waits for an
 * input, a lost snapshot is repeated between updates. */
static void games_in_turn_are_games_alone(void **state)
{
    (void)state;
    static const char *const syncs[] = {"server.sync=free", "server.sync=lockstep",
                                        "server.sync=lockstep_pipelined"};
    static const char *const codecs[] = {"server.snapshot_encoding=quantised",
                                         "server.snapshot_encoding=delta"};
    for (int i = 0; i < 6; i++) {
        scene turn[2], alone[2];
        for (int g = 0; g < 2; g++) {
            const char *const sets[] = {syncs[i % 3],
                                        codecs[i / 3],
                                        g == 0 ? "seed=5" : "seed=6",
                                        "players.0.link.down.loss_pct=25",
                                        "players.1.link.down.loss_pct=25",
                                        NULL};
            turn[g] = scene_open("crates", sets);
            alone[g] = scene_open("crates", sets);
            scene_run(&alone[g], 12, NULL);
        }
        for (int tick = 1; tick <= 12 * 60; tick++)
            for (int g = 0; g < 2; g++)
                scene_run(&turn[g], tick / 60.0, NULL);
        for (int g = 0; g < 2; g++) {
            if (turn[g].scenario.kind->hash(turn[g].game) != alone[g].scenario.kind->hash(alone[g].game))
                fail_msg("%s, %s: another state in turn than alone", syncs[i % 3], codecs[i / 3]);
            scene_close(&turn[g]);
            scene_close(&alone[g]);
        }
    }
}

/* Water: what is drawn between two snapshots has a tenth of the error with Hermite as with lines, and the
 * grid adds at most the two halves of a step. */
static void water_is_drawn_between_states(void **state)
{
    (void)state;
    const char *const coarse[] = {"server.quantum_m=0.2", NULL};
    scene a = scene_open("sea_watched", NULL), b = scene_open("sea_watched", coarse);
    scene_run(&a, 30, NULL);
    scene_run(&b, 30, NULL);
    double hermite = summary(&a, 0, LL_METRIC_TIMELINE_ERROR).rms,
           lines = summary(&a, 1, LL_METRIC_TIMELINE_ERROR).rms;
    double rounded = summary(&b, 1, LL_METRIC_TIMELINE_ERROR).rms, step = 0.2;
    assert_true(hermite < lines / 5 && lines > 0.003 && lines < 0.02);
    /* uniform rounding of two axes has an rms of step / sqrt(6); between two snapshots less of it is left */
    assert_true(rounded > step / sqrt(6) / 2 && rounded < step / sqrt(6) + lines);
    assert_true(per_state(&b, 0) < per_state(&a, 0));
    scene_close(&a);
    scene_close(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_codec_changes_only_the_drawn_others),
        cmocka_unit_test(delta_equals_quantised),
        cmocka_unit_test(rounding_is_uniform),
        cmocka_unit_test(snapshots_over_a_bad_link_are_decoded),
        cmocka_unit_test(long_states_travel_as_fragments),
        cmocka_unit_test(the_link_carries_the_encoded_bytes),
        cmocka_unit_test(a_codec_may_change_while_it_runs),
        cmocka_unit_test(scopes_differ_by_corrections_of_pushes),
        cmocka_unit_test(games_in_turn_are_games_alone),
        cmocka_unit_test(water_is_drawn_between_states),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
