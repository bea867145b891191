#include "netcode/server/admission.h"

#include <string.h>

#include "netcode/protocol/connection.h"

typedef struct answer_kind {
    ll_message type;
    const ll_request_message *request; /* that it answers; NULL: none */
    bool with_world;
} answer_kind;

/* The newest step that is not made yet of which an input of the player itself has come; inputs that the
 * server made for it have no number. The last step made: there is none. */
static int64_t own_upto(const ll_server *server, const ll_client_slot *client_slot)
{
    for (int64_t tick = client_slot->connection.first; tick > server->step; tick--) {
        const ll_input_slot *slot = &client_slot->inputs.ring[tick & (LL_INPUT_RING - 1)];
        if (slot->tick == tick && slot->seq != 0)
            return tick;
    }
    return server->step;
}

static int answer(const ll_server *server, int player, answer_kind kind, ll_time now, void *reply)
{
    const ll_request_message *request = kind.request;
    const ll_client_slot *client_slot = &server->client_slots[player];
    ll_answer_message m = {
        .head = {.type = (uint8_t)kind.type,
                 .epoch = client_slot->connection.connected ? client_slot->connection.epoch : 0},
        .received = now,
        .tick = server->step,
        .first = client_slot->connection.first};
    int size = (int)sizeof m;
    if (request) {
        m.head.count = LL_ANSWER_ECHO;
        m.head.seq = request->head.seq;
        m.sent = request->sent;
    }
    if (kind.with_world) {
        const ll_world *world = ll_server_world_const(server);
        m.head.count |= LL_ANSWER_WORLD;
        memcpy((char *)reply + size, world, ll_world_size(world));
        size += (int)ll_world_size(world);
        const int64_t own = own_upto(server, client_slot);
        if (own > server->step) {
            m.head.count |= LL_ANSWER_OWN;
            memcpy((char *)reply + size, &own, sizeof own);
            size += (int)sizeof own;
        }
    }
    memcpy(reply, &m, sizeof m);
    return size;
}

/* Where the relay server made inputs for the player, and may have sent them to others, the player's own
 * inputs come after them. */
static void accept(ll_server *server, bool with_world, int player, const ll_request_message *request,
                   ll_time now)
{
    ll_slot_connection *connection = &server->client_slots[player].connection;
    ll_client_slot *client_slot = &server->client_slots[player];
    int64_t first =
        with_world && client_slot->inputs.newest > server->step ? client_slot->inputs.newest : server->step;
    if (!with_world)
        ll_client_slot_clear(client_slot);
    ll_client_slot_open(client_slot, server->client_freq, server->step, now);
    connection->epoch = server->epoch = ll_server_next_epoch(server);
    connection->first = first;
    client_slot->inputs.newest = with_world ? first : client_slot->inputs.newest;
    client_slot->peer.relayed = first;
    connection->attempt = request->head.seq;
    connection->connected = 1;
    connection->seen = now;
    connection->last_ack =
        now + (now - request->seen); /* the time that this answer can still be acknowledged */
    connection->joins++;
}

static __attribute__((noinline)) ll_admitted take_connect(ll_server *server, bool with_world, int player,
                                                          const ll_request_message *request, ll_time now,
                                                          void *reply)
{
    ll_slot_connection *connection = &server->client_slots[player].connection;
    bool fresh = request->seen != LL_NEVER && now - request->seen <= LL_FRESH;
    bool again = connection->connected && connection->attempt == request->head.seq;
    bool old =
        request->head.seq < connection->attempt; /* overtaken: its client has already used a later attempt */
    ll_admitted done = {.joined = fresh && !again && !old};
    if (done.joined)
        accept(server, with_world, player, request, now);
    ll_message type = done.joined || again ? LL_MESSAGE_ACCEPT : LL_MESSAGE_PONG;
    done.reply = answer(server, player, (answer_kind){type, request, with_world && type == LL_MESSAGE_ACCEPT},
                        now, reply);
    return done;
}

static bool asks(const ll_message_head *head)
{
    return head->type == LL_MESSAGE_CONNECT || head->type == LL_MESSAGE_PING;
}

/* Of a request, or of a player who is not connected. */
static __attribute__((noinline)) ll_admitted receive_request(ll_server *server, bool with_world, int player,
                                                             const void *packet, ll_time now, void *reply)
{
    ll_slot_connection *connection = &server->client_slots[player].connection;
    ll_message_head head;
    ll_request_message request;
    memcpy(&head, packet, sizeof head);
    const bool asked = asks(&head);
    if (asked)
        memcpy(&request, packet, sizeof request);
    if (head.type == LL_MESSAGE_CONNECT)
        return take_connect(server, with_world, player, &request, now, reply);
    if (head.type == LL_MESSAGE_PING)
        connection->offset = head.count;
    if (asked && request.seen != LL_NEVER && request.seen > connection->seen) {
        connection->seen = request.seen;
        connection->last_ack = now;
    }
    if (!asked && now - connection->last_sent < LL_KEEP_ALIVE)
        return (ll_admitted){.reply = 0}; /* it already knows that it is not connected */
    return (ll_admitted){.reply = answer(server, player,
                                         (answer_kind){LL_MESSAGE_PONG, asked ? &request : NULL, false}, now,
                                         reply)};
}

bool ll_admission_is_of_game(const ll_server *server, int player, const void *packet)
{
    const ll_slot_connection *connection = &server->client_slots[player].connection;
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    return connection->connected && !asks(&head) && head.epoch == connection->epoch;
}

/* Most packets are of the game. */
ll_admitted ll_admission_receive(ll_server *server, bool with_world, int player, const void *packet,
                                 ll_time now, void *reply)
{
    const ll_slot_connection *connection = &server->client_slots[player].connection;
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    if (connection->connected && !asks(&head))
        return (ll_admitted){.game = head.epoch == connection->epoch};
    return receive_request(server, with_world, player, packet, now, reply);
}

bool ll_admission_check(ll_server *server, int player, ll_time timeout, ll_time now)
{
    ll_slot_connection *connection = &server->client_slots[player].connection;
    if (!connection->connected || timeout == LL_NEVER || now - connection->last_ack <= timeout)
        return false;
    connection->connected = 0;
    connection->drops++;
    server->client_slots[player].inputs.held = (ll_action){0};
    return true;
}

int ll_admission_keep_alive(ll_server *server, int player, ll_time now, void *packet)
{
    const ll_slot_connection *connection = &server->client_slots[player].connection;
    if (!connection->connected || now - connection->last_sent < LL_KEEP_ALIVE)
        return 0;
    return answer(server, player, (answer_kind){.type = LL_MESSAGE_PONG}, now, packet);
}
