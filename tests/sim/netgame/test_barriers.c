/* Barriers of deterministic lockstep and rollback: no client passes one, all continue, no input is lost, and
 * the result is that of a game without barriers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/hash.h"
#include "base/rng.h"
#include "support/scene.h"

#define SECONDS 30
#define TICKS (SECONDS * 60)

/* The server's worlds by tick. */
typedef struct outcome {
    const scene *s;
    int64_t ticks;
    uint64_t hash[TICKS + 1];
} outcome;

static void on_event(void *context, const void *row)
{
    const ll_event *event = row;
    outcome *o = context;
    ll_server *server = ll_netgame_server(o->s->game);
    const ll_world *world = ll_server_world(server);
    if (event->type == LL_EVENT_STEP)
        o->hash[o->ticks = server->step] = ll_hash(1, world, ll_world_size(world));
}

static double draw(uint64_t number, int k, double low, double high)
{
    return low + (high - low) * ll_rng_unit(20261124, (uint64_t)k, number);
}

/* Links fail for less than the timeout: a dropped player would get other inputs. */
static scene game(uint64_t n, bool fails)
{
    char text[2048], *at = text, *end = text + sizeof text;
    int players = 2 + (int)draw(n, 0, 0, 3), who = (int)draw(n, 1, 0, players);
    at += snprintf(
        at, (size_t)(end - at),
        "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":3600,\"seed\":%d,\"warmup_s\":0,\"params\":{"
        "\"laps\":10000},\"server\":{\"sync\":\"%s\",\"update_hz\":%d,\"max_rollback_ticks\":%d},\"players\":"
        "[",
        (int)n, n % 2 ? "rollback" : "deterministic", 10 * (1 + (int)draw(n, 2, 0, 6)),
        1 + (int)draw(n, 3, 0, 12));
    for (int p = 0; p < players; p++) {
        bool hit = fails && (p == who || draw(n, 4, 0, 1) < 0.3);
        char blackout[120] = "";
        if (hit)
            snprintf(blackout, sizeof blackout, "\"blackout_at_ms\":%.3f,\"blackout_length_ms\":%.3f",
                     draw(n, 5, 0, 8000), draw(n, 6, 300, 4000));
        at += snprintf(at, (size_t)(end - at),
                       "%s{\"lag_ms\":%.3f,\"input_delay_ticks\":%d,\"link\":{\"up\":{%s},\"down\":{%s}}}",
                       p > 0 ? "," : "", draw(n, 10 + p, 0, 250), (int)draw(n, 20 + p, 0, 5),
                       draw(n, 7, 0, 1) < 0.7 ? blackout : "", draw(n, 8, 0, 1) < 0.7 ? blackout : "");
    }
    snprintf(at, (size_t)(end - at), "]}");
    return scene_make(text, NULL);
}

/* Continues, and counts the barriers that it saw. */
static int play(scene *s, outcome *o)
{
    ll_recorder r = {.record = on_event, .context = o};
    const ll_server *server = ll_netgame_server(s->game);
    int held = 0;
    for (int64_t k = 1; k <= SECONDS * 100; k++) {
        scene_run(s, (double)k / 100, &r);
        held += server->barriers.tick != 0;
        for (int p = 0; p < server->players; p++) {
            const ll_peer *peer = ll_client_peer(ll_netgame_client(s->game, p));
            if (peer->barrier != 0)
                assert_true(peer->tick <= peer->barrier &&
                            ll_netgame_client(s->game, p)->inputs.tick <= peer->barrier);
        }
    }
    return held;
}

static void a_barrier_does_not_change_the_result(void **state)
{
    (void)state;
    int games_held = 0;
    for (uint64_t n = 1; n <= 40; n++) {
        outcome *whole = calloc(1, sizeof *whole), *held = calloc(1, sizeof *held);
        scene a = game(n, false), b = game(n, true);
        whole->s = &a;
        held->s = &b;
        assert_int_equal(play(&a, whole), 0); /* nothing failed */
        games_held += play(&b, held) > 0;
        assert_int_equal(ll_netgame_server(b.game)->barriers.tick, 0);
        assert_true(held->ticks > 50 && held->ticks <= whole->ticks);
        for (int64_t tick = 1; tick <= held->ticks; tick++)
            assert_true(held->hash[tick] == whole->hash[tick]);
        for (int p = 0; p < b.game->config.player_count; p++) {
            const int64_t *results = ll_netgame_client_metrics(b.game, p)->input_history.count;
            assert_int_equal(results[LL_INPUT_WAS_LOST] + results[LL_INPUT_WAS_REFUSED], 0);
            assert_int_equal(ll_netgame_client(b.game, p)->connection.joins, 1);
        }
        scene_close(&a);
        scene_close(&b);
        free(whole);
        free(held);
    }
    assert_true(games_held > 30);
}

/* Where relays are rare one of them is soon lost: that is no outage. Two in a row are. */
static void a_single_lost_relay_causes_no_barrier(void **state)
{
    (void)state;
    for (int k = 0; k < 24; k++) {
        int hz = (const int[]){5, 10, 12}[k % 3], lost = k % 2 + 1;
        char text[1024];
        snprintf(text, sizeof text,
                 "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"seed\":%d,\"warmup_s\":0,"
                 "\"server\":{\"sync\":\"%s\",\"update_hz\":%d},\"players\":[{\"lag_ms\":%d},{\"lag_ms\":35,"
                 "\"link\":{\"down\":{\"blackout_at_ms\":%.3f,\"blackout_length_ms\":%.3f}}}]}",
                 k, k % 4 < 2 ? "rollback" : "deterministic", hz, 20 + 9 * k, (12 + k - 0.5) * 1e3 / hz,
                 (lost - 0.1) * 1e3 / hz);
        scene s = scene_make(text, NULL);
        bool held = false;
        for (int64_t t = 1; t <= 1200; t++) {
            scene_run(&s, (double)t / 100, NULL);
            held |= ll_netgame_server(s.game)->barriers.tick != 0;
        }
        assert_int_equal(held, lost == 2);
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_barrier_does_not_change_the_result),
        cmocka_unit_test(a_single_lost_relay_causes_no_barrier),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
