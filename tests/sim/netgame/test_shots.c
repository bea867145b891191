/* Shots in whole games: which shots that hit in the view count, by the server's policy; and at whose cost. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "support/near.h"
#include "support/scene.h"

static const ll_shot_stats *shot_stats(const scene *s, int player)
{
    return &ll_netgame_shots(s->game)->shot_stats[player];
}

static const ll_shot_tally *tally(const scene *s, int player, ll_weapon weapon)
{
    return &shot_stats(s, player)->tally[weapon];
}

static double agreement(const ll_shot_tally *t)
{
    return (double)t->agreed / (double)t->shots;
}

static int64_t refused(const scene *s, int player, ll_rule rule)
{
    return ll_netgame_server(s->game)->client_slots[player].counts.refused[rule];
}

/* ---- agreement ---- */

/* From 0 to 300 ms of lag: with rewind at least 99 of 100 shots count as seen, and without it far fewer. */
static void only_rewind_agrees_with_the_view(void **state)
{
    (void)state;
    for (int lag = 0; lag <= 300; lag += 50) {
        char set[64];
        snprintf(set, sizeof set, "players.0.lag_ms=%d", lag);
        const char *const with[] = {set, "server.max_rewind_ms=1000", NULL};
        const char *const without[] = {set, "server.hitscan=none", "server.max_rewind_ms=1000", NULL};
        scene a = scene_open("rifle", with), b = scene_open("rifle", without);
        scene_run(&a, 120, NULL);
        scene_run(&b, 120, NULL);
        const ll_shot_tally *rewound = tally(&a, 0, LL_HITSCAN), *judged = tally(&b, 0, LL_HITSCAN);
        assert_true(rewound->shots > 400 && rewound->hits[LL_JUDGE_VIEW] > 250);
        assert_true(rewound->hits[LL_JUDGE_VIEW] < 0.9 * (double)rewound->shots);
        assert_int_equal(rewound->within, rewound->shots);
        assert_true(agreement(rewound) >= 0.99);
        assert_true(agreement(judged) < (lag == 0 ? 0.8 : 0.65));
        assert_int_equal(judged->hits[LL_JUDGE_SERVER], judged->hits[LL_JUDGE_NOW]);
        scene_close(&a);
        scene_close(&b);
    }
}

/* Beyond max_rewind_ms the server rewinds to its limit, which is not far enough; below it, it agrees with the
 * view. */
static void rewinding_ends_at_its_limit(void **state)
{
    (void)state;
    for (int lag = 0; lag <= 300; lag += 50) {
        char set[64];
        snprintf(set, sizeof set, "players.0.lag_ms=%d", lag);
        const char *const sets[] = {set, "server.max_rewind_ms=250", NULL};
        scene s = scene_open("rifle", sets);
        scene_run(&s, 60, NULL);
        const ll_shot_tally *t = tally(&s, 0, LL_HITSCAN);
        double age = 2 * lag + 2000.0 / 30 + 10; /* the round trip, the interpolation delay, and some ticks */
        double most = ll_histogram_summary(&shot_stats(&s, 0)->rewind).max;
        assert_int_equal(t->clamped, age > 250 ? t->shots : 0);
        assert_int_equal(t->within + t->clamped, t->shots);
        assert_true((double)t->within_agreed >= 0.99 * (double)t->within);
        assert_true(t->clamped == 0 || agreement(t) < 0.9);
        assert_true(t->clamped > 0 ? fabs(most - 250) < 1e-9 : most < 250);
        scene_close(&s);
    }
}

/* Jitter and loss vary the view ages; the server still rewinds to what was drawn, and rejects no view
 * time. */
static void honest_shooters_on_bad_links_are_believed(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.link.up.jitter_ms=100",
                                "players.0.link.down.jitter_ms=100",
                                "players.0.link.up.loss_pct=2",
                                "players.0.link.down.loss_pct=2",
                                "players.1.link.up.jitter_ms=100",
                                "players.1.link.up.loss_pct=2",
                                "players.0.slack_ticks=4",
                                "server.max_rewind_ms=1000",
                                "params.weapons=both",
                                NULL};
    scene s = scene_open("rifle", sets);
    scene_run(&s, 120, NULL);
    for (int p = 0; p < 2; p++) {
        for (int rule = 1; rule < LL_RULES; rule++)
            assert_int_equal(refused(&s, p, (ll_rule)rule), 0);
        assert_true(tally(&s, p, LL_HITSCAN)->shots > 200);
        assert_int_equal(tally(&s, p, LL_HITSCAN)->view_time_rejected, 0);
    }
    assert_true(agreement(tally(&s, 1, LL_HITSCAN)) >= 0.99);
    scene_close(&s);
}

/* A client that predicts the others draws them where they will be when the shot arrives: no rewind is needed,
 * and no view without age is rejected. */
static void predicted_targets_need_no_rewinding(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.prediction_scope=all", "players.0.lag_ms=150", NULL};
    scene s = scene_open("rifle", sets);
    scene_run(&s, 60, NULL);
    const ll_shot_tally *t = tally(&s, 0, LL_HITSCAN);
    assert_true(t->shots > 200 && t->hits[LL_JUDGE_VIEW] > 100);
    assert_int_equal(t->view_time_rejected, 0);
    assert_int_equal(shot_stats(&s, 0)->rewind.count, 0);
    assert_true(agreement(t) >= 0.97); /* but of the other player, whose controls are guessed */
    scene_close(&s);
}

static double projectile_agreement(const char *id, const char *family, int64_t *hits)
{
    char set[64];
    snprintf(set, sizeof set, "server.projectile=%s", family);
    const char *const sets[] = {set, NULL};
    scene s = scene_open(id, sets);
    scene_run(&s, 120, NULL);
    const ll_shot_tally *t = tally(&s, 0, LL_PROJECTILE);
    double share = agreement(t);
    assert_true(t->shots > 100 && t->hits[LL_JUDGE_VIEW] > 50);
    assert_true(strcmp(family, "none") != 0 || t->hits[LL_JUDGE_SERVER] == t->hits[LL_JUDGE_NOW]);
    *hits = t->hits[LL_JUDGE_SERVER];
    scene_close(&s);
    return share;
}

/* With fast projectiles and 300 ms of round trip, only C (and client_authoritative) agrees with the view. */
static void only_rewound_projectiles_agree_with_the_view(void **state)
{
    (void)state;
    int64_t hits;
    assert_true(projectile_agreement("cannon_families", "rewind", &hits) >= 0.98);
    assert_true(projectile_agreement("cannon_families", "client_authoritative", &hits) >= 0.98);
    assert_true(projectile_agreement("cannon_families", "none", &hits) < 0.7);
    assert_true(projectile_agreement("cannon_families", "partial", &hits) < 0.8);
    assert_true(projectile_agreement("cannon_families", "fast_forward", &hits) < 0.8);
}

/* The error of the straight trace is that of its closed form for the fast-forwarded time. */
static void straight_traces_are_off_as_computed(void **state)
{
    (void)state;
    scene s = scene_open("cannon_straight", NULL);
    scene_run(&s, 60, NULL);
    ll_summary error = ll_histogram_summary(&shot_stats(&s, 0)->trace_error);
    ll_summary back = ll_histogram_summary(&shot_stats(&s, 0)->rewind);
    assert_true(error.count > 40);
    assert_near(error.max, 25 * back.max * back.max / 8e6, 1e-9);
    assert_true(agreement(tally(&s, 0, LL_PROJECTILE)) < 0.8);
    scene_close(&s);
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

typedef struct landing {
    ll_time start, end;
    ll_point at;
    int body;
} landing;

static const ll_weapon_state *arms_of(const scene *s, int player)
{
    return ll_netgame_game(s->game)->weapons->arms(ll_server_world(ll_netgame_server(s->game)), player);
}

/* The projectile that a player with `lag` fires on the snapshot of 4 s, which its client draws as it is. */
static landing fire_upon(const char *lag, double aim)
{
    const char *const sets[] = {lag,
                                "players.0.control=person",
                                "players.1.script=idle",
                                "players.0.interpolation=false",
                                "server.max_rewind_ms=1000",
                                "params.targets=16",
                                NULL};
    scene s = scene_open("cannon_shell", sets);
    const ll_client *c = ll_netgame_client(s.game, 0);
    int64_t k = 0;
    while (c->drawing.view_time < 4 * LL_SECOND)
        tick(&s, &k);
    assert_int_equal(c->drawing.view_time, 4 * LL_SECOND);
    act(&s, 0, 0, aim, LL_BUTTON_CANNON);
    tick(&s, &k);
    act(&s, 0, 0, aim, 0);
    while (k < 60 * 8)
        tick(&s, &k);
    const ll_projectile *projectile = &arms_of(&s, 0)->projectiles[1 % LL_PROJECTILES];
    assert_int_equal(arms_of(&s, 0)->shots[LL_PROJECTILE], 1);
    assert_int_equal(projectile->start, 4 * LL_SECOND);
    assert_true(projectile->end != LL_NEVER);
    ll_flight f = {projectile->from, projectile->velocity, 9.81, 0};
    landing l = {projectile->start, projectile->end,
                 ll_flight_at(&f, ll_to_s(projectile->end - projectile->start)), projectile->body};
    scene_close(&s);
    return l;
}

/* Family C: the impact is that of a run without lag, found in the past or in the present. */
static void a_rewound_projectile_lands_as_without_lag(void **state)
{
    (void)state;
    const char *const lags[] = {"players.0.lag_ms=40", "players.0.lag_ms=150", "players.0.lag_ms=400"};
    int hits = 0;
    for (int i = 0; i < 24; i++) {
        double aim = -0.05 + 0.012 * i;
        landing none = fire_upon("players.0.lag_ms=0", aim);
        hits += none.body != LL_NOBODY;
        for (int k = 0; k < 3; k++) {
            landing late = fire_upon(lags[k], aim);
            assert_int_equal(late.body, none.body);
            assert_near(late.at.x, none.at.x, 1e-9);
            assert_near(late.at.y, none.at.y, 1e-9);
        }
    }
    assert_true(hits >= 5 && hits < 24);
}

/* B moves down behind its wall. 0.6 s later it is hidden, on its own screen and at the server; A, far away,
 * still sees it over the wall and fires. */
static void shoot_at_where_it_was(scene *s)
{
    int64_t k = 0;
    while (k < 180)
        tick(s, &k);
    act(s, 1, -1, 0, 0);
    for (int i = 0; i < 36; i++)
        tick(s, &k);
    const ll_world *shown = ll_client_rendered(ll_netgame_client(s->game, 0));
    double up = shown->entity[1].y - shown->entity[0].y, forward = shown->entity[1].x - shown->entity[0].x;
    assert_true(shown->entity[1].y > 6);
    assert_true(ll_server_world(ll_netgame_server(s->game))->entity[1].y < 5.5);
    act(s, 0, 0, atan2(up, forward) / (M_PI / 2), LL_BUTTON_FIRE);
    tick(s, &k);
    act(s, 0, 0, 0, 0);
    for (int i = 0; i < 60; i++)
        tick(s, &k);
}

static void a_hit_on_a_hidden_player_is_shot_behind_cover(void **state)
{
    (void)state;
    for (int rewinds = 0; rewinds < 2; rewinds++) {
        const char *const sets[] = {rewinds ? "server.hitscan=rewind" : "server.hitscan=none",
                                    "players.0.control=person",
                                    "players.1.control=person",
                                    "players.0.lag_ms=200",
                                    "players.1.lag_ms=50",
                                    "server.max_rewind_ms=1000",
                                    NULL};
        scene s = scene_open("behind_cover", sets);
        shoot_at_where_it_was(&s);
        const ll_shot_tally *t = tally(&s, 0, LL_HITSCAN);
        assert_int_equal(t->shots, 1);
        assert_int_equal(t->hits[LL_JUDGE_VIEW], 1);
        assert_int_equal(t->hits[LL_JUDGE_NOW], 0);
        assert_int_equal(t->hits[LL_JUDGE_PERFECT], 0);
        assert_int_equal(t->hits[LL_JUDGE_SERVER], rewinds);
        assert_int_equal(t->kept, rewinds);
        assert_int_equal(t->false_misses, !rewinds);
        assert_int_equal(t->on_players, rewinds);
        assert_int_equal(t->behind_cover, rewinds);
        ll_summary rollback = ll_histogram_summary(&shot_stats(&s, 0)->rollback);
        ll_summary back = ll_histogram_summary(&shot_stats(&s, 0)->rewind);
        assert_int_equal(rollback.count, rewinds);
        assert_true(!rewinds || fabs(rollback.max - 5 * back.max / 1000) < 1e-6); /* it moved down at 5 m/s */
        scene_close(&s);
    }
}

/* A target that stands still is at the same place for all: all judges agree, for the hitscan weapon and the
 * projectile. */
static void judges_agree_on_standing_targets(void **state)
{
    (void)state;
    for (int w = 0; w < LL_WEAPONS; w++) {
        for (int hits = 0; hits < 2; hits++) {
            const char *const sets[] = {"players.0.control=person", "players.1.script=idle",
                                        "params.weapons=both", "server.max_rewind_ms=1000", NULL};
            scene s = scene_open("behind_cover", sets);
            int64_t k = 0;
            while (k < 180)
                tick(&s, &k);
            /* level for the hitscan weapon; for the projectile 35 m/s by sin 2 a = g x / v^2 */
            double aim = w == LL_HITSCAN ? 0 : asin(9.81 * 52 / (35 * 35)) / 2 / (M_PI / 2);
            act(&s, 0, 0, hits ? aim : aim + 0.05, UINT32_C(1) << w);
            tick(&s, &k);
            act(&s, 0, 0, 0, 0);
            for (int i = 0; i < 240; i++)
                tick(&s, &k);
            const ll_shot_tally *t = tally(&s, 0, (ll_weapon)w);
            assert_int_equal(t->shots, 1);
            for (int j = 0; j < LL_JUDGES; j++)
                assert_int_equal(t->hits[j], hits);
            assert_int_equal(t->agreed, 1);
            assert_int_equal(t->on_players, hits);
            assert_int_equal(t->behind_cover, 0);
            scene_close(&s);
        }
    }
}

/* The moving player sees first: by its own delay up, the other's delay down and view age, and some ticks. */
static void the_peeker_sees_first(void **state)
{
    (void)state;
    const double ups[] = {0, 40, 150}, downs[] = {0, 120, 60};
    for (int i = 0; i < 3; i++) {
        char up[64], down[64];
        snprintf(up, sizeof up, "players.0.lag_ms=%g", ups[i]);
        snprintf(down, sizeof down, "players.1.lag_ms=%g", downs[i]);
        const char *const sets[] = {up, down, NULL};
        scene s = scene_open("behind_cover", sets);
        scene_run(&s, 60, NULL);
        ll_summary peek = ll_shots_peeks(shot_stats(&s, 0));
        double ways = ups[i] + downs[i] + 2000.0 / 30 + 10;
        assert_true(peek.count >= 20);
        assert_true(peek.mean >= ways && peek.max <= ways + 5 * 1000.0 / 60);
        assert_int_equal(ll_shots_peeks(shot_stats(&s, 1)).count, 0);
        assert_true(tally(&s, 1, LL_HITSCAN)->behind_cover >= (i > 0 ? 5 : 0));
        scene_close(&s);
    }
}

/* The standing player sees first when the peeker waits for its own motion: the sign is kept. A naive median
 * and mean of the same list, which the two halves of the histogram must match. */
static void the_peeker_may_see_last(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.prediction=false", "players.0.lag_ms=170", "players.1.lag_ms=20",
                                "players.0.link.down.jitter_ms=60", NULL};
    scene s = scene_open("behind_cover", sets);
    scene_run(&s, 120, NULL);
    const ll_shot_stats *m = shot_stats(&s, 0);
    ll_summary peek = ll_shots_peeks(m);
    assert_true(peek.count >= 20 && m->peek[1].count >= 15);
    assert_true(peek.mean < -50 && peek.p50 < 0);
    assert_true(peek.p50 <= peek.p95 && peek.p95 <= peek.p99 && peek.p99 <= peek.max);
    assert_int_equal(peek.count, m->peek[0].count + m->peek[1].count);
    scene_close(&s);
}

static void a_summary_keeps_the_sign(void **state)
{
    (void)state;
    ll_shot_stats *m = calloc(1, sizeof *m);
    static const double values[] = {-7, -2, 0, 1, 3, 4, 8, 9, 11, 20}; /* whole tenths below 6.3 are exact */
    ll_histogram_init(&m->peek[0], 1);
    ll_histogram_init(&m->peek[1], 1);
    for (int i = 0; i < 10; i++)
        ll_histogram_add(&m->peek[values[i] < 0], fabs(values[i]));
    ll_summary s = ll_shots_peeks(m);
    assert_int_equal(s.count, 10);
    assert_near(s.mean, 4.7, 1e-12);
    assert_true(s.p50 == 3);
    assert_true(s.p95 == 20);
    assert_true(s.max == 20);
    assert_near(s.rms, sqrt(745 / 10.0), 1e-12);
    for (int i = 0; i < 9; i++)
        ll_histogram_add(&m->peek[1], 5);
    assert_true(ll_shots_peeks(m).p50 == -5); /* the tenth of 19: ten lie below -2 */
    free(m);
}

/* A player in permanent motion has no peeker's advantage over another, and no other over it. */
static void riders_do_not_peek(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.script=steady", "players.1.script=steady", NULL};
    scene s = scene_open("behind_cover", sets);
    scene_run(&s, 120, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    for (int p = 0; p < 2; p++) {
        const cJSON *shots =
            cJSON_GetObjectItem(cJSON_GetArrayItem(cJSON_GetObjectItem(m, "players"), p), "shots");
        const cJSON *peek = cJSON_GetObjectItem(shots, "peeker_advantage_ms");
        assert_true(cJSON_GetObjectItem(peek, "count")->valuedouble == 0);
        assert_true(cJSON_IsNull(cJSON_GetObjectItem(peek, "mean")));
        assert_true(cJSON_IsNull(cJSON_GetObjectItem(peek, "p95")));
    }
    cJSON_Delete(m);
    scene_close(&s);
}

/* ---- shots that do not count ---- */

/* Where nothing is rewound, no shot counts as within or beyond the rewind limit. */
static void limits_count_where_the_server_rewinds(void **state)
{
    (void)state;
    static const struct {
        const char *id, *policy;
        ll_weapon weapon;
        bool looks_back;
    } rows[] = {{"rifle", "server.hitscan=none", LL_HITSCAN, false},
                {"rifle", "server.hitscan=client_authoritative", LL_HITSCAN, false},
                {"rifle", "server.hitscan=rewind", LL_HITSCAN, true},
                {"cannon_families", "server.projectile=none", LL_PROJECTILE, false},
                {"cannon_families", "server.projectile=client_authoritative", LL_PROJECTILE, false},
                {"cannon_families", "server.projectile=fast_forward", LL_PROJECTILE, true},
                {"cannon_families", "server.projectile=partial", LL_PROJECTILE, true},
                {"cannon_families", "server.projectile=rewind", LL_PROJECTILE, true}};
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const char *const sets[] = {rows[i].policy, "server.max_rewind_ms=40", "players.0.lag_ms=90", NULL};
        scene s = scene_open(rows[i].id, sets);
        scene_run(&s, 40, NULL);
        const ll_shot_tally *t = tally(&s, 0, rows[i].weapon);
        cJSON *m = ll_netgame_metrics(s.game);
        const cJSON *o =
            cJSON_GetObjectItem(cJSON_GetArrayItem(cJSON_GetObjectItem(m, "players"), 0), "shots");
        o = cJSON_GetObjectItem(o, rows[i].weapon == LL_HITSCAN ? "hitscan" : "projectile");
        assert_true(t->shots > 10);
        assert_int_equal(t->clamped, rows[i].looks_back ? t->shots : 0);
        assert_int_equal(t->within, 0);
        assert_true(cJSON_IsNull(cJSON_GetObjectItem(o, "agreement_within_max_rewind")));
        assert_true(cJSON_IsNumber(cJSON_GetObjectItem(o, "agreement")));
        cJSON_Delete(m);
        scene_close(&s);
    }
}

static void nothing_shot_has_no_shares(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.script=idle", NULL};
    static const char *const shares[] = {"agreement", "agreement_within_max_rewind", "favour_the_shooter"};
    scene s = scene_open("rifle", sets);
    scene_run(&s, 5, NULL);
    cJSON *m = ll_netgame_metrics(s.game);
    const cJSON *o = cJSON_GetObjectItem(cJSON_GetArrayItem(cJSON_GetObjectItem(m, "players"), 0), "shots");
    for (int i = 0; i < 3; i++)
        assert_true(cJSON_IsNull(cJSON_GetObjectItem(cJSON_GetObjectItem(o, "hitscan"), shares[i])));
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(o, "hit_ratio")));
    cJSON_Delete(m);
    scene_close(&s);
}

/* ---- weapons and rules ---- */

static void weapons_fire_as_often_as_they_may(void **state)
{
    (void)state;
    const char *const sets[] = {"params.hitscan_interval_s=0.25", NULL};
    scene s = scene_open("rifle_no_rewind", sets);
    scene_run(&s, 60, NULL);
    for (int p = 0; p < 2; p++) {
        int32_t shots = arms_of(&s, p)->shots[LL_HITSCAN];
        assert_true(shots >= 234 && shots <= 240); /* four per second, whenever something is in sight */
        assert_int_equal(refused(&s, p, LL_RULE_FIRE_RATE), 0);
    }
    scene_close(&s);
}

static void pressing_faster_gains_nothing(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.cheat=fire_rate", NULL};
    scene honest = scene_open("rifle", NULL), s = scene_open("rifle", sets);
    scene_run(&honest, 60, NULL);
    scene_run(&s, 60, NULL);
    assert_true(refused(&s, 0, LL_RULE_FIRE_RATE) > 1000);
    assert_int_equal(arms_of(&s, 0)->shots[LL_HITSCAN], arms_of(&honest, 0)->shots[LL_HITSCAN]);
    scene_close(&honest);
    scene_close(&s);
}

/* Gain of a client that states an older view: hits beyond those in its true view. With the cross-check the
 * stated time does not count, without it the shots at the past do. */
static int64_t gain_of_faking(const char *tolerance, int64_t *view_time_rejected)
{
    const char *const sets[] = {tolerance, "players.0.cheat=view_time", "server.max_rewind_ms=1000", NULL};
    scene s = scene_open("rifle", sets);
    scene_run(&s, 120, NULL);
    const ll_shot_tally *t = tally(&s, 0, LL_HITSCAN);
    int64_t gain = t->hits[LL_JUDGE_SERVER] - t->hits[LL_JUDGE_VIEW];
    assert_true(t->shots > 400);
    assert_int_equal(refused(&s, 1, LL_RULE_REWIND), 0);
    assert_true(refused(&s, 0, LL_RULE_REWIND) >= t->view_time_rejected);
    *view_time_rejected = t->view_time_rejected;
    if (*view_time_rejected == 0)
        assert_true(t->false_hits > 150);
    scene_close(&s);
    return gain;
}

static void a_faked_view_gains_by_trust_only(void **state)
{
    (void)state;
    int64_t view_time_rejected;
    assert_true(gain_of_faking("server.rewind_tolerance_ms=200", &view_time_rejected) < 20);
    assert_true(view_time_rejected > 400);
    assert_true(gain_of_faking("server.rewind_tolerance_ms=10000", &view_time_rejected) > 80);
    assert_int_equal(view_time_rejected, 0);
}

static void a_claim_counts_only_if_client_authoritative(void **state)
{
    (void)state;
    const char *const sets[] = {"server.hitscan=rewind", "server.max_rewind_ms=1000", NULL};
    scene trusts = scene_open("rifle_trust", NULL), looks = scene_open("rifle_trust", sets);
    scene_run(&trusts, 60, NULL);
    scene_run(&looks, 60, NULL);
    const ll_shot_tally *lie = tally(&trusts, 0, LL_HITSCAN), *truth = tally(&looks, 0, LL_HITSCAN);
    assert_int_equal(lie->hits[LL_JUDGE_SERVER], lie->shots);
    assert_true(lie->behind_cover > 50);
    assert_true(agreement(truth) >= 0.99);
    assert_true(truth->hits[LL_JUDGE_SERVER] < truth->shots);
    scene_close(&trusts);
    scene_close(&looks);
}

/* ---- the block ---- */

static void prediction_is_exact_while_shots_fly(void **state)
{
    (void)state;
    const char *const scenes[] = {"rifle", "cannon_families", "behind_cover"};
    for (int i = 0; i < 3; i++) {
        scene s = scene_open(scenes[i], NULL);
        scene_run(&s, 60, NULL);
        for (int p = 0; p < 2; p++)
            assert_int_equal(ll_netgame_client_metrics(s.game, p)->corrections.count, 0);
        scene_close(&s);
    }
}

static void block_may_be_moved_and_runs_are_equal(void **state)
{
    (void)state;
    const char *const sets[] = {"params.weapons=both", "players.0.link.up.jitter_ms=30", NULL};
    scene s = scene_open("cannon_families", sets), t = scene_open("cannon_families", sets);
    for (int i = 1; i <= 60; i++) {
        scene_run(&s, i / 6.0, NULL);
        ll_netgame *elsewhere = malloc(ll_netgame_bytes(s.game));
        memcpy(elsewhere, s.game, ll_netgame_bytes(s.game));
        memset(s.game, 0xee, ll_netgame_bytes(s.game));
        free(s.game);
        s.game = elsewhere;
    }
    scene_run(&t, 10, NULL);
    assert_int_equal(s.scenario.kind->hash(s.game), t.scenario.kind->hash(t.game));
    scene_close(&s);
    scene_close(&t);
}

static void games_without_weapons_keep_no_shots(void **state)
{
    (void)state;
    scene s = scene_open("race", NULL);
    assert_null(ll_netgame_shots(s.game));
    assert_null(ll_netgame_weapon_prediction(s.game, 0));
    scene_close(&s);
}

/* The player holds the trigger while the game restarts in each other mode: what is fired starts in the view
 * that is drawn then. */
static void projectiles_start_in_the_view_of_their_tick(void **state)
{
    (void)state;
    const char *const sets[] = {"players.0.control=person", NULL};
    int modes = 0;
    for (int mode = 0; ll_syncs[mode]; mode++) {
        scene s = scene_open("cannon_families", sets);
        ll_netgame_config config = scene_config(s.game);
        const ll_weapon_prediction *weapons = ll_netgame_weapon_prediction(s.game, 0);
        const ll_client *c = ll_netgame_client(s.game, 0);
        int64_t k = 300, fired = 0;
        scene_run(&s, 5, NULL);
        act(&s, 0, 0, 0.2, LL_BUTTON_CANNON);
        if (ll_syncs[mode]->interpolate && config.server.sync != mode) {
            config.server.sync = mode;
            s.scenario.kind->change(s.game, &config, s.game->now);
            modes++;
        }
        while (k < 360) {
            ll_time before = c->drawing.view_time;
            tick(&s, &k);
            for (; fired < weapons->fired; fired++)
                assert_between("start", weapons->projectiles[(fired + 1) % LL_PROJECTILES].start, before,
                               c->drawing.view_time);
        }
        assert_true(fired > 0);
        scene_close(&s);
    }
    assert_true(modes >= 4);
}

/* ---- the page's shots and the metrics are the same ---- */

typedef struct shown {
    int tick, view, now, server, perfect, flags;
} shown;

typedef struct counted {
    shown last;
    int shots, view, now, server, perfect, agreed, false_hits, false_misses, clamped, rejected;
} counted;

static int field(const ll_rows *rows, int row, const char *name)
{
    for (int i = 0; i < rows->record->count; i++)
        if (strcmp(rows->record->fields[i].name, name) == 0)
            return (int)ll_field_value(&rows->record->fields[i], ll_rows_at(rows, row)[i]);
    fail_msg("a shot has no %s", name);
    return 0;
}

static void count_shot(counted *c)
{
    const shown *r = &c->last;
    if (r->tick < 0 || r->view < -1 || r->now < -1 || r->server < -1 || r->perfect < -1)
        return; /* not decided by all */
    c->shots++;
    c->view += r->view >= 0;
    c->now += r->now >= 0;
    c->server += r->server >= 0;
    c->perfect += r->perfect >= 0;
    c->agreed += r->server == r->view;
    c->false_hits += r->server >= 0 && r->server != r->view;
    c->false_misses += r->view >= 0 && r->server != r->view;
    c->clamped += r->flags >> 1 & 1;
    c->rejected += r->flags >> 2 & 1;
}

/* A player's last shot is in every frame: one of the rifle is complete when the next one comes. */
static void watch_shots(const scene *s, counted *of)
{
    ll_row_set set = {0};
    int place = ll_row_set_add(&set, &ll_netgame_shot_record, true);
    ll_row_set_add(&set, &ll_netgame_shot_body_record, false);
    ll_netgame_fill_shots(s->game, &set);
    const ll_rows *rows = set.rows[place];
    for (int i = 0; i < rows->count; i++) {
        counted *c = &of[field(rows, i, "player")];
        if (c->last.tick != field(rows, i, "tick"))
            count_shot(c);
        c->last = (shown){field(rows, i, "tick"),           field(rows, i, "client_view_hit"),
                          field(rows, i, "server_now_hit"), field(rows, i, "compensated_hit"),
                          field(rows, i, "perfect_hit"),    field(rows, i, "flags")};
    }
    ll_row_set_free(&set);
}

static void shots_that_are_drawn_are_those_counted(void **state)
{
    (void)state;
    const char *const sets[] = {"warmup_s=0", "players.0.lag_ms=140", "server.max_rewind_ms=250", NULL};
    scene s = scene_open("rifle", sets);
    counted of[2] = {{.last.tick = -1}, {.last.tick = -1}};
    for (int frame = 1; frame <= 60 * 60; frame++) {
        scene_run(&s, frame / 60.0, NULL);
        watch_shots(&s, of);
    }
    cJSON *metrics = ll_netgame_metrics(s.game);
    for (int i = 0; i < 2; i++) {
        const counted *c = &of[i];
        const struct {
            const char *name;
            int want;
        } rows[] = {{"shots", c->shots},
                    {"client_view_hits", c->view},
                    {"server_now_hits", c->now},
                    {"compensated_hits", c->server},
                    {"perfect_hits", c->perfect},
                    {"false_hits", c->false_hits},
                    {"false_misses", c->false_misses},
                    {"clamped", c->clamped},
                    {"view_time_rejected", c->rejected}};
        assert_true(c->shots > 10);
        assert_true(i > 0 || (c->view > 10 && c->view != c->now && c->server != c->perfect));
        for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
            char path[96];
            snprintf(path, sizeof path, "players.%d.shots.hitscan.%s", i, rows[k].name);
            const cJSON *item = ll_param_number_at(metrics, path);
            /* The last shot may be counted, and is not yet followed by another. */
            if (!item || !(item->valuedouble - rows[k].want >= 0 && item->valuedouble - rows[k].want <= 1))
                fail_msg("%s is %g, and %d are drawn", path, item ? item->valuedouble : NAN, rows[k].want);
        }
    }
    cJSON_Delete(metrics);
    scene_close(&s);
}

/* A server that only applies inputs on arrival would leave targets and projectiles where they are. */
static void draining_is_refused_with_a_sentence(void **state)
{
    (void)state;
    scene s = scene_open("rifle", NULL);
    ll_netgame_config config = scene_config(s.game);
    ll_status status = ll_param_set(s.scenario.kind->table, &config, "server.sync", "gambetta", true);
    assert_int_equal(status.code, LL_BAD_INPUT);
    assert_string_equal(status.field, "server.sync");
    assert_non_null(strstr(status.text, "shooter"));
    scene_close(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(only_rewind_agrees_with_the_view),
        cmocka_unit_test(rewinding_ends_at_its_limit),
        cmocka_unit_test(honest_shooters_on_bad_links_are_believed),
        cmocka_unit_test(predicted_targets_need_no_rewinding),
        cmocka_unit_test(only_rewound_projectiles_agree_with_the_view),
        cmocka_unit_test(straight_traces_are_off_as_computed),
        cmocka_unit_test(a_rewound_projectile_lands_as_without_lag),
        cmocka_unit_test(a_hit_on_a_hidden_player_is_shot_behind_cover),
        cmocka_unit_test(judges_agree_on_standing_targets),
        cmocka_unit_test(the_peeker_sees_first),
        cmocka_unit_test(the_peeker_may_see_last),
        cmocka_unit_test(a_summary_keeps_the_sign),
        cmocka_unit_test(riders_do_not_peek),
        cmocka_unit_test(limits_count_where_the_server_rewinds),
        cmocka_unit_test(nothing_shot_has_no_shares),
        cmocka_unit_test(weapons_fire_as_often_as_they_may),
        cmocka_unit_test(pressing_faster_gains_nothing),
        cmocka_unit_test(a_faked_view_gains_by_trust_only),
        cmocka_unit_test(a_claim_counts_only_if_client_authoritative),
        cmocka_unit_test(prediction_is_exact_while_shots_fly),
        cmocka_unit_test(block_may_be_moved_and_runs_are_equal),
        cmocka_unit_test(projectiles_start_in_the_view_of_their_tick),
        cmocka_unit_test(games_without_weapons_keep_no_shots),
        cmocka_unit_test(draining_is_refused_with_a_sentence),
        cmocka_unit_test(shots_that_are_drawn_are_those_counted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
