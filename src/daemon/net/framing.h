/* The framing of WebSockets (RFC 6455) as a server reads and writes it: pure functions, no sockets.
 *
 * A reader is given bytes as they come, in pieces of any size, and tells event by event what they are. What
 * the RFC does not allow, an unmasked frame above all, is a fault: nothing behind it can be read, and the
 * connection ends with the fault's close code. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum ll_framing_event {
    LL_FRAMING_NONE,  /* all bytes are used up */
    LL_FRAMING_PIECE, /* of a message: a frame, or as much of it as is there */
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

#define LL_FRAMING_CONTROL 125  /* most bytes of a ping, a pong, a close */
#define LL_FRAMING_ROOM 16      /* before a payload, for its head */
#define LL_FRAMING_NO_CODE 1005 /* of a close frame without one (RFC 6455 7.4.1) */

/* All zero: before the first byte. */
typedef struct ll_framing {
    unsigned char head[14], control[LL_FRAMING_CONTROL];
    int head_size, control_size;
    uint64_t left; /* of the payload */
    unsigned masked;
    bool in_payload, fresh; /* fresh: nothing of the message was told */
    ll_opcode message;      /* that is begun; 0: none */
    uint8_t utf8_left, utf8_low, utf8_high;
    bool broken;

    /* of the last event */
    const unsigned char *bytes; /* payload of a piece, or of a control frame */
    size_t size;
    bool first, last, binary; /* of a piece */
    int code;                 /* of a close, of a fault */
    const char *fault;        /* a sentence */
} ll_framing;

/* Reads `bytes` from `*used` on, and sets `*used` to where it came. Unmasks them where they are. */
ll_framing_event ll_framing_read(ll_framing *framing, unsigned char *bytes, size_t size, size_t *used);

/* Writes the head of an unmasked whole frame into the room before `payload`; gives its size. */
size_t ll_framing_put_head(unsigned char *payload, size_t size, ll_opcode opcode);

bool ll_framing_is_code(int code); /* that a close frame may have */

/* Sec-WebSocket-Accept of a key (RFC 6455 4.2.2), with its NUL. */
bool ll_framing_accept(const char *key, char accept[29]);
