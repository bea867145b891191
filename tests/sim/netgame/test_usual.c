/* A usual client takes a short way through its ticks, displays and timers. Another one takes the general way:
 * its clock drifts, but by less than 1 ns in a year. The blocks behind the two configurations stay the same,
 * byte for byte, also while the parameters change. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#include "base/rng.h"
#include "sim/netgame/parts.h"
#include "support/scene.h"

enum { SEEDS = 60, SECONDS = 12 };

static uint64_t draw(int seed, int what, uint64_t below)
{
    return ll_rng_u64((uint64_t)seed, (uint64_t)what, 7) % below;
}

static bool on(int seed, int what)
{
    return draw(seed, what, 2) == 1;
}

static bool is_usual(ll_netgame *g, int player)
{
    ll_script_memo memo = {.until = INT64_MIN};
    ll_client_setup setup = ll_netgame_client_setup(g, player, NULL);
    setup.memo = &memo;
    return ll_client_is_usual(&setup);
}

static ll_netgame_config random_config(const ll_netgame *g, int seed)
{
    ll_netgame_config c = scene_config(g);
    for (int i = 0; i < c.player_count; i++) {
        ll_player_config *p = &c.players[i];
        const int at = 100 * (i + 1);
        p->lag_ms = (double)draw(seed, at, 300);
        p->prediction = on(seed, at + 1);
        p->reconciliation = p->prediction && on(seed, at + 2);
        p->interpolation = on(seed, at + 3);
        p->redundancy = (int64_t)draw(seed, at + 4, 4);
        p->link.up.jitter_ms = (double)draw(seed, at + 5, 40);
        p->link.down.loss_pct = (double)draw(seed, at + 6, 20);
        p->link.up.loss_pct = (double)draw(seed, at + 7, 20);
    }
    return c;
}

static void change(scene *s, const ll_netgame_config *to)
{
    s->scenario.kind->change(s->game, to, s->game->now);
}

static scene open_scene(const char *id, int seed, bool general)
{
    char number[32];
    snprintf(number, sizeof number, "seed=%d", seed);
    const char *const sets[] = {number,
                                "warmup_s=1",
                                general ? "players.0.drift_ppm=1e-12" : "players.0.drift_ppm=0",
                                general ? "players.1.drift_ppm=1e-12" : "players.1.drift_ppm=0",
                                on(seed, 1) ? "server.timeout_s=4" : "server.timeout_s=0",
                                NULL};
    return scene_open(id, sets);
}

static void compare(const ll_netgame *a, const ll_netgame *b, const char *id, int seed, int tick)
{
    assert_int_equal(a->server, b->server);
    assert_int_equal(a->size, b->size);
    if (memcmp((const char *)a + a->server, (const char *)b + b->server, (size_t)(a->size - a->server)) != 0)
        fail_msg("%s, seed %d, tick %d: the short way differs", id, seed, tick);
}

/* What makes a client unusual for a while. */
static void disturb(ll_netgame_config *c, int what)
{
    switch (what) {
    case 0:
        c->players[0].cheat = LL_CHEAT_LAG_SWITCH;
        break;
    case 1:
        c->players[0].send_hz = 20;
        break;
    case 2:
        c->players[1].timer_jitter_ms = 9;
        break;
    default:
        c->players[1].link.up.blackout_at_ms = 0;
        c->players[1].link.up.blackout_every_ms = 2000;
        c->players[1].link.up.blackout_length_ms = 700;
    }
}

static void run_both(const char *id, int seed, int *usual)
{
    scene a = open_scene(id, seed, false), b = open_scene(id, seed, true);
    for (int tick = 1; tick <= SECONDS * 60; tick++) {
        if (tick % 150 == 1) {
            ll_netgame_config to = random_config(a.game, seed * 1000 + tick),
                              same = random_config(b.game, seed * 1000 + tick);
            if (tick / 150 % 2 == 1) {
                disturb(&to, (seed + tick / 300) % 4);
                disturb(&same, (seed + tick / 300) % 4);
            } else {
                to.players[0].cheat = same.players[0].cheat = LL_CHEAT_NONE;
                to.players[0].send_hz = same.players[0].send_hz = 0;
                to.players[1].timer_jitter_ms = same.players[1].timer_jitter_ms = 0;
                to.players[1].link.up.blackout_length_ms = same.players[1].link.up.blackout_length_ms = 0;
            }
            change(&a, &to);
            change(&b, &same);
        }
        *usual += is_usual(a.game, 0) + is_usual(a.game, 1);
        assert_false(is_usual(b.game, 0) || is_usual(b.game, 1));
        scene_run(&a, tick / 60.0, NULL);
        scene_run(&b, tick / 60.0, NULL);
        compare(a.game, b.game, id, seed, tick);
    }
    scene_close(&a);
    scene_close(&b);
}

static void the_short_way_is_the_general_one(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"race", "rifle", "crates", "eight"};
    int usual = 0;
    for (int seed = 1; seed <= SEEDS; seed++)
        run_both(scenarios[seed % 16 == 3 ? 2 : seed % 8 == 5 ? 3 : seed % 4 == 2 ? 1 : 0], seed, &usual);
    assert_true(usual > SEEDS * SECONDS * 60 / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_short_way_is_the_general_one)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
