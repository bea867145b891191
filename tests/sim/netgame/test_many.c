/* More entities than a set of the prediction holds, and snapshots of some of them: whole games. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/prefetch.h"
#include "session/kinds.h"
#include "support/netgame_valid.h"
#include "support/scene.h"

/* With 1,004 entities a client predicts its own alone, which is never corrected on a clean link; and it knows
 * only those of its area. */
static void clients_of_a_thousand_predict_their_own(void **state)
{
    (void)state;
    const char *const sets[] = {"params.bodies=1000", "params.field_m=330", "players.1.link.up.loss_pct=0",
                                "players.1.link.down.loss_pct=0", NULL};
    scene s = scene_open("swarm_interest", sets);
    scene_run(&s, 6, NULL);
    assert_null(netgame_broken(s.game));
    for (int p = 0; p < s.game->config.player_count; p++) {
        const ll_client *c = ll_netgame_client(s.game, p);
        const ll_world *shown = ll_client_rendered_const(c);
        int known = 0;
        assert_int_equal(shown->entities, 1004);
        assert_int_equal(c->snapshots.unreadable, 0);
        assert_int_equal(ll_netgame_client_metrics(s.game, p)->corrections.count, 0);
        for (int i = 0; i < shown->entities; i++) {
            bool predicted = ll_client_draw_infos_const(c)[i].flags & LL_RENDERED_PREDICTED;
            assert_int_equal(predicted, i == p);
            known += !(shown->entity[i].flags & LL_ENTITY_UNKNOWN);
        }
        assert_in_range(known, 10, 120); /* 46 in a circle of 40 m, where it is whole */
    }
    scene_close(&s);
}

/* Forty players, until each has made more inputs than a client keeps open: the last ones predict as well as
 * the first. */
static void the_fortieth_player_predicts_as_the_first(void **state)
{
    (void)state;
    enum { PLAYERS = 40 };
    char json[4000];
    int n = snprintf(json, sizeof json,
                     "{\"kind\":\"netgame\",\"game\":\"swarm\",\"duration_s\":12,\"params\":{\"bodies\":20,"
                     "\"field_m\":200},\"server\":{\"snapshot_encoding\":\"interest\",\"update_hz\":20,"
                     "\"snapshot_bytes\":500,\"interest_radius_m\":50},\"players\":[");
    for (int p = 0; p < PLAYERS; p++)
        n += snprintf(json + n, sizeof json - (size_t)n,
                      "%s{\"lag_ms\":%d,\"prediction\":true,\"reconciliation\":true}", p > 0 ? "," : "",
                      20 + p);
    snprintf(json + n, sizeof json - (size_t)n, "]}");
    scene s = scene_make(json, NULL);
    scene_run(&s, 11, NULL);
    assert_null(netgame_broken(s.game));
    for (int p = 0; p < PLAYERS; p++) {
        const ll_client *c = ll_netgame_client(s.game, p);
        assert_true(c->inputs.seq > LL_PENDING_RING);
        assert_int_equal(ll_netgame_client_metrics(s.game, p)->corrections.count, 0);
        assert_true(ll_client_draw_infos_const(c)[p].flags & LL_RENDERED_PREDICTED);
    }
    scene_close(&s);
}

/* Snapshots of 40 bytes leave most of the others unknown. What a client predicts then touches none of them:
 * it did, all at the origin, and a step had more contacts than its world holds. */
static void the_unknown_take_no_part(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"crates_delta", "crates", "race", "eight", "cannon_drag"};
    static const char *const scopes[] = {"own", "contacts", "all"};
    for (size_t k = 0; k < sizeof scenarios / sizeof *scenarios; k++)
        for (int scope = 0; scope < 3; scope++) {
            char chosen[64];
            snprintf(chosen, sizeof chosen, "players.0.prediction_scope=%s", scopes[scope]);
            const char *const sets[] = {"server.snapshot_encoding=partial_delta",
                                        "server.snapshot_bytes=40",
                                        "server.update_hz=50",
                                        "players.0.prediction=true",
                                        chosen,
                                        NULL};
            scene s = scene_open(scenarios[k], sets);
            scene_run(&s, 3, NULL);
            assert_null(netgame_broken(s.game));
            scene_close(&s);
        }
}

/* What a client remembers of its last display saves work only: where it is forgotten, and all is drawn again,
 * each display shows the same. Links are so bad that others are extrapolated now and then. */
static void what_is_kept_on_the_screen_is_what_would_be_drawn(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"crates_delta", "crates", "race", "eight", "swarm_interest"};
    for (size_t k = 0; k < sizeof scenarios / sizeof *scenarios; k++) {
        const char *const sets[] = {"server.snapshot_encoding=partial_delta",
                                    "server.snapshot_bytes=40",
                                    "server.update_hz=30",
                                    "players.0.interpolation=true",
                                    "players.0.correction=snap",
                                    "players.0.extrapolation_ms=300",
                                    "players.0.link.down.loss_pct=60",
                                    "players.0.link.down.jitter_ms=60",
                                    NULL};
        scene s = scene_open(scenarios[k], sets), forgetful = scene_open(scenarios[k], sets);
        int again = 0, extrapolated = 0;
        for (int i = 1; i <= 8 * 60; i++) {
            for (int p = 0; p < s.game->config.player_count; p++)
                ll_netgame_recent(forgetful.game, p)->drawn = 0;
            scene_run(&s, i / 60.0, NULL);
            scene_run(&forgetful, i / 60.0, NULL);
            for (int p = 0; p < s.game->config.player_count; p++) {
                const ll_client *c = ll_netgame_client(s.game, p);
                again += ll_netgame_recent(s.game, p)->shows;
                assert_false(ll_netgame_recent(forgetful.game, p)->shows);
                extrapolated += c->view.extrapolated;
                const ll_world *shown = ll_client_rendered_const(c),
                               *fresh = ll_client_rendered_const(ll_netgame_client(forgetful.game, p));
                for (int e = 0; e < shown->entities; e++)
                    if (memcmp(&shown->entity[e], &fresh->entity[e], sizeof *fresh->entity) != 0)
                        fail_msg("%s: entity %d is drawn otherwise in display %d of player %d", scenarios[k],
                                 e, i, p);
            }
        }
        assert_true(again > 100 && extrapolated > 100);
        scene_close(&s);
        scene_close(&forgetful);
    }
}

/* At any time, for any number of players: hints for prefetching. */
static void what_a_tick_touches_lies_in_the_block(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"race", "eight", "swarm_interest", "cannon_drag"};
    for (size_t k = 0; k < sizeof scenarios / sizeof *scenarios; k++) {
        scene s = scene_open(scenarios[k], NULL);
        for (int seconds = 0; seconds < 3; seconds++) {
            ll_block_range range[LL_BLOCK_RANGES_MAX];
            int count = ll_sim_netgame.touches(s.game, range);
            assert_in_range(count, 8, LL_BLOCK_RANGES_MAX); /* a large block has parts out of reach */
            for (int i = 0; i < count; i++) {
                size_t end = (size_t)(range[i].line + range[i].count) * LL_LINE;
                assert_in_range(range[i].count, 1, 33);
                assert_true(end < ll_netgame_bytes(s.game) + LL_LINE);
            }
            scene_run(&s, seconds + 1, NULL);
        }
        scene_close(&s);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clients_of_a_thousand_predict_their_own),
        cmocka_unit_test(the_fortieth_player_predicts_as_the_first),
        cmocka_unit_test(the_unknown_take_no_part),
        cmocka_unit_test(what_is_kept_on_the_screen_is_what_would_be_drawn),
        cmocka_unit_test(what_a_tick_touches_lies_in_the_block),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
