/* UDP is written as it is. TCP is written as Linux sends it: the place of a chunk in the stream follows from
 * the chunks that were sent before it. The packets of QUIC and of WebRTC are encrypted on a real wire; here
 * the part that is not, the head of a short packet or of a DTLS record, stands before bytes of the right
 * number. */
#include "capture/wire/wire_image.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "capture/format/ip.h"
#include "capture/format/tcp.h"
#include "link/transport/segment.h"
#include "netcode/protocol/limits.h"

/* Addresses of networks reserved for documentation (RFC 5737). */
#define SERVER_ADDRESS UINT32_C(0xC0000201)  /* 192.0.2.1 */
#define PLAYERS_ADDRESS UINT32_C(0xC6336401) /* 198.51.100.1 and on */
enum { SERVER_PORT = 7777, PLAYERS_PORT = 50000 };
enum { CONNECTIONS_MAX = 64 }; /* of a player, before ports come again */
enum { FRAGMENT_COUNT_MAX = 255 };

/* The chunks that one side has sent in its present connection. */
typedef struct stream {
    uint16_t generation;
    uint32_t first, count; /* number of the first chunk; how many */
    uint32_t *at;          /* tcp: where each begins in the stream */
    size_t capacity;
    uint32_t end;       /* tcp: of the stream so far */
    uint32_t newest_ms; /* tcp: newest clock of the other side that has arrived here */
    uint16_t id;        /* of the next packet */
} stream;

struct ll_wire {
    stream stream[LL_PLAYERS_MAX][2]; /* from the server, from the player */
};

ll_wire *ll_wire_new(void)
{
    return calloc(1, sizeof(ll_wire));
}

void ll_wire_free(ll_wire *wire)
{
    for (int i = 0; wire && i < LL_PLAYERS_MAX; i++)
        for (int up = 0; up < 2; up++)
            free(wire->stream[i][up].at);
    free(wire);
}

static ll_status no_memory(void)
{
    return ll_error(LL_NO_MEMORY, "out of memory: packets of a capture");
}

/* ---- chunks ---- */

static void follow(stream *s, uint16_t generation)
{
    if (s->generation == generation && s->end > 0)
        return;
    s->generation = generation;
    s->first = s->count = 0;
    s->end = 1; /* place 0 is that of the packet that opens a connection */
}

/* Where a chunk begins in the stream. */
static uint32_t place_of(const stream *s, uint32_t number)
{
    if (s->count == 0 || number < s->first)
        return 1;
    return number - s->first < s->count ? s->at[number - s->first] : s->end;
}

static bool note_place(stream *s, uint32_t bytes)
{
    if (s->count == s->capacity) {
        size_t capacity = s->capacity ? 2 * s->capacity : 256;
        uint32_t *at = realloc(s->at, capacity * sizeof *at);
        if (!at)
            return false;
        s->at = at;
        s->capacity = capacity;
    }
    s->at[s->count] = s->end;
    s->end += bytes;
    return true;
}

/* Notes a chunk; whether it was sent before. */
static bool note_chunk(stream *s, const ll_segment_chunk *c, bool *failed)
{
    if (s->count == 0)
        s->first = c->number;
    if (c->number - s->first < s->count)
        return true;
    *failed |= !note_place(s, (uint32_t)c->whole);
    s->count += !*failed;
    return false;
}

/* ---- comments ---- */

static const char *const message_names[LL_MESSAGES] = {
    [LL_MESSAGE_INPUT] = "input", [LL_MESSAGE_SNAPSHOT] = "snapshot", [LL_MESSAGE_REFUSAL] = "refusal",
    [LL_MESSAGE_RELAY] = "relay", [LL_MESSAGE_CONNECT] = "connect",   [LL_MESSAGE_ACCEPT] = "accept",
    [LL_MESSAGE_PING] = "ping",   [LL_MESSAGE_PONG] = "pong",
};

static const char *const fate_names[] = {[LL_FATE_DELIVERED] = "",
                                         [LL_FATE_LOST] = "; lost",
                                         [LL_FATE_OVERFLOW] = "; dropped by a full queue",
                                         [LL_FATE_CORRUPTED] = "; arrives corrupted"};

/* What a message is, from at least its head. */
static void name_message(const void *bytes, int size, char *name, size_t room)
{
    ll_message_head head;
    ll_snapshot_message snapshot;
    memcpy(&head, bytes, sizeof head);
    if (head.type == LL_MESSAGE_SNAPSHOT && size >= (int)sizeof snapshot) {
        memcpy(&snapshot, bytes, sizeof snapshot);
        snprintf(name, room, "snapshot of step %" PRId64, snapshot.tick);
    } else if (head.type == LL_MESSAGE_INPUT && head.count > 1) {
        snprintf(name, room, "input %" PRIu32 " to %" PRIu32, head.seq, head.seq + head.count - 1u);
    } else {
        snprintf(name, room, "%s %" PRIu32, message_names[head.type], head.seq);
    }
}

/* The messages that begin in the segment; notes its chunks. */
static void name_segment(const ll_packet *p, const ll_segment *segment, stream *s, char *name, size_t room,
                         bool *failed)
{
    int at = 0, messages = 0;
    bool again = false;
    snprintf(name, room, "%s",
             segment->reset        ? "reset"
             : segment->chunks > 0 ? "rest of a message"
                                   : "acknowledgement");
    for (int i = 0; i < segment->chunks; i++) {
        ll_segment_chunk c = ll_segment_chunk_at(p->transport, segment, i, &at);
        again |= note_chunk(s, &c, failed);
        if (c.first && messages++ == 0 && c.size >= (int)sizeof(ll_message_head))
            name_message(c.bytes, c.size, name, room);
    }
    size_t length = strlen(name);
    if (messages > 1)
        length += (size_t)snprintf(name + length, room - length, " and %d more", messages - 1);
    if (again)
        snprintf(name + length, room - length, "; sent again");
}

static void describe(const ll_packet *p, const char *name, ll_wire_image *image)
{
    char part[40] = "";
    if (p->on_link->count > 1)
        snprintf(part, sizeof part, "; fragment %" PRId32 " of %" PRId32, p->on_link->index + 1,
                 p->on_link->count);
    snprintf(image->comment, sizeof image->comment, "%s%s%s", name, part, fate_names[p->on_link->fate]);
}

/* ---- headers ---- */

static void ends_of(const ll_packet *p, uint16_t connection, ll_ip_end *from, ll_ip_end *to)
{
    int port = PLAYERS_PORT + p->player + LL_PLAYERS_MAX * (connection % CONNECTIONS_MAX);
    ll_ip_end server = {SERVER_ADDRESS, SERVER_PORT},
              player = {PLAYERS_ADDRESS + (uint32_t)p->player, (uint16_t)port};
    *from = p->up ? player : server;
    *to = p->up ? server : player;
}

/* What a real packet shows before its encrypted part, over the first bytes of ours. */
static void write_clear_part(const ll_packet *p, const ll_segment *segment, uint8_t *at)
{
    if (p->transport ==
        LL_TRANSPORT_QUIC) { /* RFC 9000, 17.3.1: a connection ID of 4, a packet number of 1 */
        const uint8_t head[] = {0x40,
                                (uint8_t)p->player,
                                (uint8_t)p->up,
                                (uint8_t)(segment->generation >> 8),
                                (uint8_t)segment->generation,
                                (uint8_t)segment->number};
        memcpy(at, head, sizeof head);
    } else { /* RFC 6347, 4.1: application data of DTLS 1.2, epoch 1, the packet's number, length */
        int length = p->on_link->size - 13;
        const uint8_t head[] = {23,
                                0xfe,
                                0xfd,
                                0,
                                1,
                                0,
                                0,
                                (uint8_t)(segment->number >> 24),
                                (uint8_t)(segment->number >> 16),
                                (uint8_t)(segment->number >> 8),
                                (uint8_t)segment->number,
                                (uint8_t)(length >> 8),
                                (uint8_t)length};
        memcpy(at, head, sizeof head);
    }
}

/* `segment`: NULL for a message that is a packet of its own. */
static ll_status write_datagram(stream *s, const ll_packet *p, const ll_segment *segment,
                                ll_wire_image *image)
{
    const ll_link_packet *l = p->on_link;
    size_t header = l->count > 1 ? LL_FRAGMENT_HEADER : 0, payload = header + (size_t)p->size;
    ll_ip_end from, to;
    image->size = (uint32_t)(LL_UDP_HEADERS + payload);
    image->bytes = malloc(image->size);
    if (!image->bytes)
        return no_memory();
    uint8_t *at = image->bytes + LL_UDP_HEADERS;
    if (header > 0) { /* the message, modulo 2^16; index and count, as far as they fit */
        int32_t most = FRAGMENT_COUNT_MAX;
        at[0] = (uint8_t)(l->number >> 8);
        at[1] = (uint8_t)l->number;
        at[2] = (uint8_t)(l->index < most ? l->index : most);
        at[3] = (uint8_t)(l->count < most ? l->count : most);
    }
    memcpy(at + header, p->bytes, (size_t)p->size);
    if (segment && l->index == 0)
        write_clear_part(p, segment, at + header);
    ends_of(p, segment ? (uint16_t)(segment->generation - 1) : 0, &from, &to);
    ll_udp_headers_write(image->bytes, &from, &to, s->id++, payload);
    return ll_ok();
}

static ll_status write_tcp(stream *s, const stream *other, const ll_packet *p, const ll_segment *segment,
                           ll_wire_image *image)
{
    if (p->on_link->count > 1)
        return ll_error(
            LL_CONFLICT,
            "packets: mtu_bytes must be at least %d, or 0, with transport tcp, which does not split "
            "its segments; got less",
            p->on_link->size);
    ll_tcp_segment tcp = {.sequence = place_of(s, segment->number),
                          .acknowledgement = place_of(other, segment->next),
                          .push = segment->chunks > 0,
                          .reset = segment->reset,
                          .echo = segment->echo,
                          .reduced = segment->reduced,
                          .time_ms = (uint32_t)(p->sent / LL_MS) + 1,
                          .echo_ms = s->newest_ms,
                          .blocks = segment->blocks};
    for (int i = 0; i < tcp.blocks; i++)
        for (int end = 0; end < 2; end++)
            tcp.block[i][end] = place_of(other, segment->block[i][end]);
    size_t headers = ll_tcp_headers_size(&tcp), payload = (size_t)segment->payload_size;
    ll_ip_end from, to;
    image->size = (uint32_t)(headers + payload);
    image->bytes = malloc(image->size);
    if (!image->bytes)
        return no_memory();
    memcpy(image->bytes + headers, segment->payload, payload);
    ends_of(p, (uint16_t)(segment->generation - 1), &from, &to);
    ll_tcp_headers_write(image->bytes, &from, &to, s->id++, &tcp, payload);
    return ll_ok();
}

ll_status ll_wire_image_of(ll_wire *wire, const ll_packet *p, ll_wire_image *image)
{
    stream *s = &wire->stream[p->player][p->up], *other = &wire->stream[p->player][!p->up];
    char name[120];
    ll_segment segment;
    bool failed = false;
    if (p->transport == LL_TRANSPORT_UDP) {
        name_message(p->on_link->message, p->on_link->size, name, sizeof name);
        describe(p, name, image);
        return write_datagram(s, p, NULL, image);
    }
    segment = ll_segment_read(p->transport, p->on_link->message, p->on_link->size);
    follow(s, segment.generation);
    if (p->on_link->index == 0)
        name_segment(p, &segment, s, name, sizeof name, &failed);
    else
        snprintf(name, sizeof name, "rest of a packet");
    if (failed)
        return no_memory();
    describe(p, name, image);
    return p->transport == LL_TRANSPORT_TCP ? write_tcp(s, other, p, &segment, image)
                                            : write_datagram(s, p, &segment, image);
}

void ll_wire_arrived(ll_wire *wire, int32_t transport, int player, bool up, const uint8_t *bytes)
{
    stream *receiver = &wire->stream[player][!up];
    if (transport != LL_TRANSPORT_TCP)
        return;
    uint32_t sent = ll_tcp_time_ms(bytes);
    if ((int32_t)(sent - receiver->newest_ms) > 0)
        receiver->newest_ms = sent;
}
