/* The server's rules at their edges, and a client that keeps to them. */
#include "toy.h"

#include "base/rng.h"
#include "support/scene.h"

static ll_rule judge(double x, double y, int64_t ahead)
{
    ll_allowance full = {LL_RATE_BURST, 0};
    ll_action a = {.axis = {(float)x, (float)y}};
    return ll_validate(&a, ahead, &full, HZ(60), 0);
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
    const int64_t good[] = {INT64_MIN / 2, -1000, 0, 1, LL_BUDGET_TICKS - 1};
    const int64_t bad[] = {LL_BUDGET_TICKS, LL_BUDGET_TICKS + 1, 1000, INT64_MAX / 2};
    for (size_t i = 0; i < sizeof good / sizeof good[0]; i++)
        assert_int_equal(judge(1, 0, good[i]), LL_RULE_NONE);
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(judge(1, 0, bad[i]), LL_RULE_BUDGET);
    assert_true(LL_INPUT_RING >= 2 * LL_BUDGET_TICKS);
}

static int64_t take_all(ll_allowance *allowance, ll_freq freq, ll_time now)
{
    ll_action a = push(1);
    int64_t taken = 0;
    while (taken < 100000 && ll_validate(&a, 1, allowance, freq, now) == LL_RULE_NONE)
        taken++;
    assert_int_equal(ll_validate(&a, 1, allowance, freq, now), LL_RULE_RATE);
    return taken;
}

/* 80 at once; then 1.25 for each tick of the client, kept up to 80. */
static void bucket_fills_with_time(void **state)
{
    (void)state;
    ll_allowance bucket = {LL_RATE_BURST, 0};
    assert_int_equal(take_all(&bucket, HZ(60), 0), 80);
    assert_int_equal(take_all(&bucket, HZ(60), 0), 0);
    assert_int_equal(take_all(&bucket, HZ(60), LL_SECOND / 5), 15);             /* 0.2 s x 75 / s */
    assert_int_equal(take_all(&bucket, HZ(60), LL_SECOND / 5 + 13 * LL_MS), 0); /* 0.975 of one */
    assert_int_equal(take_all(&bucket, HZ(60), LL_SECOND / 5 + 14 * LL_MS), 1); /* 1.05 */
    assert_int_equal(take_all(&bucket, HZ(60), 3600 * LL_SECOND), 80);
    assert_int_equal(take_all(&bucket, HZ(10), 3601 * LL_SECOND), 12); /* 12.5 */
    assert_int_equal(take_all(&bucket, HZ(10), 3602 * LL_SECOND), 13); /* 12.5 + 0.5 left */
}

/* A flood in the long run: not one more than the burst and the rate allow. */
static void flood_is_held_to_the_rate(void **state)
{
    (void)state;
    ll_allowance bucket = {LL_RATE_BURST, 0};
    ll_action a = push(1);
    int64_t taken = 0;
    for (int64_t i = 0; i <= 600 * 1000; i++) /* 1000 inputs a second for ten minutes */
        taken += ll_validate(&a, 1, &bucket, HZ(60), i * LL_MS) == LL_RULE_NONE;
    assert_in_range(taken, 80 + 600 * 75 - 1, 80 + 600 * 75);
}

static void refused_inputs_cost_nothing(void **state)
{
    (void)state;
    ll_allowance bucket = {1, 0};
    ll_action wild = push(2), good = push(1);
    for (int i = 0; i < 100; i++) {
        assert_int_equal(ll_validate(&wild, 1, &bucket, HZ(60), 0), LL_RULE_MAGNITUDE);
        assert_int_equal(ll_validate(&good, LL_BUDGET_TICKS, &bucket, HZ(60), 0), LL_RULE_BUDGET);
    }
    assert_int_equal(ll_validate(&good, 1, &bucket, HZ(60), 0), LL_RULE_NONE);
    assert_int_equal(ll_validate(&good, 1, &bucket, HZ(60), 0), LL_RULE_RATE);
}

/* A client's inputs come in any rhythm that its link makes of them, also all of a second at once. */
static void late_and_bunched_inputs_are_honest(void **state)
{
    (void)state;
    const double rates[] = {10, 50, 60, 120, 240};
    ll_action a = push(1);
    for (size_t r = 0; r < sizeof rates / sizeof rates[0]; r++) {
        ll_freq freq = ll_freq_from_hz(rates[r]);
        ll_server *server = new_server(1, &ll_sync_free, rates[r], rates[r]);
        ll_allowance bucket = server->seats[0].allowance;
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

/* The same with a whole game and every link that may be set: nobody is refused who plays by the rules. */
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
            ll_seat *seat = &ll_netgame_server(s.game)->seats[0];
            assert_true(seat->accepted > 20);
            for (int rule = 0; rule < LL_RULES; rule++)
                if (seat->refused[rule] != 0)
                    fail_msg("%s %s: %d refused for %s", rates[r], links[i][0], (int)seat->refused[rule],
                             ll_rule_names[rule]);
            scene_close(&s);
        }
}

/* And a lag that changes while inputs are on their way: the late and the new ones come at the same time. */
static void honest_clients_survive_a_change_of_lag(void **state)
{
    (void)state;
    static const char *const rates[] = {"tick_hz=30", "tick_hz=64"};
    for (size_t r = 0; r < 2; r++) {
        const char *const sets[] = {rates[r], "players.0.lag_ms=1000", NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 5, NULL);
        ll_netgame_config config = s.game->config;
        config.players[0].lag_ms = 100;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 20, NULL);
        for (int rule = 0; rule < LL_RULES; rule++)
            assert_int_equal(ll_netgame_server(s.game)->seats[0].refused[rule], 0);
        scene_close(&s);
    }
}

/* One who sends too many runs ahead of the server too, so that either rule may refuse. */
static void cheats_are_refused_by_their_rule(void **state)
{
    (void)state;
    static const struct {
        const char *set;
        bool by[LL_RULES];
    } cheats[] = {{"players.0.cheat=magnitude", {[LL_RULE_MAGNITUDE] = true}},
                  {"players.0.cheat=rate", {[LL_RULE_RATE] = true, [LL_RULE_BUDGET] = true}},
                  {"players.0.cheat=budget", {[LL_RULE_BUDGET] = true}}};
    for (size_t i = 0; i < 3; i++) {
        const char *const sets[] = {cheats[i].set, "players.0.script=steady", NULL};
        scene s = scene_open("race", sets);
        scene_run(&s, 20, NULL);
        const ll_seat *seat = &ll_netgame_server(s.game)->seats[0];
        for (int rule = 0; rule < LL_RULES; rule++)
            assert_true((seat->refused[rule] > 0) == cheats[i].by[rule]);
        assert_true(seat->accepted < 20 * 60 / 2); /* the rest was refused */
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(axes_end_at_one),
        cmocka_unit_test(budget_ends_before_its_number),
        cmocka_unit_test(bucket_fills_with_time),
        cmocka_unit_test(flood_is_held_to_the_rate),
        cmocka_unit_test(refused_inputs_cost_nothing),
        cmocka_unit_test(late_and_bunched_inputs_are_honest),
        cmocka_unit_test(honest_clients_are_never_refused),
        cmocka_unit_test(honest_clients_survive_a_change_of_lag),
        cmocka_unit_test(cheats_are_refused_by_their_rule),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
