/* Shared by the tests of this room: a game that can be computed in the head, a client in a set-up, and
 * packets made by hand.
 *
 * The toy's rule: a step moves entity i by its first axis, in metres, for any length of the step. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "netcode/server/server.h"
#include "netcode/state/client.h"

#define HZ(f) ((ll_freq)(f)*1000)

static inline ll_extent toy_extent(const void *params, int players)
{
    (void)params;
    return (ll_extent){players, 8};
}

static inline void toy_step_own(ll_world *world, const ll_game_env *env, int player, const ll_action *action)
{
    (void)env;
    world->entity[player].x += (double)action->axis[0];
    world->entity[player].vx = (double)action->axis[0];
}

static inline void toy_step(ll_world *world, const ll_game_env *env, const ll_action *actions, ll_time now,
                            const ll_past *past)
{
    (void)now, (void)past;
    for (int i = 0; i < world->players; i++)
        toy_step_own(world, env, i, &actions[i]);
}

static const ll_game toy = {.name = "toy", .extent = toy_extent, .step = toy_step, .step_own = toy_step_own};

static inline ll_action push(double x)
{
    return (ll_action){.axis = {(float)x, 0}};
}

static inline ll_world *new_world(int players)
{
    ll_world *world = calloc(1, ll_extent_size(toy_extent(NULL, players)));
    world->players = world->entities = players;
    world->tail = 8;
    return world;
}

/* ---- a server ---- */

/* Takes its configuration from NULL-terminated "row=value" pairs, other rows from the defaults. */
static inline void configure(ll_server *server, const char *const *sets)
{
    ll_server_config rules;
    ll_param_defaults(&ll_server_table, &rules);
    for (; sets && *sets; sets++) {
        char row[64];
        const char *equals = strchr(*sets, '=');
        memcpy(row, *sets, (size_t)(equals - *sets));
        row[equals - *sets] = '\0';
        ll_status status = ll_param_set(&ll_server_table, &rules, row, equals + 1, false);
        assert_false(ll_failed(&status));
    }
    ll_server_configure(server, &rules);
}

static inline ll_server *new_server(int players, const ll_sync_mode *sync, double step_hz, double client_hz)
{
    size_t size = ll_extent_size(toy_extent(NULL, players));
    ll_extent extent = toy_extent(NULL, players);
    ll_server *server = malloc(ll_server_size(players, extent));
    ll_world *world = new_world(players);
    (void)sync;
    ll_server_init(server, players, extent);
    configure(server, NULL);
    memcpy(ll_server_world(server), world, size);
    ll_server_start(server, ll_freq_from_hz(step_hz), ll_freq_from_hz(30), ll_freq_from_hz(client_hz), 0);
    for (int i = 0; i < players; i++)
        server->client_slots[i].connection.connected = 1;
    free(world);
    return server;
}

/* A packet of inputs seq = tick, tick + 1, ... that push by `pushes`. */
static inline ll_input_message inputs(int64_t tick, int count, const double *pushes)
{
    ll_input_message m = {.head = {LL_MESSAGE_INPUT, (uint8_t)count, 1, (uint32_t)tick},
                          .tick = (int32_t)tick,
                          .fresh = (uint8_t)count};
    for (int i = 0; i < count; i++)
        m.inputs[i] = push(pushes[i]);
    return m;
}

/* ---- a client ---- */

typedef struct lone {
    ll_client *client;
    ll_player_config config;
    ll_server_config rules;
    ll_client_metrics *client_metrics;
    ll_game_env env;
    ll_client_setup setup;
    int players;
} lone;

/* A client of player 0, controlled by a person, at rest at x = 0; `hz` frames per second from time 0 on. */
static inline lone *new_lone(int players, const ll_game *game, const ll_sync_mode *sync)
{
    lone *l = calloc(1, sizeof *l);
    ll_world *world = new_world(players);
    ll_extent extent = toy_extent(NULL, players);
    l->players = players;
    l->client = malloc(ll_client_size(extent));
    l->client_metrics = malloc(ll_client_metrics_size(players));
    ll_param_defaults(&ll_player_table, &l->config);
    ll_param_defaults(&ll_server_table, &l->rules);
    l->config.control = LL_CONTROL_PERSON;
    l->config.clock_phase = 0;
    ll_client_metrics_init(l->client_metrics, players, 0);
    l->setup = (ll_client_setup){.game = game,
                                 .env = &l->env,
                                 .sync = sync,
                                 .config = &l->config,
                                 .client_metrics = l->client_metrics,
                                 .rules = &l->rules};
    ll_client_init(l->client, 0, world);
    free(world);
    return l;
}

/* The clock that the handshake would have measured over the configured link. */
static inline void measure_clock(lone *l, ll_time now)
{
    ll_connection *n = &l->client->connection;
    const ll_link_params *up = &l->config.link.up;
    ll_time way = ll_ms(l->config.lag_ms + up->delay_ms + up->jitter_ms);
    n->state = LL_CONNECTION_PLAYING;
    n->clock.count = 0;
    ll_clock_sync_add(&n->clock, ll_clock_filters[0], now - 2 * way, now - way, now, true);
}

static inline void start_lone(lone *l, double hz, int64_t step, ll_time now)
{
    ll_world *world = new_world(l->players);
    if (!ll_connection_plays(&l->client->connection))
        measure_clock(l, now);
    ll_client_start(l->client, &l->setup,
                    &(ll_client_begin){.epoch = 1, .freq = ll_freq_from_hz(hz), .step = step, .world = world},
                    now);
    free(world);
}

static inline void free_lone(lone *l)
{
    free(l->client_metrics);
    free(l->client);
    free(l);
}

/* A snapshot with the players at `x`. */
typedef struct packet {
    ll_snapshot_message head;
    int32_t world_players, world_entities, world_tail, reserved; /* as in ll_world */
    ll_entity entity[LL_PLAYERS_MAX];
    char tail[64];
} packet;

static inline packet state_of(int64_t tick, ll_time time, uint32_t acked, int players, const double *x)
{
    packet p = {.head = {.head = {.type = LL_MESSAGE_SNAPSHOT, .epoch = 1, .seq = acked},
                         .tick = tick,
                         .time = time,
                         .applied = acked,
                         .update_hz = 30,
                         .slack = LL_SLACK_UNKNOWN},
                .world_players = players,
                .world_entities = players,
                .world_tail = 8};
    for (int i = 0; i < players; i++)
        p.entity[i].x = x[i];
    return p;
}

static inline int size_of(const packet *p)
{
    return (int)(sizeof p->head + ll_extent_size((ll_extent){p->world_entities, p->world_tail}));
}

static inline int give(lone *l, const packet *p, ll_time now)
{
    return ll_client_receive(l->client, &l->setup, p, size_of(p), now);
}

/* The observer sees that the server applied inputs `first` to `last` in step `tick`. */
static inline void server_applies(lone *l, uint32_t first, uint32_t last, int64_t tick)
{
    ll_input_history *input_history = &l->client_metrics->input_history;
    for (uint32_t seq = first; seq <= last; seq++)
        ll_input_history_received(input_history, seq, LL_INPUT_HISTORY_IN_TIME);
    ll_input_history_applied(input_history, tick, 0, 0);
}

static inline int frame(lone *l, ll_time now, ll_input_message *m)
{
    ll_input_message unused;
    int size = l->setup.sync->tick(l->client, &l->setup, now, m != NULL ? m : &unused);
    l->setup.sync->display(l->client, &l->setup, now);
    return size;
}
