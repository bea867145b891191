/* Scripts: their random draws depend on the session's seed, the time and what the script sees, and on nothing
 * else. */
#include "base/rng.h"
#include "game/core/script.h"
#include "game/harness.h"

enum { PLAYERS = 4, TICKS = 60 * 20 };

/* Whether what a script does depends on the seed. A script that a game does not have is its `varied`. */
static bool draws(const ll_game *game, int script)
{
    if (script == LL_SCRIPT_STEADY)
        return game == &ll_game_shooter; /* it aims */
    return script != LL_SCRIPT_IDLE;
}

static ll_world *open_game(const ll_game *game, int players, ll_game_env *env)
{
    static double params[LL_GAME_PARAMS]; /* `env` refers to them: one game at a time */
    memset(params, 0, sizeof params);
    *env = (ll_game_env){0};
    ll_param_defaults(game->params, params);
    return world_open(game, params, players, 1.0 / 60, env);
}

typedef struct traced {
    ll_action action[TICKS][PLAYERS];
} traced;

static void play(const ll_game *game, ll_script script, uint64_t seed, traced *out)
{
    ll_game_env env;
    ll_world *world = open_game(game, PLAYERS, &env);
    for (int k = 0; k < TICKS; k++) {
        for (int i = 0; i < PLAYERS; i++)
            out->action[k][i] = game->drive(world, &env, seed, i, script, ll_tick_time(k, 60000));
        game->step(world, &env, out->action[k], ll_tick_time(k + 1, 60000), NULL);
    }
    free(world);
}

static int differing(const traced *a, const traced *b, int player)
{
    int n = 0;
    for (int k = 0; k < TICKS; k++)
        n += memcmp(&a->action[k][player], &b->action[k][player], sizeof(ll_action)) != 0;
    return n;
}

static void seeds_matter_only_where_the_table_says_so(void **state)
{
    (void)state;
    traced *one = malloc(sizeof *one), *same = malloc(sizeof *same), *other = malloc(sizeof *other);
    assert_true(one && same && other);
    for (int g = 0; ll_games[g]; g++)
        for (int script = 0; ll_script_names[script]; script++) {
            const ll_game *game = ll_games[g];
            play(game, (ll_script)script, 7, one);
            play(game, (ll_script)script, 7, same);
            play(game, (ll_script)script, 8, other);
            assert_memory_equal(one, same, sizeof *one);
            for (int i = 0; i < PLAYERS; i++)
                if ((differing(one, other, i) > 0) != draws(game, script))
                    fail_msg("%s %s: player %d has %d of %d actions that differ between seeds", game->name,
                             ll_script_names[script], i, differing(one, other, i), TICKS);
        }
    free(one);
    free(same);
    free(other);
}

/* Called backwards and out of order, with one world that does not change: the same answers. */
static void a_script_keeps_nothing(void **state)
{
    (void)state;
    enum { ASKED = 500 };
    for (int g = 0; ll_games[g]; g++)
        for (int script = 0; ll_script_names[script]; script++) {
            const ll_game *game = ll_games[g];
            ll_game_env env;
            ll_action first[ASKED];
            ll_world *world = open_game(game, PLAYERS, &env);
            for (int k = 0; k < ASKED; k++)
                first[k] = game->drive(world, &env, 3, k % PLAYERS, (ll_script)script, k * 37 * LL_MS);
            for (int k = ASKED; k-- > 0;) {
                ll_action again = game->drive(world, &env, 3, k % PLAYERS, (ll_script)script, k * 37 * LL_MS);
                assert_memory_equal(&again, &first[k], sizeof again);
            }
            free(world);
        }
}

/* Up to the time that a game names the script does the same in any world; and that time is the change itself,
 * or nothing is gained by asking for it. */
static void a_script_does_the_same_until_it_says(void **state)
{
    (void)state;
    int told = 0, changed = 0;
    for (int g = 0; ll_games[g]; g++)
        for (int script = 0; ll_script_names[script] && ll_games[g]->same_until; script++) {
            const ll_game *game = ll_games[g];
            ll_game_env env;
            ll_world *world = open_game(game, PLAYERS, &env);
            for (int k = 0; k < 400; k++) {
                int player = k % PLAYERS;
                ll_time t = k * 173 * LL_MS, until = game->same_until(&env, 7, player, (ll_script)script, t);
                ll_action now = game->drive(world, &env, 7, player, (ll_script)script, t);
                assert_true(until >= t);
                for (int i = 1; i <= 40 && until > t && until != LL_NEVER; i++) {
                    world->entity[player].x = i * 977.0;
                    world->entity[player].flags ^= LL_ENTITY_FINISHED;
                    ll_time later = i < 40 ? t + (until - t) * i / 40 : until - 1;
                    ll_action then = game->drive(world, &env, 7, player, (ll_script)script, later);
                    assert_memory_equal(&then, &now, sizeof now);
                    told++;
                }
                if (until > t && until != LL_NEVER) {
                    ll_action next = game->drive(world, &env, 7, player, (ll_script)script, until);
                    changed += memcmp(&next, &now, sizeof now) != 0;
                }
            }
            free(world);
        }
    assert_true(told > 10000 && changed > 500);
}

static void players_do_not_do_the_same(void **state)
{
    (void)state;
    traced *one = malloc(sizeof *one);
    assert_non_null(one);
    for (int g = 0; ll_games[g]; g++) {
        play(ll_games[g], LL_SCRIPT_VARIED, 11, one);
        int same = 0;
        for (int k = 0; k < TICKS; k++)
            same += memcmp(&one->action[k][0], &one->action[k][1], sizeof(ll_action)) == 0;
        assert_true(same < TICKS);
    }
    free(one);
}

/* ---- prediction ---- */

/* In how many of TICKS steps `step_own` leaves each player's entity as the server's step does, to the last
 * bit. */
static int predicted_steps(const ll_game *game, int players)
{
    ll_game_env env;
    ll_world *world = open_game(game, players, &env);
    int steps = 0;
    for (int k = 0; k < TICKS; k++) {
        ll_action actions[PLAYERS];
        ll_world *own[PLAYERS];
        for (int i = 0; i < players; i++) {
            own[i] = world_copy(world);
            actions[i] = game->drive(world, &env, 7, i, LL_SCRIPT_VARIED, ll_tick_time(k, 60000));
        }
        game->step(world, &env, actions, ll_tick_time(k + 1, 60000), NULL);
        int same = 0;
        for (int i = 0; i < players; i++) {
            game->step_own(own[i], &env, i, &actions[i]);
            same += memcmp(&own[i]->entity[i], &world->entity[i], sizeof(ll_entity)) == 0;
            free(own[i]);
        }
        steps += same == players;
    }
    free(world);
    return steps;
}

/* Always, where a prediction reads nothing else and nothing touches; else a player alone, who pushes things
 * about (in `stack` cards, which no prediction has), a third of the time. */
static void a_step_is_what_its_players_predict(void **state)
{
    (void)state;
    for (int g = 0; ll_games[g]; g++) {
        const ll_game *game = ll_games[g];
        bool exact = !game->own_reads_world && game->reach == NULL && game != &ll_game_stack;
        int steps = predicted_steps(game, exact ? PLAYERS : 1);
        if (steps < (exact ? TICKS : TICKS / 3))
            fail_msg("%s: %d of %d steps are as predicted", game->name, steps, TICKS);
    }
}

/* ---- slots ---- */

/* The boundaries by a loop from the beginning: a second reading of the same words. */
static ll_slot slot_by_walking(uint64_t seed, int player, int purpose, ll_time t, ll_time mean,
                               ll_time spread)
{
    uint64_t stream = UINT64_C(0x7363726970740000) + 16 * (uint64_t)player + (uint64_t)purpose;
    ll_time at = t + (ll_time)(ll_rng_u64(seed, stream, 0) % (uint64_t)mean), begin = 0;
    int64_t k = 0;
    for (;; k++) {
        ll_time next =
            (k + 1) * mean + (ll_time)(ll_rng_u64(seed, stream, (uint64_t)k + 1) % (uint64_t)spread);
        if (next > at)
            return (ll_slot){k, at - begin};
        begin = next;
    }
}

static void slots_are_those_of_a_walk(void **state)
{
    (void)state;
    for (uint64_t n = 0; n < 20000; n++) {
        ll_time mean = 1 + (ll_time)(ll_rng_u64(1, 0, n) % (2 * LL_SECOND));
        ll_time spread = 1 + (ll_time)(ll_rng_u64(1, 1, n) % (uint64_t)mean);
        ll_time t = (ll_time)(ll_rng_u64(1, 2, n) % (uint64_t)(40 * mean));
        int player = (int)(ll_rng_u64(1, 3, n) % 16), purpose = (int)(ll_rng_u64(1, 4, n) % 16);
        ll_slot a = ll_script_slot(n, player, purpose, t, mean, spread),
                b = slot_by_walking(n, player, purpose, t, mean, spread);
        assert_int_equal(a.number, b.number);
        assert_int_equal(a.since, b.since);
    }
}

/* The times are on no grid: when a race's controls change, relative to 750 ms, is spread over all of them. */
static void changes_lie_on_no_raster(void **state)
{
    (void)state;
    enum { BINS = 10 };
    const ll_time mean = 750 * LL_MS;
    int bins[BINS] = {0}, changes = 0;
    ll_game_env env;
    ll_world *world = open_game(&ll_game_race, 2, &env);
    for (uint64_t seed = 0; seed < 40; seed++) {
        ll_action before = {0};
        for (ll_time t = 3 * LL_SECOND; t < 33 * LL_SECOND; t += 5 * LL_MS) {
            ll_action a = ll_game_race.drive(world, &env, seed, 1, LL_SCRIPT_VARIED, t);
            if (t > 3 * LL_SECOND && a.axis[0] != before.axis[0]) {
                changes++;
                bins[t % mean * BINS / mean]++;
            }
            before = a;
        }
    }
    /* 30 s hold 40 slots, and two of six pedals are alike: 40 x 40 x (1 - 8/36) = 1244 are expected */
    assert_in_range(changes, 1150, 1340);
    for (int i = 0; i < BINS; i++)
        assert_in_range(bins[i], 60, 190); /* 124 are expected */
    free(world);
}

/* A car at the finish goes on: the view changes for as long as the session lasts. */
static void a_varied_race_goes_on_behind_the_finish(void **state)
{
    (void)state;
    ll_game_env env;
    ll_world *world = open_game(&ll_game_race, 1, &env);
    int changes = 0, still = 0;
    ll_action before = {0};
    for (int k = 0; k < 60 * 300; k++) {
        ll_action a = ll_game_race.drive(world, &env, 5, 0, LL_SCRIPT_VARIED, ll_tick_time(k, 60000));
        ll_game_race.step(world, &env, &a, ll_tick_time(k + 1, 60000), NULL);
        if (k > 60 * 240) {
            changes += a.axis[0] != before.axis[0];
            still += world->entity[0].vx == 0;
        }
        before = a;
    }
    assert_true(world->entity[0].flags & LL_ENTITY_FINISHED);
    assert_true(changes > 40);
    assert_true(still < 300);
    free(world);
}

/* Length and time of a peek are random: the times of coming out are on no grid. */
static void peeks_come_at_drawn_intervals(void **state)
{
    (void)state;
    ll_game_env env;
    ll_world *world = open_game(&ll_game_shooter, 2, &env);
    ll_time last = 0, least = LL_NEVER, most = 0;
    int peeks = 0;
    double sum = 0;
    world->entity[0].y = 5; /* between the hiding-place and the lookout: up when out, down when not */
    float before = -1;
    for (ll_time t = 0; t < 600 * LL_SECOND; t += LL_MS) {
        float way = ll_game_shooter.drive(world, &env, 21, 0, LL_SCRIPT_PEEK, t).axis[0];
        if (way > 0 && before < 0) {
            if (last > 0) {
                ll_time gap = t - last;
                least = gap < least ? gap : least;
                most = gap > most ? gap : most;
                sum += ll_to_s(gap);
                peeks++;
            }
            last = t;
        }
        before = way;
    }
    assert_in_range(peeks, 230, 260); /* 600 / 2.4 */
    assert_true(sum / peeks > 2.3 && sum / peeks < 2.5);
    assert_true(least >= 1600 * LL_MS - LL_MS && least < 1900 * LL_MS);
    assert_true(most <= 3200 * LL_MS + LL_MS && most > 2900 * LL_MS);
    free(world);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_step_is_what_its_players_predict),
        cmocka_unit_test(seeds_matter_only_where_the_table_says_so),
        cmocka_unit_test(a_script_keeps_nothing),
        cmocka_unit_test(a_script_does_the_same_until_it_says),
        cmocka_unit_test(players_do_not_do_the_same),
        cmocka_unit_test(slots_are_those_of_a_walk),
        cmocka_unit_test(changes_lie_on_no_raster),
        cmocka_unit_test(a_varied_race_goes_on_behind_the_finish),
        cmocka_unit_test(peeks_come_at_drawn_intervals),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
