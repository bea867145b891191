#include "netcode/server/relay_server.h"

#include "base/assert.h"
#include "netcode/protocol/world_hash.h"
#include "netcode/server/barrier.h"

static const ll_input_slot *slot_of(const ll_client_slot *client_slot, int64_t tick)
{
    return &client_slot->inputs.ring[tick & (LL_INPUT_RING - 1)];
}

/* A player's inputs arrive without gaps; up to this tick they have arrived. */
static int64_t known(const ll_server *server, const ll_client_slot *client_slot)
{
    return client_slot->inputs.newest < 0 ? server->clock.k0 : client_slot->inputs.newest;
}

/* ---- steps ---- */

/* Several packets together complete whole ticks: the last of them makes the step due. */
ll_time ll_relay_server_due(const ll_server *server)
{
    int64_t k = server->step + 1;
    ll_time due = server->stepped;
    for (int i = 0; i < server->players; i++) {
        const ll_input_slot *slot = slot_of(&server->client_slots[i], k);
        if (slot->tick != k)
            return LL_NEVER;
        due = slot->came > due ? slot->came : due;
    }
    return due;
}

/* All clients step without a history, and so does the relay server: shots are judged against the present. */
static const ll_compensation no_compensation;

void ll_relay_server_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                          ll_time now)
{
    ll_action actions[LL_PLAYERS_MAX];
    int64_t k = ++server->step;
    LL_ASSERT(now >= server->stepped); /* the time of steps does not decrease */
    ll_time interval = ll_tick_time(1, server->clock.freq);
    if (now - server->stepped > interval)
        server->stalled += now - server->stepped - interval;
    for (int i = 0; i < server->players; i++) {
        ll_client_slot *client_slot = &server->client_slots[i];
        LL_ASSERT(slot_of(client_slot, k)->tick == k); /* no step without all inputs */
        actions[i] = client_slot->inputs.held = slot_of(client_slot, k)->action;
        if (k <= client_slot->connection.first)
            continue; /* not the player's own */
        client_slot->inputs.acked = (uint32_t)(k - client_slot->connection.first);
        ll_client_slot_done(client_slot, client_slot->inputs.acked, !ll_client_slot_replaced(client_slot, k));
    }
    if (past)
        past->rules = &no_compensation;
    /* The time of the tick, not the present: the result must not depend on when the inputs arrived. */
    game->step(ll_server_world(server), env, actions, ll_clock_time(&server->clock, k), past);
    server->hashes[k & (LL_HASH_RING - 1)] = ll_world_hash(ll_server_world(server));
    server->stepped = now;
}

/* ---- packets ---- */

static void take_acks(const ll_server *server, ll_peer_status *peer, const ll_peer_message *m,
                      const ll_peer_ack *acks)
{
    bool counts_for_time_sync = !ll_barrier_waits(server, m->tick + m->head.count - 1);
    for (int p = 0; p < server->players; p++) {
        if (acks[p].known > peer->acks[p].known)
            peer->acks[p].known = acks[p].known;
        if (m->at >= peer->at && counts_for_time_sync)
            peer->acks[p].ahead = acks[p].ahead;
    }
    if (m->at > peer->at && counts_for_time_sync)
        peer->at = m->at;
}

/* In order. A client may have all inputs of a tick before the relay server has: it sends that hash again. A
 * hash that arrives after the server's own was overwritten counts as equal. */
static void compare(ll_server *server, ll_peer_status *peer, int64_t first, const uint32_t *hashes,
                    int64_t count)
{
    int64_t end = first + count <= server->step ? first + count : server->step + 1;
    for (int64_t k = peer->hashed >= first ? peer->hashed + 1 : first; k < end; k++) {
        peer->hashed = k;
        if (peer->desync < 0 && ll_server_has_hash(server, k) &&
            hashes[k - first] != server->hashes[k & (LL_HASH_RING - 1)])
            peer->desync = k;
    }
}

/* Passes new inputs to ll_server_receive as one message; the client sends the rest again. */
static void take_new_inputs(ll_server *server, ll_client_slot *client_slot, const ll_peer_message *m,
                            const ll_input_run *runs, ll_input_message *inputs)
{
    int64_t tick = m->tick, next = known(server, client_slot) + 1;
    int count = 0;
    for (int r = 0; r < m->runs; r++)
        for (uint32_t i = 0; i < runs[r].count; i++, tick++) {
            const ll_controls *input = &runs[r].input;
            if (tick < next)
                client_slot->counts.duplicate++;
            else if (tick == next + count && count < LL_INPUTS_MAX)
                inputs->inputs[count++] = (ll_action){{input->axis[0], input->axis[1]}, input->buttons, 0};
        }
    LL_ASSERT(next > client_slot->connection.first);
    inputs->head = (ll_message_head){LL_MESSAGE_INPUT, (uint8_t)count, m->head.epoch,
                                     (uint32_t)(next - client_slot->connection.first)};
    inputs->tick = (int32_t)next;
    inputs->fresh = (uint8_t)count;
}

int ll_relay_server_take(ll_server *server, const ll_sync_mode *sync, int player, const void *packet,
                         ll_time now, ll_input_result results[LL_INPUTS_MAX])
{
    const ll_peer_message *m = packet;
    if (m->head.epoch != server->client_slots[player].connection.epoch)
        return 0;
    const ll_peer_ack *acks = (const ll_peer_ack *)(m + 1);
    const ll_input_run *runs = (const ll_input_run *)(acks + server->players);
    ll_client_slot *client_slot = &server->client_slots[player];
    ll_input_message inputs = {.wants = 0}; /* parts of snapshots, which no client gets here */
    take_acks(server, &client_slot->peer, m, acks);
    compare(server, &client_slot->peer, m->hashed, (const uint32_t *)(runs + m->runs), m->hashes);
    take_new_inputs(server, client_slot, m, runs, &inputs);
    if (server->rules.mesh && inputs.head.count > 0) /* it passes the packet on at once */
        client_slot->peer.relayed = inputs.tick + inputs.head.count - 1;
    /* An input is for its own tick alone, however many arrive at once: after an outage all open inputs do. */
    client_slot->limits.allowance = (ll_rate_limiter){ll_rate_burst(server->client_freq), now};
    int result_count = ll_server_receive(server, sync, player, &inputs, now, results);
    ll_relay_server_fill(server, now);
    ll_barrier_follow(server, sync, player, m, now);
    return result_count;
}

void ll_relay_server_fill(ll_server *server, ll_time now)
{
    int64_t upto = server->step;
    for (int i = 0; i < server->players; i++)
        if (server->client_slots[i].connection.connected && server->client_slots[i].inputs.newest > upto)
            upto = server->client_slots[i].inputs.newest;
    for (int i = 0; i < server->players; i++) {
        ll_client_slot *client_slot = &server->client_slots[i];
        int64_t tick = known(server, client_slot);
        for (; !client_slot->connection.connected && tick < upto; client_slot->inputs.newest = ++tick)
            client_slot->inputs.ring[(tick + 1) & (LL_INPUT_RING - 1)] =
                (ll_input_slot){.tick = tick + 1, .came = now};
    }
}

/* The newest of the inputs of a player that the server itself sends: over a mesh those that it made. */
static int64_t sent_upto(const ll_server *server, const ll_client_slot *client_slot)
{
    return server->rules.mesh && client_slot->connection.connected ? client_slot->connection.first
                                                                   : known(server, client_slot);
}

/* The inputs of `other` that `player` has not acknowledged. */
static char *write_part(ll_server *server, int player, int other, char *at)
{
    ll_client_slot *client_slot = &server->client_slots[other];
    const int64_t upto = sent_upto(server, client_slot);
    int64_t first = server->client_slots[player].peer.acks[other].known + 1;
    ll_relay_part *part = (ll_relay_part *)(void *)at;
    ll_input_run *runs = (ll_input_run *)(part + 1);
    int count = 0;
    for (int64_t tick = first; tick <= upto; tick++) {
        const ll_action *a = &slot_of(client_slot, tick)->action;
        if (!ll_run_add(runs, &count, &(ll_controls){{a->axis[0], a->axis[1]}, a->buttons}))
            break;
    }
    *part = (ll_relay_part){.tick = (int32_t)first,
                            .at = server->rules.mesh ? -1 : client_slot->peer.at,
                            .ahead = client_slot->peer.acks[player].ahead,
                            .player = (uint16_t)other,
                            .runs = (uint16_t)count};
    client_slot->peer.relayed = known(server, client_slot);
    return (char *)(runs + count);
}

/* Over a mesh most parts would be empty, and are left out. */
static bool has_part(const ll_server *server, int player, int other)
{
    return !server->rules.mesh || server->client_slots[player].peer.acks[other].known <
                                      sent_upto(server, &server->client_slots[other]);
}

int ll_relay_server_compose(ll_server *server, const ll_sync_mode *sync, int player,
                            struct ll_snapshot_common *common, void *packet)
{
    (void)sync;
    (void)common;
    const ll_client_slot *client_slot = &server->client_slots[player];
    ll_relay_message *m = packet;
    *m = (ll_relay_message){
        .head = {.type = LL_MESSAGE_RELAY,
                 .epoch = client_slot->connection.epoch,
                 .seq = (uint32_t)(known(server, client_slot) - client_slot->connection.first)},
        .tick = (int32_t)server->step,
        .barrier = (int32_t)server->barriers.tick,
        .time = server->stepped,
        .hashed = (int32_t)client_slot->peer.hashed,
        .resume = (int32_t)server->barriers.resume};
    char *at = (char *)(m + 1);
    m->head.count = 0;
    for (int other = 0; other < server->players; other++)
        if (other != player && has_part(server, player, other)) {
            at = write_part(server, player, other, at);
            m->head.count++;
        }
    return (int)(at - (char *)packet);
}
