#include "netcode/server/admission.h"

#include <string.h>

#include "netcode/protocol/connection.h"

static int answer(const ll_server *server, int player, ll_message type, const ll_request_message *request,
                  bool with_world, ll_time now, void *reply)
{
    const ll_client_slot *client_slot = &server->client_slots[player];
    ll_answer_message m = {
        .head = {.type = (uint8_t)type, .epoch = client_slot->connected ? client_slot->epoch : 0},
        .received = now,
        .tick = server->step,
        .first = client_slot->first};
    int size = (int)sizeof m;
    if (request) {
        m.head.count = LL_ANSWER_ECHO;
        m.head.seq = request->head.seq;
        m.sent = request->sent;
    }
    if (with_world) {
        const ll_world *world = ll_server_world_const(server);
        m.head.count |= LL_ANSWER_WORLD;
        memcpy((char *)reply + size, world, ll_world_size(world));
        size += (int)ll_world_size(world);
    }
    memcpy(reply, &m, sizeof m);
    return size;
}

/* Where the relay server made inputs for the player, and may have sent them to others, the player's own
 * inputs come after them. */
static void accept(ll_server *server, bool with_world, int player, const ll_request_message *request,
                   ll_time now)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    int64_t first = with_world && client_slot->newest > server->step ? client_slot->newest : server->step;
    if (!with_world)
        ll_client_slot_clear(client_slot);
    ll_client_slot_open(client_slot, server->client_freq, server->step, now);
    client_slot->epoch = server->epoch = ll_server_next_epoch(server);
    client_slot->first = first;
    client_slot->newest = with_world ? first : client_slot->newest;
    client_slot->peer.relayed = first;
    client_slot->attempt = request->head.seq;
    client_slot->connected = 1;
    client_slot->seen = now;
    client_slot->last_ack =
        now + (now - request->seen); /* the time that this answer can still be acknowledged */
    client_slot->joins++;
}

static ll_admitted take_connect(ll_server *server, bool with_world, int player,
                                const ll_request_message *request, ll_time now, void *reply)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    bool fresh = request->seen != LL_NEVER && now - request->seen <= LL_FRESH;
    bool again = client_slot->connected && client_slot->attempt == request->head.seq;
    bool old =
        request->head.seq < client_slot->attempt; /* overtaken: its client has already used a later attempt */
    ll_admitted done = {.joined = fresh && !again && !old};
    if (done.joined)
        accept(server, with_world, player, request, now);
    ll_message type = done.joined || again ? LL_MESSAGE_ACCEPT : LL_MESSAGE_PONG;
    done.reply = answer(server, player, type, request, with_world && type == LL_MESSAGE_ACCEPT, now, reply);
    return done;
}

ll_admitted ll_admission_receive(ll_server *server, bool with_world, int player, const void *packet,
                                 ll_time now, void *reply)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    ll_message_head head;
    ll_request_message request;
    memcpy(&head, packet, sizeof head);
    bool asks = head.type == LL_MESSAGE_CONNECT || head.type == LL_MESSAGE_PING;
    if (asks)
        memcpy(&request, packet, sizeof request);
    if (head.type == LL_MESSAGE_CONNECT)
        return take_connect(server, with_world, player, &request, now, reply);
    if (!asks && client_slot->connected)
        return (ll_admitted){.game = head.epoch == client_slot->epoch};
    if (head.type == LL_MESSAGE_PING)
        client_slot->offset = head.count;
    if (asks && request.seen != LL_NEVER && request.seen > client_slot->seen) {
        client_slot->seen = request.seen;
        client_slot->last_ack = now;
    }
    if (!asks && now - client_slot->last_sent < LL_KEEP_ALIVE)
        return (ll_admitted){.reply = 0}; /* it already knows that it is not connected */
    return (ll_admitted){
        .reply = answer(server, player, LL_MESSAGE_PONG, asks ? &request : NULL, false, now, reply)};
}

bool ll_admission_check(ll_server *server, int player, ll_time timeout, ll_time now)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    if (!client_slot->connected || timeout == LL_NEVER || now - client_slot->last_ack <= timeout)
        return false;
    client_slot->connected = 0;
    client_slot->drops++;
    client_slot->held = (ll_action){0};
    return true;
}

int ll_admission_keep_alive(ll_server *server, int player, ll_time now, void *packet)
{
    const ll_client_slot *client_slot = &server->client_slots[player];
    if (!client_slot->connected || now - client_slot->last_sent < LL_KEEP_ALIVE)
        return 0;
    return answer(server, player, LL_MESSAGE_PONG, NULL, false, now, packet);
}
