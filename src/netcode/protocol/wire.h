/* All messages between server and clients. */
#pragma once

#include <stdint.h>
#include <string.h>

#include "base/vtime.h"
#include "game/core/game.h"

#define LL_INPUTS_MAX 16   /* inputs in a packet: the newest and repeated ones */
#define LL_UDP_OVERHEAD 28 /* bytes of IPv4 and UDP headers of a packet, for bandwidth */

typedef enum ll_message {
    LL_MESSAGE_INPUT = 1,
    LL_MESSAGE_SNAPSHOT = 2,
    LL_MESSAGE_REFUSAL = 3,
    LL_MESSAGE_RELAY = 4,   /* other players' inputs */
    LL_MESSAGE_CONNECT = 5, /* from a client that is not connected */
    LL_MESSAGE_ACCEPT = 6,  /* the server's answer to a connect */
    LL_MESSAGE_PING = 7,    /* from a connected client: asks for the server's time */
    LL_MESSAGE_PONG = 8,    /* the answer to a ping, or an unrequested keep-alive */
    LL_MESSAGES,
} ll_message;

/* Every message starts with these. A change of `sync`, and a player who joins again, start a new epoch:
 * messages of an earlier one are discarded. */
typedef struct ll_message_head {
    uint8_t type;
    uint8_t count; /* input: number of inputs; snapshot: its ll_part; refusal: the rule; answer: its
                      ll_answer_part */
    uint16_t epoch;
    uint32_t seq; /* input: sequence number of the first; snapshot: of the last whose step is over; relay:
                     last known; refusal: the refused; connect, accept: the attempt; ping, pong: its number */
} ll_message_head;

/* From a client: connect and ping. */
typedef struct ll_request_message {
    ll_message_head head;
    ll_time sent; /* by the client's clock */
    ll_time seen; /* server time of the newest answer that the client has; LL_NEVER: none */
} ll_request_message;

typedef enum ll_answer_part {
    LL_ANSWER_ECHO = 1,  /* `sent` is that of a request, so that the client can measure its clock */
    LL_ANSWER_WORLD = 2, /* the world after step `tick` follows, as it lies in memory */
    LL_ANSWER_OWN = 4, /* after that: the newest tick (int64_t) of which the server has an input of the player
                          from before, which others may have too; those after it up to `first` are neutral */
} ll_answer_part;

/* From the server: accept and pong. A pong of epoch 0 means that the player is not connected. */
typedef struct ll_answer_message {
    ll_message_head head;
    ll_time sent;     /* of the request */
    ll_time received; /* answered at the same time, by the server's clock */
    int64_t tick;     /* the server's step */
    int64_t first;    /* accept: the player's first input is for the step after this one */
} ll_answer_message;

/* Optional parts between the header of a snapshot message and its world, in this order. */
typedef enum ll_part {
    LL_PART_AXES = 1,    /* an ll_axes for each player but the receiver */
    LL_PART_APPLIED = 2, /* an ll_input_result_part and its words */
    /* In an input message: after its inputs follows a word, a bit for each of the 32 ticks before that of the
     * newest snapshot that the client has, the latest first: it has the snapshot of that tick too. */
    LL_PART_RECEIVED = 4,
    LL_PART_STATE = 8, /* in an input message, after that: an ll_motion, the state of the own entity after the
                          last of the inputs (netcode/protocol/report.h) */
} ll_part;

/* Inputs with sequence numbers seq, seq + 1, ...; the first is meant for the server's step `tick`. */
typedef struct ll_input_message {
    ll_message_head head;
    int32_t tick;
    uint8_t wants; /* ll_part: parts that snapshots to this client must contain, and of this message */
    uint8_t fresh; /* number of inputs, the last ones, that are sent for the first time */
    uint16_t
        lead; /* number of steps from the newest snapshot that the client has to `tick`; 0: it has none */
    ll_action inputs[LL_INPUTS_MAX]; /* only head.count are sent */
} ll_input_message;

/* A player's controls in a step. */
typedef struct ll_controls {
    float axis[2];
    uint32_t buttons;
} ll_controls;

/* The same without presses, which a guess never repeats. */
typedef struct ll_axes {
    float axis[2];
} ll_axes;

/* Which of the receiver's last inputs were applied: bit i of the words that follow stands for input newest -
 * i. As many words as reach back to the newest snapshot that the client is known to have. */
typedef struct ll_input_result_part {
    uint32_t newest, words;
} ll_input_result_part;

#define LL_INPUT_RESULT_WORDS_MAX 16

/* Its parts follow, and then the world, encoded. */
typedef struct ll_snapshot_message {
    ll_message_head head;
    int64_t tick; /* the server's step whose result this is */
    ll_time time; /* of that step, by the server's clock */
    float update_hz;
    uint32_t applied;   /* the newest applied input; 0: none */
    int32_t slack;      /* smallest slack of the player's inputs since the last update, steps */
    uint32_t slack_seq; /* input with that slack */
    uint16_t codec;     /* index into ll_codecs */
    uint16_t baseline;  /* number of ticks from the baseline to `tick`; 0: no baseline */
    uint32_t refused;   /* the newest input whose reported state was refused; 0: none */
} ll_snapshot_message;

#define LL_SLACK_UNKNOWN INT32_MAX

/* ---- deterministic and rollback: only inputs are sent ---- */

#define LL_RUNS_MAX 32   /* of one player in a packet; the rest is sent when these are acknowledged */
#define LL_HASHES_MAX 64 /* in a packet */

/* Equal inputs for `count` ticks in a row. */
typedef struct ll_input_run {
    ll_controls input;
    uint32_t count;
} ll_input_run;

/* What a client knows of a player. */
typedef struct ll_peer_ack {
    int32_t known; /* has its inputs up to this tick */
    int32_t ahead; /* ticks that it is ahead of that player */
} ll_peer_ack;

#define LL_WAY_GAP (UINT32_C(1) << 31)

/* From a client: its unacknowledged inputs, head.count of them, and the unacknowledged hashes of its world
 * after ticks hashed, hashed + 1, ... An ll_peer_ack per player, runs and hashes (uint32_t) follow. Over a
 * mesh each other player gets one, with the inputs that this player has not acknowledged. */
typedef struct ll_peer_message {
    ll_message_head head;
    int32_t tick; /* of the first input */
    uint32_t
        way; /* one-way delay as measured by the client, us; combined with LL_WAY_GAP if relays had stopped */
    int32_t at;     /* the client's tick */
    int32_t hashed; /* tick of the first hash */
    uint16_t runs;
    uint16_t other; /* over a mesh: 1 + the player that this copy is for, once it has passed the server 1 +
                       the player that it is from; 0: it is for the server. Stands for an address of IP. */
    uint32_t hashes;
} ll_peer_message;

/* To a client: the other players' inputs that it has not acknowledged, a part per player. The parts follow.
 * Over a mesh there are parts only of inputs that the server made for players who were not connected. */
typedef struct ll_relay_message {
    ll_message_head head; /* count: parts */
    int32_t tick;         /* steps that the server has made */
    int32_t barrier; /* no player makes inputs for a tick beyond this one (netcode/server/barrier.h); 0: no
                        barrier */
    ll_time time;    /* of the last step, by the server's clock */
    int32_t hashed;  /* the client's hashes up to this tick have arrived */
    int32_t
        resume; /* the barrier ends when this many ticks have passed since the game began; 0: not known yet */
} ll_relay_message;

/* The runs follow. */
typedef struct ll_relay_part {
    int32_t tick;  /* of the first input */
    int32_t at;    /* the player's tick; -1: unknown */
    int32_t ahead; /* lead of the receiving client as the player sees it, ticks */
    uint16_t player, runs;
} ll_relay_part;

/* Adds an input to `count` runs; false if that needs one run too many. */
static inline bool ll_run_add(ll_input_run *runs, int *count, const ll_controls *input)
{
    if (*count > 0 && memcmp(&runs[*count - 1].input, input, sizeof *input) == 0) {
        runs[*count - 1].count++;
        return true;
    }
    if (*count == LL_RUNS_MAX)
        return false;
    runs[(*count)++] = (ll_input_run){*input, 1};
    return true;
}

static inline int ll_input_message_size(int count)
{
    return (int)offsetof(ll_input_message, inputs) + count * (int)sizeof(ll_action);
}

/* The longest packet of each kind with this many players. */
static inline int ll_peer_message_max(int players)
{
    return (int)(sizeof(ll_peer_message) + (size_t)players * sizeof(ll_peer_ack) +
                 LL_RUNS_MAX * sizeof(ll_input_run) + LL_HASHES_MAX * sizeof(uint32_t));
}

static inline int ll_relay_message_max(int players)
{
    return (int)(sizeof(ll_relay_message) +
                 (size_t)(players - 1) * (sizeof(ll_relay_part) + LL_RUNS_MAX * sizeof(ll_input_run)));
}
