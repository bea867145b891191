/* Reports of shots: shot statistics, and the last shots and the projectiles in flight, streamed. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "sim/netgame/netgame.h"

#define TALLY(X)                                                                                             \
    X(count, shots, NULL, t->shots,                                                                          \
      "shots with all four results: in the shooter's view, in the server's present, by the server's policy " \
      "and in the ground truth",                                                                             \
      NULL)                                                                                                  \
    X(count, lost, NULL, t->lost,                                                                            \
      "shots without a result: the input came late or not at all, or the weapon was not ready", NULL)        \
    X(count, client_view_hits, NULL, t->hits[LL_JUDGE_VIEW],                                                 \
      "shots that hit in the view of the shooter's client, as pressed", NULL)                                \
    X(count, server_now_hits, NULL, t->hits[LL_JUDGE_NOW],                                                   \
      "shots that would hit in the server's present, without lag compensation", NULL)                        \
    X(count, compensated_hits, NULL, t->hits[LL_JUDGE_SERVER],                                               \
      "shots that hit by the server's policy: the result that counts", NULL)                                 \
    X(count, perfect_hits, NULL, t->hits[LL_JUDGE_PERFECT],                                                  \
      "shots that would hit in the ground truth at the moment of the press, as pressed", NULL)               \
    X(number, agreement, NULL, share(t->agreed, t->shots),                                                   \
      "share of shots for which the server's policy and the shooter's view name the same body, or both "     \
      "none",                                                                                                \
      "No shot was judged.")                                                                                 \
    X(count, shots_within_max_rewind, NULL, t->within,                                                       \
      "shots for which the server rewound as far as the shooter's view was old", NULL)                       \
    X(number, agreement_within_max_rewind, NULL, share(t->within_agreed, t->within),                         \
      "share of shots for which the server's policy and the shooter's view name the same body, or both "     \
      "none, among those rewound as far as the view was old",                                                \
      "No shot was rewound as far as the view was old.")                                                     \
    X(events, false_hits, NULL, t->false_hits,                                                               \
      "shots that hit a body by the server's policy, but not this body in the shooter's view", NULL)         \
    X(events, false_misses, NULL, t->false_misses,                                                           \
      "shots that hit a body in the shooter's view, but not this body by the server's policy", NULL)         \
    X(number, favour_the_shooter, NULL, share(t->kept, t->hits[LL_JUDGE_VIEW]),                              \
      "share of hits in the shooter's view that the server counted", "No shot hit in the shooter's view.")   \
    X(events, hits_on_players, NULL, t->on_players, "hits on players that the server counted", NULL)         \
    X(events, shot_behind_cover, NULL, t->behind_cover,                                                      \
      "hits of hitscan shots that the server counted while the line to the shooter was blocked in the "      \
      "victim's own view",                                                                                   \
      NULL)                                                                                                  \
    X(events, clamped, NULL, t->clamped,                                                                     \
      "shots that max_rewind_ms or the policy hybrid rewound less far than the view was old", NULL)          \
    X(events, view_time_rejected, NULL, t->view_time_rejected,                                               \
      "shots whose reported view age the server did not believe", NULL)

#define SHOTS(X)                                                                                             \
    X(number, hit_ratio, NULL, share(hits, shots), "share of all shots that counted as hits",                \
      "No shot was judged.")                                                                                 \
    X(distribution, rollback_distance_m, "m", ll_netgame_distribution(ll_histogram_summary(&m->rollback)),   \
      "distance of the body that was hit from where it was judged (rewound) to where it is in the server's " \
      "present",                                                                                             \
      "No shot hit.")                                                                                        \
    X(distribution, rewind_ms, "ms", ll_netgame_distribution(ll_histogram_summary(&m->rewind)),              \
      "time that the server rewound from its present to judge a shot", "No shot was judged.")                \
    X(distribution, behind_cover_ms, "ms", ll_netgame_distribution(ll_histogram_summary(&cover->shown)),     \
      "time since the line to the shooter closed in the victim's own view, when its client first showed "    \
      "the hit of a hitscan shot",                                                                           \
      "No hit was shown to a victim behind cover.")                                                          \
    X(events, vetoed, NULL, cover->vetoed, "hits that the policy victim_veto did not count", NULL)           \
    X(distribution, trace_error_m, "m", ll_netgame_distribution(ll_histogram_summary(&m->trace_error)),      \
      "largest distance of the traced past part of a projectile's flight from the flight itself",            \
      "No projectile was traced.")

#define NEGLECT(X)                                                                                           \
    X(count, traced, NULL, n->traced,                                                                        \
      "projectiles of whose flight a part was past when the server received the shot, and that the server "  \
      "compensated",                                                                                         \
      NULL)                                                                                                  \
    X(events, differing, NULL, n->differing,                                                                 \
      "of them, those whose past part hits another body, or none, if drag is neglected", NULL)               \
    X(events, false_hits, NULL, n->false_hits,                                                               \
      "of them, those whose past part hits a body only if drag is neglected", NULL)                          \
    X(events, false_misses, NULL, n->false_misses,                                                           \
      "of them, those whose past part hits a body that it does not hit if drag is neglected", NULL)          \
    X(distribution, past_m, "m", ll_netgame_distribution(ll_histogram_summary(&n->past)),                    \
      "distance between the flight without drag and the flight itself, at the end of the past part",         \
      "No part of a flight was past.")                                                                       \
    X(distribution, end_m, "m", ll_netgame_distribution(ll_histogram_summary(&n->end)),                      \
      "distance between the flight without drag and the flight itself, at the end of the flight",            \
      "No projectile has ended.")

#define PEEKS(X)                                                                                             \
    X(number, mean, "ms", s.count > 0 ? s.mean : NAN, "mean of the peeker's advantage",                      \
      "No player that moves came in sight of one that had stood for a second, as with scripts that never "   \
      "stand.")                                                                                              \
    X(number, rms, "ms", s.count > 0 ? s.rms : NAN, "root mean square of the peeker's advantage",            \
      "No player that moves came in sight of one that had stood for a second, as with scripts that never "   \
      "stand.")                                                                                              \
    X(number, p50, "ms", s.count > 0 ? s.p50 : NAN, "median of the peeker's advantage",                      \
      "No player that moves came in sight of one that had stood for a second, as with scripts that never "   \
      "stand.")                                                                                              \
    X(number, p95, "ms", s.count > 0 ? s.p95 : NAN, "95th percentile of the peeker's advantage",             \
      "No player that moves came in sight of one that had stood for a second, as with scripts that never "   \
      "stand.")                                                                                              \
    X(number, p99, "ms", s.count > 0 ? s.p99 : NAN, "99th percentile of the peeker's advantage",             \
      "No player that moves came in sight of one that had stood for a second, as with scripts that never "   \
      "stand.")                                                                                              \
    X(number, max, "ms", s.count > 0 ? s.max : NAN, "largest peeker's advantage",                            \
      "No player that moves came in sight of one that had stood for a second, as with scripts that never "   \
      "stand.")                                                                                              \
    X(count, count, NULL, s.count, "pairs of players that the peeker's advantage was measured of", NULL)     \
    X(events, seen_second, NULL, m->peek[1].count,                                                           \
      "pairs in which the standing player saw the moving player first", NULL)

const ll_metric_table ll_netgame_tally_table = {
    LL_OF_PLAYERS(".shots.hitscan"), .when = "Only in games with weapons.",
    .help = "Hitscan shots (of the rifle).", LL_METRICS_FROM(TALLY)};

const ll_metric_table ll_netgame_projectile_table = {LL_OF_PLAYERS(".shots.projectile"),
                                                     .when = "Only in games with weapons.",
                                                     .help = "Projectiles (shells).", LL_METRICS_FROM(TALLY)};

const ll_metric_table ll_netgame_shot_table = {LL_OF_PLAYERS(".shots"), .when = "Only in games with weapons.",
                                               .help = "Shots of both weapons.", LL_METRICS_FROM(SHOTS)};

const ll_metric_table ll_netgame_neglect_table = {
    LL_OF_PLAYERS(".shots.drag_neglected"), .when = "Only in games with weapons whose projectiles have drag.",
    .help = "What it costs to neglect drag, whether or not the server does: each projectile is compared with "
            "one of the same launch without drag.",
    LL_METRICS_FROM(NEGLECT)};

const ll_metric_table ll_netgame_peek_table = {
    LL_OF_PLAYERS(".shots.peeker_advantage_ms"), .when = "Only in games with weapons.",
    .help = "Peeker's advantage, counted for the moving player. It concerns two players between whom the "
            "line of sight opens while one moves and the other has stood for a second: time at which the "
            "standing player's client draws the line open less the time at which the moving player's does; "
            "negative: the standing player saw first.",
    LL_METRICS_FROM(PEEKS)};

/* null where nothing was counted: unknown, not zero */
static double share(int64_t part, int64_t whole)
{
    return ll_netgame_ratio((double)part, (double)whole);
}

static void tally(cJSON *o, const ll_metric_table *table, const ll_shot_tally *t)
{
    LL_METRICS_PUT(o, table, TALLY);
}

void ll_netgame_shots_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    if (!ll_netgame_shots(g))
        return;
    const ll_shot_stats *m = &ll_netgame_shots(g)->shot_stats[player];
    const ll_behind_cover_player *cover = &ll_netgame_behind_cover(g)->player[player];
    ll_summary s = ll_shots_peeks(m);
    cJSON *o = cJSON_AddObjectToObject(metrics, "shots");
    tally(cJSON_AddObjectToObject(o, "hitscan"), &ll_netgame_tally_table, &m->tally[LL_HITSCAN]);
    tally(cJSON_AddObjectToObject(o, "projectile"), &ll_netgame_projectile_table, &m->tally[LL_PROJECTILE]);
    int64_t shots = 0, hits = 0;
    for (int w = 0; w < LL_WEAPONS; w++) {
        shots += m->tally[w].shots;
        hits += m->tally[w].hits[LL_JUDGE_SERVER];
    }
    LL_METRICS_PUT(o, &ll_netgame_shot_table, SHOTS);
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "peeker_advantage_ms"), &ll_netgame_peek_table, PEEKS);
    if (!ll_netgame_drag_neglect(g))
        return;
    const ll_drag_neglect_player *n = &ll_netgame_drag_neglect(g)->player[player];
    LL_METRICS_PUT(cJSON_AddObjectToObject(o, "drag_neglected"), &ll_netgame_neglect_table, NEGLECT);
}

/* ---- the last shots ---- */

enum { NOBODY_YET = -2 };

#define SHOWN (5 * LL_SECOND) /* older shots are not streamed: the history keeps them only for a time */

typedef struct shot {
    uint8_t player, weapon, flags;
    uint32_t tick;
    double pressed_s, view_time_s, evaluated_at_s, rewound_to_s;
    float x, y, dx, dy, server_x, server_y;
    int32_t client_view_hit, server_now_hit, compensated_hit, perfect_hit;
} shot;

static const char *const weapons[] = {"hitscan", "projectile", NULL};
static const char *const shot_flags[] = {"taken", "clamped", "view_time_rejected", "behind_cover", NULL};

static const ll_record_field shot_fields[] = {
    LL_INT(shot, player, NULL, "index of the shooter"),
    LL_ENUM(shot, weapon, weapons, "weapon"),
    LL_INT(shot, tick, NULL, "the server's step that it was meant for"),
    LL_FLAGS(shot, flags, shot_flags,
             "clamped: to max_rewind_ms; view_time_rejected: the server did not believe the stated view age; "
             "behind_cover: the target was behind cover"),
    LL_STEP(shot, pressed_s, LL_BITS_S, "s", "when the button was pressed"),
    LL_STEP(shot, view_time_s, LL_BITS_S, "s", "render time of the shooter's view"),
    LL_STEP(shot, evaluated_at_s, LL_BITS_S, "s", "the server's present when it judged the shot"),
    LL_STEP(shot, rewound_to_s, LL_BITS_S, "s", "server time of the bodies that the shot was judged against"),
    LL_STEP(shot, x, LL_BITS_M, "m", "the muzzle at the press"),
    LL_STEP(shot, y, LL_BITS_M, "m", "the muzzle at the press"),
    LL_STEP(shot, dx, LL_BITS_RAD, NULL, "the aim, a unit vector"),
    LL_STEP(shot, dy, LL_BITS_RAD, NULL, "the aim, a unit vector"),
    LL_STEP(shot, server_x, LL_BITS_M, "m", "the muzzle at the server"),
    LL_STEP(shot, server_y, LL_BITS_M, "m", "the muzzle at the server"),
    LL_INT(shot, client_view_hit, NULL, "body hit in the shooter's view; -1: none; -2: not known yet"),
    LL_INT(shot, server_now_hit, NULL, "body hit in the server's present, without compensation"),
    LL_INT(shot, compensated_hit, NULL, "body hit by the server's policy"),
    LL_INT(shot, perfect_hit, NULL, "body hit on a network without delay"),
};

const ll_record ll_netgame_shot_record = {
    .id = 11,
    .name = "shots",
    .channel = LL_CHANNEL_SHOTS,
    .help = "For each player the last shot of each weapon that the server judged, not older than 5 s.",
    .form = LL_FORM_KEYED,
    .keys = 3,
    LL_ROWS_OF(shot, shot_fields)};

typedef struct shot_body {
    uint8_t player, weapon, body;
    uint32_t tick;
    float seen_x, seen_y, now_x, now_y, looked_x, looked_y;
} shot_body;

static const ll_record_field shot_body_fields[] = {
    LL_INT(shot_body, player, NULL, "index of the shooter"),
    LL_ENUM(shot_body, weapon, weapons, "weapon"),
    LL_INT(shot_body, tick, NULL, "of the shot"),
    LL_INT(shot_body, body, NULL, "index of its entity"),
    LL_STEP(shot_body, seen_x, LL_BITS_M, "m", "in the shooter's view, at view_time_s"),
    LL_STEP(shot_body, seen_y, LL_BITS_M, "m", "in the shooter's view, at view_time_s"),
    LL_STEP(shot_body, now_x, LL_BITS_M, "m", "in the server's present, at evaluated_at_s"),
    LL_STEP(shot_body, now_y, LL_BITS_M, "m", "in the server's present, at evaluated_at_s"),
    LL_STEP(shot_body, looked_x, LL_BITS_M, "m", "where the shot was judged, at rewound_to_s"),
    LL_STEP(shot_body, looked_y, LL_BITS_M, "m", "where the shot was judged, at rewound_to_s"),
};

const ll_record ll_netgame_shot_body_record = {.id = 12,
                                               .name = "shot_bodies",
                                               .channel = LL_CHANNEL_SHOTS,
                                               .help = "The bodies at the times of these shots.",
                                               .form = LL_FORM_KEYED,
                                               .keys = 4,
                                               LL_ROWS_OF(shot_body, shot_body_fields)};

static shot shot_of(const ll_shot_record *r, int player, int weapon)
{
    int32_t hit[LL_JUDGES];
    for (int j = 0; j < LL_JUDGES; j++)
        hit[j] = r->decided >> j & 1 ? r->body[j] : NOBODY_YET;
    return (shot){.player = (uint8_t)player,
                  .weapon = (uint8_t)weapon,
                  .flags = (uint8_t)(r->flags & (LL_SHOT_LOST - 1)),
                  .tick = (uint32_t)r->tick,
                  .pressed_s = ll_to_s(r->pressed),
                  .view_time_s = ll_to_s(r->seen),
                  .evaluated_at_s = ll_to_s(r->evaluated_at),
                  .rewound_to_s = ll_to_s(r->rewound_to),
                  .x = (float)r->aim.from.x,
                  .y = (float)r->aim.from.y,
                  .dx = (float)r->aim.direction.x,
                  .dy = (float)r->aim.direction.y,
                  .server_x = (float)r->muzzle.x,
                  .server_y = (float)r->muzzle.y,
                  .client_view_hit = hit[LL_JUDGE_VIEW],
                  .server_now_hit = hit[LL_JUDGE_NOW],
                  .compensated_hit = hit[LL_JUDGE_SERVER],
                  .perfect_hit = hit[LL_JUDGE_PERFECT]};
}

static void fill_bodies(const ll_netgame *g, const ll_shot_record *r, const float (*seen)[2], const shot *of,
                        ll_row_set *rows)
{
    const ll_arena *arena = &ll_netgame_shots(g)->arena;
    ll_point now[LL_BODIES_MAX], rewound_to[LL_BODIES_MAX];
    ll_bodies_at(arena, ll_netgame_history(g), r->evaluated_at, now);
    ll_bodies_at(arena, ll_netgame_history(g), r->rewound_to, rewound_to);
    for (int i = 0; i < arena->bodies; i++) {
        shot_body body = {.player = of->player,
                          .weapon = of->weapon,
                          .body = (uint8_t)i,
                          .tick = of->tick,
                          .seen_x = seen[i][0],
                          .seen_y = seen[i][1],
                          .now_x = (float)now[i].x,
                          .now_y = (float)now[i].y,
                          .looked_x = (float)rewound_to[i].x,
                          .looked_y = (float)rewound_to[i].y};
        ll_row_set_put(rows, &ll_netgame_shot_body_record, &body, 1);
    }
}

void ll_netgame_fill_shots(const ll_netgame *g, ll_row_set *rows)
{
    int players = ll_netgame_shots(g) ? g->config.player_count : 0;
    for (int i = 0; i < players; i++)
        for (int w = 0; w < LL_WEAPONS; w++) {
            const float(*seen)[2];
            const ll_shot_record *r = ll_shots_last(ll_netgame_shots(g), i, (ll_weapon)w, &seen);
            if (!r || g->now - r->evaluated_at > SHOWN)
                continue;
            shot one = shot_of(r, i, w);
            ll_row_set_put(rows, &ll_netgame_shot_record, &one, 1);
            fill_bodies(g, r, seen, &one, rows);
        }
}

/* ---- projectiles in flight, in every view ---- */

typedef struct projectile_row {
    uint8_t view, player;
    uint16_t number;
    float flown_s, x, y, vx, vy, from_x, from_y, from_vx, from_vy;
} projectile_row;

static const ll_record_field projectile_fields[] = {
    LL_INT(projectile_row, view, NULL, "index of the view"),
    LL_INT(projectile_row, player, NULL, "whose"),
    LL_INT(projectile_row, number, NULL, "running number of the player's projectiles"),
    LL_STEP(projectile_row, flown_s, LL_BITS_S, "s", "since the start of its flight"),
    LL_STEP(projectile_row, x, LL_BITS_M, "m", "position"),
    LL_STEP(projectile_row, y, LL_BITS_M, "m", "position"),
    LL_STEP(projectile_row, vx, LL_BITS_MPS, "m/s", "velocity"),
    LL_STEP(projectile_row, vy, LL_BITS_MPS, "m/s", "velocity"),
    LL_STEP(projectile_row, from_x, LL_BITS_M, "m", "position at the start"),
    LL_STEP(projectile_row, from_y, LL_BITS_M, "m", "position at the start"),
    LL_STEP(projectile_row, from_vx, LL_BITS_MPS, "m/s", "velocity at the start"),
    LL_STEP(projectile_row, from_vy, LL_BITS_MPS, "m/s", "velocity at the start"),
};

const ll_record ll_netgame_projectile_record = {.id = 5,
                                                .name = "shells",
                                                .channel = LL_CHANNEL_SCENE,
                                                .help = "Projectiles in flight, in a game with weapons.",
                                                .form = LL_FORM_KEYED,
                                                .keys = 3,
                                                LL_ROWS_OF(projectile_row, projectile_fields)};

enum { SHELLS_MAX = (LL_PEERS_MAX + 1) * LL_PEERS_MAX * LL_PROJECTILES };

static projectile_row projectile_at(int view, int player, uint32_t number, const ll_flight *f, double s)
{
    ll_point at = ll_flight_at(f, s), velocity = ll_flight_velocity(f, s);
    return (projectile_row){.view = (uint8_t)view,
                            .player = (uint8_t)player,
                            .number = (uint16_t)number,
                            .flown_s = (float)s,
                            .x = (float)at.x,
                            .y = (float)at.y,
                            .vx = (float)velocity.x,
                            .vy = (float)velocity.y,
                            .from_x = (float)f->from.x,
                            .from_y = (float)f->from.y,
                            .from_vx = (float)f->velocity.x,
                            .from_vy = (float)f->velocity.y};
}

/* Projectiles of `player` that a world contains, at the world's render time. */
static int known_projectiles(const ll_netgame *g, int view, const ll_world *world, int player, ll_time time,
                             projectile_row *out)
{
    const ll_weapon_state *arms = ll_netgame_game(g)->weapons->arms(world, player);
    const ll_arena *arena = &ll_netgame_shots(g)->arena;
    int n = 0;
    for (int i = 0; i < LL_PROJECTILES; i++) {
        const ll_projectile *projectile = &arms->projectiles[i];
        ll_flight f = {projectile->from, projectile->velocity, arena->gravity, arena->projectile_drag};
        if (projectile->number > 0 && time >= projectile->start && time < projectile->end)
            out[n++] = projectile_at(view, player, projectile->number, &f, ll_to_s(time - projectile->start));
    }
    return n;
}

/* Own projectiles are where the client has moved them. */
static int own_projectiles(const ll_netgame *g, int player, projectile_row *out)
{
    const ll_weapon_prediction *weapon_prediction = ll_netgame_weapon_prediction(g, player);
    int n = 0;
    for (int64_t number = weapon_prediction->fired - LL_PROJECTILES + 1; number <= weapon_prediction->fired;
         number++) {
        const ll_predicted_projectile *projectile =
            &weapon_prediction->projectiles[(number + LL_PROJECTILES) % LL_PROJECTILES];
        const ll_flight f = ll_predicted_flight(weapon_prediction, projectile);
        if (number > 0 && projectile->state == LL_WEAPON_PREDICTION_FLYING)
            out[n++] = projectile_at(player + 1, player, (uint32_t)number, &f,
                                     ll_to_s(weapon_prediction->drawn_time - projectile->start));
    }
    return n;
}

static int list_projectiles(const ll_netgame *g, projectile_row *out)
{
    const ll_server *server = ll_netgame_server(g);
    int players = g->config.player_count, n = 0;
    for (int i = 0; i < players; i++)
        n += known_projectiles(g, 0, ll_server_world_const(server), i, server->stepped, out + n);
    for (int v = 0; v < players; v++) {
        const ll_client *c = ll_netgame_client(g, v);
        for (int i = 0; i < players; i++)
            n += i == v ? own_projectiles(g, v, out + n)
                        : known_projectiles(g, v + 1, ll_client_rendered_const(c), i, c->drawing.view_time,
                                            out + n);
    }
    return n;
}

void ll_netgame_fill_projectiles(const ll_netgame *g, ll_row_set *rows)
{
    projectile_row projectiles[SHELLS_MAX];
    if (ll_netgame_shots(g))
        ll_row_set_put(rows, &ll_netgame_projectile_record, projectiles, list_projectiles(g, projectiles));
}
