/* Events of a netgame: the rows written to its recorder (base/recorder.h), for the message lanes of a view
 * and for tests. */
#pragma once

#include <stdint.h>

#include "base/vtime.h"

typedef struct ll_event {
    uint32_t id;  /* set by the recorder; counts up */
    uint8_t type; /* ll_event_type */
    uint8_t player;
    uint8_t fate;    /* of a packet: 0 delivered, 1 lost, 2 queue overflow, 3 corrupted */
    uint8_t outcome; /* of an input's result and of an applied snapshot: ll_outcome */
    ll_time begin;   /* time sent; of other events: time */
    ll_time end;     /* time due; equal to `begin` when lost */
    uint32_t
        number; /* input: sequence number; snapshot: server tick; input's result: sequence number or tick */
    uint32_t tick;   /* input: the server's step that the input is meant for; 0: it is applied with
                        the step after its arrival, or the packet has no snapshot for an answer */
    float device_ms; /* input: from moving the controls to its newest input */
    float held_ms;   /* input: from making its newest input to sending the packet */
    float value; /* correction: signed distance in m; input: first axis; applied snapshot: x of the own entity
                  */
} ll_event;

typedef enum ll_outcome {
    LL_OUTCOME_APPLIED = 0,
    LL_OUTCOME_REFUSED = 1,     /* by a rule of the server */
    LL_OUTCOME_STALE = 2,       /* a snapshot older than the last one */
    LL_OUTCOME_LATE = 3,        /* an input that arrived after its step */
    LL_OUTCOME_UNDECODABLE = 4, /* a snapshot that could not be decoded */
} ll_outcome;

typedef enum ll_event_type {
    LL_EVENT_INPUT = 1,         /* `player` sent an input packet */
    LL_EVENT_SNAPSHOT = 2,      /* a snapshot was sent to `player` */
    LL_EVENT_REFUSAL = 3,       /* a refusal was sent to `player` */
    LL_EVENT_RELAY = 4,         /* other players' inputs were sent to `player` */
    LL_EVENT_CONNECT = 5,       /* `player` asked to connect */
    LL_EVENT_ACCEPT = 6,        /* the server accepted */
    LL_EVENT_PING = 7,          /* `player` asked for the server's time */
    LL_EVENT_PONG = 8,          /* the server answered, or sent a keep-alive */
    LL_EVENT_INPUT_RESULT = 16, /* the server applied or refused input `number` of `player` */
    LL_EVENT_APPLIED = 17,      /* `player` applied snapshot `number` */
    LL_EVENT_CORRECTION =
        18,              /* reconciliation with snapshot `number` moved `player`'s own entity by `value` m */
    LL_EVENT_STEP = 19,  /* the server made step `number` */
    LL_EVENT_STALL = 20, /* `player` had waited `value` ms for the players in the bits of `number` */
    LL_EVENT_ROLLBACK = 21, /* `player` resimulated from tick `number`, `value` ticks in all */
    LL_EVENT_DESYNC = 22,   /* `player`'s state differs from the server's at tick `number`, by `value` ulps */
    LL_EVENT_CONNECTION =
        23,                /* `player`'s connection has the state `outcome`, in its `number`-th connection */
    LL_EVENT_DROPPED = 24, /* the server continues without `player`, for the `number`-th time */
    LL_EVENT_DISPLAY = 25, /* `player`'s display shows for the first time snapshot `number`, or, where
                              displays are apart from ticks, a predicted input */
    LL_EVENT_SEGMENT = 26, /* a packet of `player`'s transport was lost, or sent what was sent before;
                              `outcome`: bits of ll_segment */
    LL_EVENT_BLOCKED = 27, /* a message of `player`'s transport, complete at `begin`, waited until `end` for
                              an earlier one; `number` and `outcome` as of its event and of a segment */
} ll_event_type;

/* Of segments and blocked messages. */
typedef enum ll_segment { LL_SEGMENT_RESENT = 1, LL_SEGMENT_UP = 2 /* to the server */ } ll_segment;
