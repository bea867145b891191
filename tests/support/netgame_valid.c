#include "support/netgame_valid.h"

#include <stddef.h>
#include <string.h>

/* ---- a client ---- */

static const char *broken_inputs(const ll_client *c)
{
    if (c->inputs.acked > c->inputs.seq || c->inputs.newest_sent > c->inputs.seq)
        return "an input is acknowledged or sent that was not made";
    uint32_t open =
        c->inputs.seq - c->inputs.acked < LL_PENDING_RING ? c->inputs.seq - c->inputs.acked : LL_PENDING_RING;
    for (uint32_t i = 0; i < open; i++) {
        const ll_pending_input *p = &c->pending[(c->inputs.seq - i) & (LL_PENDING_RING - 1)];
        if (p->seq != 0 && p->seq != c->inputs.seq - i)
            return "an open input is not in its place of the ring";
    }
    for (int i = 0; i < LL_PENDING_RING; i++)
        if (c->pending[i].seq > c->inputs.seq || c->pending[i].state > LL_INPUT_SKIPPED)
            return "the ring has an input that was not made, or an unknown state of one";
    return c->inputs.refused < 0 || c->ticks.skipped < 0 ? "a count is negative" : NULL;
}

static const char *broken_snapshots(const ll_client *c, bool in_order)
{
    if (c->snapshots.used < 0 || c->snapshots.used > c->snapshots.received ||
        c->drawing.received > c->snapshots.received)
        return "more snapshots are used than were received";
    int64_t at = ll_client_oldest(c);
    for (int64_t i = at + 1; i < c->snapshots.received; i++) {
        const ll_snapshot_entry *before = ll_client_state((ll_client *)(uintptr_t)c, i - 1);
        const ll_snapshot_entry *entry = ll_client_state((ll_client *)(uintptr_t)c, i);
        if (in_order && entry->tick <= before->tick)
            return "snapshots are not in the order of their ticks";
        if (entry->arrived < before->arrived)
            return "snapshots are not in the order of their arrival";
    }
    return c->snapshots.stale < 0 || c->snapshots.unreadable < 0 ? "a count is negative" : NULL;
}

static const char *broken_layout(const ll_client *c)
{
    const int64_t at[] = {sizeof *c,          c->layout.latest,     c->layout.predicted, c->layout.checked,
                          c->layout.rendered, c->layout.draw_infos, c->layout.errors,    c->layout.states};
    for (size_t i = 1; i < sizeof at / sizeof at[0]; i++)
        if (at[i] < at[i - 1] || at[i] % 8 != 0)
            return "the parts of the block overlap, or are not aligned";
    return (int64_t)ll_world_size(ll_client_rendered_const(c)) != c->layout.world_size
               ? "the rendered world has another size than the game's"
               : NULL;
}

/* `in_order`: snapshots that come after a newer one are dropped. */
static const char *broken_client(const ll_client *c, bool in_order)
{
    const char *broken = broken_layout(c);
    if (c->self < 0 || c->self >= LL_PLAYERS_MAX)
        return "the client is no player's";
    if (c->view.state > LL_VIEW_EXTRAPOLATING || c->view.has_render > 1 || c->view.underrun > 1 ||
        c->view.held > 1)
        return "a state of the view is unknown";
    if (broken == NULL)
        broken = broken_inputs(c);
    return broken ? broken : broken_snapshots(c, in_order);
}

/* ---- the server ---- */

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

static const char *broken_server(const ll_server *server)
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

/* ---- both ---- */

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

const char *netgame_broken(const ll_netgame *g)
{
    const ll_server *server = ll_netgame_server(g);
    const char *broken = broken_server(server);
    if (server->players != g->config.player_count || server->stepped > g->now)
        return "the server has other players, or a later step, than the game";
    for (int i = 0; i < server->players && broken == NULL; i++) {
        broken = broken_client(ll_netgame_client(g, i), ll_netgame_sync(g)->drops_stale);
        if (broken == NULL)
            broken = broken_knowledge(g, i);
        if (broken == NULL)
            broken = broken_recent(g, i);
    }
    return broken;
}
