/* What is told of shots: M10, and the sections 4 and 9 of session/frame.h. */
#include <cjson/cJSON.h>
#include <stddef.h>
#include <string.h>

#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

/* null where nothing was counted: no share, rather than a bad one */
static void share(cJSON *object, const char *name, int64_t part, int64_t whole)
{
    number(object, name, ll_netgame_ratio((double)part, (double)whole));
}

static void peeks(cJSON *object, const ll_marksman *m)
{
    static const char *const names[] = {"mean", "rms", "p50", "p95", "p99", "max"};
    ll_summary s = ll_shots_peeks(m);
    const double values[] = {s.mean, s.rms, s.p50, s.p95, s.p99, s.max};
    cJSON *o = cJSON_AddObjectToObject(object, "peeker_advantage_ms");
    for (int i = 0; i < 6; i++)
        if (s.count > 0)
            number(o, names[i], values[i]);
        else
            cJSON_AddNullToObject(o, names[i]);
    number(o, "count", (double)s.count);
    number(o, "seen_second", (double)m->peek[1].count);
}

static void tally(cJSON *parent, const char *name, const ll_shot_tally *t)
{
    static const char *const hits[LL_JUDGES] = {[LL_JUDGE_VIEW] = "client_view_hits",
                                                [LL_JUDGE_NOW] = "server_now_hits",
                                                [LL_JUDGE_SERVER] = "compensated_hits",
                                                [LL_JUDGE_PERFECT] = "perfect_hits"};
    cJSON *o = cJSON_AddObjectToObject(parent, name);
    number(o, "shots", (double)t->shots);
    number(o, "lost", (double)t->lost);
    for (int j = 0; j < LL_JUDGES; j++)
        number(o, hits[j], (double)t->hits[j]);
    share(o, "agreement", t->agreed, t->shots);
    number(o, "shots_within_max_rewind", (double)t->within);
    share(o, "agreement_within_max_rewind", t->within_agreed, t->within);
    number(o, "false_hits", (double)t->false_hits);
    number(o, "false_misses", (double)t->false_misses);
    share(o, "favour_the_shooter", t->kept, t->hits[LL_JUDGE_VIEW]);
    number(o, "hits_on_players", (double)t->on_players);
    number(o, "shot_behind_cover", (double)t->behind_cover);
    number(o, "clamped", (double)t->clamped);
    number(o, "distrusted", (double)t->distrusted);
}

void ll_netgame_shots_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    if (!ll_netgame_shots(g))
        return;
    const ll_marksman *m = &ll_netgame_shots(g)->marksman[player];
    cJSON *o = cJSON_AddObjectToObject(metrics, "shots");
    tally(o, "rifle", &m->tally[LL_RIFLE]);
    tally(o, "shell", &m->tally[LL_CANNON]);
    int64_t shots = 0, hits = 0;
    for (int w = 0; w < LL_WEAPONS; w++) {
        shots += m->tally[w].shots;
        hits += m->tally[w].hits[LL_JUDGE_SERVER];
    }
    share(o, "hit_ratio", hits, shots);
    ll_netgame_distribution(o, "rollback_distance_m", ll_histogram_summary(&m->rollback));
    ll_netgame_distribution(o, "rewind_ms", ll_histogram_summary(&m->rewind));
    ll_netgame_distribution(o, "trace_error_m", ll_histogram_summary(&m->trace_error));
    peeks(o, m);
}

/* ---- section 4: the last shots ---- */

enum { SECTION_SHOTS = 4, SECTION_SHELLS = 9 };
enum { NOBODY_YET = -2 };

#define SHOWN (5 * LL_SECOND) /* older shots are not told: the history would not have them for ever */

typedef struct shot_body {
    float seen_x, seen_y, now_x, now_y, looked_x, looked_y;
} shot_body;

typedef struct shot_record {
    uint8_t player, weapon, bodies, flags;
    uint32_t tick;
    double pressed_s, seen_s, judged_s, looked_s;
    float x, y, dx, dy, server_x, server_y;
    int32_t hit[LL_JUDGES];
    shot_body body[LL_BODIES_MAX];
} shot_record;

_Static_assert(offsetof(shot_record, body) == 80 && sizeof(shot_body) == 24, "the layout of session/frame.h");

static void fill_bodies(const ll_netgame *g, const ll_shot_record *r, const float (*seen)[2], shot_body *out)
{
    const ll_arena *arena = &ll_netgame_shots(g)->arena;
    ll_point now[LL_BODIES_MAX], looked[LL_BODIES_MAX];
    ll_bodies_at(arena, ll_netgame_history(g), r->judged, now);
    ll_bodies_at(arena, ll_netgame_history(g), r->looked, looked);
    for (int i = 0; i < arena->bodies; i++)
        out[i] = (shot_body){seen[i][0],      seen[i][1],         (float)now[i].x,
                             (float)now[i].y, (float)looked[i].x, (float)looked[i].y};
}

static bool shot_of(const ll_netgame *g, int player, ll_weapon weapon, shot_record *out)
{
    const float(*seen)[2];
    const ll_shot_record *r = ll_shots_last(ll_netgame_shots(g), player, weapon, &seen);
    if (!r || g->now - r->judged > SHOWN)
        return false;
    *out = (shot_record){.player = (uint8_t)player,
                         .weapon = (uint8_t)weapon,
                         .bodies = (uint8_t)ll_netgame_shots(g)->arena.bodies,
                         .flags = r->flags,
                         .tick = (uint32_t)r->tick,
                         .pressed_s = ll_to_s(r->pressed),
                         .seen_s = ll_to_s(r->seen),
                         .judged_s = ll_to_s(r->judged),
                         .looked_s = ll_to_s(r->looked),
                         .x = (float)r->aim.from.x,
                         .y = (float)r->aim.from.y,
                         .dx = (float)r->aim.direction.x,
                         .dy = (float)r->aim.direction.y,
                         .server_x = (float)r->muzzle.x,
                         .server_y = (float)r->muzzle.y};
    for (int j = 0; j < LL_JUDGES; j++)
        out->hit[j] = r->spoken >> j & 1 ? r->body[j] : NOBODY_YET;
    fill_bodies(g, r, seen, out->body);
    return true;
}

/* ---- section 9: shells in flight, as every view has them ---- */

typedef struct shell_record {
    uint8_t view, player;
    uint16_t number;
    float flown_s, x, y, vx, vy, from_x, from_y, from_vx, from_vy;
} shell_record;

_Static_assert(sizeof(shell_record) == 40, "the layout of session/frame.h");

enum { SHELLS_MAX = (LL_PLAYERS_MAX + 1) * LL_PLAYERS_MAX * LL_SHELLS };

static shell_record shell_at(int view, int player, uint32_t number, const ll_flight *f, double s)
{
    ll_point at = ll_flight_at(f, s);
    return (shell_record){.view = (uint8_t)view,
                          .player = (uint8_t)player,
                          .number = (uint16_t)number,
                          .flown_s = (float)s,
                          .x = (float)at.x,
                          .y = (float)at.y,
                          .vx = (float)f->velocity.x,
                          .vy = (float)(f->velocity.y - f->gravity * s),
                          .from_x = (float)f->from.x,
                          .from_y = (float)f->from.y,
                          .from_vx = (float)f->velocity.x,
                          .from_vy = (float)f->velocity.y};
}

/* Those of `player` that a world knows of, at the time that it is drawn at. */
static int known_shells(const ll_netgame *g, int view, const ll_world *world, int player, ll_time time,
                        shell_record *out)
{
    const ll_arms *arms = ll_netgame_game(g)->weapons->arms(world, player);
    int n = 0;
    for (int i = 0; i < LL_SHELLS; i++) {
        const ll_shell *shell = &arms->shells[i];
        ll_flight f = {shell->from, shell->velocity, ll_netgame_shots(g)->arena.gravity};
        if (shell->number > 0 && time >= shell->start && time < shell->end)
            out[n++] = shell_at(view, player, shell->number, &f, ll_to_s(time - shell->start));
    }
    return n;
}

/* The own ones are where the client has flown them. */
static int own_shells(const ll_netgame *g, int player, shell_record *out)
{
    const ll_gunner *gunner = ll_netgame_gunner(g, player);
    int n = 0;
    for (int64_t number = gunner->fired - LL_SHELLS + 1; number <= gunner->fired; number++) {
        const ll_gunner_shell *shell = &gunner->shells[(number + LL_SHELLS) % LL_SHELLS];
        if (number > 0 && shell->state == LL_GUNNER_FLYING)
            out[n++] = shell_at(player + 1, player, (uint32_t)number, &shell->flight,
                                ll_to_s(gunner->drawn_time - shell->start));
    }
    return n;
}

static int list_shells(const ll_netgame *g, shell_record *out)
{
    const ll_server *server = ll_netgame_server(g);
    int players = g->config.player_count, n = 0;
    for (int i = 0; i < players; i++)
        n += known_shells(g, 0, ll_server_world_const(server), i, server->stepped, out + n);
    for (int v = 0; v < players; v++) {
        const ll_client *c = ll_netgame_client(g, v);
        for (int i = 0; i < players; i++)
            n += i == v ? own_shells(g, v, out + n)
                        : known_shells(g, v + 1, ll_client_shown_const(c), i, c->view_time, out + n);
    }
    return n;
}

/* ---- both ---- */

void ll_netgame_shots_sections(const ll_netgame *g,
                               void (*section)(void *context, int type, int count, const void *bytes,
                                               size_t size),
                               void *context)
{
    if (!ll_netgame_shots(g))
        return;
    size_t stride =
        offsetof(shot_record, body) + (size_t)ll_netgame_shots(g)->arena.bodies * sizeof(shot_body);
    _Alignas(8) char shots[LL_PLAYERS_MAX * LL_WEAPONS * sizeof(shot_record)];
    shell_record shells[SHELLS_MAX];
    int count = 0, flying = list_shells(g, shells);
    for (int i = 0; i < g->config.player_count; i++)
        for (int w = 0; w < LL_WEAPONS; w++)
            count += shot_of(g, i, (ll_weapon)w, (shot_record *)(void *)(shots + (size_t)count * stride));
    section(context, SECTION_SHOTS, count, shots, (size_t)count * stride);
    section(context, SECTION_SHELLS, flying, shells, (size_t)flying * sizeof shells[0]);
}

static cJSON *shot_json(const shot_record *r)
{
    static const char *const hits[LL_JUDGES] = {[LL_JUDGE_VIEW] = "client_view_hit",
                                                [LL_JUDGE_NOW] = "server_now_hit",
                                                [LL_JUDGE_SERVER] = "compensated_hit",
                                                [LL_JUDGE_PERFECT] = "perfect_hit"};
    cJSON *o = cJSON_CreateObject(), *bodies = cJSON_AddArrayToObject(o, "bodies");
    number(o, "player", r->player);
    number(o, "weapon", r->weapon);
    number(o, "flags", r->flags);
    number(o, "tick", r->tick);
    number(o, "pressed_s", r->pressed_s);
    number(o, "seen_s", r->seen_s);
    number(o, "judged_s", r->judged_s);
    number(o, "looked_s", r->looked_s);
    number(o, "x", (double)r->x);
    number(o, "y", (double)r->y);
    number(o, "dx", (double)r->dx);
    number(o, "dy", (double)r->dy);
    number(o, "server_x", (double)r->server_x);
    number(o, "server_y", (double)r->server_y);
    for (int j = 0; j < LL_JUDGES; j++)
        number(o, hits[j], r->hit[j]);
    for (int i = 0; i < r->bodies; i++) {
        cJSON *b = cJSON_CreateObject();
        number(b, "seen_x", (double)r->body[i].seen_x);
        number(b, "seen_y", (double)r->body[i].seen_y);
        number(b, "now_x", (double)r->body[i].now_x);
        number(b, "now_y", (double)r->body[i].now_y);
        number(b, "looked_x", (double)r->body[i].looked_x);
        number(b, "looked_y", (double)r->body[i].looked_y);
        cJSON_AddItemToArray(bodies, b);
    }
    return o;
}

static cJSON *shell_json(const shell_record *r)
{
    cJSON *o = cJSON_CreateObject();
    number(o, "view", r->view);
    number(o, "player", r->player);
    number(o, "number", r->number);
    number(o, "flown_s", (double)r->flown_s);
    number(o, "x", (double)r->x);
    number(o, "y", (double)r->y);
    number(o, "vx", (double)r->vx);
    number(o, "vy", (double)r->vy);
    number(o, "from_x", (double)r->from_x);
    number(o, "from_y", (double)r->from_y);
    number(o, "from_vx", (double)r->from_vx);
    number(o, "from_vy", (double)r->from_vy);
    return o;
}

void ll_netgame_shots_sections_json(const ll_netgame *g, cJSON *frame)
{
    if (!ll_netgame_shots(g))
        return;
    cJSON *shots = cJSON_AddArrayToObject(frame, "shots"), *shells = cJSON_AddArrayToObject(frame, "shells");
    shell_record flying[SHELLS_MAX];
    shot_record shot;
    for (int i = 0; i < g->config.player_count; i++)
        for (int w = 0; w < LL_WEAPONS; w++)
            if (shot_of(g, i, (ll_weapon)w, &shot))
                cJSON_AddItemToArray(shots, shot_json(&shot));
    int n = list_shells(g, flying);
    for (int i = 0; i < n; i++)
        cJSON_AddItemToArray(shells, shell_json(&flying[i]));
}
