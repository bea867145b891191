/* The worlds of a netgame by tick, for tests of the peer-to-peer syncs. cmocka.h and what it needs come
 * before. */
#pragma once

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/hash.h"
#include "support/scene.h"

#define TICKS_MAX 40000

/* All worlds by tick, or their hashes: recorded when they are made, compared afterwards. */
typedef struct world_log {
    scene *s;
    int ticks;                        /* number of whole worlds that are kept */
    size_t size;                      /* of a world */
    int64_t seen[1 + LL_PLAYERS_MAX]; /* ticks recorded, of the server and of each client */
    uint64_t *hashes[1 + LL_PLAYERS_MAX];
    char *worlds[1 + LL_PLAYERS_MAX];
} world_log;

static inline void write_down(world_log *d, int whose, int64_t tick, const ll_world *world)
{
    assert_true(tick == d->seen[whose] + 1 && tick < TICKS_MAX);
    d->hashes[whose][tick] = ll_hash(1, world, d->size);
    if (tick < d->ticks)
        memcpy(d->worlds[whose] + (size_t)tick * d->size, world, d->size);
    d->seen[whose] = tick;
}

static inline void on_event(void *context, const void *row)
{
    const ll_event *event = row;
    world_log *d = context;
    ll_server *server = ll_netgame_server(d->s->game);
    if (event->type == LL_EVENT_STEP)
        write_down(d, 0, server->step, ll_server_world(server));
}

static inline world_log log_of(scene *s, int ticks)
{
    world_log d = {
        .s = s, .ticks = ticks, .size = ll_world_size(ll_server_world(ll_netgame_server(s->game)))};
    for (int i = 0; i <= s->game->config.player_count; i++) {
        d.hashes[i] = calloc(TICKS_MAX, sizeof *d.hashes[i]);
        d.worlds[i] = calloc((size_t)ticks + 1, d.size);
    }
    return d;
}

static inline void log_free(world_log *d)
{
    for (int i = 0; i <= LL_PLAYERS_MAX; i++) {
        free(d->hashes[i]);
        free(d->worlds[i]);
    }
}

static inline const ll_peer *peer_of(const scene *s, int player)
{
    return ll_client_peer(ll_netgame_client(s->game, player));
}

/* Continues frame by frame. */
static inline void run(world_log *d, double from_s, double until_s)
{
    ll_recorder r = {.record = on_event, .context = d};
    for (int64_t k = (int64_t)(from_s * 60) + 1; k <= (int64_t)(until_s * 60); k++) {
        scene_run(d->s, (double)k / 60 + 1e-6, &r);
        for (int p = 0; p < d->s->game->config.player_count; p++)
            while (d->seen[1 + p] < peer_of(d->s, p)->confirmed) {
                int64_t tick = d->seen[1 + p] + 1;
                write_down(d, 1 + p, tick, ll_peer_world(ll_netgame_client(d->s->game, p), tick));
            }
    }
}

static inline void set_loss(scene *s, int player, double percent)
{
    ll_netgame_config config = scene_config(s->game);
    config.players[player].link.up.loss_pct = percent;
    s->scenario.kind->change(s->game, &config, s->game->now);
}

static const char *const peer_syncs[] = {"server.sync=deterministic", "server.sync=rollback"};
