/* Shared by the files of this room: the state of a transport, and what a protocol, a delivery class and a
 * congestion control are. */
#pragma once

#include <string.h>

#include "link/transport/transport.h"

#define LL_TRANSPORT_PACKET_MAX 1200 /* bytes of a packet after IPv4 and UDP: fits mtu_bytes' default */
#define LL_RANGES_MAX 8              /* of received packets that an endpoint remembers */
#define LL_LOSS_THRESHOLD 3          /* packets: duplicate acknowledgements, or the packet threshold */
#define LL_RTO_MAX (60 * LL_SECOND)
#define LL_INITIAL_WINDOW 10 /* mss: RFC 6928, RFC 9002 */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef enum ll_chunk_state {
    LL_CHUNK_DONE,   /* acknowledged, or given up */
    LL_CHUNK_QUEUED, /* to be sent, or sent again */
    LL_CHUNK_FLYING,
} ll_chunk_state;

enum { LL_CHUNK_FIRST = 1, LL_CHUNK_LAST = 2 }; /* of its message */

/* At the sender, in a ring by number. */
typedef struct ll_chunk {
    ll_time made;   /* the message was sent */
    ll_time sent;   /* last */
    int64_t packet; /* that last held it */
    uint16_t size;
    uint16_t order; /* of the message in its stream */
    uint8_t state;  /* ll_chunk_state */
    uint8_t flags, type;
    uint8_t sends;  /* 2: more than once */
    uint8_t misses; /* acknowledgements of later packets */
    uint8_t reserved[7];
} ll_chunk;

/* At the receiver, in a ring by number. */
typedef struct ll_cell {
    int64_t number; /* -1: none */
    ll_time arrived;
    uint16_t size, order;
    uint8_t flags, type;
    uint8_t taken; /* handed over */
    uint8_t reserved;
} ll_cell;

typedef struct ll_rtt {
    ll_time smoothed, variation, latest, least;
    int64_t samples;
} ll_rtt;

typedef struct ll_window {
    double bytes, threshold; /* slow start below the threshold */
    double plateau, root;    /* cubic: W_max and K, in mss and s */
    ll_time since;           /* cubic: start of the present growth; LL_LONG_AGO: none */
} ll_window;

typedef struct ll_sender {
    int64_t base, end; /* chunks that are not done begin here; number of the next one */
    int64_t kept;      /* the message of `base` begins here: the receiver may still need what was before */
    int64_t scan;      /* none before is queued */
    int64_t packet;    /* number of the next packet */
    int64_t largest;   /* highest packet known to have arrived; -1: none */
    int64_t recovery;  /* a loss of a packet from here on reduces the window */
    int32_t queued, flying, flight; /* chunks; chunks and bytes in flight */
    int32_t backoff;                /* time-outs in a row */
    ll_time expires;                /* of the retransmission timer, while something is in flight */
    ll_time last;                   /* when the last packet with chunks was sent */
    ll_time loss;                   /* when the time threshold is due; LL_NEVER: not running */
    ll_time progress;               /* last acknowledgement of something new, or first sending */
    ll_rtt rtt;
    ll_window window;
    uint16_t order[LL_TRANSPORT_TYPES]; /* of the next message of each type */
    int32_t limited; /* the window has held something back since the last acknowledgement */
    uint16_t marks;  /* quic: marked packets that the receiver has reported, modulo 2^16 */
    uint16_t answer; /* tcp: the next new chunks report that the window was reduced for a mark */
} ll_sender;

typedef struct ll_range {
    int64_t first, last;
} ll_range;

typedef struct ll_receiver {
    int64_t next;                  /* chunks before this have arrived or were given up */
    int64_t highest;               /* arrived chunks end here */
    int64_t floor;                 /* messages before this are handed over */
    ll_range range[LL_RANGES_MAX]; /* quic: received packets, the newest first */
    int16_t ranges;
    uint16_t marks;     /* quic: marked packets so far, modulo 2^16; tcp: 1 while marks are echoed */
    int32_t unacked;    /* packets with chunks since the last acknowledgement */
    ll_time largest_at; /* quic: when the newest packet came */
    ll_time ack_due;    /* LL_NEVER: none */
    uint16_t order[LL_TRANSPORT_TYPES];
} ll_receiver;

typedef struct ll_flow {
    ll_sender sender;
    ll_receiver receiver;
    int32_t chunks; /* places of the rings, a power of two */
    int32_t cell;   /* bytes of a place */
    int64_t ring;   /* offset of the rings from the transport: chunks, cells, sent bytes, received bytes */
} ll_flow;

struct ll_transport {
    ll_time due;
    int32_t kind, delivery, congestion;
    uint16_t generation[LL_SIDES]; /* of the connection, of each side */
    uint8_t open[LL_SIDES];
    uint8_t nagle;
    uint8_t reserved;
    int32_t message_max;
    ll_flow flow[LL_SIDES];
};

/* The first bytes of a packet. They stand for those that the protocol has there. */
typedef struct ll_packet_head {
    uint16_t generation;
    uint8_t flags; /* ll_packet_flag */
    uint8_t chunks;
    uint32_t kept;   /* the sender's: messages before it are done */
    uint32_t number; /* tcp: of the first chunk; others: of the packet */
    uint32_t next;   /* tcp: cumulative acknowledgement */
} ll_packet_head;

#pragma GCC diagnostic pop

/* Before each chunk of a packet; where chunks are adjacent, only the size. */
typedef struct ll_chunk_head {
    uint32_t number;
    uint16_t size; /* with flags from bit 11 and type from bit 13 */
    uint16_t order;
} ll_chunk_head;

typedef enum ll_packet_flag {
    LL_PACKET_ACK = 1,    /* an acknowledgement follows the head */
    LL_PACKET_RESET = 2,  /* this connection has ended */
    LL_PACKET_BLOCKS = 4, /* tcp: a selective acknowledgement follows */
    LL_PACKET_ECHO = 8, /* marks have come: ECE of tcp; with quic their number follows the acknowledgement */
    LL_PACKET_REDUCED = 16,         /* tcp: CWR */
    LL_PACKET_MARKED = LL_ECN_MARK, /* a link has marked it */
} ll_packet_flag;

/* Reads the head of the chunk at `from`. */
static inline ll_chunk_head ll_chunk_head_at(const char *from, bool adjacent)
{
    ll_chunk_head head = {0};
    memcpy(adjacent ? (char *)&head.size : (char *)&head, from, adjacent ? sizeof head.size : sizeof head);
    return head;
}

static inline int ll_chunk_bytes(const ll_chunk_head *head)
{
    return head->size & 0x7ff;
}

static inline ll_chunk *ll_chunk_of(const ll_transport *t, const ll_flow *f, int64_t number)
{
    return (ll_chunk *)((char *)t + f->ring) + (number & (f->chunks - 1));
}

static inline ll_cell *ll_place_of(const ll_transport *t, const ll_flow *f, int64_t number)
{
    char *cells = (char *)t + f->ring + (size_t)f->chunks * sizeof(ll_chunk);
    return (ll_cell *)cells + (number & (f->chunks - 1));
}

static inline char *ll_sent_bytes(const ll_transport *t, const ll_flow *f, int64_t number)
{
    char *bytes = (char *)t + f->ring + (size_t)f->chunks * (sizeof(ll_chunk) + sizeof(ll_cell));
    return bytes + (number & (f->chunks - 1)) * f->cell;
}

static inline char *ll_received_bytes(const ll_transport *t, const ll_flow *f, int64_t number)
{
    return ll_sent_bytes(t, f, number) + (ptrdiff_t)f->chunks * f->cell;
}

static inline bool ll_arrived(const ll_transport *t, const ll_flow *f, int64_t number)
{
    return ll_place_of(t, f, number)->number == number;
}

/* A number of which 32 bits were sent, near `near`. */
static inline int64_t ll_number_near(int64_t near, uint32_t sent)
{
    return near + (int32_t)(sent - (uint32_t)near);
}

/* ---- delivery classes ---- */

typedef struct ll_delivery_class {
    bool reliable;
    bool ordered;   /* all messages in one stream */
    bool by_type;   /* a stream for each type */
    bool sequenced; /* one that comes after a later one of its type is dropped */
} ll_delivery_class;

const ll_delivery_class *ll_delivery_of(const ll_transport *t);

/* ---- congestion control ---- */

void ll_window_init(ll_window *window, double mss);
/* `full`: the window limited the sender. */
void ll_window_acked(const ll_transport *t, ll_sender *s, double bytes, bool full, ll_time now);
void ll_window_lost(const ll_transport *t, ll_sender *s, ll_time now);
/* The other side reports marks, with an acknowledgement whose newest packet is `newest`. As at a loss, but
 * nothing is sent again. True: the window is reduced. */
bool ll_window_marked(const ll_transport *t, ll_sender *s, int64_t newest, ll_time now);
void ll_window_collapse(const ll_transport *t, ll_sender *s,
                        ll_time now); /* persistent congestion, time-out */

/* ---- protocols ---- */

typedef struct ll_protocol {
    int32_t header;       /* bytes of a packet after IPv4 and UDP, without acknowledgement and chunks */
    int32_t chunk_header; /* bytes before each chunk */
    int32_t ack_max;      /* longest acknowledgement next to chunks */
    int32_t deliveries;   /* bits of ll_delivery that it can do */
    int32_t usual;        /* ll_delivery */
    bool ecn;             /* takes part in ECN: reacts to marks */
    bool adjacent;        /* a packet holds chunks of consecutive numbers: a piece of a byte stream */
    bool always_acks;     /* every packet acknowledges, without bytes of its own */
    ll_time ack_delay;    /* longest time until a packet in order is acknowledged, if no second one comes */
    ll_time rto_initial, rto_min;
    /* Appends the acknowledgement of what flow `f` has received; its bytes. */
    int (*write_ack)(const ll_transport *t, const ll_flow *f, ll_packet_head *head, char *to, ll_time now);
    /* Reads one of what flow `f` has sent. */
    void (*read_ack)(ll_transport *t, const ll_transport_env *env, int side, const ll_packet_head *head,
                     const char *from, ll_time now);
    int (*ack_size)(const ll_packet_head *head, const char *from); /* bytes that read_ack reads */
    ll_time (*rto)(const ll_sender *s);                            /* without backoff */
    /* The retransmission timer of the sender of `side` has ended. */
    void (*time_out)(ll_transport *t, const ll_transport_env *env, int side, ll_time now);
    /* The time threshold is due; NULL: it has none. */
    void (*find_losses)(ll_transport *t, const ll_transport_env *env, int side, ll_time now);
    /* Notes that a packet was received; false: it was before. `gap`: it does not follow the newest so far.
     * NULL: packets have no numbers, and there is a gap where a chunk is missing. */
    bool (*note_packet)(ll_receiver *r, int64_t number, bool *gap, ll_time now);
    /* With ECN: a packet with chunks came that is marked, or reports a reduction. */
    void (*note_flags)(ll_receiver *r, uint8_t flags);
    bool timer_by_packet; /* the retransmission timer runs from the last packet, not from the oldest */
} ll_protocol;

/* In the order of LL_TRANSPORTS; udp has no functions. */
extern const ll_protocol ll_protocol_udp, ll_protocol_tcp, ll_protocol_quic, ll_protocol_webrtc;
const ll_protocol *ll_protocol_of(int kind);

static inline int32_t ll_mss(const ll_protocol *p)
{
    return LL_TRANSPORT_PACKET_MAX - p->header - p->ack_max - p->chunk_header;
}

/* ---- recovery.c: what an acknowledgement does to a sender ---- */

/* A round trip of which the other side held the acknowledgement for `held`. */
void ll_rtt_add(ll_rtt *rtt, ll_time sample, ll_time held);
/* Starts the retransmission timer as of `from`. */
void ll_timer_start(const ll_transport *t, ll_sender *s, ll_time from, ll_time now);
ll_time ll_rto_of(const ll_sender *s, ll_time initial, ll_time granularity, ll_time least, ll_time extra);

/* What an acknowledgement newly acknowledges. */
typedef struct ll_acked {
    int64_t newest; /* the latest packet of it; -1: nothing is new */
    ll_time sent;   /* of the latest chunk that was sent once */
    int64_t bytes;
    bool measured; /* `sent` is of use */
    bool full;     /* the window was in use when it came */
} ll_acked;

ll_acked ll_acked_begin(const ll_transport *t, const ll_sender *s);
void ll_acked_chunk(const ll_transport *t, ll_flow *f, int64_t number, ll_acked *all);
void ll_acked_end(ll_transport *t, int side, const ll_acked *all, ll_time now);

/* The chunk counts as lost: it is queued again, or given up. */
void ll_chunk_lost(ll_transport *t, const ll_transport_env *env, int side, int64_t number, ll_time now);
/* The same as soon as as many acknowledgements as the threshold came for later packets (tcp, webrtc). */
void ll_count_misses(ll_transport *t, const ll_transport_env *env, int side, int64_t newest, ll_time now);
/* All that is in flight counts as lost, the window shrinks to one packet, the timer doubles. */
void ll_time_out_all(ll_transport *t, const ll_transport_env *env, int side, ll_time now);

/* ---- gaps.c: acknowledgements by chunk ---- */

/* The last `most` blocks of chunks that arrived beyond a gap, in ascending order; how many. */
int ll_blocks_of(const ll_transport *t, const ll_flow *f, ll_range *blocks, int most);
/* Returns the newest packet that is newly acknowledged; -1: none. */
int64_t ll_take_blocks(ll_transport *t, const ll_transport_env *env, int side, int64_t next,
                       const ll_range *blocks, int count, ll_time now);

/* ---- sending.c ---- */

void ll_transport_push(ll_transport *t, const ll_transport_env *env, int side, bool probe, ll_time now);
void ll_transport_send_ack(ll_transport *t, const ll_transport_env *env, int side, uint8_t flags,
                           uint16_t generation, ll_time now);

/* ---- transport.c ---- */

void ll_transport_watch(const ll_transport_env *env, const ll_transport_note *note, ll_time now);
void ll_transport_reset(ll_transport *t, const ll_transport_env *env, int side, ll_time now);
void ll_transport_renew_due(ll_transport *t, const ll_transport_env *env);
