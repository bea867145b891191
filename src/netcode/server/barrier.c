#include "netcode/server/barrier.h"

#include "base/assert.h"

static int64_t newest(const ll_server *server, const ll_client_slot *client_slot)
{
    return client_slot->inputs.newest < 0 ? server->clock.k0 : client_slot->inputs.newest;
}

static ll_time way_of(const ll_peer_message *m)
{
    return (ll_time)(m->way & ~LL_WAY_GAP) * 1000;
}

/* Whether the player's packets had stopped before this one. The first one counts as sent when the game
 * began. */
static bool stopped(const ll_server *server, const ll_peer_status *peer, const ll_peer_message *m,
                    ll_time now)
{
    ll_time since = now - peer->came - (peer->way == 0 ? way_of(m) : 0);
    return since > 2 * ll_tick_time(1, server->client_freq) + LL_BARRIER_GAP;
}

#define NO_PLAYER (-1)

/* The newest tick that a client may have made an input for before it learns of a barrier. It knows the
 * others' inputs as far as relays have reported them, guesses as far as it may, and its inputs are ahead of
 * its tick by its input delay. A client that has just been accepted knows what it started with; the next
 * relay also reports the barrier to it. */
static int64_t newest_possible(const ll_server *server, const ll_sync_mode *sync, int player, int newcomer)
{
    const ll_client_slot *client_slot = &server->client_slots[player];
    int64_t own = newest(server, client_slot), known = LL_NEVER;
    int64_t delay = client_slot->peer.at >= 0 && own > client_slot->peer.at ? own - client_slot->peer.at : 1;
    for (int p = 0; p < server->players; p++) {
        int64_t reported = server->client_slots[p].peer.relayed,
                acknowledged = client_slot->peer.acks[p].known;
        reported = acknowledged > reported || player == newcomer ? acknowledged : reported;
        if (p != player && reported < known)
            known = reported;
    }
    if (known == LL_NEVER)
        return own; /* it plays alone */
    known += (sync->guesses ? server->barriers.rollback : 0) + delay;
    return known > own ? known : own;
}

/* Of all connected players: their number, the farthest reach, the newest input, and the oldest of their
 * newest inputs. */
typedef struct summary {
    int connected;
    int64_t newest_possible, newest, oldest;
} summary;

static summary summarise(const ll_server *server, const ll_sync_mode *sync, int newcomer)
{
    summary a = {.oldest = LL_NEVER};
    for (int p = 0; p < server->players; p++) {
        if (!server->client_slots[p].connection.connected)
            continue;
        int64_t far = newest_possible(server, sync, p, newcomer),
                tick = newest(server, &server->client_slots[p]);
        a.connected++;
        a.newest_possible = far > a.newest_possible ? far : a.newest_possible;
        a.newest = tick > a.newest ? tick : a.newest;
        a.oldest = tick < a.oldest ? tick : a.oldest;
    }
    return a;
}

/* Whether all inputs up to the barrier's tick have arrived: the next relays bring them to all clients. */
static bool all_inputs_arrived(const ll_server *server)
{
    for (int p = 0; p < server->players; p++) {
        const ll_peer_status *peer = &server->client_slots[p].peer;
        if (!server->client_slots[p].connection.connected)
            continue;
        if (peer->at < 0 || newest(server, &server->client_slots[p]) != server->barriers.tick)
            return false;
    }
    return true;
}

#define TICKS_MAX 1024 /* at usual rates a tick coincides with an update within this many ticks */

/* The next tick that coincides with an update, counted since the game began, and by which all clients have
 * made the barrier's tick with the inputs of the next update's relays. */
static int64_t next_start(const ll_server *server)
{
    ll_freq ticks = server->clock.freq, updates = server->updates.freq;
    ll_time longest = 0;
    for (int p = 0; p < server->players; p++) {
        const ll_peer_status *peer = &server->client_slots[p].peer;
        ll_time ready = peer->way + (peer->at < server->barriers.tick ? ll_tick_time(1, ticks) : 0);
        if (server->client_slots[p].connection.connected && ready > longest)
            longest = ready;
    }
    ll_time reported = ll_clock_time(&server->updates, server->update) + longest;
    int64_t tick = ll_tick_at(reported - server->clock.epoch, ticks) + 1;
    for (int i = 0; i < TICKS_MAX; i++)
        if ((tick + i) * updates % ticks == 0)
            return tick + i;
    return tick;
}

/* Discards the time sync data received so far. */
static void set_resume(ll_server *server)
{
    server->barriers.resume = next_start(server);
    LL_ASSERT(server->barriers.resume > 0); /* 0 is: not decided */
    server->barriers.recovery_until =
        server->clock.epoch + ll_tick_time(server->barriers.resume, server->clock.freq) + LL_BARRIER_EVERY;
    for (int p = 0; p < server->players; p++) {
        ll_peer_status *peer = &server->client_slots[p].peer;
        peer->at = -1;
        for (int other = 0; other < server->players; other++)
            peer->acks[other].ahead = 0;
    }
}

/* Begins, continues or ends a barrier. */
static void update_barrier(ll_server *server, const ll_sync_mode *sync, int newcomer, ll_time now)
{
    if (server->barriers.tick == 0 && (!server->barriers.due || now < server->barriers.recovery_until))
        return;
    summary a = summarise(server, sync, newcomer);
    if (server->barriers.resume != 0) {
        if (a.oldest > server->barriers.tick ||
            newcomer != NO_PLAYER) /* a client that is in step with no other: the next barrier begins */
            server->barriers.tick = server->barriers.resume = 0;
        if (newcomer == NO_PLAYER)
            return;
    }
    server->barriers.due = 0;
    if (a.connected < 2) {
        server->barriers.tick = 0;
        return;
    }
    if (server->barriers.tick == 0 || a.newest > server->barriers.tick) {
        server->barriers.tick = a.newest_possible;
        LL_ASSERT(server->barriers.tick >= a.newest); /* no client has passed it */
    } else if (newcomer != NO_PLAYER) {
        int64_t far = newest_possible(server, sync, newcomer, newcomer);
        server->barriers.tick = far > server->barriers.tick ? far : server->barriers.tick;
    }
    if (all_inputs_arrived(server))
        set_resume(server);
}

void ll_barrier_follow(ll_server *server, const ll_sync_mode *sync, int player, const ll_peer_message *m,
                       ll_time now)
{
    ll_peer_status *peer = &server->client_slots[player].peer;
    if (!ll_barrier_waits(server, m->tick + m->head.count - 1))
        server->barriers.due |= (m->way & LL_WAY_GAP) != 0 || stopped(server, peer, m, now);
    peer->way = way_of(m);
    peer->came = now;
    update_barrier(server, sync, NO_PLAYER, now);
}

void ll_barrier_join(ll_server *server, const ll_sync_mode *sync, int player, ll_time now)
{
    server->barriers.due = 1;
    server->barriers.recovery_until = now; /* without LL_BARRIER_EVERY since the last barrier */
    update_barrier(server, sync, player, now);
}
