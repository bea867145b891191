/* The gain of cheats, with the server's validation and without. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "game/games/games.h"
#include "support/near.h"
#include "support/scene.h"

#define RUN_S 40

/* ---- the metric ---- */

static double gain_of(const double *x, int count, bool at_rest)
{
    ll_game_env env = {.dt = 0.02};
    ll_param_defaults(&ll_gambetta_table, env.params); /* 2 m/s */
    ll_entity e = {.x = x[0], .vx = at_rest ? 0 : 2};
    ll_cheat_gain gain = {.most = 0};
    ll_cheat_gain_watch(&gain, &e);
    for (int i = 1; i < count; i++) {
        e.x = x[i];
        ll_cheat_gain_step(&gain, &ll_game_gambetta, &env, &e, 0.5); /* a metre each */
    }
    return gain.most;
}

/* The largest excess over any stretch: a leap, one of several in a row, a rate slightly too high; distance
 * saved up before does not compensate for it. */
static void gain_is_the_largest_excess_over_any_stretch(void **state)
{
    (void)state;
    assert_true(gain_of((double[]){0, 1, 2, 3, 4, 3, 2}, 7, true) == 0);
    assert_true(gain_of((double[]){0, 1, 7, 8, 9}, 5, true) == 5);
    assert_true(gain_of((double[]){0, 1, -5, -6}, 4, true) == 5);
    assert_true(gain_of((double[]){0, 0, 0, 0, 6}, 5, false) ==
                5); /* three steps of standing still permit nothing */
    assert_true(gain_of((double[]){0, 4, 4, 4, 9}, 5, false) == 5); /* 3 + 4 - 2 */
    assert_near(gain_of((double[]){0, 1.25, 2.5, 3.75, 5}, 5, true), 1, 1e-12);
    assert_true(gain_of((double[]){0, 0.5, 1, 1.5}, 4, true) == 0);
}

/* ---- whole games ---- */

typedef struct outcome {
    double gain, way; /* m */
    int64_t refused, refused_inputs;
} outcome;

static outcome run(const char *sync, const char *cheat, bool validation)
{
    char a[48], b[48], c[48];
    outcome o = {0};
    snprintf(a, sizeof a, "server.sync=%s", sync);
    snprintf(b, sizeof b, "players.0.cheat=%s", cheat);
    snprintf(c, sizeof c, "server.validation=%s", validation ? "true" : "false");
    const char *const sets[] = {
        a,   b, c, "players.0.script=steady", "players.1.script=steady", "tick_hz=50", "params.laps=10000",
        NULL};
    scene s = scene_open("race", sets);
    scene_run(&s, RUN_S, NULL);
    const ll_client_slot *client_slot = &ll_netgame_server(s.game)->client_slots[0];
    for (int rule = 1; rule < LL_RULES; rule++)
        o.refused += client_slot->counts.refused[rule];
    o.gain = ll_netgame_client_metrics(s.game, 0)->gain.most;
    o.way = ll_server_world(ll_netgame_server(s.game))->entity[0].x;
    o.refused_inputs = ll_netgame_client(s.game, 0)->inputs.refused;
    assert_int_equal(ll_netgame_client_metrics(s.game, 0)->false_refusals, 0);
    assert_int_equal(ll_netgame_client_metrics(s.game, 1)->false_refusals, 0);
    scene_close(&s);
    return o;
}

/* 1/50 s at 16 m/s: an update of the demo's rules may contain one input more or less. */
#define TICK_M (16.0 / 50)

/* What the time budget permits at once. */
#define BURST_M (80 * TICK_M)

/* Inputs that are too large gain metres in every sync mode; with validation they gain nothing. */
static void large_inputs_gain_nothing_with_validation(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "lockstep_pipelined", "gambetta"};
    static const char *const cheats[] = {"magnitude", "teleport"};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 2; i++) {
            outcome honest = run(syncs[k], "none", true), on = run(syncs[k], cheats[i], true),
                    off = run(syncs[k], cheats[i], false);
            assert_true(on.refused > 10);
            assert_true(on.gain < 1e-6 + (k == 2 ? TICK_M : 0) && on.way < honest.way + 1e-6);
            assert_int_equal(off.refused, 0);
            assert_true(off.gain > 10 && off.way > honest.way + 10);
            assert_true(k == 2 ? on.refused_inputs == 0
                               : on.refused_inputs > 10); /* the demo sends no refusals */
        }
}

/* Where inputs are applied on arrival, more of them than time has passed, and a burst, gain what they state;
 * with the time budget at most one burst. */
static void inputs_of_future_time_gain_a_burst_at_most(void **state)
{
    (void)state;
    static const struct {
        const char *cheat;
        double off; /* at least: 16 m/s for twice the time, for a fifth more of it, and for the 3 s that were
                       held back */
    } cheats[] = {{"rate", 16 * (RUN_S - 6)}, {"budget", 16 * 0.2 * (RUN_S - 6)}, {"lag_switch", 16 * 2.9}};
    outcome honest = run("gambetta", "none", true);
    for (int i = 0; i < 3; i++) {
        outcome on = run("gambetta", cheats[i].cheat, true), off = run("gambetta", cheats[i].cheat, false);
        assert_true(on.refused > 50);
        assert_true(on.gain > 1 && on.gain <= BURST_M + 1e-6);
        assert_true(on.way <= honest.way + BURST_M);
        assert_int_equal(off.refused, 0);
        assert_true(off.gain >= cheats[i].off && off.gain > 1.5 * BURST_M);
    }
}

/* Where each input belongs to a step of the server's clock they gain nothing, validated or not. */
static void inputs_by_step_are_proof_against_too_many(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "lockstep_pipelined", "lockstep"};
    static const char *const cheats[] = {"rate", "budget", "lag_switch"};
    for (int k = 0; k < 3; k++) {
        outcome honest = run(syncs[k], "none", true);
        for (int i = 0; i < 3; i++)
            for (int validation = 0; validation < 2; validation++) {
                outcome o = run(syncs[k], cheats[i], validation);
                assert_true(o.gain < 1e-6 && o.way < honest.way + 1e-6);
            }
    }
}

/* The metric distinguishes: a player who keeps the rules gains nothing by the same metric. */
static void honest_players_gain_nothing(void **state)
{
    (void)state;
    static const char *const syncs[] = {"server.sync=free", "server.sync=lockstep_pipelined",
                                        "server.sync=gambetta"};
    for (int k = 0; k < 3; k++) {
        const char *const sets[] = {syncs[k], "players.0.script=steady", "server.update_hz=30", NULL};
        scene s = scene_open("race", sets);
        ll_cheat_gain gain = {.most = 0};
        ll_server *server = ll_netgame_server(s.game);
        const ll_entity *car = &ll_server_world(server)->entity[0];
        ll_cheat_gain_watch(&gain, car);
        ll_time stepped = 0;
        for (int i = 1; i < 30 * 240; i++) { /* after every step */
            scene_run(&s, i / 240.0, NULL);
            if (server->stepped == stepped)
                continue;
            double elapsed = k == 2 ? ll_to_s(server->stepped - stepped) : s.game->env.dt;
            stepped = server->stepped;
            ll_cheat_gain_step(&gain, &ll_game_race, &s.game->env, car, elapsed);
        }
        assert_true(car->x > 300);
        assert_true(gain.most < (k == 2 ? 16.0 / 60 + 1e-6 : 1e-6)); /* a tick more or less in an update */
        scene_close(&s);
    }
}

/* ---- against the honest reference ---- */

#define REFERENCE_S 30
#define REFERENCE_STEPS (REFERENCE_S * 60)

typedef struct course {
    double covered[REFERENCE_STEPS]; /* m, after each tick */
    double gain, gain_over_honest;
    int64_t refused;
} course;

/* The race, on two clean links. The player cheats from `from_s` on. */
static void drive(const char *const *sets, const char *cheat, double from_s, course *c)
{
    scene s = scene_open("race", sets);
    const ll_entity *car = &ll_server_world(ll_netgame_server(s.game))->entity[0];
    ll_netgame_config config = scene_config(s.game);
    double x = car->x;
    ll_status status = ll_param_set(s.scenario.kind->table, &config, "players.0.cheat", cheat, false);
    assert_false(ll_failed(&status));
    for (int i = 0; i < REFERENCE_STEPS; i++) {
        if (i > 0)
            scene_run(&s, i / 60.0, NULL);
        c->covered[i] = i > 0 ? c->covered[i - 1] + fabs(car->x - x) : 0;
        x = car->x;
        if (i == (int)(from_s * 60))
            s.scenario.kind->change(s.game, &config, s.game->now);
    }
    c->gain = ll_netgame_client_metrics(s.game, 0)->gain.most;
    c->gain_over_honest = ll_netgame_client_metrics(s.game, 0)->honest.most;
    c->refused = 0;
    for (int rule = 1; rule < LL_RULES; rule++)
        c->refused += ll_netgame_server(s.game)->client_slots[0].counts.refused[rule];
    scene_close(&s);
}

static double most_ahead(const course *cheat, const course *honest)
{
    double most = 0;
    for (int i = 0; i < REFERENCE_STEPS; i++) {
        double ahead = cheat->covered[i] - honest->covered[i];
        most = larger(most, ahead);
    }
    return most;
}

static const char *const by_place[] = {"magnitude", "rate",  "budget",   "view_time",
                                       "fire_rate", "claim", "teleport", "lag_switch"};

/* The reference matches a separate run without cheats: in every sync mode, from the start or later on,
 * validated or not, with any refusals. */
static void the_honest_is_the_honest_run(void **state)
{
    (void)state;
    static const char *const syncs[] = {"server.sync=free", "server.sync=lockstep", "server.sync=gambetta"};
    static const char *const rules[] = {"server.validation=true", "server.validation=false",
                                        "server.starved=repeat"};
    course *honest = malloc(sizeof *honest), *cheat = malloc(sizeof *cheat);
    int gained = 0;
    for (int k = 0; k < 27; k++) {
        const char *script = k % 2 ? "players.0.script=steady" : "players.0.script=varied";
        const char *const sets[] = {syncs[k % 3],
                                    rules[k / 3 % 3],
                                    script,
                                    "params.laps=10000",
                                    "tick_hz=60",
                                    "server.refused=previous",
                                    k < 9 ? "players.0.lag_ms=50" : "players.0.lag_ms=130",
                                    NULL};
        const double from_s = k % 4 * 2.5;
        drive(sets, "none", from_s, honest);
        assert_true(honest->gain_over_honest == 0 && honest->gain == 0);
        for (int i = 0; i < 8; i++) {
            drive(sets, by_place[i], from_s, cheat);
            bool waits =
                k % 3 == 1 && strcmp(by_place[i], "lag_switch") == 0; /* and makes the reference wait */
            if (!waits)
                assert_float_equal(cheat->gain_over_honest, most_ahead(cheat, honest), 1e-6);
            gained += cheat->gain_over_honest > 1;
        }
    }
    assert_true(gained > 40); /* of 216 */
    free(honest);
    free(cheat);
}

/* Gains that the server permits with sync free: inputs made up to 127 ticks before their step, so that a
 * pedal may be down for that much longer. No other cheat gains, and none gains where the pedal is down
 * anyway. */
static void no_cheat_passes_its_honest_honest(void **state)
{
    (void)state;
    static const char *const lags[] = {"players.0.lag_ms=50", "players.0.lag_ms=130", "players.0.lag_ms=8"};
    static const char *const scripts[] = {"players.0.script=varied", "players.0.script=steady"};
    course *honest = malloc(sizeof *honest), *cheat = malloc(sizeof *cheat);
    for (int k = 0; k < 6; k++) {
        const char *const sets[] = {lags[k % 3], scripts[k / 3], "params.laps=10000", NULL};
        drive(sets, "none", 0, honest);
        assert_int_equal(honest->refused, 0);
        assert_true(honest->covered[REFERENCE_STEPS - 1] > 250);
        for (int i = 0; i < 8; i++) {
            bool ahead = strcmp(by_place[i], "rate") == 0 || strcmp(by_place[i], "budget") == 0;
            double allowed = ahead && k < 3 ? LL_BUDGET_TICKS * 16.0 / 60 : 0;
            drive(sets, by_place[i], 0, cheat);
            assert_true(most_ahead(cheat, honest) <= allowed + 1e-6);
            assert_true(cheat->gain_over_honest <= allowed + 1e-6 && cheat->gain < 1e-6);
            assert_true(cheat->covered[REFERENCE_STEPS - 1] <= honest->covered[REFERENCE_STEPS - 1] + 1e-6);
        }
    }
    free(honest);
    free(cheat);
}

/* Purpose of the policies: if the last input is repeated, a cheat whose inputs are all refused keeps its
 * throttle. */
static void a_latched_throttle_is_a_gain(void **state)
{
    (void)state;
    static const char *const seeds[] = {"seed=1", "seed=2", "seed=3", "seed=4"};
    static const char *const cheats[] = {"rate", "budget"};
    course *cheat = malloc(sizeof *cheat);
    for (int i = 0; i < 2; i++) {
        double most = 0; /* the seed determines which pedal stays down */
        for (int k = 0; k < 4; k++) {
            const char *const sets[] = {"server.starved=repeat", "players.0.lag_ms=70", "params.laps=10000",
                                        seeds[k], NULL};
            drive(sets, cheats[i], 0, cheat);
            assert_true(cheat->gain < 1e-6);
            most = larger(most, cheat->gain_over_honest);
        }
        assert_true(most > 2 * LL_BUDGET_TICKS * 16.0 / 60);
    }
    free(cheat);
}

/* Where inputs are applied on arrival, a burst gains the distance of its time, and then what its speed
 * gains. */
static void the_demo_permits_a_burst(void **state)
{
    (void)state;
    static const char *const scripts[] = {"players.0.script=varied", "players.0.script=steady"};
    const double burst_s = 4.0 / 3, way = 16 * burst_s, coast = 6 * burst_s / 0.3;
    course *cheat = malloc(sizeof *cheat);
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 8; i++) {
            const char *const sets[] = {"server.sync=gambetta", scripts[k], "params.laps=10000", NULL};
            drive(sets, by_place[i], 0, cheat);
            assert_true(cheat->gain <= way + 1e-6 &&
                        cheat->gain_over_honest <= way + (k == 0 ? coast : 0) + 1e-6);
        }
    free(cheat);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(gain_is_the_largest_excess_over_any_stretch),
        cmocka_unit_test(large_inputs_gain_nothing_with_validation),
        cmocka_unit_test(inputs_of_future_time_gain_a_burst_at_most),
        cmocka_unit_test(inputs_by_step_are_proof_against_too_many),
        cmocka_unit_test(honest_players_gain_nothing),
        cmocka_unit_test(the_honest_is_the_honest_run),
        cmocka_unit_test(no_cheat_passes_its_honest_honest),
        cmocka_unit_test(a_latched_throttle_is_a_gain),
        cmocka_unit_test(the_demo_permits_a_burst),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
