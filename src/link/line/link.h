/* One direction of an impaired network path, in netem's terms. docs/links.md has every rule in full.
 *
 * Messages go in at a virtual time and come out at their due time, in an order fixed by (due time, order of
 * sending). One that is longer than mtu_bytes travels as several packets (fragments), others as one.
 *
 * The fate of packets is drawn when they are sent, in stages: duplicate, loss, corrupt, limit of the queue,
 * delay + jitter or reorder, rate. Each stage draws once per packet, also for packets that an earlier stage
 * took, from a stream of its own by the number of the message and of the fragment: switching one impairment
 * on leaves the draws of all others. A copy has draws of its own from the loss on.
 *
 * So all is known of a message when it is sent. It is put on its way once, due when the last of its fragments
 * comes, or not at all; a message of one packet comes twice when it is duplicated.
 *
 * A link is a relocatable part of a simulation's block: offsets, no pointers. It holds at most `slots`
 * messages and `arena` bytes in flight; a message beyond is dropped and counted. No allocation. */
#pragma once

#include "link/stages/parameters.h"

typedef struct ll_link ll_link; /* lives in a block; size from ll_link_size */

size_t ll_link_size(int slots, int arena_bytes); /* a multiple of 8 */
void ll_link_init(ll_link *link, int slots, int arena_bytes, uint64_t seed, uint64_t stream);

/* Sends `size` bytes (at most the arena) at `now` with `lag_ms` of base delay. No message may take 2^32 ns or
 * more: see ll_link_delay_max_ms. */
ll_sending ll_link_send(ll_link *link, const ll_link_params *params, double lag_ms, ll_time now,
                        const void *bytes, int size);

ll_time ll_link_next_due(const ll_link *link); /* LL_NEVER when empty */

/* Takes the next message due at or before `now`; copies it out. Returns its size, or -1 when none is due. */
int ll_link_receive(ll_link *link, ll_time now, void *bytes, int capacity, ll_time *sent, ll_time *due);

/* Keeps a message that has just been received for its receiver's de-jitter buffer, which holds times alone:
 * its place in the link is still free. It is no longer in flight. */
void ll_link_hold(ll_link *link, uint32_t id, const void *bytes, int size);

/* Takes out what is held as `id`, of several the first; copies it out and returns its size. It must be there.
 */
int ll_link_take_held(ll_link *link, uint32_t id, void *bytes, int capacity);

void ll_link_clear(ll_link *link); /* drops all messages; resets fifo order and the queue */
int ll_link_in_flight(const ll_link *link);
void ll_link_restart_stats(ll_link *link); /* they count from now on; what is in flight is still delivered */
const ll_link_stats *ll_link_get_stats(const ll_link *link);
int64_t ll_link_put_on_way(const ll_link_stats *stats); /* packets and copies */
int64_t ll_link_messages(const ll_link_stats *stats);   /* sent */
/* Share of the draws of the loss that took something, to stand next to loss_pct: packets have one each, and
 * copies, unless they were lost with it. */
double ll_link_loss_pct(const ll_link_stats *stats);
/* Correlation of the delays of successive packets so far; 0 when they do not vary. */
double ll_link_delay_correlation(const ll_link_stats *stats);
bool ll_link_valid(const ll_link *link); /* whole-structure check for LL_VALIDATE */
