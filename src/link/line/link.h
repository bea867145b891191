/* One direction of an impaired network path, in netem's terms. docs/links.md has every rule in full.
 *
 * Messages are sent at a virtual time and received at their due time, in an order fixed by (due time, order
 * of sending). A message longer than mtu_bytes travels as several packets (fragments), others as one.
 *
 * The fate of packets is drawn when they are sent, in stages: duplicate, loss, corrupt, limit of the queue,
 * delay + jitter or reorder, rate. Each stage draws once per packet, also for packets that an earlier stage
 * dropped, from its own stream by the number of the message and of the fragment: switching one impairment on
 * does not change the draws of the others. A copy has its own draws from the loss on.
 *
 * So the fate of a message is known when it is sent. It is stored once, due when its last fragment arrives,
 * or not at all; a duplicated message of one packet arrives twice.
 *
 * A link is a relocatable part of a simulation's block: offsets, no pointers. It holds at most `slots`
 * messages and `arena` bytes in flight; excess messages are dropped and counted. No allocation. */
#pragma once

#include "link/bottleneck/bottleneck.h"
#include "link/profile/profile.h"
#include "link/stages/parameters.h"

typedef struct ll_link ll_link; /* part of a block; size from ll_link_size */

size_t ll_link_size(int slots, int arena_bytes); /* a multiple of 8 */
void ll_link_init(ll_link *link, int slots, int arena_bytes, uint64_t seed, uint64_t stream);

/* Is called for each packet, in the order of sending. */
typedef struct ll_link_tap {
    void (*packet)(void *context, const ll_link_packet *packet);
    void *context;
} ll_link_tap;

#define LL_ECN_MARK 0x80 /* stands for the codepoint CE of an IP header (RFC 3168) */

/* What parameters and a base delay mean for every message, worked out once for many: valid as long as
 * `params`. */
typedef struct ll_link_plan {
    const ll_link_params *params;
    double lag_ms, delay_ms; /* `lag_ms` and the parameters' delay together */
    ll_time delay;           /* the same */
    const ll_link_tap *tap;  /* NULL: none */
    uint32_t stages;         /* 0: no impairment */
    uint32_t ecn; /* 1 + the byte of a message in which a mark sets LL_ECN_MARK; 0: messages are not
                     capable of ECN, and marks change nothing in them */
    const ll_link_profile *profile; /* NULL: none */
    ll_profile_state *state;
    ll_bottleneck *bottleneck; /* NULL: none; shared with other links */
} ll_link_plan;

ll_link_plan ll_link_plan_of(const ll_link_params *params, double lag_ms);
/* Of a plan that is complete otherwise: packets pass `queue`, which other links share, before all delays.
 * `state` counts marks. */
void ll_link_plan_share(ll_link_plan *plan, ll_bottleneck *queue, ll_profile_state *state);
/* The same of a link with a profile; both NULL: of one without. `profile` and `state` live as long as the
 * plan. */
ll_link_plan ll_link_plan_with(const ll_link_params *params, double lag_ms, const ll_link_profile *profile,
                               ll_profile_state *state);

/* Sends `size` bytes (at most the arena) at `now`. No message may take 2^32 ns or more: see
 * ll_link_delay_max_ms. */
ll_sending ll_link_send_by(ll_link *link, const ll_link_plan *plan, ll_time now, const void *bytes, int size);

/* The same for the usual message: in one packet, of a link with room, without impairments or a tap. It
 * arrives at `due`. False for any other: nothing has happened, and ll_link_send_by sends it. */
bool ll_link_send_plain(ll_link *link, const ll_link_plan *plan, ll_time now, const void *bytes, int size,
                        ll_time *due);

/* The same for a message of one packet of a link with impairments, but without copies or a tap; its fate is
 * not said. */
bool ll_link_send_single(ll_link *link, const ll_link_plan *plan, ll_time now, const void *bytes, int size);

ll_time ll_link_next_due(const ll_link *link); /* LL_NEVER if empty */

/* Removes the next message due at or before `now` and returns where its `size` bytes still lie, at a multiple
 * of 4, until the link gets another message; NULL if there is none. */
const void *ll_link_next(ll_link *link, ll_time now, int *size);

/* Removes the next message due at or before `now` and copies it out. Returns its size, or -1 if there is
 * none. */
int ll_link_receive(ll_link *link, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due);

/* Whether a message of `size` bytes has room. */
bool ll_link_room(const ll_link *link, int size);

/* Keeps a message just received for its receiver's de-jitter buffer, which holds times only: its place in the
 * link is still free. It is no longer in flight. */
void ll_link_hold(ll_link *link, uint32_t id, const void *bytes, int size);

/* Removes the first message held as `id` and copies it out; returns its size. It must exist. */
int ll_link_take_held(ll_link *link, uint32_t id, void *bytes, int capacity);

int ll_link_in_flight(const ll_link *link);
void ll_link_restart_stats(ll_link *link); /* counts from now on; messages in flight are still delivered */
const ll_link_stats *ll_link_get_stats(const ll_link *link);
int64_t ll_link_put_on_way(const ll_link_stats *stats); /* packets and copies */
int64_t ll_link_messages(const ll_link_stats *stats);   /* sent */
/* Fraction of loss draws with a loss, to compare with loss_pct: one draw per packet, and per copy unless both
 * were lost together. */
double ll_link_loss_pct(const ll_link_stats *stats);
/* Correlation of the delays of successive packets so far; 0 if they do not vary. */
double ll_link_delay_correlation(const ll_link_stats *stats);
bool ll_link_valid(const ll_link *link); /* checks the whole structure, for LL_VALIDATE */
