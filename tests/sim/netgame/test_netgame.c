/* A netgame as a whole: techniques, links and rules, compared with their definitions. */
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

static double moved(const scene *s, int player)
{
    return ll_server_world(ll_netgame_server(s->game))->entity[player].x;
}

#define ALL_ON(p)                                                                                            \
    "players." p ".prediction=true", "players." p ".reconciliation=true", "players." p ".interpolation=true"

static void clean_link_needs_no_correction(void **state)
{
    (void)state;
    const char *const lags[] = {"players.0.lag_ms=0", "players.0.lag_ms=37.3", "players.0.lag_ms=150",
                                "players.0.lag_ms=1000"};
    for (size_t i = 0; i < sizeof lags / sizeof lags[0]; i++) {
        const char *const sets[] = {lags[i], ALL_ON("0"), ALL_ON("1"), NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 40, NULL);
        assert_true(moved(&s, 0) > 200);
        for (int p = 0; p < 2; p++) {
            assert_int_equal(ll_netgame_client_metrics(s.game, p)->corrections.count, 0);
            assert_true(summary(&s, p, LL_METRIC_INPUT_LATENCY).max == 0);
            assert_true(summary(&s, p, LL_METRIC_POP).count > 1000);
            assert_int_equal(ll_netgame_server(s.game)->client_slots[p].counts.late, 0);
        }
        scene_close(&s);
    }
}

/* The own car is drawn input_delay_ticks later: more input latency, less lead over the server, and smaller
 * errors after contact with another car. */
static void input_delay_trades_latency_for_corrections(void **state)
{
    (void)state;
    static const char *const delays[] = {"0", "4", "8"};
    double lead[3], wrong[3];
    for (int i = 0; i < 3; i++) {
        char a[64], b[64];
        snprintf(a, sizeof a, "players.0.input_delay_ticks=%s", delays[i]);
        snprintf(b, sizeof b, "players.1.input_delay_ticks=%s", delays[i]);
        const char *const clean[] = {a, ALL_ON("0"), "players.0.script=steady", "warmup_s=8", NULL};
        const char *const contact[] = {a, b, NULL}, *const varied[] = {a, ALL_ON("0"), NULL};
        scene s = scene_open("race", clean), t = scene_open("contact", contact),
              u = scene_open("race", varied);
        scene_run(&s, 20, NULL);
        scene_run(&t, 60, NULL);
        scene_run(&u, 20, NULL);
        ll_summary latency = summary(&u, 0, LL_METRIC_INPUT_LATENCY);
        scene_close(&u);
        assert_true(latency.count > 10);
        assert_near(latency.mean, 1000 * atof(delays[i]) / 60, 1e-3);
        assert_true(latency.max - latency.mean < 1e-3);
        assert_int_equal(ll_netgame_client_metrics(s.game, 0)->corrections.count, 0);
        lead[i] = summary(&s, 0, LL_METRIC_OWN_LEAD).mean;
        wrong[i] = summary(&t, 0, LL_METRIC_CORRECTION).mean;
        scene_close(&s);
        scene_close(&t);
    }
    assert_near(lead[0] - lead[1], 16 * 4 / 60.0, 1e-6); /* at 16 m/s */
    assert_near(lead[0] - lead[2], 16 * 8 / 60.0, 1e-6);
    assert_true(wrong[0] > 1.1 * wrong[1] && wrong[1] > 1.1 * wrong[2] && wrong[2] > 0);
}

static void contact_is_mispredicted_and_corrected(void **state)
{
    (void)state;
    scene s = scene_open("contact", NULL);
    scene_run(&s, 40, NULL);
    assert_true(moved(&s, 0) > 100);
    assert_true(ll_netgame_client_metrics(s.game, 0)->corrections.count > 10);
    assert_true(ll_netgame_client_metrics(s.game, 1)->corrections.count > 10);
    scene_close(&s);
}

/* Without prediction an input is seen after the lag, the wait for its step and for an update, the lag again,
 * and the wait for a display. With a lag of 9 ticks and a tick of slack, a change made `phase` after a step
 * of the server's counts for the step 10 ticks later, or 11 if it arrives after a step; every second step is
 * sent; and it is seen at the same phase. */
static void without_prediction_input_takes_a_round_trip(void **state)
{
    (void)state;
    static const double phases[] = {0, 0.01, 0.3, 0.95};
    for (size_t i = 0; i < sizeof phases / sizeof phases[0]; i++) {
        char phase[48];
        snprintf(phase, sizeof phase, "players.0.clock_phase=%g", phases[i]);
        const char *const sets[] = {"players.0.prediction=false", phase, NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 20, NULL);
        ll_summary input_latency = summary(&s, 0, LL_METRIC_INPUT_LATENCY),
                   ack = summary(&s, 0, LL_METRIC_ACK_RTT);
        double tick = 1000.0 / 60, least = (phases[i] == 0 ? 19 : 20) * tick;
        assert_true(input_latency.count > 10 && input_latency.mean >= least &&
                    input_latency.mean <= least + tick);
        assert_true(fabs(input_latency.max - least - tick) < 0.01 || fabs(input_latency.max - least) < 0.01);
        /* inputs of both kinds equally often; from making to the arrival of the snapshot, before the
         * display's wait */
        double arrives = least - phases[i] * tick;
        assert_near(ack.mean - arrives, tick / 2, 0.05);
        assert_near(ack.max - arrives, tick, 0.05);
        scene_close(&s);
    }
}

/* Prediction alone moves at once, but every snapshot resets it to what the server knew one lag ago: the own
 * car is drawn behind the truth, and jumps when its controls change. With reconciliation it is drawn ahead
 * and does not jump. */
static void prediction_alone_is_thrown_back(void **state)
{
    (void)state;
    const char *const alone[] = {"players.0.reconciliation=false", "warmup_s=0", NULL};
    scene a = scene_open("race", alone), b = scene_open("race", NULL);
    scene_run(&a, 20, NULL);
    scene_run(&b, 20, NULL);
    assert_true(summary(&a, 0, LL_METRIC_INPUT_LATENCY).max == 0);
    assert_true(ll_netgame_client_metrics(a.game, 0)->corrections.count > 100);
    assert_true(summary(&a, 0, LL_METRIC_POP).max > 0.06); /* at least the start: 1/2 * 6 m/s2 * (0.15 s)^2 */
    assert_true(ll_netgame_client_metrics(a.game, 0)->last.own_lead < 0);
    assert_int_equal(ll_netgame_client_metrics(b.game, 0)->corrections.count, 0);
    assert_true(ll_netgame_client_metrics(b.game, 0)->last.own_lead > 0);
    scene_close(&a);
    scene_close(&b);
}

/* Remote entities are drawn lag + ratio / rate + margin in the past, between two snapshots, and stay on the
 * true path. */
static void interpolation_draws_the_true_path_later(void **state)
{
    (void)state;
    const char *const sets[] = {"players.1.script=steady", "warmup_s=8", "players.0.clock_phase=0", NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, 30, NULL); /* a display of A and a step of the server */
    ll_summary age = summary(&s, 0, LL_METRIC_VIEW_AGE);
    assert_near(age.mean, (150 + 2000.0 / 30 + 10), 0.1);
    assert_true(age.max - age.mean < 0.1);
    assert_true(summary(&s, 0, LL_METRIC_TIMELINE_ERROR).max <
                1e-5); /* constant speed: the chord is the path; times are whole ns */
    double truth = moved(&s, 1), drawn = ll_client_rendered(ll_netgame_client(s.game, 0))->entity[1].x;
    assert_near(truth - drawn, 16 * age.mean / 1000, 1e-3);
    scene_close(&s);
}

/* At ratio 2 a jitter up to (ratio - 1) / rate + margin freezes nothing; the demo's rule does freeze on the
 * same link. */
static void jitter_below_the_margin_does_not_freeze(void **state)
{
    (void)state;
    const char *const ours[] = {"server.update_hz=10",
                                "players.0.interpolation=true",
                                "players.0.link.down.jitter_ms=30",
                                "players.1.link.up.jitter_ms=30",
                                "players.1.script=steady",
                                "duration_s=120",
                                NULL};
    const char *const demo[] = {"server.update_hz=10",
                                "players.0.interpolation=true",
                                "players.0.link.down.jitter_ms=30",
                                "players.1.link.up.jitter_ms=30",
                                "players.1.script=steady",
                                "duration_s=120",
                                NULL};
    scene a = scene_open("gambetta_default", ours), b = scene_open("gambetta", demo);
    scene_run(&a, 120, NULL);
    scene_run(&b, 120, NULL);
    assert_int_equal(ll_netgame_client_metrics(a.game, 0)->buffer.underruns, 0);
    assert_true(ll_netgame_client_metrics(b.game, 0)->buffer.underruns > 20);
    scene_close(&a);
    scene_close(&b);
}

/* A change of lag during a run: the client finds its new lead, and then everything is as if the lag had
 * always been so. */
static void lag_may_change_while_it_runs(void **state)
{
    (void)state;
    const double lags[] = {500, 20, 1000, 0, 150};
    const char *const sets[] = {ALL_ON("0"), ALL_ON("1"), NULL};
    scene s = scene_open("race", sets);
    double t = 4;
    scene_run(&s, t, NULL);
    for (size_t i = 0; i < sizeof lags / sizeof lags[0]; i++) {
        ll_netgame_config config = scene_config(s.game);
        config.players[0].lag_ms = lags[i];
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, t += 6, NULL);
        ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[0];
        int64_t late = client_slot->counts.late, starved = client_slot->counts.starved;
        int64_t corrections = ll_netgame_client_metrics(s.game, 0)->corrections.count;
        scene_run(&s, t += 2, NULL);
        assert_int_equal(client_slot->counts.late, late);
        assert_int_equal(client_slot->counts.starved, starved);
        assert_int_equal(ll_netgame_client_metrics(s.game, 0)->corrections.count, corrections);
        assert_true(client_slot->snapshots.last_slack >= 1 && client_slot->snapshots.last_slack <= 2);
    }
    scene_close(&s);
}

/* Repeated inputs survive loss: hardly any step is starved. */
static void repeated_inputs_survive_loss(void **state)
{
    (void)state;
    const char *const with[] = {ALL_ON("0"), "players.0.link.up.loss_pct=10", "players.0.slack_ticks=3",
                                NULL};
    const char *const without[] = {ALL_ON("0"), "players.0.link.up.loss_pct=10", "players.0.slack_ticks=3",
                                   "players.0.redundancy=0", NULL};
    scene a = scene_open("race", with), b = scene_open("race", without);
    scene_run(&a, 60, NULL);
    scene_run(&b, 60, NULL);
    int64_t starved = ll_netgame_server(a.game)->client_slots[0].counts.starved,
            bare = ll_netgame_server(b.game)->client_slots[0].counts.starved;
    assert_true(bare > 250 && bare < 450); /* 10 % of 3600 */
    assert_true(starved < 20);             /* three losses in a row: 0.1 % */
    scene_close(&a);
    scene_close(&b);
}

/* Lockstep stalls for a lost input and continues; no player is ever corrected. With inputs in flight it
 * nearly keeps its rate. Stop and wait asks again after 200 ms and twice the round trip: 0.6 of B's packets
 * are lost, so it asks 2.5 times on average, up to 1.6 s apart, and A 1.4 times for the snapshot: a step
 * takes about 3.5 s, and at most twice that. */
static void lockstep_survives_loss_and_jitter(void **state)
{
    (void)state;
    static const struct {
        const char *sync;
        int64_t least, most;
    } cases[] = {{"server.sync=lockstep_pipelined", 1400, 60 * 30},
                 {"server.sync=lockstep", 60 / 7, 60 * 1.875}};
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {cases[i].sync,
                                    "players.0.link.up.loss_pct=30",
                                    "players.0.link.down.loss_pct=30",
                                    "players.1.link.up.jitter_ms=200",
                                    "players.1.link.up.loss_pct=60",
                                    "duration_s=60",
                                    NULL};
        scene s = scene_open("paper/fig11", sets);
        scene_run(&s, 60, NULL);
        ll_server *server = ll_netgame_server(s.game);
        assert_in_range(server->step, cases[i].least, cases[i].most);
        assert_true(server->stalled > LL_SECOND / 4);
        assert_int_equal(ll_netgame_client_metrics(s.game, 0)->corrections.count, 0);
        scene_close(&s);
    }
}

/* Sets B's loss up. */
static void silence(scene *s, double loss_pct)
{
    ll_netgame_config config = scene_config(s->game);
    config.players[1].link.up.loss_pct = loss_pct;
    s->scenario.kind->change(s->game, &config, s->game->now);
}

/* Steps in `seconds` of an undisturbed lockstep over the links of Figure 11. */
static double steps_in(int pipelined, double seconds)
{
    return seconds * (pipelined ? 30 : 1.875);
}

/* Without a timeout, or before it, all wait for the player without limit; when it is back they continue at
 * once and at the same rate. */
static void lockstep_stops_without_a_player_and_continues_with_it(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {i % 2 ? "server.sync=lockstep_pipelined" : "server.sync=lockstep",
                                    i < 2 ? "server.timeout_s=0" : "server.timeout_s=13", NULL};
        scene s = scene_open("paper/fig11", sets);
        scene_run(&s, 5, NULL);
        silence(&s, 100);
        scene_run(&s, 6, NULL);
        int64_t step = ll_netgame_server(s.game)->step;
        scene_run(&s, 16, NULL);
        assert_int_equal(ll_netgame_server(s.game)->step, step);
        silence(&s, 0);
        scene_run(&s, 18, NULL); /* 2 s and twice the round trip is the limit */
        step = ll_netgame_server(s.game)->step;
        scene_run(&s, 28, NULL);
        assert_near((double)(ll_netgame_server(s.game)->step - step), steps_in(i % 2, 10), 1);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[1].connection.drops, 0);
        assert_int_equal(ll_netgame_client(s.game, 1)->connection.joins, 1);
        scene_close(&s);
    }
}

/* Either direction fails, for any player, for any time below the timeout: within 2 s and twice the round trip
 * after the link is good again, the rate is what it was. Repeated requests are answered again, also where
 * nothing steps. */
static void lockstep_recovers_from_any_outage(void **state)
{
    (void)state;
    static const double lengths_s[] = {0.13, 0.4, 1.1, 3.7};
    for (int i = 0; i < 2 * 3 * 3 * 4 * 2; i++) {
        int pipelined = i % 2, ways = 1 + i / 2 % 3, players = 1 + i / 6 % 3;
        double length_s = lengths_s[i / 18 % 4], begin_s = i < 72 ? 5.2 : 0; /* from the start on, too */
        const char *const sets[] = {pipelined ? "server.sync=lockstep_pipelined" : "server.sync=lockstep",
                                    NULL};
        scene s = scene_open("paper/fig11", sets);
        scene_run(&s, begin_s, NULL);
        ll_netgame_config config = scene_config(s.game), well = config;
        for (int p = 0; p < 2; p++) {
            config.players[p].link.up.loss_pct = players >> p & ways & 1 ? 100 : 0;
            config.players[p].link.down.loss_pct = players >> p & ways >> 1 & 1 ? 100 : 0;
        }
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, begin_s + length_s, NULL);
        s.scenario.kind->change(s.game, &well, s.game->now);
        scene_run(&s, begin_s + length_s + 3, NULL);
        int64_t step = ll_netgame_server(s.game)->step;
        scene_run(&s, begin_s + length_s + 13, NULL);
        double steps = (double)(ll_netgame_server(s.game)->step - step);
        for (int p = 0; p < 2; p++)
            assert_int_equal(ll_netgame_client_metrics(s.game, p)->false_refusals, 0);
        if (!is_near(steps, steps_in(pipelined, 10), 1))
            fail_msg("%s, ways %d of players %d for %g s: %g steps in 10 s", sets[0], ways, players, length_s,
                     steps);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[0].connection.drops +
                             ll_netgame_server(s.game)->client_slots[1].connection.drops,
                         0);
        scene_close(&s);
    }
}

/* After the timeout the player is dropped and the others continue, at the rate of those who are connected;
 * when its link is back it joins again. */
static void lockstep_drops_a_silent_player_and_accepts_it_again(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {i ? "server.sync=lockstep_pipelined" : "server.sync=lockstep", NULL};
        scene s = scene_open("paper/fig11", sets);
        ll_server *server = ll_netgame_server(s.game);
        scene_run(&s, 5, NULL);
        silence(&s, 100);
        scene_run(&s, 6, NULL);
        int64_t step = server->step;
        scene_run(&s, 9.4, NULL);
        assert_int_equal(server->step, step); /* received at 5 s, minus the age of its last answer */
        scene_run(&s, 11, NULL);
        assert_int_equal(server->client_slots[1].connection.connected, 0);
        step = server->step;
        scene_run(&s, 21, NULL);
        double alone = i ? 300 : 10 / (0.3 + 1 / 30.0); /* A's round trip and an interval */
        assert_near((double)(server->step - step), alone, 1);
        assert_true(ll_server_world(server)->entity[1].flags & LL_ENTITY_AWAY);
        silence(&s, 0);
        scene_run(&s, 24, NULL);
        assert_int_equal(server->client_slots[1].connection.connected, 1);
        assert_int_equal(ll_netgame_client(s.game, 1)->connection.state, LL_CONNECTION_PLAYING);
        assert_false(ll_server_world(server)->entity[1].flags & LL_ENTITY_AWAY);
        step = server->step;
        double x = moved(&s, 1);
        scene_run(&s, 34, NULL);
        assert_near((double)(server->step - step), steps_in(i, 10), 1);
        assert_true(moved(&s, 1) > x);
        scene_close(&s);
    }
}

/* At the extremes of every range honest players are served: nothing refused, late, or lost to a full
 * queue. */
static void extremes_of_the_ranges_are_served(void **state)
{
    (void)state;
    const char *const free_[] = {ALL_ON("0"),
                                 "tick_hz=64",
                                 "server.update_hz=1",
                                 "players.0.lag_ms=1000",
                                 "players.0.link.up.delay_ms=150",
                                 "players.0.link.up.jitter_ms=100",
                                 "players.0.link.down.delay_ms=250",
                                 "players.0.interpolation_ratio=4",
                                 "players.0.jitter_margin_ms=500",
                                 "warmup_s=12",
                                 NULL};
    const char *const often[] = {ALL_ON("0"),
                                 "tick_hz=64",
                                 "server.update_hz=120",
                                 "players.0.lag_ms=1000",
                                 "players.0.link.down.delay_ms=250",
                                 "players.0.jitter_margin_ms=500",
                                 "warmup_s=12",
                                 NULL};
    const char *const lockstep[] = {"server.sync=lockstep_pipelined",
                                    "tick_hz=60",
                                    "server.update_hz=60",
                                    "players.0.lag_ms=1000",
                                    "players.0.link.up.delay_ms=250",
                                    "players.0.link.down.delay_ms=250",
                                    "warmup_s=12",
                                    NULL};
    const char *const *const all[] = {free_, often, lockstep};
    for (size_t i = 0; i < 3; i++) {
        scene s = scene_open("race", all[i]);
        scene_run(&s, 20, NULL);
        int64_t late = ll_netgame_server(s.game)->client_slots[0].counts.late;
        scene_run(&s, 60, NULL);
        assert_true(moved(&s, 0) > 100);
        for (int p = 0; p < 2; p++) {
            const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[p];
            for (int rule = 1; rule < LL_RULES; rule++)
                assert_int_equal(client_slot->counts.refused[rule], 0);
            assert_int_equal(ll_link_get_stats(ll_netgame_up(s.game, p))->overflowed, 0);
            assert_int_equal(ll_link_get_stats(ll_netgame_down(s.game, p))->overflowed, 0);
            assert_true(summary(&s, p, LL_METRIC_TIMELINE_ERROR).max <
                        16 * 1.1); /* chords of up to a second */
        }
        assert_true(ll_netgame_server(s.game)->client_slots[0].counts.late - late <=
                    2560 / 100); /* the client learns the jitter from late inputs */
        scene_close(&s);
    }
}

/* A change of the sync mode during a run is a resync: cars continue from where they are. */
static void sync_may_change_while_it_runs(void **state)
{
    (void)state;
    const char *const sets[] = {ALL_ON("0"),
                                "players.0.script=steady",
                                "players.1.script=steady",
                                "players.0.input_delay_ticks=16",
                                "players.1.input_delay_ticks=16",
                                "params.laps=10000",
                                NULL};
    scene s = scene_open("race", sets);
    double t = 4, last = 0;
    scene_run(&s, t, NULL);
    int syncs = 0;
    while (ll_syncs[syncs])
        syncs++;
    for (int i = 0; i < 2 * syncs * syncs; i++) { /* from each to each */
        ll_netgame_config config = scene_config(s.game);
        config.server.sync = i % 2 ? i / 2 % syncs : i / 2 / syncs;
        config.bucket_delay_ms = 400; /* longer than every link */
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, t += 2, NULL);
        /* stop and wait makes three or four steps of 1/30 s in 2 s */
        assert_true(moved(&s, 0) > last + (ll_syncs[config.server.sync]->answers ? 16.0 / 30 * 2.9 : 10));
        last = moved(&s, 0);
        for (int p = 0; p < 2;
             p++) { /* no client takes a packet still on its way as a sign of being dropped */
            assert_int_equal(ll_netgame_client(s.game, p)->connection.joins, 1);
            assert_int_equal(ll_netgame_client(s.game, p)->connection.state, LL_CONNECTION_PLAYING);
        }
    }
    scene_close(&s);
}

static void update_rate_is_kept(void **state)
{
    (void)state;
    const char *const rates[] = {"server.update_hz=1", "server.update_hz=7", "server.update_hz=60",
                                 "server.update_hz=120"};
    const double wanted[] = {1, 7, 60, 120};
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {rates[i], NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 20, NULL);
        double got = (double)ll_netgame_client_metrics(s.game, 0)->traffic.messages[LL_MESSAGE_SNAPSHOT] /
                     18; /* after the warm-up */
        assert_near(got, wanted[i], 1.0 / 18 + 1e-9);
        scene_close(&s);
    }
}

/* Each cheat is refused by its rule and informed; an honest player on a bad link never is. */
static void cheats_are_refused_and_answered(void **state)
{
    (void)state;
    const struct {
        const char *set;
        ll_rule rule;
    } cheats[] = {{"players.0.cheat=magnitude", LL_RULE_MAGNITUDE},
                  {"players.0.cheat=rate", LL_RULE_BUDGET}, /* it runs ahead */
                  {"players.0.cheat=budget", LL_RULE_BUDGET},
                  {"players.0.cheat=lag_switch", LL_RULE_RATE}};
    for (size_t i = 0; i < 4; i++) {
        const char *const sets[] = {cheats[i].set,
                                    "players.0.script=steady",
                                    "players.1.script=steady",
                                    "players.1.link.up.jitter_ms=100",
                                    "players.1.link.up.loss_pct=2",
                                    NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 30, NULL);
        ll_server *server = ll_netgame_server(s.game);
        assert_true(server->client_slots[0].counts.refused[cheats[i].rule] > 0);
        assert_true(ll_netgame_client(s.game, 0)->inputs.refused > 100);
        assert_true(moved(&s, 0) <=
                    moved(&s, 1) + 16 * 0.5); /* no gain beyond the head start of the better link */
        for (int rule = 1; rule < LL_RULES; rule++)
            assert_int_equal(server->client_slots[1].counts.refused[rule], 0);
        scene_close(&s);
    }
}

static void reconciliation_and_prediction_depend_on_each_other(void **state)
{
    (void)state;
    ll_player_config before = {0}, now = {.reconciliation = true};
    ll_player_apply_dependencies(&now, &before);
    assert_true(now.prediction && now.reconciliation);
    before = now;
    now.prediction = false;
    ll_player_apply_dependencies(&now, &before);
    assert_false(now.prediction || now.reconciliation);
}

static void block_may_be_moved(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"eight", "rollback_loss"};
    for (int k = 0; k < 2; k++) {
        scene s = scene_open(scenarios[k], NULL), t = scene_open(scenarios[k], NULL);
        for (int i = 1; i <= 60; i++) { /* every sixth of a second to another place */
            scene_run(&s, i / 6.0, NULL);
            ll_netgame *elsewhere = malloc(ll_netgame_bytes(s.game));
            memcpy(elsewhere, s.game, ll_netgame_bytes(s.game));
            memset(s.game, 0xee, ll_netgame_bytes(s.game));
            free(s.game);
            s.game = elsewhere;
        }
        scene_run(&t, 10, NULL);
        assert_int_equal(s.scenario.kind->hash(s.game), t.scenario.kind->hash(t.game));
        scene_close(&s);
        scene_close(&t);
    }
}

static void recording_changes_nothing(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"eight", "rollback_loss", "desync_ulp"};
    for (int k = 0; k < 3; k++) {
        tape all = {0};
        ll_recorder r = tape_recorder(&all);
        scene s = scene_open(scenarios[k], NULL), t = scene_open(scenarios[k], NULL);
        scene_run(&s, 20, NULL);
        scene_run(&t, 20, &r);
        assert_true(all.count > 5000);
        for (size_t i = 1; i < all.count; i++)
            assert_true(all.events[i].begin >= all.events[i - 1].begin);
        assert_int_equal(s.scenario.kind->hash(s.game), t.scenario.kind->hash(t.game));
        scene_close(&s);
        scene_close(&t);
        tape_free(&all);
    }
}

static void a_value_that_is_not_finite_stops_at_its_tick(void **state)
{
    (void)state;
    scene s = scene_open("race", NULL);
    scene_run(&s, 5, NULL);
    ll_server_world(ll_netgame_server(s.game))->entity[1].vx = NAN;
    ll_status status = s.scenario.kind->advance(s.game, 10 * LL_SECOND, NULL, NULL, NULL, NULL);
    assert_int_equal(status.code, LL_DIVERGED);
    assert_non_null(strstr(status.text, "player B"));
    assert_true(s.game->now <= 5 * LL_SECOND + 17 * LL_MS);
    scene_close(&s);
}

/* A prediction may diverge while the server's world is finite: the next snapshot would hide it. */
static void a_view_that_is_not_finite_stops_at_its_display(void **state)
{
    (void)state;
    const char *const sets[] = {ALL_ON("0"), ALL_ON("1"), NULL};
    for (int viewer = 0; viewer < 2; viewer++) {
        scene s = scene_open("race", sets);
        scene_run(&s, 5, NULL);
        ll_client_predicted(ll_netgame_client(s.game, viewer))->entity[viewer].x = NAN;
        ll_status status = s.scenario.kind->advance(s.game, 10 * LL_SECOND, NULL, NULL, NULL, NULL);
        assert_int_equal(status.code, LL_DIVERGED);
        assert_non_null(strstr(status.text, viewer == 0 ? "player A in the view of player A is not finite"
                                                        : "player B in the view of player B is not finite"));
        assert_true(s.game->now <= 5 * LL_SECOND + 17 * LL_MS);
        assert_true(isfinite(moved(&s, viewer)));
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clean_link_needs_no_correction),
        cmocka_unit_test(input_delay_trades_latency_for_corrections),
        cmocka_unit_test(contact_is_mispredicted_and_corrected),
        cmocka_unit_test(without_prediction_input_takes_a_round_trip),
        cmocka_unit_test(prediction_alone_is_thrown_back),
        cmocka_unit_test(interpolation_draws_the_true_path_later),
        cmocka_unit_test(jitter_below_the_margin_does_not_freeze),
        cmocka_unit_test(lag_may_change_while_it_runs),
        cmocka_unit_test(repeated_inputs_survive_loss),
        cmocka_unit_test(lockstep_survives_loss_and_jitter),
        cmocka_unit_test(lockstep_stops_without_a_player_and_continues_with_it),
        cmocka_unit_test(lockstep_recovers_from_any_outage),
        cmocka_unit_test(lockstep_drops_a_silent_player_and_accepts_it_again),
        cmocka_unit_test(extremes_of_the_ranges_are_served),
        cmocka_unit_test(sync_may_change_while_it_runs),
        cmocka_unit_test(update_rate_is_kept),
        cmocka_unit_test(cheats_are_refused_and_answered),
        cmocka_unit_test(reconciliation_and_prediction_depend_on_each_other),
        cmocka_unit_test(block_may_be_moved),
        cmocka_unit_test(recording_changes_nothing),
        cmocka_unit_test(a_value_that_is_not_finite_stops_at_its_tick),
        cmocka_unit_test(a_view_that_is_not_finite_stops_at_its_display),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
