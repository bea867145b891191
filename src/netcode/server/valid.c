#include "netcode/server/valid.h"

#include <stddef.h>

static const char *broken_counts(const ll_server *server, const ll_client_slot *slot)
{
    if (slot->counts.accepted < 0 || slot->counts.duplicate < 0 || slot->counts.late < 0 ||
        slot->counts.starved < 0 || slot->connection.joins < 0)
        return "a count of inputs is negative";
    if (slot->connection.drops > slot->connection.joins)
        return "a player left more often than it joined";
    return slot->snapshots.received > server->step ? "a client has a snapshot that was not made" : NULL;
}

static const char *broken_slot(const ll_server *server, const ll_client_slot *slot)
{
    if (slot->connection.connected > 1 || (slot->connection.connected && slot->connection.epoch == 0))
        return "a connected player has no epoch";
    if (slot->inputs.processed > slot->inputs.decided)
        return "an input is applied that has no result";
    for (int i = 0; i < LL_INPUT_RING; i++) {
        int64_t tick = slot->inputs.ring[i].tick;
        if (tick < -1 || (tick >= 0 && (tick & (LL_INPUT_RING - 1)) != i))
            return "an input is not in its place of the ring";
    }
    return broken_counts(server, slot);
}

const char *ll_server_broken(const ll_server *server)
{
    if (server->players < 1 || server->players > LL_PLAYERS_MAX)
        return "the server has an impossible number of players";
    if (server->step < 0 || server->update < 0 || server->stalled < 0)
        return "a count of steps, updates or waiting is negative";
    if (ll_codec_at(server->codec) == NULL || ll_server_world_const(server)->players != server->players)
        return "the encoding of snapshots or the world is not the game's";
    for (int i = 0; i < server->players; i++) {
        const char *broken = broken_slot(server, &server->client_slots[i]);
        if (broken)
            return broken;
    }
    return NULL;
}
