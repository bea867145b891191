/* What is streamed of a netgame: the sections of session/frame.h. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "sim/netgame/netgame.h"

enum { SECTION_VIEWS = 1, SECTION_GAME = 3 };

enum {
    VIEW_PREDICTION = 1,
    VIEW_RECONCILIATION = 2,
    VIEW_INTERPOLATION = 4,
    VIEW_UNDERRUN = 8,
    VIEW_STALLED = 16,
    VIEW_PERSON = 32,
    VIEW_CONNECTION = 8, /* the first of three bits: ll_connection_state */
    VIEW_DROPPED = 2048,
};

typedef struct view_entity {
    float x, y, vx, vy, angle, spin, age_ms;
    uint32_t flags;
} view_entity;

typedef struct view {
    uint8_t view, entities;
    uint16_t flags;
    uint32_t input_seq, acked_seq, unacked;
    float lag_ms, view_age_ms, own_lead_m, remote_error_m, buffer_ms, slack_ticks;
    uint32_t corrections;
    float correction_m;
    uint32_t refused;
    float alpha;
    double shown_s;
    view_entity entity[LL_ENTITIES_MAX];
} view;

_Static_assert(offsetof(view, entity) == 64 && sizeof(view_entity) == 32, "the layout of session/frame.h");

static view_entity entity(const ll_entity *e, ll_time age, uint32_t flags)
{
    return (view_entity){(float)e->x,     (float)e->y,    (float)e->vx,         (float)e->vy,
                         (float)e->angle, (float)e->spin, (float)ll_to_ms(age), (uint32_t)e->flags | flags};
}

/* Only as many entities are written as there are. */
static size_t stride_of(int entities)
{
    return offsetof(view, entity) + (size_t)entities * sizeof(view_entity);
}

static void server_view(const ll_netgame *g, view *v)
{
    const ll_server *server = ll_netgame_server(g);
    const ll_world *world = ll_server_world_const(server);
    v->shown_s = ll_to_s(server->stepped);
    v->alpha = 1;
    v->input_seq = (uint32_t)server->step;
    int stalled = ll_netgame_sync(g)->due(server) == LL_NEVER ? VIEW_STALLED : 0;
    v->flags = (uint16_t)(stalled | LL_CONNECTION_PLAYING << VIEW_CONNECTION);
    for (int i = 0; i < world->entities; i++)
        v->entity[i] = entity(&world->entity[i], g->now - server->stepped, 0);
}

static void player_view(const ll_netgame *g, int i, view *v)
{
    const ll_client *c = ll_netgame_client(g, i);
    const ll_player_config *config = &g->config.players[i];
    const ll_instruments *in = ll_netgame_instruments(g, i);
    const ll_seat *seat = &ll_netgame_server(g)->seats[i];
    int flags = (config->prediction ? VIEW_PREDICTION : 0) |
                (config->reconciliation ? VIEW_RECONCILIATION : 0) |
                (config->interpolation ? VIEW_INTERPOLATION : 0) | (c->held_now ? VIEW_UNDERRUN : 0) |
                (ll_netgame_stalled(g, i) ? VIEW_STALLED : 0) |
                (config->control == LL_CONTROL_PERSON ? VIEW_PERSON : 0) |
                c->connection.state << VIEW_CONNECTION | (seat->connected ? 0 : VIEW_DROPPED);
    v->flags = (uint16_t)flags;
    v->input_seq = c->seq;
    v->acked_seq = c->acked;
    v->unacked = c->seq - c->acked;
    v->lag_ms = (float)config->lag_ms;
    v->view_age_ms = (float)in->view_age;
    v->own_lead_m = (float)in->own_lead;
    v->remote_error_m = (float)in->remote_error;
    v->buffer_ms = (float)c->buffer_ms;
    v->slack_ticks = seat->last_slack == LL_SLACK_UNKNOWN ? NAN : (float)seat->last_slack;
    v->corrections = (uint32_t)in->corrections;
    v->correction_m = (float)in->last_correction;
    v->refused = (uint32_t)in->ledger.count[LL_INPUT_WAS_REFUSED];
    v->alpha = (float)c->alpha;
    v->shown_s = ll_to_s(c->view_time);
    const ll_world *shown = ll_client_shown_const(c);
    const ll_mark *marks = ll_client_marks_const(c);
    for (int k = 0; k < shown->entities; k++)
        v->entity[k] = entity(&shown->entity[k], g->now - marks[k].time, marks[k].flags);
}

static void view_of(const ll_netgame *g, int index, view *v)
{
    memset(v, 0, offsetof(view, entity));
    v->view = (uint8_t)index;
    v->entities = (uint8_t)ll_netgame_entities(g);
    if (index == 0)
        server_view(g, v);
    else
        player_view(g, index - 1, v);
}

static int game_values(const ll_netgame *g, int player, double *values)
{
    const ll_game *game = ll_netgame_game(g);
    int n = 0;
    game->describe(ll_server_world_const(ll_netgame_server(g)), &g->env, player, values);
    while (game->values[n])
        n++;
    return n;
}

void ll_netgame_sections(const void *block,
                         void (*section)(void *context, int type, int count, const void *bytes, size_t size),
                         void *context)
{
    const ll_netgame *g = block;
    int n = g->config.player_count;
    size_t stride = stride_of(ll_netgame_entities(g));
    _Alignas(8) char views[(LL_PLAYERS_MAX + 1) * sizeof(view)];
    for (int i = 0; i <= n; i++)
        view_of(g, i, (view *)(void *)(views + (size_t)i * stride));
    section(context, SECTION_VIEWS, n + 1, views, (size_t)(n + 1) * stride);

    double values[LL_PLAYERS_MAX * LL_GAME_VALUES], own[LL_GAME_VALUES];
    int columns = 0, count = 0;
    for (int i = 0; i < n; i++) {
        columns = game_values(g, i, own);
        for (int k = 0; k < columns; k++)
            values[count++] = own[k];
    }
    section(context, SECTION_GAME, n, values, (size_t)count * sizeof(double));
    ll_netgame_peer_section(g, section, context);
    ll_netgame_view_sections(g, section, context);
    ll_netgame_ladder_section(g, section, context);
    ll_netgame_shots_sections(g, section, context);
    ll_netgame_measures_section(g, section, context);
}

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

static cJSON *view_json(const view *v)
{
    cJSON *o = cJSON_CreateObject(), *entities = cJSON_AddArrayToObject(o, "entities");
    number(o, "view", v->view);
    number(o, "flags", v->flags);
    cJSON_AddStringToObject(o, "connection", ll_connection_state_names[v->flags >> VIEW_CONNECTION & 7]);
    cJSON_AddBoolToObject(o, "connected", (v->flags & VIEW_DROPPED) == 0);
    number(o, "input_seq", v->input_seq);
    number(o, "acked_seq", v->acked_seq);
    number(o, "unacked", v->unacked);
    number(o, "lag_ms", (double)v->lag_ms);
    number(o, "view_age_ms", (double)v->view_age_ms);
    number(o, "own_lead_m", (double)v->own_lead_m);
    number(o, "remote_error_m", (double)v->remote_error_m);
    number(o, "buffer_ms", (double)v->buffer_ms);
    number(o, "slack_ticks", (double)v->slack_ticks);
    number(o, "corrections", v->corrections);
    number(o, "correction_m", (double)v->correction_m);
    number(o, "refused", v->refused);
    number(o, "alpha", (double)v->alpha);
    number(o, "shown_s", v->shown_s);
    for (int i = 0; i < v->entities; i++) {
        const view_entity *e = &v->entity[i];
        cJSON *item = cJSON_CreateObject();
        number(item, "x", (double)e->x);
        number(item, "y", (double)e->y);
        number(item, "vx", (double)e->vx);
        number(item, "vy", (double)e->vy);
        number(item, "angle", (double)e->angle);
        number(item, "spin", (double)e->spin);
        number(item, "age_ms", (double)e->age_ms);
        number(item, "flags", e->flags);
        cJSON_AddItemToArray(entities, item);
    }
    return o;
}

void ll_netgame_sections_json(const void *block, cJSON *frame)
{
    const ll_netgame *g = block;
    cJSON *views = cJSON_AddArrayToObject(frame, "views"), *game = cJSON_AddArrayToObject(frame, "game");
    for (int i = 0; i <= g->config.player_count; i++) {
        view v;
        view_of(g, i, &v);
        cJSON_AddItemToArray(views, view_json(&v));
    }
    for (int i = 0; i < g->config.player_count; i++) {
        double values[LL_GAME_VALUES];
        int n = game_values(g, i, values);
        cJSON_AddItemToArray(game, cJSON_CreateDoubleArray(values, n));
    }
    ll_netgame_peer_section_json(g, frame);
    ll_netgame_view_sections_json(g, frame);
    ll_netgame_ladder_section_json(g, frame);
    ll_netgame_shots_sections_json(g, frame);
    ll_netgame_measures_section_json(g, frame);
}
