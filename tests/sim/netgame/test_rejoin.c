/* A client that gives its connection up by its own time-out, and is let in again before the server has
 * dropped it, has sent inputs that others have: it begins again with these. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "support/scene.h"

#if defined(__SANITIZE_ADDRESS__) || !defined(__OPTIMIZE__)
#define CASES 60
#else
#define CASES 240
#endif

static double draw(uint64_t n, int k, double low, double high)
{
    return low + (high - low) * ll_rng_unit(5, (uint64_t)k, n);
}

/* One of two or three players is cut off for a moment, in one direction or both, behind much lag. */
static void write_case(uint64_t n, char *text, size_t room)
{
    static const double timeouts[] = {0.6, 0.7, 0.9};
    const int players = 2 + (int)(n % 2), who = (int)(n / 2) % players;
    int at =
        snprintf(text, room,
                 "{\"kind\":\"netgame\",\"game\":\"race\",\"duration_s\":60,\"seed\":%d,\"warmup_s\":0,"
                 "\"server\":{\"sync\":\"%s\",\"update_hz\":%d,\"timeout_s\":%g},\"peers\":{\"topology\":"
                 "\"%s\"},\"players\":[",
                 (int)n, n % 3 ? "deterministic" : "rollback", n % 4 ? 60 : 20, timeouts[n % 3],
                 n % 5 < 3 ? "relay" : "mesh");
    for (int p = 0; p < players; p++) {
        char cut[96] = "";
        if (p == who)
            snprintf(cut, sizeof cut, "\"blackout_at_ms\":%.3f,\"blackout_length_ms\":%.3f",
                     draw(n, 2, 1500, 3500), draw(n, 3, 300, 1500));
        at +=
            snprintf(text + at, room - (size_t)at,
                     "%s{\"lag_ms\":%.3f,\"script\":\"varied\",\"lane\":0,\"input_delay_ticks\":%d,\"link\":{"
                     "\"up\":{%s},\"down\":{%s}}}",
                     p ? "," : "", draw(n, 10 + p, 20, 550), (int)draw(n, 20 + p, 0, 17),
                     n % 7 < 4 ? "" : cut, n % 7 == 4 ? "" : cut);
    }
    snprintf(text + at, room - (size_t)at, "]}");
}

static void who_joins_again_before_it_was_dropped_is_in_step(void **state)
{
    (void)state;
    int early = 0;
    for (uint64_t n = 0; n < CASES; n++) {
        char text[2048];
        write_case(n, text, sizeof text);
        scene s = scene_make(text, (const char *const[]){NULL});
        scene_run(&s, 9, NULL);
        const ll_server *server = ll_netgame_server(s.game);
        for (int p = 0; p < server->players; p++) {
            const ll_slot_connection *slot = &server->client_slots[p].connection;
            early += slot->joins > 1 + slot->drops;
            if (ll_netgame_desync(s.game, p)->tick >= 0)
                fail_msg("case %d: player %d differs from tick %lld on", (int)n, p,
                         (long long)ll_netgame_desync(s.game, p)->tick);
            assert_int_equal(server->client_slots[p].peer.desync, -1);
        }
        assert_true(server->step > 10); /* lockstep over much lag is slow */
        scene_close(&s);
    }
    print_message("%d let in again before they were dropped\n", early);
    assert_true(early > CASES / 20);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(who_joins_again_before_it_was_dropped_is_in_step)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
