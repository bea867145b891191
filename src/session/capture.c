/* Packets of a session as a capture file: pcapng (draft-ietf-opsawg-pcapng), because a packet that arrives is
 * in the file twice, where it was sent and where and when it was received, and only pcapng says which of the
 * two a packet is, and what became of it. With every transport, what the link carried is the payload of a UDP
 * datagram: its 28 bytes of headers are those that the metrics count. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "netcode/protocol/packet.h"
#include "session/internal.h"

enum { EPOCH_S = 946684800 }; /* 2000-01-01T00:00:00Z: the time of a capture at virtual time 0 */

/* Addresses of networks reserved for documentation (RFC 5737). */
#define SERVER_ADDRESS UINT32_C(0xC0000201)  /* 192.0.2.1 */
#define PLAYERS_ADDRESS UINT32_C(0xC6336401) /* 198.51.100.1 and on */
enum { SERVER_PORT = 7777, PLAYERS_PORT = 50000 };

enum { COMMENT_MAX = 64, OPTIONS_MAX = 600 };

/* A packet from its IPv4 header on, and when it is at one of its ends. */
typedef struct frame {
    ll_time time;
    int interface;
    bool received;
    uint8_t *bytes; /* owned */
    uint32_t size;
    char comment[COMMENT_MAX];
} frame;

typedef struct ll_capture {
    void (*write)(void *context, const char *bytes, size_t length);
    void *context;
    int server;    /* its interface, after those of the players */
    int interface; /* that is written; LL_ALL_INTERFACES */
    ll_time from;  /* what is before is not written */
    frame *coming; /* arrivals in their order: from `first` to `end` */
    size_t first, end, capacity;
    uint16_t id; /* of the next packet */
    ll_status status;
    char block[UINT16_MAX + OPTIONS_MAX];
    size_t size;
} ll_capture;

/* ---- blocks of the file, little-endian ---- */

enum { SECTION = 0x0A0D0D0A, INTERFACE = 1, PACKET = 6, BYTE_ORDER_MAGIC = 0x1A2B3C4D };
enum { LINKTYPE_RAW = 101 }; /* packets begin with an IP header */
enum { COMMENT = 1, INTERFACE_NAME = 2, INTERFACE_RESOLUTION = 9, PACKET_FLAGS = 2, NANOSECONDS = 9 };
enum { INBOUND = 1, OUTBOUND = 2 };

static void put(ll_capture *c, uint64_t value, size_t size)
{
    LL_ASSERT(c->size + size <= sizeof c->block);
    for (size_t i = 0; i < size; i++)
        c->block[c->size++] = (char)(value >> (8 * i));
}

static void put_bytes(ll_capture *c, const void *bytes, size_t size)
{
    LL_ASSERT(c->size + size <= sizeof c->block);
    memcpy(c->block + c->size, bytes, size);
    c->size += size;
    put(c, 0, -size & 3); /* padding */
}

static void put_option(ll_capture *c, uint32_t code, const void *value, size_t size)
{
    put(c, code | (uint64_t)size << 16, 4);
    put_bytes(c, value, size);
}

static void begin_block(ll_capture *c, uint32_t type)
{
    c->size = 0;
    put(c, type, 8); /* the length follows when it is known */
}

static void end_block(ll_capture *c)
{
    put(c, 0, 4); /* the end of the options */
    size_t total = c->size + 4;
    put(c, total, 4);
    c->size = 4;
    put(c, total, 4);
    c->write(c->context, c->block, total);
}

static void write_section(ll_capture *c, const ll_scenario_head *head)
{
    char comment[LL_TITLE_MAX + 120];
    int length = snprintf(comment, sizeof comment,
                          "%s; seed %" PRId64 "; laglab %s; virtual time 0 is 2000-01-01 00:00:00 UTC",
                          head->title, head->seed, ll_version);
    begin_block(c, SECTION);
    put(c, BYTE_ORDER_MAGIC, 4);
    put(c, 1, 4);          /* version 1.0 */
    put(c, UINT64_MAX, 8); /* the length of the section is not given */
    put_option(c, COMMENT, comment, (size_t)length);
    end_block(c);
}

static void write_interface(ll_capture *c, const char *name)
{
    const uint8_t resolution = NANOSECONDS;
    begin_block(c, INTERFACE);
    put(c, LINKTYPE_RAW, 8); /* packets are whole: no limit of their length */
    put_option(c, INTERFACE_NAME, name, strlen(name));
    put_option(c, INTERFACE_RESOLUTION, &resolution, 1);
    end_block(c);
}

static void write_frame(ll_capture *c, const frame *f)
{
    const uint64_t time = (uint64_t)(EPOCH_S * (int64_t)LL_SECOND + f->time);
    const uint8_t flags[4] = {f->received ? INBOUND : OUTBOUND};
    if (f->time < c->from || (c->interface != LL_ALL_INTERFACES && c->interface != f->interface))
        return;
    begin_block(c, PACKET);
    put(c, (uint64_t)f->interface, 4);
    put(c, time >> 32, 4);
    put(c, time & UINT32_MAX, 4);
    put(c, f->size, 4); /* captured, and as it was */
    put(c, f->size, 4);
    put_bytes(c, f->bytes, f->size);
    put_option(c, COMMENT, f->comment, strlen(f->comment));
    put_option(c, PACKET_FLAGS, flags, sizeof flags);
    end_block(c);
}

/* ---- headers of IPv4 (RFC 791) and UDP (RFC 768) ---- */

enum { IP_HEADER = 20, HEADERS = LL_UDP_OVERHEAD };
enum { VERSION_AND_LENGTH = 0x45, DO_NOT_FRAGMENT = 0x40, TIME_TO_LIVE = 64, PROTOCOL_UDP = 17 };

static void put16(uint8_t *at, size_t value)
{
    at[0] = (uint8_t)(value >> 8);
    at[1] = (uint8_t)value;
}

static void put32(uint8_t *at, uint32_t value)
{
    put16(at, value >> 16);
    put16(at + 2, value);
}

/* The one's complement of the one's complement sum of 16-bit words (RFC 1071), from `sum` on. */
static uint16_t checksum(uint64_t sum, const uint8_t *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++)
        sum += i & 1 ? bytes[i] : (uint64_t)bytes[i] << 8;
    while (sum >> 16)
        sum = (sum & 0xFFFF) + (sum >> 16);
    return (uint16_t)~sum;
}

static void write_headers(uint8_t *ip, const ll_packet *p, uint16_t id, size_t size)
{
    uint8_t *udp = ip + IP_HEADER;
    const size_t datagram = size - IP_HEADER;
    memset(ip, 0, HEADERS);
    ip[0] = VERSION_AND_LENGTH;
    put16(ip + 2, size);
    put16(ip + 4, id);
    ip[6] = DO_NOT_FRAGMENT;
    ip[8] = TIME_TO_LIVE;
    ip[9] = PROTOCOL_UDP;
    put32(ip + (p->up ? 12 : 16), PLAYERS_ADDRESS + (uint32_t)p->player);
    put32(ip + (p->up ? 16 : 12), SERVER_ADDRESS);
    put16(ip + 10, checksum(0, ip, IP_HEADER));
    put16(udp + (p->up ? 0 : 2), PLAYERS_PORT + (size_t)p->player);
    put16(udp + (p->up ? 2 : 0), SERVER_PORT);
    put16(udp + 4, datagram);
    /* with the pseudo header: protocol, length, and both addresses, which are before the datagram */
    uint16_t sum = checksum(PROTOCOL_UDP + datagram, ip + 12, 8 + datagram);
    put16(udp + 6, sum ? sum : UINT16_MAX); /* 0 means: without a checksum */
}

/* ---- packets ---- */

/* NULL without memory. */
static uint8_t *bytes_of(const ll_packet *p, uint16_t id, uint32_t *size)
{
    const ll_link_packet *l = p->on_link;
    const size_t headers = HEADERS + (l->count > 1 ? LL_FRAGMENT_HEADER : 0);
    *size = (uint32_t)(headers + (size_t)p->size);
    LL_ASSERT(*size <= UINT16_MAX);
    uint8_t *bytes = malloc(*size);
    if (!bytes)
        return NULL;
    if (l->count > 1) { /* the message, modulo 2^16; index and count, as far as they fit */
        put16(bytes + HEADERS, (size_t)l->number);
        bytes[HEADERS + 2] = (uint8_t)(l->index < UINT8_MAX ? l->index : UINT8_MAX);
        bytes[HEADERS + 3] = (uint8_t)(l->count < UINT8_MAX ? l->count : UINT8_MAX);
    }
    memcpy(bytes + headers, p->bytes, (size_t)p->size);
    write_headers(bytes, p, id, *size);
    return bytes;
}

/* The names of the metrics. */
static void describe(const ll_packet *p, char *comment)
{
    static const char *const fates[] = {[LL_FATE_DELIVERED] = "",
                                        [LL_FATE_LOST] = "; lost",
                                        [LL_FATE_OVERFLOW] = "; dropped",
                                        [LL_FATE_CORRUPTED] = "; corrupted"};
    static const char *const copies[] = {[LL_FATE_DELIVERED] = "; duplicated",
                                         [LL_FATE_LOST] = "; duplicated; copy lost",
                                         [LL_FATE_OVERFLOW] = "; duplicated; copy dropped",
                                         [LL_FATE_CORRUPTED] = "; duplicated; copy corrupted"};
    const ll_link_packet *l = p->on_link;
    snprintf(comment, COMMENT_MAX, "%s%s%s", p->name, fates[l->fate],
             l->duplicated ? copies[l->copy_fate] : "");
}

/* Takes the frame. */
static bool keep(ll_capture *c, const frame *f)
{
    if (c->end == c->capacity && c->first > c->capacity / 2) {
        memmove(c->coming, c->coming + c->first, (c->end - c->first) * sizeof *f);
        c->end -= c->first;
        c->first = 0;
    } else if (c->end == c->capacity) {
        size_t capacity = c->capacity ? 2 * c->capacity : 64;
        frame *coming = realloc(c->coming, capacity * sizeof *f);
        if (!coming)
            return false;
        c->coming = coming;
        c->capacity = capacity;
    }
    size_t i = c->end++;
    for (; i > c->first && c->coming[i - 1].time > f->time; i--)
        c->coming[i] = c->coming[i - 1];
    c->coming[i] = *f;
    return true;
}

static void write_arrivals(ll_capture *c, ll_time until)
{
    for (; c->first < c->end && c->coming[c->first].time <= until; c->first++) {
        write_frame(c, &c->coming[c->first]);
        free(c->coming[c->first].bytes);
    }
}

/* The packet, or its copy, arrives. */
static bool arrive(ll_capture *c, const frame *sent, int interface, ll_fate fate, ll_time due,
                   const char *comment)
{
    frame f = {.time = due, .interface = interface, .received = true, .size = sent->size};
    if (fate != LL_FATE_DELIVERED && fate != LL_FATE_CORRUPTED)
        return true;
    f.bytes = malloc(f.size);
    if (!f.bytes)
        return false;
    memcpy(f.bytes, sent->bytes, f.size);
    if (fate == LL_FATE_CORRUPTED)
        f.bytes[f.size - 1] ^= 1; /* the checksum no longer holds */
    snprintf(f.comment, sizeof f.comment, "%s", comment);
    if (keep(c, &f))
        return true;
    free(f.bytes);
    return false;
}

/* An ll_recorder function; the context is the session. */
static void capture_packet(void *context, const void *row)
{
    ll_capture *c = ((ll_session *)context)->capture;
    const ll_packet *p = row;
    const ll_link_packet *l = p->on_link;
    const int to = p->up ? c->server : p->player;
    frame sent = {.time = p->sent, .interface = p->up ? p->player : c->server};
    char copy[COMMENT_MAX];
    write_arrivals(c, p->sent);
    sent.bytes = bytes_of(p, c->id++, &sent.size);
    if (sent.bytes) {
        describe(p, sent.comment);
        write_frame(c, &sent);
        snprintf(copy, sizeof copy, "%s; copy", p->name);
    }
    if (!sent.bytes || !arrive(c, &sent, to, l->fate, l->due, p->name) ||
        (l->duplicated && !arrive(c, &sent, to, l->copy_fate, l->copy_due, copy)))
        c->status = ll_error(LL_NO_MEMORY, "out of memory: packets of a capture");
    free(sent.bytes);
}

/* ---- a session ---- */

int ll_session_players(const ll_session *s)
{
    const ll_sim_kind *kind = s->scenario.kind;
    int players = 0;
    while (kind->player_name && kind->player_name(s->config, players))
        players++;
    return players;
}

ll_status ll_session_interface(const ll_session *s, const char *name, int *interface)
{
    int players = ll_session_players(s);
    char known[256] = "server";
    *interface = LL_ALL_INTERFACES;
    if (!name || !*name)
        return ll_ok();
    for (int i = 0; i < players; i++) {
        const char *player = s->scenario.kind->player_name(s->config, i);
        size_t length = strlen(known);
        if (strcmp(name, player) == 0)
            *interface = i;
        snprintf(known + length, sizeof known - length, ", %s", player);
    }
    if (strcmp(name, "server") == 0)
        *interface = players;
    if (*interface == LL_ALL_INTERFACES)
        return ll_field_error(LL_BAD_INPUT, "at", "at: must be one of %s; got `%.40s`", known, name);
    return ll_ok();
}

static void begin(ll_capture *c, const ll_session *s)
{
    write_section(c, ll_session_head(s));
    for (int i = 0; i < c->server; i++) {
        char name[LL_TITLE_MAX];
        snprintf(name, sizeof name, "player %s", s->scenario.kind->player_name(s->config, i));
        write_interface(c, name);
    }
    write_interface(c, "server");
}

static ll_status run(ll_session *s, const ll_capture *c, int64_t to, const ll_interrupt *interrupt)
{
    ll_piece piece = {1, 0};
    ll_status status = ll_session_wake(s); /* packets of time 0 are sent while it wakes */
    for (int64_t tick = 0, stop = 0; tick <= to && !ll_failed(&status); tick++) {
        if (tick >= stop) {
            if (!ll_next_piece(&piece, interrupt))
                status = ll_error(LL_INTERRUPTED, "interrupted at tick %" PRId64 " of %" PRId64, tick, to);
            stop = tick + piece.size;
        }
        LL_THEN(status, ll_session_run_to(s, tick));
        LL_THEN(status, c->status);
    }
    return status;
}

ll_status ll_session_write_capture(ll_session *copy, const ll_capture_range *range,
                                   const ll_interrupt *interrupt,
                                   void (*write)(void *context, const char *bytes, size_t length),
                                   void *context)
{
    if (!copy->scenario.kind->player_name)
        return ll_error(LL_CONFLICT, "packets: the kind must be netgame; got %s", copy->scenario.kind->name);
    ll_capture *c = calloc(1, sizeof *c);
    if (!c)
        return ll_error(LL_NO_MEMORY, "out of memory: packets of a capture");
    c->write = write;
    c->context = context;
    c->server = ll_session_players(copy);
    c->interface = range->interface;
    c->from = ll_tick_time(range->from, copy->freq);
    begin(c, copy);
    copy->capture = c;
    copy->on_packet = capture_packet;
    ll_status status = run(copy, c, range->to, interrupt);
    copy->capture = NULL;
    copy->on_packet = NULL;
    if (!ll_failed(&status))
        write_arrivals(c, ll_tick_time(range->to, copy->freq));
    for (size_t i = c->first; i < c->end; i++)
        free(c->coming[i].bytes);
    free(c->coming);
    free(c);
    return status;
}

ll_status ll_session_capture(ll_session *s, const ll_capture_range *range,
                             void (*write)(void *context, const char *bytes, size_t length), void *context)
{
    ll_session *scratch;
    int64_t from = range->from, to = range->to;
    if (from < 0 || from > to || to > s->head)
        return ll_field_error(LL_BAD_INPUT, "to_s",
                              "from, to: must be in order from 0 to %" PRId64 "; got %" PRId64 " to %" PRId64,
                              s->head, from, to);
    LL_TRY(ll_session_copy(s, to, &scratch));
    ll_status status = ll_session_write_capture(scratch, range, NULL, write, context);
    ll_session_account_copy(s, scratch);
    ll_session_destroy(scratch);
    return status;
}
