/* The packets of a netgame: carried over the links, received by server and clients. */
#include <string.h>

#include "base/assert.h"
#include "base/keep.h"
#include "netcode/snapshot/common.h"
#include "sim/netgame/parts.h"

static __attribute__((noinline)) void record_sending(const ll_netgame_run *run, int player,
                                                     const void *packet, const ll_sending *s)
{
    ll_event e = ll_netgame_message_event(run, player, packet);
    e.fate = (uint8_t)s->fate;
    e.end = s->due;
    ll_netgame_record(run->recorder, e);
    if (s->duplicated) {
        e.fate = (uint8_t)s->copy_fate;
        e.end = s->copy_due;
        ll_netgame_record(run->recorder, e);
    }
}

/* By a transport that makes packets of messages: packets and their fates are noted as they travel. */
static __attribute__((noinline)) void send_by_transport(ll_netgame_run *run, int player, bool up,
                                                        const void *packet, int bytes)
{
    ll_netgame_seat *seat = &run->seat[player];
    ll_client_metrics *in = seat->metrics;
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    ll_event e = ll_netgame_message_event(run, player, packet);
    *(up ? &seat->client->connection.sent : &seat->slot->connection.last_sent) = run->game->now;
    if (run->game->now >= in->from) {
        in->traffic.bytes[head.type] += bytes;
        in->traffic.messages[head.type]++;
    }
    bool taken =
        ll_netgame_transport_send(run, player, up ? LL_CLIENT_SIDE : LL_SERVER_SIDE, packet, bytes, &e);
    bool observed = head.type == LL_MESSAGE_INPUT && (run->observes & LL_OBSERVE_INPUTS);
    if (taken && observed && ll_transport_reliable(seat->transport))
        ll_input_history_sent(&in->input_history, head.seq, head.count, LL_NEVER); /* it will come */
    e.end = e.begin;
    e.fate = LL_FATE_OVERFLOW;
    if (!taken)
        ll_netgame_record(run->recorder, e);
}

/* What is counted of a message from `from` of the metrics on. */
static inline void count_traffic(ll_traffic *t, int type, int bytes, int fragments)
{
    int headers = fragments * (LL_UDP_OVERHEAD + (fragments > 1 ? LL_FRAGMENT_HEADER : 0));
    t->bytes[type] += bytes;
    t->messages[type]++;
    t->packets[type] += fragments;
    t->wire_bytes[type] += bytes + headers;
}

/* What a message changes apart from its link. */
static inline void note_sent(const ll_netgame_run *run, const ll_netgame_seat *seat, bool up, int type,
                             int bytes, int fragments)
{
    const ll_time now = run->game->now;
    if (up)
        seat->client->connection.sent = now;
    else
        seat->slot->connection.last_sent = now;
    if (now >= seat->metrics->from)
        count_traffic(&seat->metrics->traffic, type, bytes, fragments);
}

static void note_arrivals(ll_input_history *input_history, const ll_message_head *head, const ll_sending *s)
{
    if (s->fate == LL_FATE_DELIVERED)
        ll_input_history_sent(input_history, head->seq, head->count, s->due);
    if (s->duplicated && s->copy_fate == LL_FATE_DELIVERED)
        ll_input_history_sent(input_history, head->seq, head->count, s->copy_due);
}

/* Any message that is a packet, on any link. A function of its own: its variables are large.
 */
static __attribute__((noinline)) void send_packet(ll_netgame_run *run, int player, bool up,
                                                  const void *packet, int bytes)
{
    const ll_netgame_seat *seat = &run->seat[player];
    const ll_link_plan *plan = up ? &seat->up_plan : &seat->down_plan;
    ll_message_head head;
    ll_packet_tap tap;
    memcpy(&head, packet, sizeof head);
    if (ll_netgame_records_packets(run)) {
        ll_netgame_tap(run, player, up, &tap);
        plan = &tap.plan;
    }
    const ll_sending s = ll_link_send_by(up ? seat->up : seat->down, plan, run->game->now, packet, bytes);
    note_sent(run, seat, up, head.type, bytes, s.fragments);
    if (head.type == LL_MESSAGE_INPUT && (run->observes & LL_OBSERVE_INPUTS))
        note_arrivals(&seat->metrics->input_history, &head, &s);
    if (run->recorder)
        record_sending(run, player, packet, &s);
}

/* An unrecorded message on a link with impairments, whose fate no one asks for. */
static bool send_single(ll_netgame_run *run, int player, bool up, const void *packet, int bytes)
{
    const ll_netgame_seat *seat = &run->seat[player];
    const ll_link_plan *plan = up ? &seat->up_plan : &seat->down_plan;
    ll_message_head head;
    if (run->recorder || run->observes & LL_OBSERVE_INPUTS ||
        !ll_link_send_single(up ? seat->up : seat->down, plan, run->game->now, packet, bytes))
        return false;
    memcpy(&head, packet, sizeof head);
    note_sent(run, seat, up, head.type, bytes, 1);
    return true;
}

/* The usual message takes the short way: unrecorded, on a link without impairments. */
void ll_netgame_send(ll_netgame_run *run, int player, bool up, const void *packet, int bytes)
{
    const ll_netgame_seat *seat = &run->seat[player];
    LL_KEEP(seat);
    const ll_link_plan *plan = up ? &seat->up_plan : &seat->down_plan;
    ll_message_head head;
    ll_time due;
    LL_ASSERT(bytes >= (int)sizeof head && bytes <= LL_NETGAME_PACKET_MAX);
    if (seat->transport) {
        send_by_transport(run, player, up, packet, bytes);
    } else if (run->recorder || plan->stages != 0 ||
               !ll_link_send_plain(up ? seat->up : seat->down, plan, run->game->now, packet, bytes, &due)) {
        if (!send_single(run, player, up, packet, bytes))
            send_packet(run, player, up, packet, bytes);
    } else {
        memcpy(&head, packet, sizeof head);
        note_sent(run, seat, up, head.type, bytes, 1);
        if (head.type == LL_MESSAGE_INPUT && (run->observes & LL_OBSERVE_INPUTS))
            ll_input_history_sent(&seat->metrics->input_history, head.seq, head.count, due);
    }
}

static int compose_update(ll_netgame_run *run, int player, ll_snapshot_common *common)
{
    if (run->reckoning)
        return ll_server_compose_reckoned(run->server, run->sync, player, run->reckoning, run->composed);
    return run->sync->compose(run->server, run->sync, player, common, run->composed);
}

/* The server's message of an update to a connected player. `common`: of this update; NULL: it is one message.
 */
static void update_player(ll_netgame_run *run, int player, ll_snapshot_common *common)
{
    ll_client_slot *slot = run->seat[player].slot;
    slot->inputs.repeats = 0;
    if (!slot->connection.connected)
        return;
    const int bytes = compose_update(run, player, common);
    if (run->reports)
        ll_reports_mark(run->reports, player, run->composed);
    ll_netgame_send(run, player, false, run->composed, bytes);
}

void ll_netgame_update(ll_netgame_run *run)
{
    ll_snapshot_common common;
    ll_snapshot_common_clear(&common);
    for (int i = 0; i < run->players; i++)
        update_player(run, i, &common);
}

static void note_result(const ll_netgame_run *run, ll_client_metrics *in, const ll_input_result *result)
{
    static const ll_input_history_flag marks[] = {[LL_OUTCOME_APPLIED] = LL_INPUT_HISTORY_IN_TIME,
                                                  [LL_OUTCOME_REFUSED] = LL_INPUT_HISTORY_REFUSED,
                                                  [LL_OUTCOME_LATE] = LL_INPUT_HISTORY_LATE};
    ll_input_history *input_history = &in->input_history;
    ll_input_history_received(input_history, result->seq, marks[result->outcome]);
    if (run->game->now < in->from)
        return;
    input_history->late += result->outcome == LL_OUTCOME_LATE;
    if (run->sync->client_runs_ahead)
        ll_running_stats_add(&input_history->slack, result->slack);
}

static __attribute__((noinline)) void record_result(const ll_netgame_run *run, int player,
                                                    const ll_input_result *result)
{
    ll_netgame_record(run->recorder, (ll_event){.type = LL_EVENT_INPUT_RESULT,
                                                .player = (uint8_t)player,
                                                .outcome = result->outcome,
                                                .begin = run->game->now,
                                                .end = run->game->now,
                                                .number = result->seq});
}

static __attribute__((noinline)) void refuse(ll_netgame_run *run, int player, const ll_input_result *result)
{
    ll_netgame_seat *seat = &run->seat[player];
    if (seat->setup.config->cheat == LL_CHEAT_NONE)
        seat->metrics->false_refusals++;
    if (!run->sync->reports_refusals)
        return;
    ll_message_head refusal = {LL_MESSAGE_REFUSAL, result->rule, seat->slot->connection.epoch, result->seq};
    ll_netgame_send(run, player, false, &refusal, (int)sizeof refusal);
}

static __attribute__((noinline)) void watch_result(ll_netgame_run *run, int player,
                                                   const ll_input_result *result)
{
    if (run->observes & LL_OBSERVE_INPUTS)
        note_result(run, run->seat[player].metrics, result);
    if (run->recorder)
        record_result(run, player, result);
    if (result->outcome == LL_OUTCOME_REFUSED)
        refuse(run, player, result);
}

static void server_takes(ll_netgame_run *run, int player, const void *packet)
{
    const bool watches = (run->observes & LL_OBSERVE_INPUTS) || run->recorder;
    ll_input_result *results = run->results;
    const ll_sync_mode *sync = run->sync;
    ll_netgame_seat *seat = &run->seat[player];
    if (run->detection)
        ll_netgame_detect_packet(run, player, packet);
    int n;
    do {
        n = sync->take(run->server, sync, player, packet, run->game->now, results);
        if (run->reports)
            ll_reports_take(run->reports, run->server, player, packet);
        for (int i = 0; i < n; i++)
            if (watches || results[i].outcome == LL_OUTCOME_REFUSED)
                watch_result(run, player, &results[i]);
    } while (run->meshed && n == LL_INPUTS_MAX); /* it must have all that the receiver gets */
    seat->slot->inputs.repeats += n == 0;
}

/* Whether the packet is one of the game, from a player in it. */
static bool server_receives(ll_netgame_run *run, int player, const void *packet)
{
    const ll_sync_mode *sync = run->sync;
    ll_server *server = run->server;
    const ll_time now = run->game->now;
    if (ll_admission_is_of_game(server, player, packet)) {
        server_takes(run, player, packet);
        return true;
    }
    bool with_world = sync->start != NULL && now >= 0; /* before time 0 all clients have the world */
    ll_admitted done = ll_admission_receive(server, with_world, player, packet, now, run->composed);
    if (done.joined)
        run->world->entity[player].flags &= ~(uint64_t)LL_ENTITY_AWAY;
    if (done.joined && with_world && sync->join)
        sync->join(server, sync, player, now);
    if (done.reply > 0)
        ll_netgame_send(run, player, false, run->composed, done.reply);
    return false;
}

/* By the general way of a link, which gives the same as the short one: a second use of that would slow it for
 * all. */
static ll_sending put_on_down_link(ll_netgame_run *run, int player, const void *packet, int bytes)
{
    const ll_netgame_seat *seat = &run->seat[player];
    ll_packet_tap tap;
    bool tapped = ll_netgame_records_packets(run);
    if (tapped)
        ll_netgame_tap(run, player, false, &tap);
    return ll_link_send_by(seat->down, tapped ? &tap.plan : &seat->down_plan, run->game->now, packet, bytes);
}

/* Over a mesh: a packet goes on from the sender's link up to the link down of the player that it is for, with
 * that player's epoch. On its second half it is one of the receiver's, and counts as a relay. */
static __attribute__((noinline)) void pass_on(ll_netgame_run *run, int player, const void *packet, int bytes)
{
    ll_peer_message *m = (ll_peer_message *)run->composed;
    memcpy(m, packet, (size_t)bytes);
    const int to = m->other - 1;
    LL_ASSERT(to < run->players && to != player);
    if (to < 0 || !run->seat[to].slot->connection.connected)
        return;
    m->head.epoch = run->seat[to].slot->connection.epoch;
    m->other = (uint16_t)(player + 1);
    const ll_sending s = put_on_down_link(run, to, m, bytes);
    if (run->game->now >= run->seat[to].metrics->from)
        count_traffic(&run->seat[to].metrics->traffic, LL_MESSAGE_RELAY, bytes, s.fragments);
    if (run->recorder)
        record_sending(run, to, &(ll_message_head){.type = LL_MESSAGE_RELAY, .seq = m->head.seq}, &s);
}

/* Checks the connections: players without packets for too long are dropped, and others see them leave. */
__attribute__((noinline)) void ll_netgame_check_connections(ll_netgame_run *run)
{
    const ll_sync_mode *sync = run->sync;
    ll_server *server = run->server;
    const ll_time now = run->game->now;
    double timeout_s = run->game->config.server.timeout_s;
    ll_time timeout = timeout_s > 0 ? (ll_time)(timeout_s * 1e9) : LL_NEVER;
    server->next_check += LL_CONNECTION_CHECK_INTERVAL;
    for (int i = 0; i < server->players; i++) {
        if (sync->waits && server->client_slots[i].inputs.repeats > 0)
            update_player(run, i, NULL); /* it repeats known inputs, so it lacks the snapshot */
        int bytes = ll_admission_keep_alive(server, i, now, run->composed);
        if (bytes > 0)
            ll_netgame_send(run, i, false, run->composed, bytes);
        if (!ll_admission_check(server, i, timeout, now))
            continue;
        ll_netgame_record(run->recorder,
                          (ll_event){.type = LL_EVENT_DROPPED,
                                     .player = (uint8_t)i,
                                     .begin = now,
                                     .end = now,
                                     .number = (uint32_t)server->client_slots[i].connection.drops});
        if (sync->stand_in)
            sync->stand_in(server, now);
        else /* a client's own world has no such flag */
            run->world->entity[i].flags |= LL_ENTITY_AWAY;
    }
}

static __attribute__((noinline)) void record_applied(const ll_netgame_run *run, int player,
                                                     const void *packet, int outcome)
{
    ll_client *client = run->seat[player].client;
    ll_snapshot_message m;
    memcpy(&m, packet, sizeof m.head);
    if (m.head.type != LL_MESSAGE_SNAPSHOT)
        return;
    memcpy(&m, packet, sizeof m);
    const ll_world *world = ll_snapshot_entry_world(ll_client_state(client, client->snapshots.received - 1));
    ll_netgame_record(
        run->recorder,
        (ll_event){.type = LL_EVENT_APPLIED,
                   .player = (uint8_t)player,
                   .outcome = (uint8_t)outcome,
                   .begin = run->game->now,
                   .end = run->game->now,
                   .number = (uint32_t)m.tick,
                   .value = outcome == LL_OUTCOME_APPLIED ? (float)world->entity[player].x : 0});
}

static void client_receives(ll_netgame_run *run, int player, const void *packet, int bytes)
{
    ll_netgame_seat *seat = &run->seat[player];
    int outcome = run->sync->receive(seat->client, &seat->setup, packet, bytes, run->game->now);
    if (run->recorder)
        record_applied(run, player, packet, outcome);
}

static __attribute__((noinline)) void client_joined(ll_netgame_run *run, int player)
{
    if (run->sync->observe && run->game->now >= 0)
        ll_desync_start(ll_netgame_desync(run->game, player),
                        ll_client_peer(run->seat[player].client)->start);
}

/* False: the packet belongs to the game. */
static bool client_connects(ll_netgame_run *run, int player, const void *packet, int bytes)
{
    ll_netgame_seat *seat = &run->seat[player];
    int64_t joins = seat->client->connection.joins;
    if (!ll_connection_receive(seat->client, &seat->setup, packet, bytes, run->game->now))
        return false;
    if (seat->client->connection.joins != joins)
        client_joined(run, player);
    return true;
}

/* The next packet of a link, where it lies or in `received`; valid until the link gets another. */
static const void *take_off(ll_netgame_run *run, ll_link *link, int *bytes)
{
    const void *packet = ll_link_next(link, run->game->now, bytes);
    LL_ASSERT(packet && *bytes >= (int)sizeof(ll_message_head) && *bytes <= LL_NETGAME_PACKET_MAX);
    if ((uintptr_t)packet % 8 == 0)
        return packet;
    return memcpy(run->received, packet, (size_t)*bytes);
}

/* ---- the players' de-jitter buffers, between link and client ---- */

/* Only snapshots are played out; packets that the link's receiver holds back stay in the link's store. Holds
 * back a received packet; false: it goes to the client at once. */
static __attribute__((noinline)) bool hold(ll_netgame_run *run, int player, const void *packet, int bytes)
{
    ll_netgame_seat *seat = &run->seat[player];
    const ll_player_config *config = seat->setup.config;
    ll_snapshot_message m;
    memcpy(&m, packet, sizeof m.head);
    if (m.head.type != LL_MESSAGE_SNAPSHOT ||
        (config->dejitter == LL_DEJITTER_NONE && ll_dejitter_depth(seat->dejitter) == 0))
        return false;
    if (seat->transport && !ll_link_room(seat->down, bytes))
        return false; /* one packet may complete several messages */
    memcpy(&m, packet, sizeof m);
    const ll_dejitter_params params = {.delay_ms = config->dejitter_ms,
                                       .interval_ms = 1000 / (double)m.update_hz,
                                       .policy = config->dejitter};
    if (packet != run->received)
        memcpy(run->received, packet, (size_t)bytes); /* the link is about to store it elsewhere */
    if (ll_dejitter_push(seat->dejitter, &params, m.tick, m.time, run->game->now))
        ll_link_hold(seat->down, (uint32_t)m.tick, run->received, bytes);
    return true; /* held, or dropped by a full buffer */
}

/* Plays out the next due packet into `received` and returns its size. */
static int play_out(ll_netgame_run *run, int player)
{
    ll_netgame_seat *seat = &run->seat[player];
    ll_dejitter_packet next;
    if (!ll_dejitter_pop(seat->dejitter, run->game->now, &next))
        return 0;
    return ll_link_take_held(seat->down, (uint32_t)next.id, run->received, LL_NETGAME_PACKET_MAX);
}

/* ---- deliveries ---- */

/* A packet brings any number of messages. */
static __attribute__((noinline)) void arrive_up(ll_netgame_run *run, int player)
{
    ll_netgame_transport_arrive(run, player, LL_SERVER_SIDE);
    while (ll_netgame_transport_take(run, player, LL_SERVER_SIDE, run->received) >= 0)
        server_receives(run, player, run->received);
    ll_netgame_transport_settle(run, player, LL_SERVER_SIDE);
}

static void client_gets(ll_netgame_run *run, int player, const void *packet, int bytes)
{
    ll_netgame_seat *seat = &run->seat[player];
    if (!client_connects(run, player, packet, bytes) && !(seat->dejitter && hold(run, player, packet, bytes)))
        client_receives(run, player, packet, bytes);
}

static __attribute__((noinline)) void arrive_down(ll_netgame_run *run, int player)
{
    int bytes;
    ll_netgame_transport_arrive(run, player, LL_CLIENT_SIDE);
    while ((bytes = ll_netgame_transport_take(run, player, LL_CLIENT_SIDE, run->received)) >= 0)
        client_gets(run, player, run->received, bytes);
    ll_netgame_transport_settle(run, player, LL_CLIENT_SIDE);
    ll_client_set_due(run->seat[player].client, &run->seat[player].setup);
}

void ll_netgame_deliver_up(ll_netgame_run *run, int player)
{
    int bytes;
    if (run->seat[player].transport) {
        arrive_up(run, player);
        return;
    }
    const void *packet = take_off(run, run->seat[player].up, &bytes);
    if (server_receives(run, player, packet) && run->meshed)
        pass_on(run, player, packet, bytes);
}

void ll_netgame_deliver_down(ll_netgame_run *run, int player)
{
    ll_netgame_seat *seat = &run->seat[player];
    int bytes;
    if (seat->transport) {
        arrive_down(run, player);
        return;
    }
    const void *packet = take_off(run, seat->down, &bytes);
    client_gets(run, player, packet, bytes);
    ll_client_set_due(seat->client, &seat->setup);
}

__attribute__((noinline)) void ll_netgame_deliver_held(ll_netgame_run *run, int player)
{
    ll_netgame_seat *seat = &run->seat[player];
    int bytes = play_out(run, player);
    client_receives(run, player, run->received, bytes);
    ll_client_set_due(seat->client, &seat->setup);
}
