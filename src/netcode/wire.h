/* The messages between server and clients: all that passes between them. */
#pragma once

#include <stdint.h>

#include "base/vtime.h"
#include "game/game.h"

#define LL_INPUTS_MAX 16   /* inputs in a packet: the newest and repeated ones */
#define LL_UDP_OVERHEAD 28 /* bytes of IPv4 and UDP headers, for bandwidth */

typedef enum ll_message { LL_MESSAGE_INPUT = 1, LL_MESSAGE_STATE = 2, LL_MESSAGE_REFUSAL = 3 } ll_message;

/* Every message starts with these; a change of `sync` starts a new epoch, and what was sent in an older one
 * is void. */
typedef struct ll_message_head {
    uint8_t type;
    uint8_t count; /* inputs; of a state: its ll_part; of a refusal: the rule */
    uint16_t epoch;
    uint32_t seq; /* input: sequence number of the first; state: acknowledged; refusal: the refused */
} ll_message_head;

/* What a state may hold between its message and the world, in this order. */
typedef enum ll_part {
    LL_PART_CONTROLS = 1, /* an ll_controls for each player but the receiver */
} ll_part;

/* Inputs with sequence numbers seq, seq + 1, ...; the first is meant for the server's step `tick`. */
typedef struct ll_input_message {
    ll_message_head head;
    int32_t tick;
    uint16_t wants;                  /* ll_part: what the states to this client are to hold */
    uint16_t lead;                   /* so many steps before `tick` is that of the newest state that it has */
    ll_action inputs[LL_INPUTS_MAX]; /* only head.count are sent */
} ll_input_message;

/* What somebody's controls were at the step of a state. */
typedef struct ll_controls {
    float axis[2];
    uint32_t buttons;
} ll_controls;

/* Its parts follow, and then the world, encoded. */
typedef struct ll_state_message {
    ll_message_head head;
    int64_t tick; /* the server's step that this is the state after */
    ll_time time; /* when, by the server's clock */
    float update_hz;
    int32_t slack;      /* how many steps early the player's inputs came, the least since the last update */
    uint32_t slack_seq; /* of the input that came so */
    uint16_t codec;     /* index into ll_codecs */
    uint16_t baseline;  /* how many ticks before `tick` the state was that this is told against; 0: none */
} ll_state_message;

#define LL_SLACK_UNKNOWN INT32_MAX

static inline int ll_input_message_size(int count)
{
    return (int)offsetof(ll_input_message, inputs) + count * (int)sizeof(ll_action);
}
