/* Players who report the state of their entity, next to players who send controls: the same game without
 * contact and loss; what differs with them; and that the server bounds what a false report gains. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "base/hash.h"
#include "base/rng.h"
#include "netcode/server/reports.h"
#include "support/near.h"
#include "support/netgame_valid.h"
#include "support/scene.h"

typedef struct setting {
    const char *game, *authority, *up;
    ll_cheat cheat; /* of player 0, from 2 s on */
    double lag_ms, allowance_m;
    int seed, lane; /* of B */
    bool trusting;  /* the server does not validate */
} setting;

static scene open_scene(const setting *c)
{
    char text[2000], params[64] = "";
    if (strcmp(c->game, "race") == 0)
        snprintf(params, sizeof params, "\"params\":{\"laps\":1000},");
    if (strcmp(c->game, "swarm") == 0)
        snprintf(params, sizeof params, "\"params\":{\"bodies\":5},");
    snprintf(
        text, sizeof text,
        "{\"kind\":\"netgame\",\"game\":\"%s\",%s\"duration_s\":60,\"seed\":%d,\"warmup_s\":1,"
        "\"reports\":{\"allowance_m\":%.17g},\"server\":{\"update_hz\":30,\"validation\":%s},"
        "\"players\":[{\"authority\":\"%s\",\"lag_ms\":%g,\"script\":\"varied\","
        "\"redundancy\":0,\"lane\":0,\"link\":{\"up\":{%s}},\"prediction\":true,"
        "\"reconciliation\":true},"
        "{\"lag_ms\":%g,\"lane\":%d,\"script\":\"steady\",\"prediction\":true,\"reconciliation\":true}]}",
        c->game, params, c->seed, c->allowance_m, c->trusting ? "false" : "true", c->authority, c->lag_ms,
        c->up ? c->up : "", c->lag_ms, c->lane);
    return scene_make(text, NULL);
}

static const ll_report_slot *slot_of(const scene *s, int player)
{
    return &ll_netgame_reports(s->game)->slot[player];
}

typedef struct outcome {
    uint64_t worlds;     /* hash of all worlds of the server */
    uint64_t own, other; /* hashes of the players' entities in them, along the lane */
    double error_max;    /* of the own view of player 0 */
    double gap_min;      /* between both entities on the server */
    int64_t corrections; /* of player 0 */
    int64_t accepted, refused, missing, messages, bytes, steps;
    double gain, way;
    int64_t false_refusals;
} outcome;

typedef struct watch {
    scene *s;
    outcome o;
} watch;

static void on_step(void *context, const void *row)
{
    const ll_event *e = row;
    watch *w = context;
    if (e->type != LL_EVENT_STEP)
        return;
    const ll_world *world = ll_server_world(ll_netgame_server(w->s->game));
    const ll_entity *a = &world->entity[0], *b = &world->entity[1];
    const double gap = hypot(a->x - b->x, a->y - b->y);
    w->o.worlds = ll_hash(w->o.worlds, world, ll_world_size(world));
    w->o.own = ll_hash(w->o.own, &(double[]){a->x, a->vx}, 2 * sizeof(double));
    w->o.other = ll_hash(w->o.other, &(double[]){b->x, b->vx}, 2 * sizeof(double));
    w->o.gap_min = smaller(w->o.gap_min, gap);
    w->o.steps++;
}

static outcome run_for(const setting *c, double seconds)
{
    scene s = open_scene(c);
    watch w = {.s = &s, .o.gap_min = INFINITY};
    ll_recorder recorder = {.record = on_step, .context = &w};
    if (c->cheat) {
        ll_netgame_config config = scene_config(s.game);
        scene_run(&s, 2, &recorder);
        config.players[0].cheat = c->cheat;
        s.scenario.kind->change(s.game, &config, s.game->now);
        w.o.missing = ll_netgame_reports(s.game) ? slot_of(&s, 0)->missing : 0;
    }
    scene_run(&s, seconds, &recorder);
    const ll_client_metrics *in = ll_netgame_client_metrics(s.game, 0);
    w.o.error_max = ll_histogram_summary(&in->histogram[LL_METRIC_OWN_TIMELINE_ERROR]).max;
    w.o.corrections = in->corrections.count;
    w.o.messages = in->traffic.messages[LL_MESSAGE_INPUT];
    w.o.bytes = in->traffic.bytes[LL_MESSAGE_INPUT];
    w.o.gain = in->gain.most;
    w.o.way = ll_server_world(ll_netgame_server(s.game))->entity[0].x;
    w.o.false_refusals = in->false_refusals + ll_netgame_client_metrics(s.game, 1)->false_refusals;
    if (ll_netgame_reports(s.game)) {
        w.o.accepted = slot_of(&s, 0)->accepted;
        w.o.refused = slot_of(&s, 0)->refused;
        w.o.missing = slot_of(&s, 0)->missing - w.o.missing;
    }
    assert_null(netgame_broken(s.game));
    scene_close(&s);
    return w.o;
}

static const char *const games[] = {"race", "gambetta", "swarm"};

/* ---- honest players ---- */

/* Without contact and loss an honest report says what the server computes anyway: the server's worlds are
 * equal, bit by bit, and a message up is longer by a state. The own view has no error at any lag. */
static void honest_reports_change_nothing_but_the_bytes(void **state)
{
    (void)state;
    static const double lags_ms[] = {0, 100, 400};
    for (int k = 0; k < 3; k++)
        for (int j = 0; j < 3; j++) {
            setting c = {
                .game = games[k], .authority = "controls", .lag_ms = lags_ms[j], .seed = 1, .lane = 1};
            const outcome controls = run_for(&c, 20);
            c.authority = "position";
            const outcome reports = run_for(&c, 20);
            assert_true(controls.worlds == reports.worlds && controls.steps == reports.steps);
            assert_true(reports.error_max == 0 && controls.error_max == 0);
            assert_int_equal(reports.corrections, 0);
            assert_int_equal(reports.refused, 0);
            assert_int_equal(controls.messages, reports.messages);
            assert_true(reports.bytes == controls.bytes + reports.messages * (int64_t)sizeof(ll_motion));
            assert_true(reports.accepted > reports.steps * 9 / 10);
        }
}

/* What is lost corrects a player who sends controls; a later report makes up for it. None is refused:
 * what an entity may do in the time without reports counts. */
static void losses_correct_only_who_sends_controls(void **state)
{
    (void)state;
    static const char *const links[] = {"\"loss_pct\":20",
                                        "\"blackout_every_ms\":1300,\"blackout_length_ms\":150"};
    for (int seed = 1; seed <= 3; seed++)
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 2; j++) {
                setting c = {
                    .game = games[k], .authority = "controls", .lag_ms = 60, .seed = seed, .lane = 1};
                c.up = links[j];
                const outcome controls = run_for(&c, 20);
                c.authority = "position";
                const outcome reports = run_for(&c, 20);
                assert_true(controls.corrections > 3);
                assert_int_equal(reports.corrections, 0);
                assert_int_equal(reports.refused, 0);
                assert_int_equal(reports.false_refusals, 0);
                assert_true(reports.missing > 20 && reports.accepted > 100);
            }
}

/* Two cars in one lane. By controls the server keeps them apart and corrects the client, which did not know
 * of the contact. A reported car drives as if it were alone, bit by bit, and only the other is pushed. */
static void collisions_disagree(void **state)
{
    (void)state;
    setting c = {.game = "race", .authority = "controls", .lag_ms = 80, .seed = 1};
    const outcome controls = run_for(&c, 40);
    c.authority = "position";
    const outcome reports = run_for(&c, 40);
    c.lane = 1;
    const outcome alone = run_for(&c, 40);
    assert_true(controls.corrections > 10 && controls.own != alone.own);
    assert_true(controls.gap_min >= 4 - 1e-9); /* car_length_m */
    assert_int_equal(reports.corrections, 0);
    assert_int_equal(reports.refused, 0);
    assert_true(reports.error_max == 0 && reports.own == alone.own);
    assert_true(reports.other != alone.other && reports.gap_min < 4 - 1e-3);
}

/* A client that timed out and joins again starts from the server's state, and reports on. */
static void reports_go_on_after_an_outage(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        setting c = {.game = games[k],
                     .authority = "position",
                     .lag_ms = 60,
                     .seed = 1,
                     .lane = 1,
                     .up = "\"blackout_at_ms\":5000,\"blackout_length_ms\":9000"};
        scene s = open_scene(&c);
        scene_run(&s, 17, NULL);
        assert_int_equal(ll_netgame_server(s.game)->client_slots[0].connection.drops, 1);
        const int64_t before = slot_of(&s, 0)->accepted,
                      corrections = ll_netgame_client_metrics(s.game, 0)->corrections.count;
        scene_run(&s, 27, NULL);
        assert_true(slot_of(&s, 0)->accepted >= before + 590);
        assert_int_equal(slot_of(&s, 0)->refused, 0);
        assert_int_equal(ll_netgame_client_metrics(s.game, 0)->corrections.count, corrections);
        scene_close(&s);
    }
}

/* ---- cheats ---- */

/* The gain is at most the allowance, over seeds, games, lags and cheats; without validation it is far more,
 * and with controls nothing. */
static void a_false_position_gains_the_allowance_at_most(void **state)
{
    (void)state;
    static const ll_cheat cheats[] = {LL_CHEAT_SPEED, LL_CHEAT_LEAP};
    static const double allowances_m[] = {0, 0.2, 1};
    for (int seed = 1; seed <= 6; seed++)
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 2; j++) {
                setting c = {.game = games[k],
                             .authority = "position",
                             .lag_ms = 20.0 * seed,
                             .seed = seed,
                             .lane = 1,
                             .cheat = cheats[j],
                             .allowance_m = allowances_m[seed % 3]};
                const outcome bounded = run_for(&c, 20);
                assert_true(bounded.gain <= c.allowance_m + 1e-6);
                assert_true(bounded.refused > 3 && bounded.corrections > 3);
                assert_int_equal(bounded.missing, 0); /* what has to catch up may jump */
                c.trusting = true;
                const outcome trusted = run_for(&c, 20);
                assert_true(trusted.gain > c.allowance_m + 1);
                assert_int_equal(trusted.refused, 0);
                c.trusting = false;
                c.authority = "controls";
                const outcome controls = run_for(&c, 20);
                assert_true(controls.gain <= 1e-6 && controls.corrections > 3);
            }
}

/* ---- the rule by itself ---- */

/* A server with the world of a race, in step `step`, that has taken a report for it. */
typedef struct bench {
    scene s;
    ll_server *server;
    ll_reports *reports;
    const ll_game *game;
} bench;

static bench make_bench(double allowance_m)
{
    const setting c = {
        .game = "race", .authority = "position", .seed = 1, .lane = 1, .allowance_m = allowance_m};
    bench b = {.s = open_scene(&c)};
    b.server = ll_netgame_server(b.s.game);
    b.reports = ll_netgame_reports(b.s.game);
    b.game = ll_netgame_game(b.s.game);
    b.server->client_slots[0].connection.connected = 1;
    b.reports->slot[0].epoch = b.server->client_slots[0].connection.epoch;
    return b;
}

/* From `from`, `steps` steps before; true: accepted. */
static bool judge(bench *b, const ll_entity *from, int64_t steps, const ll_entity *to)
{
    ll_server *server = b->server;
    const int64_t tick = server->step + steps;
    ll_input_slot *input = &server->client_slots[0].inputs.ring[tick & (LL_INPUT_RING - 1)];
    ll_report_slot *slot = &b->reports->slot[0];
    ll_input_message m = {.head = {LL_MESSAGE_INPUT, 1, slot->epoch, (uint32_t)tick},
                          .tick = (int32_t)tick,
                          .wants = LL_PART_STATE};
    char packet[sizeof m + sizeof(ll_motion)];
    const ll_motion state = ll_motion_of(to);
    memcpy(packet, &m, (size_t)ll_input_message_size(1));
    memcpy(packet + ll_input_message_size(1), &state, sizeof state);
    slot->anchor = *from;
    slot->anchor_step = server->step;
    *input = (ll_input_slot){.tick = tick, .seq = (uint32_t)tick};
    ll_reports_take(b->reports, server, 0, packet);
    server->step = tick;
    server->client_slots[0].inputs.newest = tick;
    ll_server_world(server)->entity[0] = *from;
    bool accepted = ll_reports_apply(b->reports, server, b->game, &b->s.game->env) == 0;
    assert_true(!accepted || fabs(ll_server_world(server)->entity[0].x - to->x) < 1e-12 || to->x != to->x);
    return accepted;
}

/* A car at speed v: after t at most at v e + a f, with drag c: x + v f + a g (the closed form of the game).
 */
static ll_entity fastest(const ll_entity *from, double t)
{
    const double a = 6, c = 0.3, e = exp(-c * t), f = (1 - e) / c, g = (t - f) / c;
    ll_entity to = *from;
    to.x += from->vx * f + a * g;
    to.vx = from->vx * e + a * f;
    return to;
}

/* Just within and just beyond the closed form, for one step and many, from rest and in motion. */
static void the_bound_is_what_the_game_permits(void **state)
{
    (void)state;
    static const double speeds[] = {0, 3, 9};
    static const int steps[] = {1, 2, 30};
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            const ll_entity from = {.x = 50, .y = 0, .vx = speeds[i]};
            const ll_entity most = fastest(&from, steps[k] / 60.0);
            for (int way = 0; way < 5; way++) {
                bench b = make_bench(0);
                ll_entity to = most;
                to.x += way == 0 ? -1e-6 : way == 1 ? 1e-6 : -1e-6;
                to.vx += way == 2 ? 1e-6 : -1e-6;
                to.y += way == 3 ? 1e-6 : 0;
                to.angle += way == 4 ? 1e-6 : 0;
                assert_int_equal(judge(&b, &from, steps[k], &to), way == 0);
                assert_int_equal(b.reports->slot[0].refused, way != 0);
                assert_true((b.reports->slot[0].refused_seq != 0) == (way != 0));
                scene_close(&b.s);
            }
        }
}

/* Each report uses up what it is too far by, in any direction; the sum of all is at most the allowance. */
static void the_allowance_is_used_once(void **state)
{
    (void)state;
    bench b = make_bench(1);
    ll_entity at = {.x = 50, .vx = 5};
    double gained = 0;
    for (int i = 0; i < 40; i++) {
        ll_entity to = fastest(&at, 1 / 60.0);
        const double excess = 0.3 * ll_rng_unit(5, 1, (uint64_t)i);
        to.x += i % 2 ? excess * 0.6 : 0;
        to.y += i % 2 ? excess * 0.8 : excess;
        to.vx = 5;
        const bool expected = gained + excess <= 1;
        assert_int_equal(judge(&b, &at, 1, &to), expected);
        gained += expected ? excess : 0;
        assert_near(b.reports->slot[0].used_m, gained, 1e-9);
        at = expected ? to : at;
        at.y = 0;
    }
    assert_true(gained > 0.7 && b.reports->slot[0].refused > 20);
    scene_close(&b.s);
}

static void what_is_no_number_is_refused(void **state)
{
    (void)state;
    static const double values[] = {NAN, INFINITY, -INFINITY};
    for (int trusting = 0; trusting < 2; trusting++)
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 4; k++) {
                bench b = make_bench(100);
                ll_entity from = {.x = 5}, to = from;
                *(k == 0 ? &to.x : k == 1 ? &to.y : k == 2 ? &to.vx : &to.angle) = values[i];
                b.server->rules.validates = !trusting;
                assert_false(judge(&b, &from, 1, &to));
                scene_close(&b.s);
            }
}

/* ---- where it cannot be chosen ---- */

static void refuse(const char *path, const char *const *sets)
{
    cJSON *json = cJSON_Parse("{\"kind\":\"netgame\",\"game\":\"race\",\"players\":[{},{\"prediction\":true,"
                              "\"reconciliation\":true}]}");
    ll_scenario scenario = {0};
    int count = 0;
    ll_status status = ll_scenario_parse(json, &scenario);
    assert_false(ll_failed(&status));
    while (sets[count])
        count++;
    status = ll_param_put(scenario.kind->table, scenario.config, sets, count);
    assert_false(ll_failed(&status));
    status = ll_param_check(scenario.kind->table, scenario.config);
    assert_true(ll_failed(&status));
    assert_string_equal(status.field, path);
    assert_non_null(strstr(status.text, path));
    ll_scenario_free(&scenario);
    cJSON_Delete(json);
}

static void it_is_refused_where_it_does_not_fit(void **state)
{
    (void)state;
    static const char *const sets[][3] = {{"game=crates"},
                                          {"game=shooter"},
                                          {"game=cannon"},
                                          {"server.sync=lockstep"},
                                          {"server.sync=bucket"},
                                          {"players.1.reconciliation=false", "players.1.prediction=false"},
                                          {"players.1.reconciliation=false"},
                                          {"players.1.prediction_scope=contacts"},
                                          {"players.1.input_delay_ticks=2"}};
    for (size_t i = 0; i < sizeof sets / sizeof sets[0]; i++) {
        const char *const all[] = {"players.1.authority=position", sets[i][0], sets[i][1], NULL};
        refuse("players.1.authority", all);
    }
}

/* A player who sends controls has none of it, next to one who reports too. */
static void others_have_none_of_it(void **state)
{
    (void)state;
    setting c = {.game = "race", .authority = "controls", .seed = 1, .lane = 1};
    scene without = open_scene(&c);
    assert_null(ll_netgame_reports(without.game));
    c.authority = "position";
    scene with = open_scene(&c);
    scene_run(&with, 5, NULL);
    assert_true(slot_of(&with, 0)->accepted > 200);
    assert_int_equal(slot_of(&with, 1)->accepted + slot_of(&with, 1)->missing, 0);
    scene_close(&without);
    scene_close(&with);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(honest_reports_change_nothing_but_the_bytes),
        cmocka_unit_test(losses_correct_only_who_sends_controls),
        cmocka_unit_test(collisions_disagree),
        cmocka_unit_test(reports_go_on_after_an_outage),
        cmocka_unit_test(a_false_position_gains_the_allowance_at_most),
        cmocka_unit_test(the_bound_is_what_the_game_permits),
        cmocka_unit_test(the_allowance_is_used_once),
        cmocka_unit_test(what_is_no_number_is_refused),
        cmocka_unit_test(it_is_refused_where_it_does_not_fit),
        cmocka_unit_test(others_have_none_of_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
