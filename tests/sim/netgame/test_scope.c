/* The prediction scope, compared with whole games. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "netcode/client/scope.h"
#include "support/scene.h"

#define PREDICTING(p) "players." p ".prediction=true", "players." p ".reconciliation=true"

static ll_summary summary(const scene *s, int player, ll_metric metric)
{
    return ll_histogram_summary(&ll_netgame_client_metrics(s->game, player)->histogram[metric]);
}

static int64_t corrections(const scene *s, int player)
{
    return ll_netgame_client_metrics(s->game, player)->corrections.count;
}

/* Every game without contact, from no lag to the longest: nothing is corrected, in any scope. */
static void clean_link_needs_no_correction(void **state)
{
    (void)state;
    static const char *const scenarios[] = {"race", "cannon", "gambetta_default"};
    static const double lags[] = {0, 37.3, 150, 1000};
    for (size_t i = 0; i < sizeof scenarios / sizeof scenarios[0]; i++)
        for (size_t k = 0; k < sizeof lags / sizeof lags[0]; k++)
            for (int scope = 0; ll_scopes[scope]; scope++) {
                char lag[48], a[64], b[64];
                snprintf(lag, sizeof lag, "players.0.lag_ms=%g", lags[k]);
                snprintf(a, sizeof a, "players.0.prediction_scope=%s", ll_prediction_scope_names[scope]);
                snprintf(b, sizeof b, "players.1.prediction_scope=%s", ll_prediction_scope_names[scope]);
                const char *const sets[] = {lag, a, b, "warmup_s=0", PREDICTING("0"), PREDICTING("1"), NULL};
                scene s = scene_open(scenarios[i], sets);
                scene_run(&s, 30, NULL);
                for (int p = 0; p < 2; p++) {
                    if (corrections(&s, p) != 0)
                        fail_msg("%s, lag %g, scope %s: %d corrections of %d", scenarios[i], lags[k],
                                 ll_prediction_scope_names[scope], (int)corrections(&s, p), p);
                    assert_true(summary(&s, p, LL_METRIC_POP).count > 80);
                    assert_true(fabs(ll_server_world(ll_netgame_server(s.game))->entity[p].x) > 1e-3);
                }
                scene_close(&s);
            }
}

/* B drives at full throttle into A, who is controlled by `script`. */
static scene contact(const char *scope, const char *script)
{
    char a[64], b[64], c[64];
    snprintf(a, sizeof a, "players.0.prediction_scope=%s", scope);
    snprintf(b, sizeof b, "players.1.prediction_scope=%s", scope);
    snprintf(c, sizeof c, "players.0.script=%s", script);
    const char *const sets[] = {a, b, c, "players.1.script=steady", NULL};
    scene s = scene_open("contact", sets);
    scene_run(&s, 30, NULL);
    return s;
}

/* Two cars that touch with constant pedals: a client that predicts only its own car is corrected at every
 * touch; stepping the other car too is never wrong, since its controls are known. */
static void contact_is_predicted_where_the_other_is_stepped_too(void **state)
{
    (void)state;
    scene own = contact("own", "idle"), contacts = contact("contacts", "idle"), all = contact("all", "idle");
    for (int p = 0; p < 2; p++) {
        assert_true(corrections(&own, p) > 100);
        assert_int_equal(corrections(&contacts, p), 0);
        assert_int_equal(corrections(&all, p), 0);
    }
    scene_close(&own);
    scene_close(&contacts);
    scene_close(&all);
}

/* A changes the pedal at times, which B receives one delay later: B is corrected then, and A, who knows B's
 * pedal, never. Both draw the other nearer to its present position than with interpolation. */
static void contact_is_mispredicted_when_the_other_changes_its_controls(void **state)
{
    (void)state;
    scene own = contact("own", "varied"), contacts = contact("contacts", "varied");
    assert_true(corrections(&own, 0) > 100 && corrections(&own, 1) > 100);
    assert_int_equal(corrections(&contacts, 0), 0);
    assert_in_range(corrections(&contacts, 1), 1, corrections(&own, 1) / 5);
    for (int p = 0; p < 2; p++) {
        assert_true(summary(&contacts, p, LL_METRIC_REMOTE_ERROR).rms <
                    0.9 * summary(&own, p, LL_METRIC_REMOTE_ERROR).rms);
        assert_true(summary(&contacts, p, LL_METRIC_VIEW_AGE).max == 0);
    }
    scene_close(&own);
    scene_close(&contacts);
}

/* Where a snapshot agrees with the prediction nothing is replayed: the predicted world must then equal the
 * result of a replay. */
static void a_skipped_replay_would_change_nothing(void **state)
{
    (void)state;
    for (int scope = 0; ll_scopes[scope]; scope++) {
        char set[8][64];
        const char *sets[9] = {NULL};
        for (int p = 0; p < 8; p++) {
            snprintf(set[p], sizeof set[p], "players.%d.prediction_scope=%s", p,
                     ll_prediction_scope_names[scope]);
            sets[p] = set[p];
        }
        scene s = scene_open("eight", sets);
        int64_t states = 0, replays = 0, compared = 0;
        for (int k = 0; k < 300; k++) {
            scene_run(&s, 2 + k * 0.05, NULL);
            ll_netgame *copy = malloc(ll_netgame_bytes(s.game));
            memcpy(copy, s.game, ll_netgame_bytes(s.game));
            for (int p = 0; p < 8; p++) {
                ll_client *c = ll_netgame_client(s.game, p), *d = ll_netgame_client(copy, p);
                ll_client_setup setup = {.game = ll_netgame_game(copy),
                                         .env = &copy->env,
                                         .sync = ll_netgame_sync(copy),
                                         .config = &copy->config.players[p],
                                         .client_metrics = ll_netgame_client_metrics(copy, p)};
                if (c->snapshots.received > c->snapshots.used)
                    continue; /* a snapshot brings the others' controls and counts from the next frame on */
                compared++;
                ll_resimulate(d, &setup);
                assert_int_equal(c->prediction.tick, d->prediction.tick);
                assert_int_equal(c->prediction.tick, c->inputs.tick);
                for (int e = 0; e < 8; e++)
                    if (ll_entity_set_has(&c->prediction.entities, e))
                        assert_memory_equal(&ll_client_predicted(c)->entity[e],
                                            &ll_client_predicted(d)->entity[e], offsetof(ll_entity, flags));
            }
            free(copy);
        }
        for (int p = 0; p < 8; p++) {
            states += ll_netgame_client(s.game, p)->snapshots.received;
            replays += ll_netgame_client_metrics(s.game, p)->input_history.replays;
        }
        assert_true(compared > 1000);
        assert_true(replays > 0 &&
                    replays < states / 4); /* the case matters: most snapshots agree with the prediction */
        scene_close(&s);
    }
}

/* Brakes do not move a car at rest, so the world stays as predicted; but the guess must follow. */
static void a_guess_follows_also_when_nothing_moves(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.prediction_scope=all", "players.1.control=person", NULL};
    scene s = scene_open("race", sets);
    const ll_client *c = ll_netgame_client(s.game, 0);
    scene_run(&s, 3, NULL);
    assert_true(c->prediction.guessed[1].axis[0] == 0);
    s.scenario.kind->input(s.game, 1, &(ll_action){.axis = {-1, 0}});
    scene_run(&s, 5, NULL);
    assert_true(ll_server_world(ll_netgame_server(s.game))->entity[1].x == 0);
    assert_true(c->prediction.guessed[1].axis[0] == -1);
    scene_close(&s);
}

/* In scope `contacts` a car far away is drawn as without it, a near one is drawn ahead of the server's
 * present. A waits behind the finish, where B drives past. */
static void only_entities_that_may_touch_are_predicted(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.prediction_scope=contacts", "players.0.script=steady",
                                "players.1.script=varied", "params.laps=3", NULL};
    scene s = scene_open("contact", sets);
    ll_client *c = ll_netgame_client(s.game, 0);
    int near = 0, far = 0;
    for (int k = 1; k < 500; k++) {
        scene_run(&s, 1 + k * 0.1, NULL);
        const ll_draw_info *mark = &ll_client_draw_infos_const(c)[1];
        ll_world *world = ll_server_world(ll_netgame_server(s.game));
        if (mark->flags & LL_RENDERED_PREDICTED) {
            near++;
            assert_true(mark->time > s.game->now && mark->time <= s.game->now + 200 * LL_MS);
        } else {
            far++;
            assert_true(mark->time < s.game->now - 150 * LL_MS);
        }
        if (fabs(world->entity[0].x - world->entity[1].x) < 5)
            assert_true(mark->flags & LL_RENDERED_PREDICTED);
        if (fabs(world->entity[0].x - world->entity[1].x) > 30)
            assert_false(mark->flags & LL_RENDERED_PREDICTED);
    }
    assert_true(near > 50 && far > 50);
    scene_close(&s);
}

/* Timeline error of what is drawn ahead: with constant pedals the prediction equals bitwise the truth to
 * come. */
static void the_predicted_world_equals_the_truth_to_come(void **state)
{
    (void)state;
    scene s = contact("all", "idle");
    for (int p = 0; p < 2; p++) {
        ll_summary timeline_error = summary(&s, p, LL_METRIC_TIMELINE_ERROR);
        assert_true(timeline_error.count > 50 &&
                    timeline_error.max < 1e-6); /* whole ns of time at 16 m/s: 2e-8 m */
    }
    scene_close(&s);
}

static void scope_may_change_while_it_runs(void **state)
{
    (void)state;
    scene s = scene_open("contact", NULL);
    for (int k = 0; k < 60; k++) {
        ll_netgame_config config = scene_config(s.game);
        config.players[0].prediction_scope = k % 3;
        config.players[1].prediction_scope = k / 3 % 3;
        s.scenario.kind->change(s.game, &config, s.game->now);
        scene_run(&s, 1 + k * 0.33, NULL);
        const ll_client *c = ll_netgame_client(s.game, 0);
        assert_int_equal(c->predicting, 1 + k % 3);
        assert_true(!(ll_client_draw_infos_const(c)[1].flags & LL_RENDERED_PREDICTED) || k % 3 != 0);
        assert_true((ll_client_draw_infos_const(c)[1].flags & LL_RENDERED_PREDICTED) || k % 3 != 2);
    }
    scene_close(&s);
}

/* The demo's server applies inputs outside of steps: there are no steps to predict others by. */
static void others_are_not_predicted_under_the_demos_rules(void **state)
{
    (void)state;
    scene s = scene_open("gambetta", NULL);
    ll_status status =
        ll_param_set(s.scenario.kind->table, s.scenario.config, "players.1.prediction_scope", "all", true);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "players.1.prediction_scope");
    assert_non_null(strstr(status.text, "must be own where server.sync is gambetta"));
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clean_link_needs_no_correction),
        cmocka_unit_test(contact_is_predicted_where_the_other_is_stepped_too),
        cmocka_unit_test(contact_is_mispredicted_when_the_other_changes_its_controls),
        cmocka_unit_test(a_skipped_replay_would_change_nothing),
        cmocka_unit_test(a_guess_follows_also_when_nothing_moves),
        cmocka_unit_test(only_entities_that_may_touch_are_predicted),
        cmocka_unit_test(the_predicted_world_equals_the_truth_to_come),
        cmocka_unit_test(scope_may_change_while_it_runs),
        cmocka_unit_test(others_are_not_predicted_under_the_demos_rules),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
