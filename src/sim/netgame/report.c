/* Reports of a netgame: state, layout, the columns of a trace, and reasons why metrics are null or
 * meaningless where the numbers do not show it. */
#include <cjson/cJSON.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "link/stages/stage.h"
#include "sim/netgame/netgame.h"

static void number(cJSON *object, const char *name, double value)
{
    if (value - value == 0)
        cJSON_AddNumberToObject(object, name, value);
    else
        cJSON_AddNullToObject(object, name);
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

/* ---- trace: a player's errors are those of the last display that was compared ---- */

#define STEP_COLUMNS(X) X(count, server_step, NULL, server->step, "steps that the server has made", NULL)

#define SERVER_COLUMNS(X)                                                                                    \
    X(signed_number, x_m, "m", truth->x, "position of the player's entity at the server: x", NULL)           \
    X(signed_number, y_m, "m", truth->y, "position of the player's entity at the server: y", NULL)           \
    X(signed_number, vx_mps, "m/s", truth->vx, "velocity of the player's entity at the server: x", NULL)

#define PLAYER_COLUMNS(X)                                                                                    \
    X(signed_number, own_x_m, "m", drawn->x, "position of the own entity as drawn: x", NULL)                 \
    X(signed_number, own_y_m, "m", drawn->y, "position of the own entity as drawn: y", NULL)                 \
    X(number, own_timeline_error_m, "m", in->rendered_views.error_m,                                         \
      "distance between the own entity as drawn and at the server at the drawn tick, of the last compared "  \
      "display",                                                                                             \
      NULL)                                                                                                  \
    X(signed_number, own_lead_m, "m", in->last.own_lead,                                                     \
      "distance between the own entity as drawn and at the server now, with the sign of the difference in "  \
      "x",                                                                                                   \
      NULL)                                                                                                  \
    X(signed_number, own_lead_ms, "ms", in->rendered_views.lead_ms,                                          \
      "time by which the own entity is drawn ahead of the server, of the last compared display", NULL)       \
    X(signed_number, remote_error_m, "m", in->last.remote_error,                                             \
      "largest distance between another entity as drawn and at the server now, with the sign of the "        \
      "difference in x; of equal ones that of the last player",                                              \
      NULL)                                                                                                  \
    X(number, view_age_ms, "ms", in->last.view_age, "age of another entity as drawn: the oldest", NULL)      \
    X(number, age_of_information_ms, "ms", in->last.age_of_information,                                      \
      "virtual time now less the server time of the client's newest snapshot", NULL)                         \
    X(number, buffer_ms, "ms", c->drawing.buffer_ms,                                                         \
      "server time of the newest snapshot less the render time; 0 while the client extrapolates", NULL)      \
    X(count, unacked, NULL, c->inputs.seq - c->inputs.acked,                                                 \
      "unacknowledged inputs, as the client believes", NULL)                                                 \
    X(count, corrections, NULL, in->corrections.count, "corrections of the own entity so far", NULL)         \
    X(number, lag_ms, "ms", g->config.players[i].lag_ms, "parameter lag_ms", NULL)                           \
    X(count, compared_step, NULL, ll_netgame_desync(g, i)->compared,                                         \
      "tick up to which the player's confirmed worlds were compared with the server's, at its last tick "    \
      "(deterministic, rollback)",                                                                           \
      NULL)                                                                                                  \
    X(number, desync_m, "m", ll_netgame_desync(g, i)->error,                                                 \
      "distance between the worlds that were compared: that of the entity that is furthest off", NULL)       \
    X(count, connection, NULL, c->connection.state,                                                          \
      "state of the connection: 0 connecting, 1 synchronising, 2 playing, 3 stalled, 4 resynchronising, "    \
      "5 disconnected",                                                                                      \
      NULL)                                                                                                  \
    X(flag, connected, NULL, server->client_slots[i].connection.connected,                                   \
      "1: the server takes the player for "                                                                  \
      "connected",                                                                                           \
      NULL)                                                                                                  \
    X(flag, up_blackout, NULL, is_out(g, &link->up), "1: the link to the server is in a blackout", NULL)     \
    X(flag, down_blackout, NULL, is_out(g, &link->down), "1: the link from the server is in a blackout", NULL)

static const ll_metric_table step_columns = {
    .path = "", .help = "The server.", LL_METRICS_FROM(STEP_COLUMNS)};
static const ll_metric_table server_columns = {
    .path = "server_*_", .help = "The truth, per player.", LL_METRICS_FROM(SERVER_COLUMNS)};
static const ll_metric_table player_columns = {
    .path = "player_*_", .help = "The view of a player.", LL_METRICS_FROM(PLAYER_COLUMNS)};

const ll_metric_table *const ll_netgame_trace_tables[] = {&step_columns, &server_columns, &player_columns,
                                                          NULL};

static bool is_out(const ll_netgame *g, const ll_link_params *p)
{
    return ll_window_open(p->blackout_at_ms, p->blackout_every_ms, p->blackout_length_ms, g->now);
}

void ll_netgame_trace(const void *block, ll_trace_line *trace)
{
    const ll_netgame *g = block;
    const ll_server *server = ll_netgame_server(g);
    LL_TRACE_PUT(trace, &step_columns, 0, STEP_COLUMNS);
    for (int i = 0; i < server->players; i++) {
        const ll_entity *truth = &ll_server_world_const(server)->entity[i];
        LL_TRACE_PUT(trace, &server_columns, i, SERVER_COLUMNS);
    }
    for (int i = 0; i < server->players; i++) {
        const ll_client *c = ll_netgame_client(g, i);
        const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
        const ll_entity *drawn = &ll_client_rendered_const(c)->entity[i];
        const ll_link_pair *link = &g->config.players[i].link;
        LL_TRACE_PUT(trace, &player_columns, i, PLAYER_COLUMNS);
    }
}

/* ---- notices ---- */

enum { NAMED = 3 /* players; of more it gives the number */ };

static void add_notice(cJSON *notices, const char *format, ...) __attribute__((format(printf, 2, 3)));

static void add_notice(cJSON *notices, const char *format, ...)
{
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    cJSON_AddItemToArray(notices, cJSON_CreateString(text));
}

cJSON *ll_netgame_notices(const void *config)
{
    const ll_netgame_config *c = config;
    cJSON *notices = cJSON_CreateArray();
    if (c->head.duration_s <= c->warmup_s)
        add_notice(
            notices,
            "duration_s, %g s, is not longer than warmup_s, %g s, from which on metrics count: those that "
            "count from there are null.",
            c->head.duration_s, c->warmup_s);
    return notices;
}

/* ---- players ---- */

static int64_t count_of(const ll_netgame *g, int player, ll_metric metric)
{
    return ll_histogram_summary(&ll_netgame_client_metrics(g, player)->histogram[metric]).count;
}

static bool never_joined(const ll_netgame *g, int player)
{
    return ll_netgame_client(g, player)->connection.joins == 0;
}

static bool touched_nothing(const ll_netgame *g, int player)
{
    return !never_joined(g, player) && ll_netgame_client_metrics(g, player)->changes.made == 0 &&
           count_of(g, player, LL_METRIC_INPUT_LATENCY) == 0;
}

static bool is_alone(const ll_netgame *g, int player)
{
    return !never_joined(g, player) && count_of(g, player, LL_METRIC_REMOTE_ERROR) == 0;
}

static const struct reason {
    bool (*holds)(const ll_netgame *g, int player);
    const char *what; /* after the players' names */
} reasons[] = {
    {never_joined, "never joined: what is drawn there stands still, and errors against its own time "
                   "(own_timeline_error_m, timeline_error_m) mean nothing."},
    {touched_nothing, "did not change the controls from warmup_s on: latencies of such changes "
                      "(input_latency_ms, confirmed_latency_ms, seen_latency_ms) are null."},
    {is_alone, "had no other player in view from warmup_s on: metrics of the others (remote_error_m, "
               "timeline_error_m, view_age_ms) are null."},
};

/* `A`, `A and B`, `A, B and 5 others`; returns their number. */
static int name_players(const ll_netgame *g, const struct reason *reason, char *out, size_t size)
{
    int count = 0, named = 0;
    size_t used = 0;
    for (int i = 0; i < g->config.player_count; i++)
        count += reason->holds(g, i);
    int most = count > NAMED ? NAMED - 1 : count;
    out[0] = '\0';
    for (int i = 0; i < g->config.player_count && named < most; i++) {
        if (!reason->holds(g, i))
            continue;
        const char *between = named == 0 ? "" : named + 1 == count ? " and " : ", ";
        int length = snprintf(out + used, size - used, "%s%s", between, g->config.players[i].name);
        used += (size_t)length < size - used ? (size_t)length : size - used - 1;
        named++;
    }
    if (named < count)
        snprintf(out + used, size - used, " and %d others", count - named);
    return count;
}

void ll_netgame_add_notices(const ll_netgame *g, cJSON *metrics)
{
    cJSON *notices = ll_netgame_notices(&g->config);
    bool begun = ll_to_s(g->now) > g->config.warmup_s;
    char names[160];
    if (!begun && g->config.warmup_s > 0 && cJSON_GetArraySize(notices) == 0)
        add_notice(notices, "Metrics count from warmup_s, %g s, on; it is %g s.", g->config.warmup_s,
                   ll_to_s(g->now));
    for (size_t i = 0; begun && i < sizeof reasons / sizeof reasons[0]; i++)
        if (name_players(g, &reasons[i], names, sizeof names) > 0)
            add_notice(notices, "%s %s", names, reasons[i].what);
    cJSON_AddItemToObject(metrics, "notices", notices);
}
