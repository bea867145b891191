/* Reports of a netgame: state, layout and the columns of a trace. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    ll_netgame_number(object, name, value);
}

static cJSON *entity_json(const ll_entity *e)
{
    cJSON *o = cJSON_CreateObject();
    number(o, "x", e->x);
    number(o, "y", e->y);
    number(o, "vx", e->vx);
    number(o, "vy", e->vy);
    number(o, "angle", e->angle);
    number(o, "angular_velocity", e->angular_velocity);
    number(o, "flags", (double)e->flags);
    return o;
}

cJSON *ll_netgame_state(const void *block)
{
    const ll_netgame *g = block;
    const ll_server *server = ll_netgame_server(g);
    const ll_game *game = ll_netgame_game(g);
    cJSON *state = cJSON_CreateObject(), *s = cJSON_AddObjectToObject(state, "server");
    number(s, "step", (double)server->step);
    number(s, "stepped_s", ll_to_s(server->stepped));
    cJSON *entities = cJSON_AddArrayToObject(s, "entities"),
          *players = cJSON_AddArrayToObject(state, "players");
    for (int i = 0; i < ll_netgame_entities(g); i++)
        cJSON_AddItemToArray(entities, entity_json(&ll_server_world_const(server)->entity[i]));
    for (int i = 0; i < server->players; i++) {
        const ll_client *c = ll_netgame_client(g, i);
        cJSON *p = cJSON_CreateObject(), *shown = cJSON_CreateArray();
        cJSON_AddStringToObject(p, "name", g->config.players[i].name);
        number(p, "input_seq", c->inputs.seq);
        number(p, "acked_seq", c->inputs.acked);
        number(p, "unacked", c->inputs.seq - c->inputs.acked);
        for (int k = 0; k < ll_netgame_entities(g); k++) {
            cJSON *e = entity_json(&ll_client_rendered_const(c)->entity[k]);
            number(e, "age_ms", ll_to_ms(g->now - ll_client_draw_infos_const(c)[k].time));
            cJSON_AddItemToArray(shown, e);
        }
        cJSON_AddItemToObject(p, "entities", shown);
        double values[LL_GAME_VALUES];
        game->describe(ll_server_world_const(server), &g->env, i, values);
        for (int k = 0; k < game->metrics->count; k++)
            number(p, game->metrics->fields[k].name, values[k]);
        cJSON_AddItemToArray(players, p);
    }
    return state;
}

static cJSON *shape_json(const ll_game_shape *shape)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "kind", shape->kind);
    number(o, "width_m", shape->width);
    number(o, "height_m", shape->height);
    cJSON_AddBoolToObject(o, "round", shape->round);
    return o;
}

static void shapes(cJSON *layout, const ll_game *game, const ll_game_env *env, const ll_netgame_config *c)
{
    cJSON *entities = cJSON_AddArrayToObject(layout, "entities"),
          *fixed = cJSON_AddArrayToObject(layout, "fixed");
    int count = game->extent(c->params, c->player_count).entities;
    ll_game_shape shape;
    for (int i = 0; memset(&shape, 0, sizeof shape), game->shape(env, c->player_count, i, &shape); i++) {
        cJSON *o = shape_json(&shape);
        if (i >= count) {
            number(o, "x", shape.x);
            number(o, "y", shape.y);
        }
        cJSON_AddItemToArray(i < count ? entities : fixed, o);
    }
}

cJSON *ll_netgame_layout(const void *config)
{
    const ll_netgame_config *c = config;
    const ll_game *game = ll_games[c->game];
    ll_game_env env = {.dt = 1 / c->tick_hz};
    game->prepare(&env, c->params);
    ll_game_scene scene = game->scene(&env, c->player_count);
    cJSON *layout = cJSON_CreateObject();
    cJSON_AddStringToObject(layout, "game", game->name);
    cJSON *players = cJSON_AddArrayToObject(layout, "players"),
          *values = cJSON_AddArrayToObject(layout, "game_values");
    for (int i = 0; i < c->player_count; i++) {
        cJSON *p = cJSON_CreateObject();
        cJSON_AddStringToObject(p, "name", c->players[i].name);
        cJSON_AddItemToArray(players, p);
    }
    for (int k = 0; k < game->metrics->count; k++)
        cJSON_AddItemToArray(values, cJSON_CreateString(game->metrics->fields[k].name));
    cJSON *s = cJSON_AddObjectToObject(layout, "scene");
    number(s, "x_min", scene.x_min);
    number(s, "x_max", scene.x_max);
    number(s, "y_min", scene.y_min);
    number(s, "y_max", scene.y_max);
    cJSON_AddBoolToObject(s, "wraps", scene.wraps);
    number(s, "finish_m", scene.finish_m);
    number(s, "target_x", scene.target_x);
    number(s, "target_y", scene.target_y);
    number(s, "target_radius", scene.target_radius);
    number(s, "entity_length_m", scene.entity_length_m);
    if (game->shape)
        shapes(layout, game, &env, c);
    cJSON_AddItemToObject(layout, "notices", ll_netgame_notices(c));
    return layout;
}

/* ---- trace ---- */

static const char *const player_columns[] = {
    "own_x_m",       "own_y_m",        "own_timeline_error_m", "own_lead_m",
    "own_lead_ms",   "remote_error_m", "view_age_ms",          "age_of_information_ms",
    "buffer_ms",     "unacked",        "corrections",          "lag_ms",
    "compared_step", "desync_m",       "connection",           "connected"};
enum { PLAYER_COLUMNS = sizeof player_columns / sizeof player_columns[0] };

int ll_netgame_trace_columns(const void *config, char (*names)[48], int capacity)
{
    const ll_netgame_config *c = config;
    int n = 0;
    if (capacity < 1 + c->player_count * (3 + PLAYER_COLUMNS))
        return 0;
    snprintf(names[n++], 48, "server_step");
    for (int i = 0; i < c->player_count; i++) {
        snprintf(names[n++], 48, "server_%d_x_m", i);
        snprintf(names[n++], 48, "server_%d_y_m", i);
        snprintf(names[n++], 48, "server_%d_vx_mps", i);
    }
    for (int i = 0; i < c->player_count; i++)
        for (int k = 0; k < PLAYER_COLUMNS; k++)
            snprintf(names[n++], 48, "player_%d_%s", i, player_columns[k]);
    return n;
}

int ll_netgame_trace_row(const void *block, double *values, int capacity)
{
    const ll_netgame *g = block;
    const ll_server *server = ll_netgame_server(g);
    const ll_world *world = ll_server_world_const(server);
    int n = 0;
    if (capacity < 1 + server->players * (3 + PLAYER_COLUMNS))
        return 0;
    values[n++] = (double)server->step;
    for (int i = 0; i < server->players; i++) {
        values[n++] = world->entity[i].x;
        values[n++] = world->entity[i].y;
        values[n++] = world->entity[i].vx;
    }
    for (int i = 0; i < server->players; i++) {
        const ll_client *c = ll_netgame_client(g, i);
        const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
        values[n++] = ll_client_rendered_const(c)->entity[i].x;
        values[n++] = ll_client_rendered_const(c)->entity[i].y;
        values[n++] = in->rendered_views.error_m;
        values[n++] = in->last.own_lead;
        values[n++] = in->rendered_views.lead_ms;
        values[n++] = in->last.remote_error;
        values[n++] = in->last.view_age;
        values[n++] = in->last.age_of_information;
        values[n++] = c->drawing.buffer_ms;
        values[n++] = c->inputs.seq - c->inputs.acked;
        values[n++] = (double)in->corrections.count;
        values[n++] = g->config.players[i].lag_ms;
        values[n++] = (double)ll_netgame_desync(g, i)->compared;
        values[n++] = ll_netgame_desync(g, i)->error;
        values[n++] = c->connection.state;
        values[n++] = server->client_slots[i].connection.connected;
    }
    return n;
}
