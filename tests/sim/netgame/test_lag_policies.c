/* Lag compensation policies in whole games, by what must hold between them: who bears the lag, and for how
 * long. Bounds are sums of the configured delays. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/hash.h"
#include "support/near.h"
#include "support/scene.h"

#define TICK_MS (1000.0 / 60)
#define UPDATE_MS (1000.0 / 30)

/* What a policy did in 120 s of the scenario behind_cover, summed over seeds: B shoots, A peeks. */
typedef struct outcome {
    double hits, kept, covered, vetoed, rollback_m, rewind_ms, longest_ms;
    uint64_t hash; /* of the server's world, of the last seed */
} outcome;

static outcome play(const char *policy, double lag_ms, int seeds)
{
    outcome all = {0};
    for (int seed = 1; seed <= seeds; seed++) {
        char set[3][64], first[64];
        const char *sets[6] = {first, NULL};
        int n = 1;
        snprintf(first, sizeof first, "players.1.lag_ms=%g", lag_ms);
        for (const char *p = policy; *p; p += strcspn(p, " "), p += strspn(p, " ")) {
            snprintf(set[n - 1], sizeof set[0], "%.*s", (int)strcspn(p, " "), p);
            sets[n] = set[n - 1];
            sets[++n] = NULL;
        }
        char s_seed[32];
        snprintf(s_seed, sizeof s_seed, "seed=%d", seed);
        sets[n] = s_seed;
        sets[n + 1] = NULL;
        scene s = scene_open("behind_cover", sets);
        scene_run(&s, 120, NULL);
        const ll_shot_stats *m = &ll_netgame_shots(s.game)->shot_stats[1];
        const ll_behind_cover_player *cover = &ll_netgame_behind_cover(s.game)->player[1];
        const ll_shot_tally *t = &m->tally[LL_HITSCAN];
        assert_true(t->shots > 50 && t->hits[LL_JUDGE_VIEW] > 30);
        all.hits += (double)t->hits[LL_JUDGE_VIEW];
        all.kept += (double)t->kept;
        all.covered += (double)cover->shown.count;
        all.vetoed += (double)cover->vetoed;
        all.rollback_m += m->rollback.sum;
        const ll_summary rewind = ll_histogram_summary(&m->rewind),
                         shown = ll_histogram_summary(&cover->shown);
        all.rewind_ms = larger(all.rewind_ms, rewind.count ? rewind.max : 0);
        all.longest_ms = larger(all.longest_ms, shown.count ? shown.max : 0);
        const ll_world *world = ll_server_world(ll_netgame_server(s.game));
        all.hash = ll_hash(0, world, ll_world_size(world));
        scene_close(&s);
    }
    return all;
}

static double favour(outcome o)
{
    return o.kept / o.hits;
}

/* For the shots of B, whose victims have been seen. */
static void assert_same_for_b(outcome a, outcome b)
{
    assert_true(a.hits == b.hits && a.kept == b.kept && a.covered == b.covered && a.vetoed == b.vetoed);
    assert_true(a.rollback_m == b.rollback_m && a.longest_ms == b.longest_ms);
}

static void assert_same(outcome a, outcome b)
{
    assert_same_for_b(a, b);
    assert_true(a.hash == b.hash);
}

/* Rewinding nothing is judging in the present, to the last bit of the state: by a limit of 0, by a hybrid
 * that ends at 0, and by a view that is beyond it. */
static void a_cap_of_zero_is_the_servers_present(void **state)
{
    (void)state;
    for (int lag = 0; lag <= 150; lag += 75) {
        outcome now = play("server.hitscan=none", lag, 1);
        assert_same(play("server.hitscan=rewind server.max_rewind_ms=0", lag, 1), now);
        assert_same(play("server.hitscan=hybrid policies.hybrid_full_ms=0 policies.hybrid_none_ms=0", lag, 1),
                    now);
        assert_same_for_b(
            play("server.hitscan=victim_veto server.max_rewind_ms=0 policies.veto_grace_ms=1000", lag, 1),
            now);
    }
}

/* A cap above every view's age, a hybrid that never fades and a veto that never strikes are all `rewind`. */
static void without_their_limits_all_favour_the_shooter(void **state)
{
    (void)state;
    outcome whole = play("server.hitscan=rewind server.max_rewind_ms=1000", 120, 1);
    assert_true(favour(whole) == 1);
    assert_same(play("server.hitscan=hybrid policies.hybrid_full_ms=1000 server.max_rewind_ms=1000", 120, 1),
                whole);
    assert_same_for_b(
        play("server.hitscan=victim_veto policies.veto_grace_ms=1000 server.max_rewind_ms=1000", 120, 1),
        whole);
}

/* The deeper the rewind may be, the more of what the shooter saw counts, the farther bodies are moved back,
 * and the more victims learn of it behind cover. */
static void all_grow_with_the_cap(void **state)
{
    (void)state;
    outcome last = {.hits = 1};
    const double caps[] = {0, 100, 200, 400};
    for (int i = 0; i < 4; i++) {
        char policy[80];
        snprintf(policy, sizeof policy, "server.hitscan=rewind server.max_rewind_ms=%g", caps[i]);
        outcome o = play(policy, 120, 6);
        assert_true(i == 0 || favour(o) > favour(last));
        assert_true(i == 0 || (o.covered > last.covered && o.rollback_m > last.rollback_m));
        assert_true(o.rewind_ms <= caps[i] && o.vetoed == 0);
        last = o;
    }
    assert_true(favour(last) > 0.99);
}

/* From a shooter with little lag, to whom hybrid gives everything, to one with much, to whom it gives
 * nothing. */
static void hybrid_lies_between(void **state)
{
    (void)state;
    const double lags[] = {0, 40, 60, 80, 150};
    double part[5];
    for (int i = 0; i < 5; i++) {
        outcome none = play("server.hitscan=none", lags[i], 3),
                rewind = play("server.hitscan=rewind", lags[i], 3);
        outcome hybrid = play("server.hitscan=hybrid", lags[i], 3);
        assert_true(favour(none) <= favour(hybrid) && favour(hybrid) <= favour(rewind));
        assert_true(none.covered <= hybrid.covered && hybrid.covered <= rewind.covered);
        assert_true(hybrid.rewind_ms <= rewind.rewind_ms && hybrid.rollback_m <= rewind.rollback_m);
        part[i] = (favour(hybrid) - favour(none)) / (favour(rewind) - favour(none));
        assert_true(i == 0 || part[i] <= part[i - 1]);
        if (i == 4)
            assert_same(hybrid, none);
    }
    assert_true(part[0] == 1 && part[4] == 0 && part[2] > 0.1 && part[2] < 0.9);
}

/* The veto bounds the time behind cover by the grace, however old the shooter's view: what is left is the
 * victim's own: it draws itself ahead of the server by its way up, and learns of the hit by its way down. */
static void the_veto_bounds_the_time_behind_cover(void **state)
{
    (void)state;
    const double graces[] = {0, 50, 100, 200};
    const double own = 40 + 40, /* A's ways */
        ticks = 4 * TICK_MS + UPDATE_MS;
    outcome last = {.hits = 1};
    outcome rewind = play("server.hitscan=rewind", 150, 4);
    for (int i = 0; i < 4; i++) {
        char policy[80];
        snprintf(policy, sizeof policy, "server.hitscan=victim_veto policies.veto_grace_ms=%g", graces[i]);
        outcome o = play(policy, 150, 4);
        assert_true(o.longest_ms <= graces[i] + own + ticks);
        assert_true(i == 0 ||
                    (favour(o) > favour(last) && o.covered >= last.covered && o.vetoed < last.vetoed));
        assert_true(favour(o) <= favour(rewind) && o.covered <= rewind.covered && o.vetoed > 0);
        assert_true(o.rewind_ms == rewind.rewind_ms);
        last = o;
    }
    assert_true(rewind.longest_ms > 0 + own + ticks + 100);
}

/* ---- by hand ---- */

static void act(scene *s, int player, double move, double aim, uint32_t buttons)
{
    const ll_action a = {.axis = {(float)move, (float)aim}, .buttons = buttons};
    s->scenario.kind->input(s->game, player, &a);
}

static void tick(scene *s, int64_t *k)
{
    scene_run(s, ll_to_s(ll_tick_time(++*k, 60000)), NULL);
}

/* Height of the victim's centre at which the line to the shooter, at 7.5 m, touches the edge of the wall,
 * which is 6 m high and 42 m away of 52. */
#define EDGE_M (7.5 - 1.5 * 52 / 42)

/* A shoots at B in the last view in which B is in sight. When B learns of it, it has been behind cover for
 * the shooter's view age + B's lead + A's way up + B's way down, and waits of whole ticks. */
static void time_behind_cover_is_the_sum_of_its_parts(void **state)
{
    (void)state;
    static const struct {
        double shooter_up, shooter_down, victim_up, victim_down;
    } ways[] = {{20, 20, 20, 20},  {200, 20, 20, 20}, {20, 200, 20, 20},
                {20, 20, 200, 20}, {20, 20, 20, 200}, {150, 100, 50, 75}};
    for (size_t i = 0; i < sizeof ways / sizeof ways[0]; i++) {
        char set[4][64];
        snprintf(set[0], sizeof set[0], "players.0.link.up.delay_ms=%g", ways[i].shooter_up);
        snprintf(set[1], sizeof set[1], "players.0.link.down.delay_ms=%g", ways[i].shooter_down);
        snprintf(set[2], sizeof set[2], "players.1.link.up.delay_ms=%g", ways[i].victim_up);
        snprintf(set[3], sizeof set[3], "players.1.link.down.delay_ms=%g", ways[i].victim_down);
        const char *const sets[] = {"players.0.lag_ms=0",
                                    "players.1.lag_ms=0",
                                    set[0],
                                    set[1],
                                    set[2],
                                    set[3],
                                    "players.0.control=person",
                                    "players.1.control=person",
                                    "server.max_rewind_ms=1000",
                                    NULL};
        scene s = scene_open("behind_cover", sets);
        int64_t k = 0;
        while (k < 180)
            tick(&s, &k);
        act(&s, 1, -1, 0, 0);
        const ll_client *shooter = ll_netgame_client(s.game, 0);
        const ll_entity *seen = ll_client_rendered(ll_netgame_client(s.game, 0))->entity;
        while (seen[1].y > EDGE_M + 5 / 60.0)
            tick(&s, &k);
        assert_true(seen[1].y > EDGE_M);
        double age = ll_to_ms(s.game->now - shooter->drawing.view_time);
        act(&s, 0, 0, atan2(seen[1].y - seen[0].y, seen[1].x - seen[0].x) / (M_PI / 2), LL_BUTTON_FIRE);
        tick(&s, &k);
        act(&s, 0, 0, 0, 0);
        for (int t = 0; t < 90; t++)
            tick(&s, &k);
        const ll_shot_stats *m = &ll_netgame_shots(s.game)->shot_stats[0];
        const ll_behind_cover_player *cover = &ll_netgame_behind_cover(s.game)->player[0];
        double sum = age + ways[i].shooter_up + ways[i].victim_up + ways[i].victim_down;
        double waits = 5 * TICK_MS + UPDATE_MS; /* steps on both ways up, an update, a display each */
        assert_int_equal(m->tally[LL_HITSCAN].kept, 1);
        assert_int_equal(cover->shown.count, 1);
        assert_true(age >= ways[i].shooter_down);
        assert_in_range(ll_histogram_summary(&cover->shown).max * 1000, sum * 1000, (sum + waits) * 1000);
        scene_close(&s);
    }
}

/* A victim that has not seen the shooter for longer than the grace is spared too: what a peeker gains by
 * seeing first, A's shots before B sees it, does not count. */
static void the_veto_takes_the_peekers_first_shots(void **state)
{
    (void)state;
    const char *const policies[] = {"server.hitscan=rewind", "server.hitscan=victim_veto"};
    int64_t vetoed[2], hits[2];
    for (int i = 0; i < 2; i++) {
        const char *const sets[] = {policies[i], NULL};
        scene s = scene_open("behind_cover", sets);
        scene_run(&s, 120, NULL);
        vetoed[i] = ll_netgame_behind_cover(s.game)->player[0].vetoed;
        hits[i] = ll_netgame_shots(s.game)->shot_stats[0].tally[LL_HITSCAN].on_players;
        scene_close(&s);
    }
    assert_true(vetoed[0] == 0 && vetoed[1] > 20);
    assert_in_range(hits[0] - hits[1], vetoed[1] - 3,
                    vetoed[1] + 3); /* the warm-up's and the end's may differ */
}

/* The policy concerns shots and not the view: who sees whom first is the same under each. */
static void no_policy_changes_the_peekers_advantage(void **state)
{
    (void)state;
    const char *const policies[] = {"server.hitscan=none", "server.hitscan=rewind", "server.hitscan=hybrid",
                                    "server.hitscan=victim_veto"};
    double mean[4];
    for (int i = 0; i < 4; i++) {
        const char *const sets[] = {policies[i], NULL};
        scene s = scene_open("behind_cover", sets);
        scene_run(&s, 60, NULL);
        mean[i] = ll_shots_peeks(&ll_netgame_shots(s.game)->shot_stats[0]).mean;
        assert_true(mean[i] > 200 && mean[i] == mean[0]);
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cap_of_zero_is_the_servers_present),
        cmocka_unit_test(without_their_limits_all_favour_the_shooter),
        cmocka_unit_test(all_grow_with_the_cap),
        cmocka_unit_test(hybrid_lies_between),
        cmocka_unit_test(the_veto_bounds_the_time_behind_cover),
        cmocka_unit_test(time_behind_cover_is_the_sum_of_its_parts),
        cmocka_unit_test(the_veto_takes_the_peekers_first_shots),
        cmocka_unit_test(no_policy_changes_the_peekers_advantage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
