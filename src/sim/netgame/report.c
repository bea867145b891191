/* Reports of a netgame: state, metrics, layout and the columns of a trace. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/detmath.h"
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
        number(p, "input_seq", c->seq);
        number(p, "acked_seq", c->acked);
        number(p, "unacked", c->seq - c->acked);
        for (int k = 0; k < ll_netgame_entities(g); k++) {
            cJSON *e = entity_json(&ll_client_rendered_const(c)->entity[k]);
            number(e, "age_ms", ll_to_ms(g->now - ll_client_draw_infos_const(c)[k].time));
            cJSON_AddItemToArray(shown, e);
        }
        cJSON_AddItemToObject(p, "entities", shown);
        double values[LL_GAME_VALUES];
        game->describe(ll_server_world_const(server), &g->env, i, values);
        for (int k = 0; game->values[k]; k++)
            number(p, game->values[k], values[k]);
        cJSON_AddItemToArray(players, p);
    }
    return state;
}

/* Time over which rates count. */
static double measured_s(const ll_netgame *g, const ll_client_metrics *in)
{
    return g->now > in->from ? ll_to_s(g->now - in->from) : 0;
}

static double ratio(double a, double b)
{
    return ll_netgame_ratio(a, b);
}

static void bandwidth(cJSON *player, const ll_netgame *g, int self)
{
    static const char *const names[LL_MESSAGES] = {NULL,      "input",  "state", "refusal", "relay",
                                                   "connect", "accept", "ping",  "pong"};
    static const bool ups[LL_MESSAGES] = {
        [LL_MESSAGE_INPUT] = true, [LL_MESSAGE_CONNECT] = true, [LL_MESSAGE_PING] = true};
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    double seconds = measured_s(g, in), up = 0, down = 0;
    cJSON *o = cJSON_AddObjectToObject(player, "bandwidth");
    for (int type = LL_MESSAGE_INPUT; type < LL_MESSAGES; type++) {
        double wire = (double)in->wire_bytes[type];
        cJSON *m = cJSON_AddObjectToObject(o, names[type]);
        number(m, "messages_per_s", ratio((double)in->messages[type], seconds));
        number(m, "packets_per_s", ratio((double)in->packets[type], seconds));
        number(m, "payload_bytes_per_s", ratio((double)in->bytes[type], seconds));
        number(m, "wire_bytes_per_s", ratio(wire, seconds));
        *(ups[type] ? &up : &down) += wire;
    }
    number(o, "up_bytes_per_s", ratio(up, seconds));
    number(o, "down_bytes_per_s", ratio(down, seconds));
}

static void snapshots(cJSON *player, const ll_netgame *g, int self)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, self);
    const ll_snapshot_cost *sent = &ll_netgame_server(g)->client_slots[self].sent;
    double states = (double)in->messages[LL_MESSAGE_SNAPSHOT], entities = (double)sent->entities;
    size_t full = sizeof(ll_snapshot_message) + ll_world_size(ll_server_world_const(ll_netgame_server(g)));
    cJSON *o = cJSON_AddObjectToObject(player, "snapshot");
    number(o, "bits_per_entity", ratio((double)sent->entity_bits, entities));
    number(o, "tail_bits", ratio((double)sent->tail_bits, states));
    number(o, "unchanged_ratio", ratio((double)sent->unchanged, entities));
    number(o, "at_rest_ratio", ratio((double)sent->resting, entities));
    number(o, "full_ratio", ratio((double)sent->whole, states));
    number(o, "bytes_over_full", ratio((double)in->bytes[LL_MESSAGE_SNAPSHOT], states * (double)full));
    number(o, "undecodable", (double)ll_netgame_client(g, self)->unreadable);
}

static void loss_report(cJSON *o, const ll_link_stats *s)
{
    number(o, "lost", (double)s->lost);
    number(o, "loss_pct", ll_link_loss_pct(s));
    number(o, "loss_bursts", (double)s->loss_bursts);
    number(o, "loss_burst_mean_packets", ratio((double)(s->lost - s->lost_copies), (double)s->loss_bursts));
    number(o, "lost_in_blackouts", (double)s->lost_in_blackouts);
    number(o, "rescued", (double)s->rescued);
}

static void message_report(cJSON *o, const ll_link_stats *s)
{
    double messages = (double)ll_link_messages(s);
    number(o, "messages", messages);
    number(o, "messages_lost", (double)s->messages_lost);
    number(o, "message_loss_pct", 100 * ratio((double)s->messages_lost, messages));
    number(o, "split", (double)s->split);
    number(o, "split_lost", (double)s->split_lost);
    number(o, "fragments", (double)s->fragments);
    number(o, "fragments_lost", (double)s->fragments_lost);
}

static void delay_report(cJSON *o, const ll_link_stats *s)
{
    double n = (double)ll_link_put_on_way(s), mean = ratio(s->delay_sum_ms, n);
    double variance = ratio(s->delay_sum_squares, n) - mean * mean;
    number(o, "delay_mean_ms", mean);
    number(o, "delay_sd_ms", variance > 0 ? ll_sqrt(variance) : 0 * variance);
    number(o, "delay_min_ms", n > 0 ? s->delay_min_ms : NAN);
    number(o, "delay_max_ms", n > 0 ? s->delay_max_ms : NAN);
    number(o, "delay_corr_pct", 100 * ll_link_delay_correlation(s));
}

static void link_report(cJSON *player, const char *name, const ll_link *link)
{
    const ll_link_stats *s = ll_link_get_stats(link);
    cJSON *o = cJSON_AddObjectToObject(player, name);
    number(o, "sent", (double)s->sent);
    number(o, "delivered", (double)s->delivered);
    loss_report(o, s);
    message_report(o, s);
    number(o, "duplicated", (double)s->duplicated);
    number(o, "corrupted", (double)s->corrupted);
    number(o, "overflowed", (double)s->overflowed);
    number(o, "reordered", (double)s->reordered);
    number(o, "reordered_ahead", (double)s->reordered_ahead);
    delay_report(o, s);
    number(o, "queue_mean_ms", ratio(s->queue_sum_ms, (double)s->queued));
    number(o, "queue_max_ms", s->queue_max_ms);
    number(o, "queue_drops", (double)s->queue_drops);
}

static void distributions(cJSON *o, const ll_client_metrics *in)
{
    for (int m = 0; m < LL_METRICS; m++) {
        ll_summary summary = ll_histogram_summary(&in->histogram[m]);
        ll_netgame_distribution(o, ll_metric_rows[m].name, summary);
        if (m < LL_LATENCIES)
            number(cJSON_GetObjectItem(o, ll_metric_rows[m].name), "lost_ratio",
                   ratio((double)in->changes.lost[m], (double)summary.count));
    }
    ll_netgame_running_stats(o, "own_lead_ms", &in->rendered_views.leads_ms, 1);
    number(o, "own_pictures_void", (double)in->rendered_views.voided);
}

/* Assumed display for visible corrections: 24 inches, 1920 pixels, at a distance of 0.6 m. */
#define ARCMIN_PER_PX 1.59

static void corrections(cJSON *o, const ll_client_metrics *in, double seconds)
{
    double px = in->pixel_m > 0 ? 1 / in->pixel_m : NAN;
    number(o, "corrections", (double)in->corrections);
    number(o, "corrections_per_s", ratio((double)in->corrections, seconds));
    number(o, "visible_corrections", (double)in->visible_m_all.count);
    number(o, "visible_corrections_per_s", ratio((double)in->visible_m_all.count, seconds));
    ll_netgame_running_stats(o, "visible_correction_m", &in->visible_m_all, 1);
    ll_netgame_running_stats(o, "visible_correction_px", &in->visible_m_all, px);
    ll_netgame_running_stats(o, "visible_correction_arcmin", &in->visible_m_all, px * ARCMIN_PER_PX);
}

static cJSON *player_metrics(const ll_netgame *g, int i)
{
    const ll_client_metrics *in = ll_netgame_client_metrics(g, i);
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[i];
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", g->config.players[i].name);
    distributions(o, in);
    corrections(o, in, measured_s(g, in));
    ll_netgame_view_metrics(g, i, o);
    ll_netgame_peer_metrics(o, g, i);
    ll_netgame_connection_metrics(g, i, o);
    cJSON *inputs = cJSON_AddObjectToObject(o, "inputs");
    number(inputs, "accepted", (double)client_slot->accepted);
    number(inputs, "duplicate", (double)client_slot->duplicate);
    number(inputs, "starved_steps", (double)client_slot->starved);
    number(inputs, "slack_ticks",
           client_slot->last_slack == LL_SLACK_UNKNOWN ? NAN : (double)client_slot->last_slack);
    cJSON *refused = cJSON_AddObjectToObject(inputs, "refused");
    for (int rule = 1; rule < LL_RULES; rule++)
        number(refused, ll_rule_names[rule], (double)client_slot->refused[rule]);
    ll_netgame_inputs_metrics(g, i, o);
    ll_netgame_shots_metrics(g, i, o);
    bandwidth(o, g, i);
    snapshots(o, g, i);
    link_report(o, "link_up", ll_netgame_up(g, i));
    link_report(o, "link_down", ll_netgame_down(g, i));
    double values[LL_GAME_VALUES];
    const ll_game *game = ll_netgame_game(g);
    game->describe(ll_server_world_const(ll_netgame_server(g)), &g->env, i, values);
    cJSON *own = cJSON_AddObjectToObject(o, "game");
    for (int k = 0; game->values[k]; k++)
        number(own, game->values[k], values[k]);
    return o;
}

/* Length of the present wait. */
static ll_time stalling(const ll_netgame *g)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    const ll_server *server = ll_netgame_server(g);
    ll_time beyond = g->now - server->stepped - ll_tick_time(1, server->clock.freq);
    return (sync->waits || sync->observe) && beyond > 0 ? beyond : 0;
}

cJSON *ll_netgame_metrics(const void *block)
{
    const ll_netgame *g = block;
    const ll_server *server = ll_netgame_server(g);
    cJSON *metrics = cJSON_CreateObject(), *s = cJSON_AddObjectToObject(metrics, "server");
    cJSON_AddStringToObject(s, "sync", ll_netgame_sync(g)->name);
    number(s, "steps", (double)server->step);
    number(s, "steps_per_s", ratio((double)server->step, ll_to_s(g->now)));
    number(s, "stalled_s", ll_to_s(server->stalled + stalling(g)));
    ll_netgame_slowest(s, g);
    cJSON_AddStringToObject(s, "snapshot", ll_codec_names[server->codec]);
    ll_netgame_distribution(s, "rounding_m", ll_rounding_summary(ll_server_baseline_history(server)));
    cJSON *players = cJSON_AddArrayToObject(metrics, "players");
    for (int i = 0; i < server->players; i++)
        cJSON_AddItemToArray(players, player_metrics(g, i));
    ll_netgame_add_fairness(g, s, players);
    ll_netgame_add_notices(g, metrics);
    return metrics;
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
    for (int k = 0; game->values[k]; k++)
        cJSON_AddItemToArray(values, cJSON_CreateString(game->values[k]));
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
        values[n++] = in->own_lead;
        values[n++] = in->rendered_views.lead_ms;
        values[n++] = in->remote_error;
        values[n++] = in->view_age;
        values[n++] = in->age_of_information;
        values[n++] = c->buffer_ms;
        values[n++] = c->seq - c->acked;
        values[n++] = (double)in->corrections;
        values[n++] = g->config.players[i].lag_ms;
        values[n++] = (double)ll_netgame_desync(g, i)->compared;
        values[n++] = ll_netgame_desync(g, i)->error;
        values[n++] = c->connection.state;
        values[n++] = server->client_slots[i].connected;
    }
    return n;
}
