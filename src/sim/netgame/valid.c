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

/* What a client notes of its newest snapshots: an entity is the same in all since the newest that contains
 * it. */
static const char *broken_recent(const ll_netgame *g, int player)
{
    const ll_recent *r = ll_netgame_recent(g, player);
    ll_client *c = ll_netgame_client(g, player);
    ll_entity_bits since;
    if (!r || c->snapshots.received == 0)
        return NULL;
    if (r->newest != c->snapshots.received)
        return "a snapshot is not noted, or noted twice";
    const ll_world *newest = ll_snapshot_entry_world(ll_client_state(c, c->snapshots.received - 1));
    for (int64_t i = ll_client_oldest(c); i < c->snapshots.received; i++) {
        const ll_world *at = ll_snapshot_entry_world(ll_client_state(c, i));
        if (!ll_recent_since(r, i + 1, since))
            return "a snapshot that is kept is not noted";
        for (int e = 0; e < newest->entities; e++)
            if (!ll_entity_bits_have(since, e) &&
                memcmp(&at->entity[e], &newest->entity[e], sizeof at->entity[e]) != 0)
                return "an entity has changed without a snapshot that contains it";
    }
    return NULL;
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
