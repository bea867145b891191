/* What happened in a simulation, for the lanes, dots and marks of a view and for tests. */
#pragma once

#include <stdint.h>

#include "base/vtime.h"

typedef struct ll_event {
    uint32_t id;  /* set by whoever keeps events; counts up */
    uint8_t type; /* ll_event_type */
    uint8_t player;
    uint8_t fate;    /* of a packet: 0 delivered, 1 lost, 2 queue overflow, 3 corrupted */
    uint8_t outcome; /* of a verdict and of an applied state: ll_outcome */
    ll_time begin;   /* sent; of other events: when */
    ll_time end;     /* due; equal to `begin` when lost */
    uint32_t number; /* input: sequence number; state: server tick; verdict: sequence number or tick */
    float value; /* correction: signed distance in m; input: first axis; applied state: x of the own entity */
} ll_event;

typedef enum ll_outcome {
    LL_OUTCOME_APPLIED = 0,
    LL_OUTCOME_REFUSED = 1,    /* against a rule of the server */
    LL_OUTCOME_STALE = 2,      /* a state older than the one before it */
    LL_OUTCOME_LATE = 3,       /* an input that came after its step */
    LL_OUTCOME_UNREADABLE = 4, /* a state that could not be decoded */
} ll_outcome;

typedef enum ll_event_type {
    LL_EVENT_INPUT = 1,    /* an input packet was sent by `player` */
    LL_EVENT_STATE = 2,    /* a state packet was sent to `player` */
    LL_EVENT_REFUSAL = 3,  /* a refusal was sent to `player` */
    LL_EVENT_RELAY = 4,    /* the others' inputs were sent to `player` */
    LL_EVENT_CONNECT = 5,  /* `player`, who is not connected, asked the server to be let in */
    LL_EVENT_ACCEPT = 6,   /* and the server's answer */
    LL_EVENT_PING = 7,     /* `player` asked for the server's time */
    LL_EVENT_PONG = 8,     /* and the server's answer, or a keep-alive */
    LL_EVENT_VERDICT = 16, /* the server took or refused input `number` of `player` */
    LL_EVENT_APPLIED = 17, /* `player` applied state `number` */
    LL_EVENT_CORRECTION =
        18,              /* `player`'s own entity was moved by `value` m on reconciling with state `number` */
    LL_EVENT_STEP = 19,  /* the server made step `number` */
    LL_EVENT_STALL = 20, /* `player` had waited `value` ms for the players of the bits of `number` */
    LL_EVENT_ROLLBACK = 21, /* `player` made tick `number` and those after it again, `value` in all */
    LL_EVENT_DESYNC = 22,   /* `player` left the server's world at tick `number`, by `value` ulps */
    LL_EVENT_CONNECTION =
        23, /* `player`'s connection is in the state `outcome`, for the `number`-th time joined */
    LL_EVENT_DROPPED = 24, /* the server goes on without `player`, for the `number`-th time */
} ll_event_type;

/* `record` is called in the order of virtual time. A NULL recorder writes nothing: a batch run pays for
 * nothing that nobody reads. */
typedef struct ll_recorder {
    void (*record)(void *context, const ll_event *event);
    void *context;
} ll_recorder;
