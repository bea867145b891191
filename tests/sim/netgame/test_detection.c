/* Detection of cheats in whole games: honest players over every preset of links, and the time until each
 * cheat is found. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "link/line/presets.h"
#include "support/many.h"
#include "support/near.h"
#include "support/scene.h"

#if defined(__SANITIZE_ADDRESS__) || !defined(__OPTIMIZE__)
enum { FEW_RATE_SEEDS = 1, PRESET_STRIDE = 4 }; /* where tests must be fast */
#else
enum { FEW_RATE_SEEDS = 2, PRESET_STRIDE = 1 };
#endif
enum { MANY_RATE_SEEDS = 8, FEW_REACTION_SEEDS = 1, MANY_REACTION_SEEDS = 3 };

static int rate_seeds = FEW_RATE_SEEDS, reaction_seeds = FEW_REACTION_SEEDS; /* per preset of links */

static const ll_detection *detection(const scene *s, int player)
{
    return &ll_netgame_detection(s->game)[player];
}

/* ---- what is not chosen ---- */

static void off_there_is_not_a_byte_of_it(void **state)
{
    (void)state;
    const char *const on[] = {"server.detection=true", NULL};
    static const char *const ids[] = {"race", "rifle", "dead_reckoning_dis", "hybrid_rewind"};
    for (int i = 0; i < 4; i++) {
        scene a = scene_open(ids[i], NULL), b = scene_open(ids[i], on);
        size_t players = (size_t)a.game->config.player_count;
        assert_null(ll_netgame_detection(a.game));
        size_t watches = sizeof(ll_detection) + (a.game->shots != 0 ? sizeof(ll_aim_watch) : 0);
        assert_null(ll_netgame_aim_watch(a.game));
        assert_int_equal(ll_netgame_bytes(b.game) - ll_netgame_bytes(a.game), players * watches);
        cJSON *off = a.scenario.kind->metrics(a.game);
        assert_null(
            cJSON_GetObjectItem(cJSON_GetArrayItem(cJSON_GetObjectItem(off, "players"), 0), "detection"));
        cJSON_Delete(off);
        scene_close(&a);
        scene_close(&b);
    }
}

/* It watches, and changes nothing. */
static void the_game_is_the_same(void **state)
{
    (void)state;
    const char *const on[] = {"server.detection=true", NULL};
    static const char *const ids[] = {"race", "rifle", "dead_reckoning_dis", "hybrid_rewind"};
    for (int i = 0; i < 4; i++) {
        scene a = scene_open(ids[i], NULL), b = scene_open(ids[i], on);
        scene_run(&a, 20, NULL);
        scene_run(&b, 20, NULL);
        const ll_world *w = ll_server_world(ll_netgame_server(a.game));
        assert_memory_equal(w, ll_server_world(ll_netgame_server(b.game)), ll_world_size(w));
        scene_close(&a);
        scene_close(&b);
    }
}

/* ---- honest players ---- */

typedef struct sum {
    int64_t players, rate, reaction, tests, shots, fast, cleared;
    double most; /* of the sums of rates */
} sum;

static void add(sum *all, const scene *s, bool armed)
{
    for (int p = 0; p < s->game->config.player_count; p++) {
        const ll_detection *d = detection(s, p);
        all->players++;
        all->rate += d->rate.alarms.count;
        all->most = larger(all->most, d->rate.most);
        all->reaction += d->reaction.alarms.count;
        assert_int_equal(d->rate.alarms.mistaken, d->rate.alarms.count);
        all->tests += armed ? d->reaction.cleared + d->reaction.alarms.count : 0;
        all->shots += d->reaction.shots;
        all->fast += d->reaction.fast;
        all->cleared += d->reaction.cleared;
    }
}

/* Both players on the same link, with the largest drift of their clocks in opposite directions. */
static scene open_over(const char *id, const char *preset, const char *sync, int seed, const char *script)
{
    char links[2][64], number[32], mode[48], scripts[2][48];
    for (int p = 0; p < 2; p++)
        snprintf(scripts[p], sizeof scripts[p], "players.%d.script=%s", p, script);
    for (int p = 0; p < 2; p++)
        snprintf(links[p], sizeof links[p], "players.%d.link.preset=%s", p, preset);
    snprintf(number, sizeof number, "seed=%d", seed);
    snprintf(mode, sizeof mode, "server.sync=%s", sync);
    const char *const sets[] = {links[0],
                                links[1],
                                number,
                                mode,
                                "server.detection=true",
                                "players.0.lag_ms=0",
                                "players.1.lag_ms=0",
                                "players.0.cheat=none",
                                "players.1.cheat=none",
                                "players.0.drift_ppm=500",
                                "players.1.drift_ppm=-500",
                                scripts[0],
                                scripts[1],
                                NULL};
    return scene_open(id, sets);
}

static void run_over(const char *id, const char *preset, const char *sync, int seed, double until_s, sum *all)
{
    scene s = open_over(id, preset, sync, seed, strcmp(id, "race") == 0 ? "varied" : "react");
    scene_run(&s, until_s, NULL);
    add(all, &s, s.game->shots != 0);
    scene_close(&s);
}

/* Alarms that chance permits among `tests` with an error of 1e-4: the mean and three deviations. */
static double permitted(int64_t tests)
{
    return 1e-4 * (double)tests + 3 * sqrt(1e-4 * (double)tests);
}

/* One test of the rate for each player and run. */
static void honest_rates_raise_no_alarm(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free", "lockstep_pipelined", "gambetta"};
    sum all = {0};
    for (int preset = 0; ll_link_presets[preset].name; preset++)
        for (int k = 0; k < 3; k++)
            for (int seed = 1; seed <= rate_seeds; seed++)
                run_over("race", ll_link_presets[preset].name, syncs[k], seed, 30, &all);
    print_message("%lld players, %lld alarms, at most %g inputs too many\n", (long long)all.players,
                  (long long)all.rate, all.most);
    assert_true(all.players >= 2 * 3 * rate_seeds * 30);
    assert_true((double)all.rate <= permitted(all.players));
}

/* Each decision is a test. */
static void honest_reactions_raise_no_alarm(void **state)
{
    (void)state;
    sum all = {0};
    for (int preset = 0; ll_link_presets[preset].name; preset++)
        for (int seed = 1; seed <= reaction_seeds; seed++)
            run_over("aim_bot", ll_link_presets[preset].name, "free", seed, 240, &all);
    print_message("%lld players, %lld shots, %lld fast, %lld cleared, %lld alarms\n", (long long)all.players,
                  (long long)all.shots, (long long)all.fast, (long long)all.cleared, (long long)all.reaction);
    assert_true(all.shots > 2000 && all.cleared > 20);
    assert_true((double)all.reaction <= permitted(all.tests) && (double)all.rate <= permitted(all.players));
}

/* Players who turn their aim as a person does. Each decision is a test. */
static void honest_aims_raise_no_alarm(void **state)
{
    (void)state;
    int64_t shots = 0, snaps = 0, tests = 0, alarms = 0, players = 0;
    for (int preset = 0; ll_link_presets[preset].name; preset++) {
        if (preset % PRESET_STRIDE != 0)
            continue;
        for (int seed = 1; seed <= reaction_seeds; seed++) {
            scene s = open_over("aim_bot", ll_link_presets[preset].name, "free", seed, "turn");
            scene_run(&s, 240, NULL);
            for (int p = 0; p < 2; p++) {
                const ll_aim_watch *w = &ll_netgame_aim_watch(s.game)[p];
                assert_int_equal(w->alarms.mistaken, w->alarms.count);
                players++, shots += w->shots, snaps += w->snaps;
                tests += w->cleared + w->alarms.count, alarms += w->alarms.count;
            }
            scene_close(&s);
        }
    }
    print_message("%lld players, %lld turns, %lld snaps, %lld tests, %lld alarms\n", (long long)players,
                  (long long)shots, (long long)snaps, (long long)tests, (long long)alarms);
    assert_true(shots > 10 * players && tests >= players);
    assert_true((double)snaps <= 0.01 * (double)shots + 3 * sqrt(0.01 * (double)shots)); /* the hypothesis */
    assert_true((double)alarms <= permitted(tests));
}

/* ---- cheats ---- */

typedef struct found {
    ll_time rate, reaction; /* the first alarm, LL_NEVER: none */
} found;

static found cheat(const char *id, const char *name)
{
    char set[48];
    snprintf(set, sizeof set, "players.0.cheat=%s", name);
    const char *const sets[] = {set, "server.detection=true", "players.1.cheat=none", NULL};
    scene s = scene_open(id, sets);
    scene_run(&s, 60, NULL);
    for (int p = 0; p < 2; p++) {
        assert_int_equal(detection(&s, p)->rate.alarms.mistaken, 0);
        assert_int_equal(detection(&s, p)->reaction.alarms.mistaken, 0);
    }
    found f = {detection(&s, 0)->rate.alarms.first, detection(&s, 0)->reaction.alarms.first};
    scene_close(&s);
    return f;
}

/* Twice as many inputs are 80 too many after 1.33 s, a fifth more after 6.7 s; what was held back for 3 s
 * comes after 6 s. The other cheats send no more inputs than time allows, and the rules refuse what they
 * send. */
static void each_cheat_is_found_in_its_time(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        double from_s, to_s; /* 0: never */
    } rows[] = {{"none", 0, 0},       {"magnitude", 0, 0},  {"teleport", 0, 0},  {"rate", 1.3, 2},
                {"budget", 6.5, 7.5}, {"lag_switch", 6, 7}, {"view_time", 0, 0}, {"fire_rate", 0, 0},
                {"claim", 0, 0},      {"aim_bot", 0, 0}};
    for (int armed = 0; armed < 2; armed++)
        for (int i = 0; i < 10; i++) {
            found f = cheat(armed ? "aim_bot" : "race", rows[i].name);
            double at = f.rate == LL_NEVER ? 0 : ll_to_s(f.rate);
            print_message("%s %s: rate %g, reaction %g\n", armed ? "shooter" : "race", rows[i].name, at,
                          f.reaction == LL_NEVER ? 0 : ll_to_s(f.reaction));
            if (!(at >= rows[i].from_s && at <= rows[i].to_s))
                fail_msg("%s: first alarm at %g s", rows[i].name, at);
            if (armed && strcmp(rows[i].name, "aim_bot") == 0)
                assert_true(f.reaction < 30 * LL_SECOND);
            else if (i == 0 || !armed)
                assert_true(f.reaction == LL_NEVER);
        }
}

/* Over bad links too, from what the server knows. */
static void an_aim_bot_is_found_over_bad_links(void **state)
{
    (void)state;
    static const char *const presets[] = {"home_broadband", "congested", "lte_4g", "unreal_bad", "wifi_busy"};
    for (int i = 0; i < 5; i++)
        for (int bot = 0; bot < 2; bot++) {
            char links[2][64];
            for (int p = 0; p < 2; p++)
                snprintf(links[p], sizeof links[p], "players.%d.link.preset=%s", p, presets[i]);
            const char *const sets[] = {links[0], links[1],
                                        bot ? "players.1.cheat=aim_bot" : "players.1.cheat=none", NULL};
            scene s = scene_open("aim_bot", sets);
            scene_run(&s, 120, NULL);
            const ll_reaction_watch *w = &detection(&s, 1)->reaction;
            print_message("%s bot %d: %lld shots, %lld fast, %lld alarms\n", presets[i], bot,
                          (long long)w->shots, (long long)w->fast, (long long)w->alarms.count);
            assert_true(bot ? w->alarms.count >= 2 && w->alarms.first < 60 * LL_SECOND
                            : w->alarms.count == 0);
            assert_int_equal(detection(&s, 0)->reaction.alarms.count, 0);
            scene_close(&s);
        }
}

/* A bot against a player who turns as a person does: the share of its snaps is that of the hypothesis or
 * more, and it is found by them alone; the other is not taken for one. */
static void an_aim_bot_is_found_by_its_aim(void **state)
{
    (void)state;
    int64_t shots = 0, snaps = 0, runs = 0;
    double latest = 0, sum_s = 0;
    for (int seed = 1; seed <= 12; seed += reaction_seeds > 1 ? 1 : 6) {
        char number[32];
        snprintf(number, sizeof number, "seed=%d", seed);
        const char *const sets[] = {number, "players.0.script=turn", "players.1.script=turn", NULL};
        scene s = scene_open("aim_bot", sets);
        scene_run(&s, 240, NULL);
        const ll_aim_watch *honest = &ll_netgame_aim_watch(s.game)[0], *bot = honest + 1;
        assert_int_equal(honest->alarms.count, 0);
        assert_true(bot->alarms.count > 0 && bot->alarms.mistaken == 0);
        shots += bot->shots, snaps += bot->snaps, runs++;
        sum_s += ll_to_s(bot->alarms.first);
        latest = larger(latest, ll_to_s(bot->alarms.first));
        scene_close(&s);
    }
    print_message("%lld runs, %lld turns, %lld snaps; first alarm at %g s in the mean, %g s at the latest\n",
                  (long long)runs, (long long)shots, (long long)snaps, sum_s / (double)runs, latest);
    assert_true((double)snaps >= 0.3 * (double)shots);
    assert_true(latest < 120);
}

/* The scenario as it is: its honest player raises no alarm of any kind, its bot does. */
static void the_scenario_takes_no_honest_player_for_a_bot(void **state)
{
    (void)state;
    for (int seed = 1; seed <= 20; seed += reaction_seeds > 1 ? 1 : 7) {
        char number[32];
        snprintf(number, sizeof number, "seed=%d", seed);
        const char *const sets[] = {number, NULL};
        scene s = scene_open("aim_bot", sets);
        scene_run(&s, 240, NULL);
        const ll_aim_watch *aims = ll_netgame_aim_watch(s.game);
        assert_int_equal(detection(&s, 0)->rate.alarms.count, 0);
        assert_int_equal(detection(&s, 0)->reaction.alarms.count, 0);
        assert_int_equal(aims[0].alarms.count, 0);
        assert_true(detection(&s, 1)->reaction.alarms.count > 0);
        scene_close(&s);
    }
}

int main(int count, char **arguments)
{
    if (ll_test_many(count, arguments)) {
        rate_seeds = MANY_RATE_SEEDS;
        reaction_seeds = MANY_REACTION_SEEDS;
    }
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(off_there_is_not_a_byte_of_it),
        cmocka_unit_test(the_game_is_the_same),
        cmocka_unit_test(honest_rates_raise_no_alarm),
        cmocka_unit_test(honest_reactions_raise_no_alarm),
        cmocka_unit_test(honest_aims_raise_no_alarm),
        cmocka_unit_test(each_cheat_is_found_in_its_time),
        cmocka_unit_test(an_aim_bot_is_found_over_bad_links),
        cmocka_unit_test(an_aim_bot_is_found_by_its_aim),
        cmocka_unit_test(the_scenario_takes_no_honest_player_for_a_bot),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
