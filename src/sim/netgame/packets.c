/* The packets of a netgame: carried over the links, received by server and clients. */
#include <string.h>

#include "base/assert.h"
#include "sim/netgame/parts.h"

/* What only an input packet has: the step of its newest input, and how long that took to be sent. */
static void describe_input(const ll_netgame *g, int player, const void *packet, ll_event *e)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_client *c = ll_netgame_client(g, player);
    if (sync->take != ll_server_receive)
        return; /* peers have packets of their own */
    ll_input_message m;
    memcpy(&m, packet, offsetof(ll_input_message, inputs));
    const ll_pending_input *input = ll_client_pending(c, e->number);
    if (!sync->applies_on_arrival)
        e->tick = (uint32_t)(m.tick + m.head.count - 1);
    if (input->seq != e->number)
        return;
    const ll_client_setup s = {.config = &g->config.players[player], .seed = (uint64_t)g->config.head.seed};
    e->held_ms = (float)ll_to_ms(g->now - input->made);
    if (e->number == c->inputs.seq)
        e->device_ms = (float)ll_to_ms(input->made - ll_client_control_time(c, &s, input->made));
}

void ll_netgame_send(ll_netgame *g, int player, bool up, const void *packet, int bytes, const ll_recorder *r)
{
    const ll_player_config *config = &g->config.players[player];
    ll_link *link = up ? ll_netgame_up(g, player) : ll_netgame_down(g, player);
    ll_message_head head;
    LL_ASSERT(bytes >= (int)sizeof head && bytes <= LL_NETGAME_PACKET_MAX);
    memcpy(&head, packet, sizeof head);
    ll_sending s =
        ll_link_send(link, up ? &config->link.up : &config->link.down, config->lag_ms, g->now, packet, bytes);

    if (up)
        ll_netgame_client(g, player)->connection.sent = g->now;
    else
        ll_netgame_server(g)->client_slots[player].connection.last_sent = g->now;
    ll_client_metrics *in = ll_netgame_client_metrics(g, player);
    if (g->now >= in->from) {
        int headers = LL_UDP_OVERHEAD + (s.fragments > 1 ? LL_FRAGMENT_HEADER : 0);
        in->traffic.bytes[head.type] += bytes;
        in->traffic.messages[head.type]++;
        in->traffic.packets[head.type] += s.fragments;
        in->traffic.wire_bytes[head.type] += bytes + s.fragments * headers;
    }
    bool inputs = head.type == LL_MESSAGE_INPUT;
    if (inputs && s.fate == LL_FATE_DELIVERED)
        ll_input_history_sent(&in->input_history, head.seq, head.count, s.due);
    if (inputs && s.duplicated && s.copy_fate == LL_FATE_DELIVERED)
        ll_input_history_sent(&in->input_history, head.seq, head.count, s.copy_due);
    if (!r)
        return;
    ll_event e = {.type = head.type, .player = (uint8_t)player, .fate = (uint8_t)s.fate, .begin = g->now};
    e.end = s.due;
    e.number = head.seq;
    if (head.type == LL_MESSAGE_SNAPSHOT || head.type == LL_MESSAGE_RELAY)
        e.number = (uint32_t)ll_netgame_server(g)->step;
    if (inputs) {
        e.number += head.count - 1u; /* its newest */
        describe_input(g, player, packet, &e);
    }
    ll_netgame_record(r, e);
    if (s.duplicated) {
        e.fate = (uint8_t)s.copy_fate;
        e.end = s.copy_due;
        ll_netgame_record(r, e);
    }
}

/* The server's message of an update to a connected player. */
static void update_player(ll_netgame *g, int player, const ll_recorder *r)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_server *server = ll_netgame_server(g);
    _Alignas(8) char packet[LL_NETGAME_PACKET_MAX];
    server->client_slots[player].inputs.repeats = 0;
    if (server->client_slots[player].connection.connected)
        ll_netgame_send(g, player, false, packet, sync->compose(server, sync, player, packet), r);
}

void ll_netgame_update(ll_netgame *g, const ll_recorder *r)
{
    for (int i = 0; i < g->config.player_count; i++)
        update_player(g, i, r);
}

static void record_result(ll_client_metrics *in, const ll_input_result *result, const ll_netgame *g)
{
    static const ll_input_history_flag marks[] = {[LL_OUTCOME_APPLIED] = LL_INPUT_HISTORY_IN_TIME,
                                                  [LL_OUTCOME_REFUSED] = LL_INPUT_HISTORY_REFUSED,
                                                  [LL_OUTCOME_LATE] = LL_INPUT_HISTORY_LATE};
    ll_input_history *input_history = &in->input_history;
    ll_input_history_received(input_history, result->seq, marks[result->outcome]);
    if (g->now < in->from)
        return;
    input_history->late += result->outcome == LL_OUTCOME_LATE;
    if (ll_netgame_sync(g)->client_runs_ahead)
        ll_running_stats_add(&input_history->slack, result->slack);
}

static void server_takes(ll_netgame *g, int player, const void *packet, const ll_recorder *r)
{
    ll_input_result results[LL_INPUTS_MAX];
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_server *server = ll_netgame_server(g);
    int n = sync->take(server, sync, player, packet, g->now, results);
    for (int i = 0; i < n; i++) {
        record_result(ll_netgame_client_metrics(g, player), &results[i], g);
        ll_netgame_record(r, (ll_event){.type = LL_EVENT_INPUT_RESULT,
                                        .player = (uint8_t)player,
                                        .outcome = results[i].outcome,
                                        .begin = g->now,
                                        .end = g->now,
                                        .number = results[i].seq});
        if (results[i].outcome == LL_OUTCOME_REFUSED && g->config.players[player].cheat == LL_CHEAT_NONE)
            ll_netgame_client_metrics(g, player)->false_refusals++;
        if (results[i].outcome == LL_OUTCOME_REFUSED && sync->reports_refusals) {
            ll_message_head refusal = {LL_MESSAGE_REFUSAL, results[i].rule,
                                       server->client_slots[player].connection.epoch, results[i].seq};
            ll_netgame_send(g, player, false, &refusal, (int)sizeof refusal, r);
        }
    }
    server->client_slots[player].inputs.repeats += n == 0;
}

static void server_receives(ll_netgame *g, int player, const void *packet, const ll_recorder *r)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_server *server = ll_netgame_server(g);
    _Alignas(8) char reply[LL_NETGAME_PACKET_MAX];
    bool with_world = sync->start != NULL && g->now >= 0; /* before time 0 all clients have the world */
    ll_admitted done = ll_admission_receive(server, with_world, player, packet, g->now, reply);
    if (done.joined)
        ll_server_world(server)->entity[player].flags &= ~(uint64_t)LL_ENTITY_AWAY;
    if (done.joined && with_world && sync->join)
        sync->join(server, sync, player, g->now);
    if (done.reply > 0)
        ll_netgame_send(g, player, false, reply, done.reply, r);
    if (done.game)
        server_takes(g, player, packet, r);
}

/* Checks the connections: players without packets for too long are dropped, and others see them leave. */
void ll_netgame_check_connections(ll_netgame *g, const ll_recorder *r)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    ll_server *server = ll_netgame_server(g);
    double timeout_s = g->config.server.timeout_s;
    ll_time timeout = timeout_s > 0 ? (ll_time)(timeout_s * 1e9) : LL_NEVER;
    _Alignas(8) char packet[LL_NETGAME_PACKET_MAX];
    server->next_check += LL_CONNECTION_CHECK_INTERVAL;
    for (int i = 0; i < server->players; i++) {
        if (sync->waits && server->client_slots[i].inputs.repeats > 0)
            update_player(g, i, r); /* it repeats known inputs, so it lacks the snapshot */
        int bytes = ll_admission_keep_alive(server, i, g->now, packet);
        if (bytes > 0)
            ll_netgame_send(g, i, false, packet, bytes, r);
        if (!ll_admission_check(server, i, timeout, g->now))
            continue;
        ll_netgame_record(r, (ll_event){.type = LL_EVENT_DROPPED,
                                        .player = (uint8_t)i,
                                        .begin = g->now,
                                        .end = g->now,
                                        .number = (uint32_t)server->client_slots[i].connection.drops});
        if (sync->stand_in)
            sync->stand_in(server, g->now);
        else /* a client's own world has no such flag */
            ll_server_world(server)->entity[i].flags |= LL_ENTITY_AWAY;
    }
}

static void client_receives(ll_netgame *g, int player, const ll_client_setup *s, const void *packet,
                            int bytes)
{
    ll_client *client = ll_netgame_client(g, player);
    const ll_recorder *r = s->recorder;
    int outcome = s->sync->receive(client, s, packet, bytes, g->now);
    if (!r)
        return;
    const ll_snapshot_message *m = packet;
    if (m->head.type != LL_MESSAGE_SNAPSHOT)
        return;
    const ll_world *world = ll_snapshot_entry_world(ll_client_state(client, client->snapshots.received - 1));
    ll_netgame_record(
        r, (ll_event){.type = LL_EVENT_APPLIED,
                      .player = (uint8_t)player,
                      .outcome = (uint8_t)outcome,
                      .begin = g->now,
                      .end = g->now,
                      .number = (uint32_t)m->tick,
                      .value = outcome == LL_OUTCOME_APPLIED ? (float)world->entity[player].x : 0});
}

/* False: the packet belongs to the game. */
static bool client_connects(ll_netgame *g, int player, const ll_client_setup *s, const void *packet,
                            int bytes)
{
    ll_client *client = ll_netgame_client(g, player);
    int64_t joins = client->connection.joins;
    bool taken = ll_connection_receive(client, s, packet, bytes, g->now);
    if (client->connection.joins != joins && s->sync->observe && g->now >= 0)
        ll_desync_start(ll_netgame_desync(g, player), ll_client_peer(client)->start);
    return taken;
}

static int take_off(ll_netgame *g, ll_link *link, void *packet)
{
    ll_time sent, due;
    int bytes = ll_link_receive(link, g->now, packet, LL_NETGAME_PACKET_MAX, &sent, &due);
    LL_ASSERT(bytes >= (int)sizeof(ll_message_head));
    return bytes;
}

/* ---- the players' de-jitter buffers, between link and client ---- */

/* Only snapshots are played out; packets that the link's receiver holds back stay in the link's store. Holds
 * back a received packet; false: it goes to the client at once. */
static bool hold(ll_netgame *g, int player, const void *packet, int bytes)
{
    ll_dejitter *buffer = ll_netgame_dejitter(g, player);
    const ll_player_config *config = &g->config.players[player];
    ll_snapshot_message m;
    memcpy(&m, packet, sizeof m.head);
    if (m.head.type != LL_MESSAGE_SNAPSHOT ||
        (config->dejitter == LL_DEJITTER_NONE && ll_dejitter_depth(buffer) == 0))
        return false;
    memcpy(&m, packet, sizeof m);
    const ll_dejitter_params params = {.delay_ms = config->dejitter_ms,
                                       .interval_ms = 1000 / (double)m.update_hz,
                                       .policy = config->dejitter};
    if (ll_dejitter_push(buffer, &params, m.tick, m.time, g->now))
        ll_link_hold(ll_netgame_down(g, player), (uint32_t)m.tick, packet, bytes);
    return true; /* held, or dropped by a full buffer */
}

/* Plays out the next due packet and returns its size. */
static int play_out(ll_netgame *g, int player, void *packet, int capacity)
{
    ll_dejitter_packet next;
    if (!ll_dejitter_pop(ll_netgame_dejitter(g, player), g->now, &next))
        return 0;
    return ll_link_take_held(ll_netgame_down(g, player), (uint32_t)next.id, packet, capacity);
}

/* ---- deliveries ---- */

void ll_netgame_deliver_up(ll_netgame *g, int player, const ll_recorder *r)
{
    _Alignas(8) char packet[LL_NETGAME_PACKET_MAX];
    take_off(g, ll_netgame_up(g, player), packet);
    server_receives(g, player, packet, r);
}

void ll_netgame_deliver_down(ll_netgame *g, int player, const ll_client_setup *s)
{
    _Alignas(8) char packet[LL_NETGAME_PACKET_MAX];
    int bytes = take_off(g, ll_netgame_down(g, player), packet);
    if (!client_connects(g, player, s, packet, bytes) && !hold(g, player, packet, bytes))
        client_receives(g, player, s, packet, bytes);
    ll_client_set_due(ll_netgame_client(g, player), s);
}

void ll_netgame_deliver_held(ll_netgame *g, int player, const ll_client_setup *s)
{
    _Alignas(8) char packet[LL_NETGAME_PACKET_MAX];
    int bytes = play_out(g, player, packet, (int)sizeof packet);
    client_receives(g, player, s, packet, bytes);
    ll_client_set_due(ll_netgame_client(g, player), s);
}
