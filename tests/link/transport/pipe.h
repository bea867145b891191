/* Both endpoints of a transport and its two links, run by their own clock. Messages are numbered: the number
 * stands in their first 8 bytes, and the rest follows from it. cmocka.h and what it needs come before. */
#pragma once

#include <stdlib.h>
#include <string.h>

#include "link/transport/transport.h"

#define PIPE_MESSAGES 40000
#define PIPE_MESSAGE_MAX 4000

typedef struct pipe_message {
    ll_time made, handed; /* handed: 0: not yet */
    int times;            /* handed over */
    int type;
} pipe_message;

typedef struct pipe {
    ll_transport *transport;
    ll_transport_env env;
    ll_link_params params[LL_SIDES];
    ll_link_plan plan[LL_SIDES];
    ll_time now;
    pipe_message *message[LL_SIDES]; /* by number */
    int64_t sent[LL_SIDES], handed[LL_SIDES];
    int64_t *order[LL_SIDES]; /* numbers as handed over */
    int64_t packets[LL_SIDES], wire_bytes[LL_SIDES], acks[LL_SIDES], resent[LL_SIDES], timeouts, ended,
        refused, lost;
    int64_t bytes_handed[LL_SIDES];
} pipe;

static inline void pipe_watch(void *context, const ll_transport_note *note, ll_time now)
{
    pipe *p = context;
    (void)now;
    if (note->event == LL_TRANSPORT_PACKET) {
        p->packets[note->side]++;
        p->wire_bytes[note->side] += note->wire_bytes;
        p->acks[note->side] += note->chunks == 0;
        p->resent[note->side] += note->resent > 0;
    }
    p->timeouts += note->event == LL_TRANSPORT_TIMED_OUT;
    p->ended += note->event == LL_TRANSPORT_ENDED;
    p->refused += note->event == LL_TRANSPORT_REFUSED;
    p->lost += note->event == LL_TRANSPORT_LOST;
}

/* `rate`: messages a second for which buffers are sized. The transport begins at time 0. */
static inline pipe *pipe_open(ll_transport_setup setup, const ll_link_params *params, double lag_ms,
                              uint64_t seed)
{
    pipe *p = calloc(1, sizeof *p);
    assert_non_null(p);
    size_t size = ll_transport_size(&setup);
    p->transport = malloc(size);
    memset(p->transport, 0xa5, size); /* init must not rely on zeros */
    ll_transport_init(p->transport, &setup, 0);
    for (int i = 0; i < LL_SIDES; i++) {
        int slots = ll_transport_link_slots(&setup, i), arena = ll_transport_link_arena(&setup, i);
        p->params[i] = *params;
        p->plan[i] = ll_link_plan_of(&p->params[i], lag_ms);
        p->env.link[i] = malloc(ll_link_size(slots, arena));
        p->env.plan[i] = &p->plan[i];
        ll_link_init(p->env.link[i], slots, arena, seed, (uint64_t)i);
        p->message[i] = calloc(PIPE_MESSAGES, sizeof *p->message[i]);
        p->order[i] = calloc(PIPE_MESSAGES, sizeof *p->order[i]);
    }
    p->env.timeout = LL_NEVER;
    p->env.watch = pipe_watch;
    p->env.context = p;
    return p;
}

static inline void pipe_close(pipe *p)
{
    for (int i = 0; i < LL_SIDES; i++) {
        free(p->env.link[i]);
        free(p->message[i]);
        free(p->order[i]);
    }
    free(p->transport);
    free(p);
}

static inline void pipe_fill(unsigned char *bytes, int64_t number, int size)
{
    for (int i = 0; i < size; i++)
        bytes[i] = (unsigned char)(number * 31 + i * 7);
    memcpy(bytes, &number, sizeof number);
}

/* False: refused. At least 8 bytes. */
static inline bool pipe_send(pipe *p, int side, int type, int size)
{
    unsigned char bytes[PIPE_MESSAGE_MAX];
    int64_t number = p->sent[side];
    assert_true(number < PIPE_MESSAGES && size >= 8 && size <= PIPE_MESSAGE_MAX);
    pipe_fill(bytes, number, size);
    p->message[side][number] = (pipe_message){.made = p->now, .type = type};
    if (!ll_transport_send(p->transport, &p->env, side, type, bytes, size, p->now))
        return false;
    p->sent[side]++;
    return true;
}

static inline void pipe_take(pipe *p, int side)
{
    unsigned char bytes[PIPE_MESSAGE_MAX], want[PIPE_MESSAGE_MAX];
    int from = 1 - side, size;
    while ((size = ll_transport_take(p->transport, &p->env, side, bytes, sizeof bytes, p->now)) >= 0) {
        int64_t number;
        memcpy(&number, bytes, sizeof number);
        assert_true(number >= 0 && number < p->sent[from]);
        pipe_fill(want, number, size);
        assert_memory_equal(bytes, want, (size_t)size);
        p->message[from][number].handed = p->now;
        p->message[from][number].times++;
        p->bytes_handed[from] += size;
        p->order[from][p->handed[from]++] = number;
    }
}

/* All events up to and including `until`. */
static inline void pipe_run(pipe *p, ll_time until)
{
    for (;;) {
        ll_time up = ll_link_next_due(p->env.link[0]), down = ll_link_next_due(p->env.link[1]),
                timer = ll_transport_due(p->transport), first = up < down ? up : down;
        first = timer < first ? timer : first;
        if (first > until)
            break;
        assert_true(first >= p->now);
        p->now = first;
        if (first == up || first == down) {
            int side = first == up ? LL_SERVER_SIDE : LL_CLIENT_SIDE;
            ll_transport_arrive(p->transport, &p->env, side, p->now);
            pipe_take(p, side);
            ll_transport_settle(p->transport, &p->env, side, p->now);
        } else {
            ll_transport_run_timers(p->transport, &p->env, p->now);
        }
        assert_true(ll_transport_valid(p->transport));
    }
    p->now = until;
}
