#include <stddef.h>

#include "netcode/client/valid.h"
#include "netcode/server/valid.h"
#include "sim/netgame/netgame.h"

/* Packets are the only way: a client cannot know what the server has not done, nor the server what a client
 * has not. */
static const char *broken_knowledge(const ll_netgame *g, int player)
{
    const ll_client *c = ll_netgame_client(g, player);
    const ll_server *server = ll_netgame_server(g);
    const ll_client_slot *slot = &server->client_slots[player];
    if (c->snapshots.confirmed > server->step || c->snapshots.newest_tick > server->step)
        return "a client knows of a step that the server has not made";
    if (c->epoch != slot->connection.epoch)
        return NULL;
    if (c->inputs.acked > c->inputs.seq || slot->inputs.processed > c->inputs.seq)
        return "an input is applied that was not made";
    return slot->snapshots.received > c->snapshots.newest_tick && c->snapshots.received > 0 &&
                   slot->snapshots.received > c->snapshots.confirmed
               ? "the server counts on a snapshot that its client does not have"
               : NULL;
}

const char *ll_netgame_broken(const ll_netgame *g)
{
    const ll_server *server = ll_netgame_server(g);
    const char *broken = ll_server_broken(server);
    if (server->players != g->config.player_count || server->stepped > g->now)
        return "the server has other players, or a later step, than the game";
    for (int i = 0; i < server->players && broken == NULL; i++) {
        broken = ll_client_broken(ll_netgame_client(g, i), ll_netgame_sync(g)->drops_stale);
        if (broken == NULL)
            broken = broken_knowledge(g, i);
    }
    return broken;
}
