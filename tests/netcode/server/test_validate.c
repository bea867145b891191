/* The server's rules at their limits, and a client that keeps them. */
#include "netcode/toy.h"

#include <stdio.h>

#include "base/rng.h"
#include "support/near.h"
#include "support/scene.h"

static ll_rule judge(double x, double y, double budget_use)
{
    ll_rate_limiter full = {LL_RATE_BURST, 0};
    ll_action a = {.axis = {(float)x, (float)y}};
    return ll_validate(&a, budget_use, &full, HZ(60), 0);
}

static void axes_end_at_one(void **state)
{
    (void)state;
    const double good[] = {0, -0.0, 1, -1, 0.5, 1e-45, -1e-45, 0.99999994};
    const double bad[] = {nextafterf(1, 2), nextafterf(-1, -2), 1.5, -2, 3e38, -3e38,
                          INFINITY,         -INFINITY,          NAN};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        for (size_t j = 0; j < sizeof good / sizeof good[0]; j++)
            assert_int_equal(judge(good[i], good[j], 1), LL_RULE_NONE);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        assert_int_equal(judge(bad[i], 0, 1), LL_RULE_MAGNITUDE);
        assert_int_equal(judge(0, bad[i], 1), LL_RULE_MAGNITUDE);
    }
}

static void budget_ends_before_its_number(void **state)
{
    (void)state;
    const int64_t good[] = {1, 2, LL_BUDGET_TICKS - 1},
                  bad[] = {LL_BUDGET_TICKS, LL_BUDGET_TICKS + 1, 1000, INT32_MAX};
    for (int i = 0; i < 7; i++) {
        ll_server *server = new_server(1, &ll_sync_free, 60, 60);
        ll_input_message m = inputs(i < 3 ? good[i] : bad[i - 3], 1, (double[]){1});
        ll_input_result v[LL_INPUTS_MAX];
        assert_int_equal(ll_server_receive(server, &ll_sync_free, 0, &m, 0, v), 1);
        assert_int_equal(v[0].rule, i < 3 ? LL_RULE_NONE : LL_RULE_BUDGET);
        assert_true(server->client_slots[0].limits.budget_used <= 1);
        free(server);
    }
    assert_int_equal(judge(1, 0, 1), LL_RULE_NONE);
    assert_int_equal(judge(1, 0, nextafter(1, 2)), LL_RULE_BUDGET);
    assert_int_equal(judge(1, 0, INFINITY), LL_RULE_BUDGET);
    assert_true(LL_INPUT_RING >= 2 * LL_BUDGET_TICKS);
}

static int64_t spend_all(ll_time_budget *account, const ll_action *a, ll_freq freq, ll_time now)
{
    int64_t taken = 0;
    for (; ll_time_use(account, a, freq, now) <= 1; taken++)
        ll_time_spend(account, a, freq, now);
    return taken;
}

/* Processed input time never exceeds elapsed time by more than 80 ticks, or 4/3 s: at once, in the long run,
 * and for any stated duration of the inputs. */
static void input_time_is_held_to_the_clock(void **state)
{
    (void)state;
    const ll_action tick = push(1), nothing = push(0), longer = push(-1.25);
    ll_time_budget account = {0, 0};
    assert_int_equal(spend_all(&account, &tick, HZ(60), 0), 80);
    assert_int_equal(spend_all(&account, &tick, HZ(60), 0), 0);
    assert_int_equal(spend_all(&account, &tick, HZ(60), LL_SECOND / 5 + 1), 12); /* 0.2 s */
    assert_int_equal(spend_all(&account, &nothing, HZ(60), LL_SECOND / 5 + 17 * LL_MS), 1);
    assert_int_equal(spend_all(&account, &tick, HZ(60), 3600 * LL_SECOND), 80);
    assert_int_equal(spend_all(&account, &longer, HZ(60), 3602 * LL_SECOND), 64); /* 80 / 1.25 */
    account = (ll_time_budget){0, 0};
    assert_int_equal(spend_all(&account, &tick, HZ(240), 0), 320); /* 4/3 s */
    int64_t taken = 0;
    account = (ll_time_budget){0, 0};
    for (int64_t i = 0; i <= 600 * 1000; i++) /* as many as are permitted, for ten minutes */
        taken += spend_all(&account, &tick, HZ(60), i * LL_MS);
    assert_in_range(taken, 80 + 600 * 60 - 1, 80 + 600 * 60);
}

/* A client with one input per tick uses hardly any of the budget, also with late timers that make fewer and
 * longer ones; after a stall of the link of a second, it uses a second. */
static void honest_inputs_are_within_their_time(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        ll_time_budget steady = {0, 0}, late = {0, 0}, stalled = {0, 0};
        ll_time last = 0, now = 0;
        double most[3] = {0, 0, 0};
        for (int64_t k = 1; k < 6000; k++) {
            const ll_action tick = push(1);
            ll_time at = ll_tick_time(k, HZ(50)),
                    came = k % 500 < 50 ? ll_tick_time(k - k % 500 + 50, HZ(50)) : at;
            now = last + LL_SECOND / 50 + (ll_time)(ll_rng_u64(seed, 0, (uint64_t)k) % (5 * LL_MS));
            const ll_action pressed = push((double)(now - last) / (double)(LL_SECOND / 50));
            const double use[3] = {ll_time_use(&steady, &tick, HZ(50), at),
                                   ll_time_use(&late, &pressed, HZ(50), now),
                                   ll_time_use(&stalled, &tick, HZ(50), came)};
            ll_time_spend(&steady, &tick, HZ(50), at);
            ll_time_spend(&late, &pressed, HZ(50), now);
            ll_time_spend(&stalled, &tick, HZ(50), came);
            for (int i = 0; i < 3; i++)
                most[i] = larger(most[i], use[i]);
            last = now;
        }
        assert_true(most[0] <= 1.01 / 80 && most[1] <= 1.26 / 80);
        assert_true(most[2] > 49.0 / 80 && most[2] <= 51.0 / 80);
    }
}

static int64_t take_all(ll_rate_limiter *allowance, ll_freq freq, ll_time now)
{
    ll_action a = push(1);
    int64_t taken = 0;
    while (taken < 100000 && ll_validate(&a, 1, allowance, freq, now) == LL_RULE_NONE)
        taken++;
    assert_int_equal(ll_validate(&a, 1, allowance, freq, now), LL_RULE_RATE);
    return taken;
}

/* 80 at once; then 2.25 for each tick of the client, kept up to 80. */
static void bucket_fills_with_time(void **state)
{
    (void)state;
    ll_rate_limiter bucket = {LL_RATE_BURST, 0};
    assert_int_equal(take_all(&bucket, HZ(60), 0), 80);
    assert_int_equal(take_all(&bucket, HZ(60), 0), 0);
    assert_int_equal(take_all(&bucket, HZ(60), LL_SECOND / 5 + LL_MS), 27); /* 0.201 s x 135 / s = 27.135 */
    assert_int_equal(take_all(&bucket, HZ(60), LL_SECOND / 5 + 7 * LL_MS), 0); /* 0.945 of one */
    assert_int_equal(take_all(&bucket, HZ(60), LL_SECOND / 5 + 8 * LL_MS), 1); /* 1.08 */
    assert_int_equal(take_all(&bucket, HZ(60), 3600 * LL_SECOND), 80);
    assert_int_equal(take_all(&bucket, HZ(10), 3601 * LL_SECOND), 22); /* 22.5 */
    assert_int_equal(take_all(&bucket, HZ(10), 3602 * LL_SECOND), 23); /* 22.5 + 0.5 left */
}

/* A flood in the long run: not one more than the burst and the rate permit. */
static void flood_is_held_to_the_rate(void **state)
{
    (void)state;
    ll_rate_limiter bucket = {LL_RATE_BURST, 0};
    ll_action a = push(1);
    int64_t taken = 0;
    for (int64_t i = 0; i <= 600 * 1000; i++) /* 1000 inputs per second for ten minutes */
        taken += ll_validate(&a, 1, &bucket, HZ(60), i * LL_MS) == LL_RULE_NONE;
    assert_in_range(taken, 80 + 600 * 135 - 1, 80 + 600 * 135);
}

static void refused_inputs_cost_nothing(void **state)
{
    (void)state;
    ll_rate_limiter bucket = {1, 0};
    ll_action wild = push(2), good = push(1);
    for (int i = 0; i < 100; i++) {
        assert_int_equal(ll_validate(&wild, 1, &bucket, HZ(60), 0), LL_RULE_MAGNITUDE);
        assert_int_equal(ll_validate(&good, 1.01, &bucket, HZ(60), 0), LL_RULE_BUDGET);
    }
    assert_int_equal(ll_validate(&good, 1, &bucket, HZ(60), 0), LL_RULE_NONE);
    assert_int_equal(ll_validate(&good, 1, &bucket, HZ(60), 0), LL_RULE_RATE);
}

/* A client's inputs arrive in any rhythm that its link causes, also all of a second at once. */
static void late_and_bunched_inputs_are_honest(void **state)
{
    (void)state;
    const double rates[] = {10, 50, 60, 120, 240};
    ll_action a = push(1);
    for (size_t r = 0; r < sizeof rates / sizeof rates[0]; r++) {
        ll_freq freq = ll_freq_from_hz(rates[r]);
        ll_server *server = new_server(1, &ll_sync_free, rates[r], rates[r]);
        ll_rate_limiter bucket = server->client_slots[0].limits.allowance;
        ll_time held_until = 0;
        for (int64_t k = 0; k < (int64_t)(rates[r] * 300); k++) {
            ll_time sent = ll_tick_time(k, freq);
            if (k % (int64_t)(rates[r] * 5) == 0)
                held_until = sent + LL_SECOND; /* the link stalls */
            ll_time comes = sent + (ll_time)(ll_rng_u64(1, r, (uint64_t)k) % (20 * LL_MS));
            ll_time came = comes > held_until ? comes : held_until;
            came = came > bucket.filled ? came : bucket.filled;
            assert_int_equal(ll_validate(&a, 1, &bucket, freq, came), LL_RULE_NONE);
        }
        free(server);
    }
}

/* A client that is behind makes two inputs per frame until it is not: for as long as it takes. */
static void catching_up_is_honest(void **state)
{
    (void)state;
    const double rates[] = {10, 50, 60, 128};
    ll_action a = push(-1);
    for (size_t r = 0; r < sizeof rates / sizeof rates[0]; r++) {
        ll_freq freq = ll_freq_from_hz(rates[r]);
        ll_server *server = new_server(1, &ll_sync_free, rates[r], rates[r]);
        ll_rate_limiter bucket = server->client_slots[0].limits.allowance;
        for (int64_t k = 0; k < (int64_t)(rates[r] * 60); k++)
            for (int i = 0; i < 2; i++)
                assert_int_equal(ll_validate(&a, 1, &bucket, freq, ll_tick_time(k, freq)), LL_RULE_NONE);
        free(server);
    }
}

/* After snapshots were missing for so long that a client has fallen behind. */
static void honest_clients_catch_up_after_silence(void **state)
{
    (void)state;
    for (int silent_s = 3; silent_s <= 15; silent_s += 4) {
        const char *const sets[] = {"players.0.lag_ms=90", NULL};
        scene s = scene_open("race", sets);
        ll_netgame_config config = scene_config(s.game);
        scene_run(&s, 5, NULL);
        config.players[0].link.down.loss_pct = 100;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 5 + silent_s, NULL);
        config.players[0].link.down.loss_pct = 0;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 40, NULL);
        assert_int_equal(ll_netgame_client_metrics(s.game, 0)->false_refusals, 0);
        scene_close(&s);
    }
}

/* The same with a whole game and every possible link: no player who keeps the rules is refused. */
static void honest_clients_are_never_refused(void **state)
{
    (void)state;
    static const char *const links[][6] = {
        {"players.0.link.up.jitter_ms=500", "players.0.lag_ms=500"},
        {"players.0.link.up.jitter_ms=500", "players.0.link.up.order=fifo", "players.0.lag_ms=500"},
        {"players.0.link.up.jitter_ms=270", "players.0.link.up.distribution=normal",
         "players.0.link.up.loss_pct=30"},
        {"players.0.link.up.duplicate_pct=100", "players.0.redundancy=15", "players.0.link.up.loss_pct=50"},
        {"players.0.lag_ms=1000", "players.0.slack_ticks=10"},
        {"server.sync=lockstep", "players.0.link.up.jitter_ms=500", "players.0.link.up.loss_pct=30"},
        {"server.sync=lockstep_pipelined", "players.0.link.up.jitter_ms=500",
         "players.0.link.up.loss_pct=30"},
        {"server.sync=gambetta", "players.0.link.up.jitter_ms=500", "players.0.lag_ms=500"},
    };
    static const char *const rates[] = {"tick_hz=20", "tick_hz=60", "tick_hz=64"};
    for (size_t i = 0; i < sizeof links / sizeof links[0]; i++)
        for (size_t r = 0; r < sizeof rates / sizeof rates[0]; r++) {
            const char *sets[10] = {rates[r], "server.update_hz=20"};
            for (int k = 0; k < 6 && links[i][k]; k++)
                sets[2 + k] = links[i][k];
            scene s = scene_open("race", sets);
            scene_run(&s, 30, NULL);
            ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[0];
            bool waits =
                strcmp(links[i][0], "server.sync=lockstep") == 0; /* for up to 1.5 s a step, and for losses */
            assert_true(client_slot->counts.accepted > (waits ? 10 : 20));
            for (int rule = 0; rule < LL_RULES; rule++)
                if (client_slot->counts.refused[rule] != 0)
                    fail_msg("%s %s: %d refused for %s", rates[r], links[i][0],
                             (int)client_slot->counts.refused[rule], ll_rule_names[rule]);
            scene_close(&s);
        }
}

/* And with a lag that changes while inputs are on their way: the late and the new ones arrive at the same
 * time. */
static void honest_clients_survive_a_change_of_lag(void **state)
{
    (void)state;
    static const char *const rates[] = {"tick_hz=30", "tick_hz=64"};
    for (size_t r = 0; r < 2; r++) {
        const char *const sets[] = {rates[r], "players.0.lag_ms=1000", NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 5, NULL);
        ll_netgame_config config = scene_config(s.game);
        config.players[0].lag_ms = 100;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 20, NULL);
        for (int rule = 0; rule < LL_RULES; rule++)
            assert_int_equal(ll_netgame_server(s.game)->client_slots[0].counts.refused[rule], 0);
        scene_close(&s);
    }
}

/* 100 ms of jitter and 2 % of loss in either direction, in every sync mode with a server that applies inputs,
 * with every technique that changes what is sent: no player who keeps the rules is refused. */
static void honest_clients_on_a_bad_link_are_never_refused(void **state)
{
    (void)state;
    static const char *const syncs[] = {"server.sync=free", "server.sync=lockstep_pipelined",
                                        "server.sync=gambetta", "server.sync=lockstep"};
    static const char *const ways[] = {"players.0.redundancy=0", "players.0.time_dilation=true",
                                       "players.0.ack=per_input", "players.0.redundancy=15"};
    for (size_t k = 0; k < 4; k++)
        for (size_t w = 0; w < 4; w++)
            for (int seed = 1; seed <= 4; seed++) {
                char draws[24];
                snprintf(draws, sizeof draws, "seed=%d", seed);
                const char *const sets[] = {syncs[k],
                                            ways[w],
                                            draws,
                                            "players.0.prediction=true",
                                            "players.0.reconciliation=true",
                                            "players.0.link.up.jitter_ms=100",
                                            "players.0.link.up.loss_pct=2",
                                            "players.0.link.down.jitter_ms=100",
                                            "players.0.link.down.loss_pct=2",
                                            "players.1.link.up.jitter_ms=100",
                                            "players.1.link.up.loss_pct=2",
                                            NULL};
                scene s = scene_open("race", sets);
                scene_run(&s, 60, NULL);
                for (int p = 0; p < 2; p++) {
                    const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[p];
                    assert_true(client_slot->counts.accepted >
                                (k == 3 ? 60 : 1000)); /* stop and wait: a second each at most */
                    assert_int_equal(ll_netgame_client_metrics(s.game, p)->false_refusals, 0);
                    for (int rule = 0; rule < LL_RULES; rule++)
                        assert_int_equal(client_slot->counts.refused[rule], 0);
                    assert_true(client_slot->limits.budget_used > 0 &&
                                client_slot->limits.budget_used < 0.5); /* by far */
                    assert_true(k < 3 || client_slot->limits.budget_used ==
                                             1.0 * 2 / LL_BUDGET_TICKS); /* one ahead, always */
                }
                scene_close(&s);
            }
}

/* A client that makes too many inputs runs ahead of the server: that is the reason for refusal, because twice
 * as many may be a client that catches up. A client whose packets come in bursts has too many at once. */
static void cheats_are_refused_by_their_rule(void **state)
{
    (void)state;
    static const struct {
        const char *set;
        bool by[LL_RULES];
    } cheats[] = {{"players.0.cheat=magnitude", {[LL_RULE_MAGNITUDE] = true}},
                  {"players.0.cheat=rate", {[LL_RULE_BUDGET] = true}},
                  {"players.0.cheat=budget", {[LL_RULE_BUDGET] = true}},
                  {"players.0.cheat=lag_switch", {[LL_RULE_RATE] = true}}};
    for (size_t i = 0; i < 4; i++) {
        const char *const sets[] = {cheats[i].set, "players.0.script=steady", NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 60, NULL); /* a fifth more than time has passed is 256 ticks after 21 s */
        const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[0];
        for (int rule = 0; rule < LL_RULES; rule++)
            assert_true((client_slot->counts.refused[rule] > 0) == cheats[i].by[rule]);
        assert_true(client_slot->counts.accepted < 60 * 60 * 2 / 3); /* the rest was refused */
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_end_at_one),
        cmocka_unit_test(budget_ends_before_its_number),
        cmocka_unit_test(input_time_is_held_to_the_clock),
        cmocka_unit_test(honest_inputs_are_within_their_time),
        cmocka_unit_test(bucket_fills_with_time),
        cmocka_unit_test(flood_is_held_to_the_rate),
        cmocka_unit_test(refused_inputs_cost_nothing),
        cmocka_unit_test(late_and_bunched_inputs_are_honest),
        cmocka_unit_test(catching_up_is_honest),
        cmocka_unit_test(honest_clients_catch_up_after_silence),
        cmocka_unit_test(honest_clients_are_never_refused),
        cmocka_unit_test(honest_clients_survive_a_change_of_lag),
        cmocka_unit_test(honest_clients_on_a_bad_link_are_never_refused),
        cmocka_unit_test(cheats_are_refused_by_their_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
