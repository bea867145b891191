/* Shared by the files of a netgame: its packets, its observer, and the loop over its events. */
#pragma once

#include "sim/netgame/netgame.h"

#define LL_NETGAME_PACKET_MAX (LL_GAME_WORLD_MAX + 512)

static inline void ll_netgame_record(const ll_recorder *r, ll_event event)
{
    if (r)
        r->record(r->context, &event);
}

static inline ll_freq ll_netgame_rate(const ll_netgame *g, bool at_update_hz)
{
    return ll_freq_from_hz(at_update_hz ? g->config.server.update_hz : g->config.tick_hz);
}

/* run.c: the set-up of the client of player `i` */
ll_client_setup ll_netgame_client_setup(const ll_netgame *g, int i, const ll_recorder *recorder);

/* Every event up to and including `until`; LL_DIVERGED where the server's world, or a client's view,
 * is not finite */
ll_status ll_netgame_run_until(ll_netgame *g, ll_time until, const ll_recorder *r, ll_pace *pace);

/* packets.c: sends and receives packets, and applies their effects on both sides */
void ll_netgame_send(ll_netgame *g, int player, bool up, const void *packet, int bytes, const ll_recorder *r);
void ll_netgame_update(ll_netgame *g, const ll_recorder *r); /* to all connected players */
void ll_netgame_check_connections(ll_netgame *g,
                                  const ll_recorder *r); /* the server checks its connections */
void ll_netgame_deliver_up(ll_netgame *g, int player, const ll_recorder *r);
void ll_netgame_deliver_down(ll_netgame *g, int player, const ll_client_setup *s);
void ll_netgame_deliver_held(ll_netgame *g, int player,
                             const ll_client_setup *s); /* by the de-jitter buffer */

/* observe.c: measurements that need a view of all actors */
void ll_netgame_record_shot(void *game, const ll_hit_result *hit_result); /* a shot was judged */
void ll_netgame_watch_players(ll_netgame *g, ll_time since);              /* after a step: gain of cheats */
/* Before a change to `next`: the gain of players that start to cheat counts from here on. */
void ll_netgame_watch_cheats_begin(ll_netgame *g, const ll_netgame_config *next);
void ll_netgame_observe_step(ll_netgame *g);
void ll_netgame_watch_tick(ll_netgame *g, int player, const ll_client_setup *s);
void ll_netgame_observe_display(ll_netgame *g, int player);
void ll_netgame_compare_views(ll_netgame *g, ll_time elapsed);
