#include <stddef.h>
#include <string.h>

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

/* What a client notes of its newest snapshots: entities in the order of their newest snapshot, and since that
 * the same in all. */
static const char *broken_recent(const ll_netgame *g, int player)
{
    const ll_recent *r = ll_netgame_recent(g, player);
    ll_client *c = ll_netgame_client(g, player);
    int count = 0;
    int64_t last = INT64_MAX;
    if (!r || c->snapshots.received == 0)
        return NULL;
    for (int link = r->newest; link != 0 && count <= (int)r->entities; count++) {
        const int e = link - 1;
        int64_t since = r->entity[e].changed;
        if (since > last || since > c->snapshots.received)
            return "the newest snapshots that contain an entity are not in their order";
        last = since;
        since = since > ll_client_oldest(c) ? since : ll_client_oldest(c) + 1;
        const ll_world *at = ll_snapshot_entry_world(ll_client_state(c, since - 1));
        const ll_world *newest = ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 1));
        if (memcmp(&at->entity[e], &newest->entity[e], sizeof at->entity[e]) != 0)
            return "an entity has changed since the newest snapshot that contains it";
        link = r->entity[e].older;
    }
    return count == (int)r->entities ? NULL : "an entity is not in the list of the newest snapshots";
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
        if (broken == NULL)
            broken = broken_recent(g, i);
    }
    return broken;
}
