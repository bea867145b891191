/* A bottleneck at the entrance of the link: packets leave it one after the other in the order of sending,
 * each taking its bytes over the rate, and travel from there. Delays add up, so it does not matter for a
 * packet whether it queues before or after its way; that the queue comes first keeps the waits free of the
 * jitter's draws. */
#include "link/stage.h"

/* The ring holds departures modulo 2^32 ns. What is left in it departs after the last sending before now,
 * since that took out all others, and less than 1.25 s from then; so a difference has its sign as long as the
 * queue has not run empty. */
static void take_out_departed(ll_memory *m, const ll_passage *p)
{
    if (m->free <= p->now)
        m->queue_count = 0;
    while (m->queue_count > 0 && (int32_t)(p->departures[m->queue_first] - (uint32_t)p->now) <= 0) {
        m->queue_first = (m->queue_first + 1) % p->slots;
        m->queue_count--;
    }
}

void ll_stage_rate(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    if (p->fate != LL_FATE_DELIVERED)
        return;
    take_out_departed(m, p);
    ll_time start = m->free > p->now ? m->free : p->now;
    double bits = 8.0 * (double)(p->size + params->packet_overhead_bytes);
    double through_ms = ll_to_ms(start - p->now) + bits / params->rate_kbps;
    if (m->queue_count >= params->limit_packets || m->queue_count == p->slots ||
        through_ms > params->limit_ms) {
        p->fate = LL_FATE_OVERFLOW;
        stats->queue_drops++;
        return;
    }
    m->free = p->now + ll_ms(through_ms);
    p->departures[(m->queue_first + m->queue_count) % p->slots] = (uint32_t)m->free;
    m->queue_count++;
    p->queued = m->free - p->now;
    stats->queued++;
    stats->queue_sum_ms += through_ms;
    stats->queue_max_ms = through_ms > stats->queue_max_ms ? through_ms : stats->queue_max_ms;
}
