/* The observer of a netgame: it sees the server and every client, and compares them. */
#include <ctype.h>
#include <string.h>

#include "netcode/client/cheat.h"
#include "netcode/observe/player_observer.h"
#include "sim/netgame/parts.h"

/* A shot was judged in the present step of the server. */
void ll_netgame_record_shot(void *context, const ll_hit_result *j)
{
    ll_netgame *g = context;
    ll_server *server = ll_netgame_server(g);
    int64_t *refused = server->client_slots[j->shooter].counts.refused;
    bool on_player = j->body != LL_NOBODY && j->body < server->players;
    bool rules = !ll_netgame_sync(g)->observe; /* a relay server refuses nothing */
    refused[LL_RULE_FIRE_RATE] += rules && j->kind == LL_HIT_RESULT_VOID;
    refused[LL_RULE_REWIND] += rules && j->shot && j->shot->view_time_rejected;
    ll_sight victim = {.self = j->body};
    if (on_player)
        victim.shown = ll_client_rendered_const(ll_netgame_client(g, j->body));
    ll_shots_judge(ll_netgame_shots(g), j, server->step, ll_netgame_history(g), ll_server_world(server),
                   on_player ? &victim : NULL);
}

/* Measures the gain of cheats. A step stands for its length; an update that applies inputs on arrival, for
 * the time since the one before. */
void ll_netgame_watch_players(ll_netgame *g, ll_time since)
{
    const ll_world *world = ll_server_world(ll_netgame_server(g));
    bool drains = ll_netgame_sync(g)->applies_on_arrival;
    const ll_honest_stepped stepped = {world, ll_netgame_server(g)->step, g->now, drains};
    double elapsed_s = drains ? ll_to_s(since) : g->env.dt;
    for (int i = 0; i < world->players; i++) {
        if (g->config.players[i].cheat == LL_CHEAT_NONE)
            continue;
        ll_client_metrics *in = ll_netgame_client_metrics(g, i);
        ll_cheat_gain_step(&in->gain, ll_netgame_game(g), &g->env, &world->entity[i], elapsed_s);
        ll_honest_step(&in->honest, ll_netgame_game(g), &g->env, i, &stepped);
    }
}

void ll_netgame_watch_cheats_begin(ll_netgame *g, const ll_netgame_config *next)
{
    const ll_server *server = ll_netgame_server(g);
    for (int i = 0; i < g->config.player_count; i++) {
        ll_client_metrics *in = ll_netgame_client_metrics(g, i);
        if (g->config.players[i].cheat != LL_CHEAT_NONE || next->players[i].cheat == LL_CHEAT_NONE)
            continue;
        ll_cheat_gain_watch(&in->gain, &ll_server_world_const(server)->entity[i]);
        ll_honest_watch(&in->honest, &ll_server_world_const(server)->entity[i], server->stepped);
    }
}

/* A packet holds the inputs made since the last one and `redundancy` earlier ones; a lag switch keeps its
 * inputs back. */
static uint32_t unsent_from(const ll_netgame *g, int player)
{
    const ll_client *c = ll_netgame_client(g, player);
    uint32_t again = (uint32_t)g->config.players[player].redundancy;
    uint32_t from = c->inputs.seq > again ? c->inputs.seq - again + 1 : 1;
    return c->inputs.unsent != 0 && c->inputs.unsent < from ? c->inputs.unsent : from;
}

/* The observer sees the results of every player's inputs in the step. */
void ll_netgame_observe_step(ll_netgame *g)
{
    const ll_server *server = ll_netgame_server(g);
    for (int i = 0; i < server->players; i++) {
        ll_stepped stepped = {.world = ll_server_world_const(server),
                              .history = ll_netgame_history(g),
                              .step = server->step,
                              .acked = server->client_slots[i].inputs.acked,
                              .unsent_from = unsent_from(g, i),
                              .applies_on_arrival = ll_netgame_sync(g)->applies_on_arrival};
        ll_client_metrics_stepped(ll_netgame_client_metrics(g, i), i, &stepped, g->now);
    }
}

/* All clients have drawn: compares their views. */
void ll_netgame_compare_views(ll_netgame *g, ll_time elapsed)
{
    ll_client_metrics *client_metrics[LL_PLAYERS_MAX];
    const ll_client *clients[LL_PLAYERS_MAX];
    int n = g->config.player_count;
    if (!(ll_netgame_client_metrics(g, 0)->observes & LL_OBSERVE_CLIENTS))
        return;
    for (int i = 0; i < n; i++) {
        client_metrics[i] = ll_netgame_client_metrics(g, i);
        clients[i] = ll_netgame_client(g, i);
    }
    ll_client_metrics_between(client_metrics, clients, n, g->now, elapsed);
}

/* The input that an honest client would have sent in this tick. */
void ll_netgame_watch_tick(ll_netgame *g, int player, const ll_client_setup *s)
{
    ll_time due = g->now + ll_ms(s->config->lag_ms + s->config->link.up.delay_ms);
    (ll_cheat_minds(s) ? ll_honest_frame : ll_honest_frame_once)(
        &s->client_metrics->honest, ll_netgame_client(g, player)->inputs.tick, due);
}

/* A display of `player`: compares its view with the truth, and records which changes of the others' controls
 * it shows. */
void ll_netgame_observe_display(ll_netgame *g, int player)
{
    const ll_client *client = ll_netgame_client(g, player);
    const ll_server *server = ll_netgame_server(g);
    const ll_truth truth = {.world = ll_server_world_const(server),
                            .history = ll_netgame_history(g),
                            .device = ll_ms(g->config.players[player].display_device_ms),
                            .acked = server->client_slots[player].inputs.acked,
                            .applies_on_arrival = ll_netgame_sync(g)->applies_on_arrival,
                            .peers = ll_netgame_sync(g)->observe != NULL};
    ll_client_metrics_frame(ll_netgame_client_metrics(g, player), client, &truth, g->now);
    if (!(ll_netgame_client_metrics(g, player)->observes & LL_OBSERVE_INPUTS))
        return;
    ll_drawn_tick last = {LL_NEVER, 0};
    for (int i = 0; i < g->config.player_count; i++)
        if (i != player)
            ll_client_metrics_seen(ll_netgame_client_metrics(g, i), i, client, &truth, &last, g->now);
}

/* ---- what must be observed for a metric ---- */

typedef struct need {
    const char *begins; /* the path, or the part of it after `players.N.` */
    uint32_t observes;
} need;

/* The first row counts; for a path without a row everything is observed. */
static const need of_run[] = {
    {"server.fairness", LL_OBSERVE_ALL}, {"server.", 0}, {"cost.", 0}, {NULL, LL_OBSERVE_ALL}};

static const need of_player[] = {
    {"own_", LL_OBSERVE_VIEWS},
    {"remote_error_m", LL_OBSERVE_VIEWS},
    {"timeline_error_m", LL_OBSERVE_VIEWS},
    {"view_age_ms", LL_OBSERVE_VIEWS},
    {"age_of_information_ms", LL_OBSERVE_VIEWS},
    {"inconsistency.server", LL_OBSERVE_VIEWS},
    {"smoothness", LL_OBSERVE_VIEWS},
    {"buffer", LL_OBSERVE_VIEWS},
    {"inconsistency.clients", LL_OBSERVE_CLIENTS},
    {"input_latency_ms", LL_OBSERVE_INPUTS},
    {"confirmed_latency_ms", LL_OBSERVE_INPUTS},
    {"seen_latency_ms", LL_OBSERVE_INPUTS},
    {"ack_rtt_ms", LL_OBSERVE_INPUTS},
    {"inputs", LL_OBSERVE_INPUTS},
    {"acks", LL_OBSERVE_INPUTS},
    {"corrections_by_cause", LL_OBSERVE_INPUTS},
    {"correction", 0},
    {"visible_correction", 0},
    {"pop_m", 0},
    {"unacked", 0},
    {"replay", 0},
    {"bandwidth", 0},
    {"snapshot", 0},
    {"link_up", 0},
    {"link_down", 0},
    {"dejitter", 0},
    {"connection", 0},
    {"validation", 0},
    {"stalls", 0},
    {"rollback", 0},
    {"sync_test", 0},
    {"desync", 0},
    {"shots", 0},
    {"game", 0},
    {NULL, LL_OBSERVE_ALL},
};

static uint32_t look_up(const need *rows, const char *path)
{
    while (rows->begins && strncmp(path, rows->begins, strlen(rows->begins)) != 0)
        rows++;
    return rows->observes;
}

uint32_t ll_netgame_observed_for(const char *path)
{
    static const char players[] = "players.";
    if (strncmp(path, players, strlen(players)) != 0)
        return look_up(of_run, path);
    path += strlen(players);
    while (isdigit((unsigned char)*path))
        path++;
    return look_up(of_player, *path == '.' ? path + 1 : path);
}
