/* WebSocket framing (RFC 6455) for a server: pure functions, no sockets.
 *
 * A reader gets bytes in pieces of any size and returns events. Anything that the RFC forbids, such as an
 * unmasked frame of a client, is a fault: nothing after it can be read, and the connection ends with the
 * fault's close code. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum ll_framing_event {
    LL_FRAMING_NONE,  /* all bytes are consumed */
    LL_FRAMING_PIECE, /* of a message: a frame, or what has arrived of it */
    LL_FRAMING_PING,
    LL_FRAMING_PONG,
    LL_FRAMING_CLOSE,
    LL_FRAMING_FAULT,
} ll_framing_event;

typedef enum ll_opcode {
    LL_OPCODE_CONTINUATION = 0,
    LL_OPCODE_TEXT = 1,
    LL_OPCODE_BINARY = 2,
    LL_OPCODE_CLOSE = 8,
    LL_OPCODE_PING = 9,
    LL_OPCODE_PONG = 10,
} ll_opcode;

#define LL_FRAMING_CONTROL_MAX 125 /* maximum payload of ping, pong and close */
#define LL_FRAMING_HEAD_SPACE 16   /* space before a payload for its head */
#define LL_FRAMING_NO_CODE 1005    /* for a close frame without a code (RFC 6455 7.4.1) */

/* All zero: initial state. */
typedef struct ll_framing {
    unsigned char head[14], control[LL_FRAMING_CONTROL_MAX];
    int head_size, control_size;
    uint64_t left; /* remaining bytes of the payload */
    unsigned masked;
    bool in_payload, fresh; /* fresh: no event of the message yet */
    ll_opcode message;      /* opcode of the open message; 0: none */
    uint8_t utf8_left, utf8_low, utf8_high;
    bool broken;

    /* data of the last event */
    const unsigned char *bytes; /* payload of a piece, or of a control frame */
    size_t size;
    bool first, last, binary; /* for a piece */
    int code;                 /* for close and fault */
    const char *fault;        /* message */
} ll_framing;

/* Reads `bytes` from `*used` on, and sets `*used` to the first unread byte. Unmasks in place. */
ll_framing_event ll_framing_read(ll_framing *framing, unsigned char *bytes, size_t size, size_t *used);

/* Writes the head of an unmasked, unfragmented frame before `payload`; returns its size. */
size_t ll_framing_put_head(unsigned char *payload, size_t size, ll_opcode opcode);

/* Sec-WebSocket-Accept for a key (RFC 6455 4.2.2), NUL-terminated. */
bool ll_framing_accept(const char *key, char accept[29]);
