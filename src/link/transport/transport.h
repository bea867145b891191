/* Transports: how the messages of a player's connection become packets on its two links.
 *
 *   udp     a message is a packet of its own, lost or late as the link decides. It has no state here: a
 * caller sends on the link directly (ll_transport_plain). tcp     one reliable ordered stream each way (RFC
 * 9293, with selective acknowledgements, RFC 2018) quic    streams side by side in one connection (RFC 9000,
 * RFC 9002) webrtc  a data channel: SCTP over DTLS over UDP (RFC 8831, RFC 9260)
 *
 * A message is cut into chunks of at most `mss` bytes, which are numbered in the order of sending. A packet
 * holds chunks and an acknowledgement of the other direction; both share its fate. A chunk that counts as
 * lost is sent again in a new packet. docs/transports.md has every rule.
 *
 * There are two endpoints: side 0 is the client, side 1 the server. Side s sends on flow s: 0 is up, 1 down.
 *
 * A connection on which nothing is acknowledged for `timeout` ends, and what it held is dropped. The client
 * then opens another, with the next generation; the server takes part in it from its first packet on.
 * Opening costs no round trip: the handshakes of the protocols are left out.
 *
 * A transport is a relocatable part of a simulation's block: indices, no pointers, no allocation. All times
 * are virtual. Cost: a message about as much as two sendings on a link; a lost packet a scan of what is in
 * flight. */
#pragma once

#include "link/line/link.h"

typedef struct ll_transport ll_transport;

/* clang-format off */
/* The rows of the list: stored configurations hold the index. */
#define LL_TRANSPORTS(ROW) \
    ROW(UDP, udp) \
    ROW(TCP, tcp) \
    ROW(QUIC, quic) \
    ROW(WEBRTC, webrtc)

/* How messages are delivered: ROW(ID, name, ...) in the order of ll_deliveries. */
#define LL_DELIVERIES(ROW) \
    ROW(USUAL, usual) \
    ROW(UNRELIABLE, unreliable) \
    ROW(SEQUENCED, sequenced) \
    ROW(UNORDERED, reliable_unordered) \
    ROW(BY_TYPE, reliable_ordered_by_type) \
    ROW(ORDERED, reliable_ordered)

#define LL_CONGESTIONS(ROW) \
    ROW(RENO, reno) \
    ROW(CUBIC, cubic)
/* clang-format on */

#define LL_TRANSPORT_ID(ID, NAME) LL_TRANSPORT_##ID,
#define LL_DELIVERY_ID(ID, NAME) LL_DELIVERY_##ID,
#define LL_CONGESTION_ID(ID, NAME) LL_CONGESTION_##ID,
typedef enum ll_transport_kind { LL_TRANSPORTS(LL_TRANSPORT_ID) LL_TRANSPORT_KINDS } ll_transport_kind;
typedef enum ll_delivery { LL_DELIVERIES(LL_DELIVERY_ID) LL_DELIVERY_CLASSES } ll_delivery;
typedef enum ll_congestion_kind { LL_CONGESTIONS(LL_CONGESTION_ID) LL_CONGESTION_KINDS } ll_congestion_kind;
#undef LL_TRANSPORT_ID
#undef LL_DELIVERY_ID
#undef LL_CONGESTION_ID

extern const char *const ll_transport_names[LL_TRANSPORT_KINDS + 1]; /* NULL-terminated, like the others */
extern const char *const ll_delivery_names[LL_DELIVERY_CLASSES + 1];
extern const char *const ll_congestion_names[LL_CONGESTION_KINDS + 1];

#define LL_TRANSPORT_TYPES 8 /* of messages: 0 to 7, each a stream of its own where streams are by type */
#define LL_IP_UDP_HEADER 28  /* bytes of IPv4 and UDP that every packet of a link has */

enum { LL_CLIENT_SIDE, LL_SERVER_SIDE, LL_SIDES };

/* Of one direction: what it must hold. */
typedef struct ll_flow_limits {
    double messages_per_s;
    int32_t message_max; /* bytes */
} ll_flow_limits;

typedef struct ll_transport_setup {
    int32_t kind, delivery, congestion;
    bool nagle; /* tcp: small segments wait while others are unacknowledged (RFC 896) */
    ll_flow_limits flow[LL_SIDES];
} ll_transport_setup;

/* True: messages are packets; nothing of this room but its tables is used. */
bool ll_transport_plain(int kind);

/* Whether the transport can deliver so. */
bool ll_transport_delivers(int kind, int delivery);

/* For a link's plan: where its marks are to be seen, or 0 where a transport does not react to them. */
uint32_t ll_transport_ecn(int kind);

/* Slots and bytes that a link needs for the packets of flow `side` and the acknowledgements of the other. */
int ll_transport_link_slots(const ll_transport_setup *setup, int side);
int ll_transport_link_arena(const ll_transport_setup *setup, int side);

/* ---- what an observer gets ---- */

typedef enum ll_transport_event {
    LL_TRANSPORT_PACKET,    /* sent; `sending` is its fate */
    LL_TRANSPORT_HANDED,    /* a message was handed over */
    LL_TRANSPORT_LOST,      /* a message will not arrive: it counts as lost and is not sent again */
    LL_TRANSPORT_REFUSED,   /* a message was not taken: the send buffer is full, or there is no connection */
    LL_TRANSPORT_TIMED_OUT, /* the retransmission timer ended */
    LL_TRANSPORT_ENDED,     /* the connection ended; `chunks` were dropped */
} ll_transport_event;

typedef struct ll_transport_note {
    ll_transport_event event;
    int side;       /* the sender's */
    int type;       /* of the message; of a packet's first chunk */
    int64_t number; /* of a packet, or of a message's first chunk */
    ll_sending sending;
    int wire_bytes;   /* of a packet, all headers included */
    int header_bytes; /* of that, everything but the bytes of messages */
    int chunks;       /* in the packet; 0: only an acknowledgement */
    int resent;       /* of these, sent before; of a message handed over: not 0 if any chunk was sent twice */
    double window;    /* congestion window, bytes */
    ll_time made;     /* message: when it was sent */
    ll_time complete; /* message: when its last byte arrived */
    const void *bytes; /* message handed over */
    int size;
} ll_transport_note;

/* What a transport works with, for one call: the links of the player and how they are used. */
typedef struct ll_transport_env {
    ll_link *link[LL_SIDES];
    const ll_link_plan *plan[LL_SIDES];
    ll_time timeout; /* LL_NEVER: connections do not end */
    void (*watch)(void *context, const ll_transport_note *note, ll_time now); /* may be NULL */
    void *context;
} ll_transport_env;

/* ---- a transport ---- */

size_t ll_transport_size(const ll_transport_setup *setup); /* a multiple of 8 */
void ll_transport_init(ll_transport *t, const ll_transport_setup *setup, ll_time now);

/* Sends a message of `size` bytes (1 to the flow's message_max) from `side`; false: refused. */
bool ll_transport_send(ll_transport *t, const ll_transport_env *env, int side, int type, const void *bytes,
                       int size, ll_time now);

/* Takes the packet that is due off the link to `side`. Then ll_transport_take until it returns -1, and
 * ll_transport_settle. */
void ll_transport_arrive(ll_transport *t, const ll_transport_env *env, int side, ll_time now);

/* The next message for `side`, copied out: its size, or -1. */
int ll_transport_take(ll_transport *t, const ll_transport_env *env, int side, void *bytes, int capacity,
                      ll_time now);

/* Sends the acknowledgement that is due at `side`, where no packet has carried it yet. */
void ll_transport_settle(ll_transport *t, const ll_transport_env *env, int side, ll_time now);

/* Number of the first chunk of the next message from `side`. */
int64_t ll_transport_next(const ll_transport *t, int side);

ll_time ll_transport_due(const ll_transport *t); /* of the first timer; LL_NEVER: none */
void ll_transport_run_timers(ll_transport *t, const ll_transport_env *env, ll_time now);

bool ll_transport_reliable(const ll_transport *t); /* what is lost is sent again */
bool ll_transport_valid(const ll_transport *t);    /* for LL_VALIDATE */
