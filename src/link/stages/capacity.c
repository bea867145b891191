/* A bottleneck of measured capacity, as Mahimahi's link: each stamp of the trace is an opportunity to send
 * 1504 bytes. Packets share an opportunity, and one that does not fit goes on in the next; what no packet
 * uses is lost. As in Mahimahi, a packet cannot use an opportunity of the very instant at which it comes. R.
 * Netravali et al., "Mahimahi: accurate record-and-replay for HTTP", USENIX ATC 2015.
 *
 * Like the rate's queue it is first in, first out by the order of sending. Capacity may be absent for long,
 * so its limit in time is on the wait itself. */
#include "base/assert.h"
#include "link/stages/stage.h"

/* Stamps repeat by the last one, before time 0 too. */
static ll_time time_of(const ll_link_profile *p, int64_t opportunity)
{
    const int64_t *times = ll_profile_capacity(p);
    int64_t n = p->capacity_count, turn = opportunity / n, at = opportunity % n;
    turn -= at < 0;
    at += at < 0 ? n : 0;
    return times[at] + turn * times[n - 1];
}

/* The first opportunity after `now`. */
static int64_t next_after(const ll_link_profile *p, ll_time now)
{
    const int64_t *times = ll_profile_capacity(p);
    int64_t n = p->capacity_count, period = times[n - 1], turn = now / period;
    turn -= now % period < 0;
    ll_time at = now - turn * period;
    int64_t low = 0, high = n - 1;
    while (low < high) {
        int64_t middle = low + (high - low) / 2;
        if (times[middle] > at)
            high = middle;
        else
            low = middle + 1;
    }
    LL_ASSERT(times[low] > at);
    return turn * n + low;
}

/* Packets that have not left at `arrives`. The ring holds departures modulo 2^32 ns, see rate.c. */
static int32_t count_waiting(ll_memory *m, const ll_passage *p, ll_time arrives)
{
    if (m->entrance <= p->now)
        m->queue_count = 0;
    while (m->queue_count > 0 && (int32_t)(p->departures[m->queue_first] - (uint32_t)p->now) <= 0) {
        m->queue_first = (m->queue_first + 1) % p->places;
        m->queue_count--;
    }
    int32_t waiting = m->queue_count;
    for (int32_t i = 0; i < m->queue_count; i++, waiting--)
        if ((int32_t)(p->departures[(m->queue_first + i) % p->places] - (uint32_t)arrives) > 0)
            break;
    return waiting;
}

static void keep(ll_passage *p, ll_memory *m, ll_link_stats *stats, ll_time arrives, ll_time leaves)
{
    m->exit = leaves;
    m->entrance = leaves > m->entrance ? leaves : m->entrance;
    p->departures[(m->queue_first + m->queue_count) % p->places] = (uint32_t)leaves;
    m->queue_count++;
    p->queued = leaves - arrives;
    double queued_ms = ll_to_ms(p->queued);
    stats->queue.count++;
    stats->queue.sum_ms += queued_ms;
    stats->queue.max_ms = queued_ms > stats->queue.max_ms ? queued_ms : stats->queue.max_ms;
}

void ll_stage_capacity(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_profile *profile = p->profile;
    ll_profile_state *s = p->state;
    if (p->fate != LL_FATE_DELIVERED || p->reordered)
        return;
    ll_time arrives = p->now + ll_ms(p->delay_ms);
    int64_t opportunity = s->opportunity, used = s->used, bytes = p->size + p->params->packet_overhead_bytes;
    if (opportunity == INT64_MIN || time_of(profile, opportunity) <= arrives) {
        opportunity = next_after(profile, arrives);
        used = 0;
    }
    int64_t rest = used + bytes - LL_OPPORTUNITY_BYTES; /* beyond this opportunity */
    int64_t more = rest > 0 ? (rest + LL_OPPORTUNITY_BYTES - 1) / LL_OPPORTUNITY_BYTES : 0;
    ll_time leaves = time_of(profile, opportunity + more);
    int32_t waiting = count_waiting(m, p, arrives);
    if (waiting >= p->params->limit_packets || m->queue_count == p->places ||
        leaves - arrives > ll_ms(p->params->limit_ms)) {
        p->fate = LL_FATE_OVERFLOW;
        stats->queue_drops++;
        return;
    }
    s->opportunity = opportunity + more;
    s->used = used + bytes - more * LL_OPPORTUNITY_BYTES;
    keep(p, m, stats, arrives, leaves);
}
