/* The block is sound after every tick: in every netgame of the library, and under settings drawn at random.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/rng.h"
#include "library/library.h"
#include "support/netgame_valid.h"
#include "support/scene.h"

static void run_checked(const char *name, scene *s, double seconds)
{
    for (int tick = 1; tick <= seconds * 60; tick++) {
        scene_run(s, tick / 60.0, NULL);
        const char *broken = netgame_broken(s->game);
        if (broken)
            fail_msg("%s, tick %d: %s", name, tick, broken);
    }
}

static void the_library_is_sound(void **state)
{
    (void)state;
    cJSON *list, *item;
    int count = 0;
    ll_status status = ll_scenario_list("scenarios", &list);
    assert_false(ll_failed(&status));
    cJSON_ArrayForEach(item, list)
    {
        const char *id = cJSON_GetObjectItem(item, "id")->valuestring;
        if (strcmp(cJSON_GetObjectItem(item, "kind")->valuestring, "netgame") != 0)
            continue;
        scene s = scene_open(id, NULL);
        run_checked(id, &s, 3);
        scene_close(&s);
        count++;
    }
    cJSON_Delete(list);
    assert_true(count > 30);
}

static int draw(int run, int which, int below)
{
    return (int)(ll_rng_unit(0x76616c6964, (uint64_t)run, (uint64_t)which) * below);
}

enum { SETTINGS = 14, TEXT = 80 };

static void random_settings_are_sound(void **state)
{
    (void)state;
    static const char *const syncs[] = {"free",          "lockstep", "lockstep_pipelined",
                                        "deterministic", "rollback", "gambetta"};
    for (int run = 0; run < 48; run++) {
        char text[SETTINGS][TEXT];
        const char *sets[SETTINGS + 1] = {0};
        int n = 0;
        snprintf(text[n++], TEXT, "server.sync=%s", syncs[run % 6]);
        snprintf(text[n++], TEXT, "server.update_hz=%d", 5 + draw(run, 0, 50));
        for (int p = 0; p < 2; p++) {
            int from = 10 * p;
            snprintf(text[n++], TEXT, "players.%d.lag_ms=%d", p, draw(run, from + 1, 400));
            snprintf(text[n++], TEXT, "players.%d.prediction=%s", p,
                     draw(run, from + 2, 2) ? "true" : "false");
            snprintf(text[n++], TEXT, "players.%d.interpolation=%s", p,
                     draw(run, from + 3, 2) ? "true" : "false");
            snprintf(text[n++], TEXT, "players.%d.link.up.loss_pct=%d", p, draw(run, from + 4, 40));
            snprintf(text[n++], TEXT, "players.%d.link.down.jitter_ms=%d", p, draw(run, from + 5, 100));
            snprintf(text[n++], TEXT, "players.%d.link.down.duplicate_pct=%d", p, draw(run, from + 6, 30));
        }
        for (int i = 0; i < n; i++)
            sets[i] = text[i];
        scene s = scene_open("race", sets);
        run_checked(text[0], &s, 8);
        scene_close(&s);
    }
}

/* What it must find. */
static void faults_are_found(void **state)
{
    (void)state;
    scene s = scene_open("race", NULL);
    scene_run(&s, 2, NULL);
    assert_null(netgame_broken(s.game));
    ll_client *c = ll_netgame_client(s.game, 0);
    ll_server *server = ll_netgame_server(s.game);
    c->inputs.acked += 1000;
    assert_non_null(netgame_broken(s.game));
    c->inputs.acked -= 1000;
    c->snapshots.confirmed = server->step + 1;
    assert_non_null(netgame_broken(s.game));
    c->snapshots.confirmed = server->step - 10;
    ll_client_state(c, c->snapshots.received - 1)->tick -= 5;
    assert_non_null(netgame_broken(s.game));
    ll_client_state(c, c->snapshots.received - 1)->tick += 5;
    assert_null(netgame_broken(s.game));
    server->client_slots[1].inputs.ring[7].tick = 8;
    assert_string_equal(netgame_broken(s.game), "an input is not in its place of the ring");
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(the_library_is_sound),
                                       cmocka_unit_test(random_settings_are_sound),
                                       cmocka_unit_test(faults_are_found)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
