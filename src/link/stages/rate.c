/* A bottleneck after the delay, as in netem: packets leave it one by one in the order of sending, each for
 * its bytes over the rate. So none overtakes, and one with a shorter delay waits for those sent earlier.
 *
 * The queue's limits are checked before the delay, against what the rate has yet to send if all had arrived
 * without delay: a long delay is not a long queue. (netem's limit counts all that it holds.) An accepted
 * packet leaves at most limit_ms after the longest delay: with E the clock of the limits and X that of the
 * rate, X - E is always at most the longest delay of the packets since the queue was empty. */
#include "link/stages/stage.h"

#include "base/assert.h"

/* The ring holds departures modulo 2^32 ns. Remaining ones are after the last sending before now, which
 * removed all others, and less than 1.25 s from it; so differences have the right sign while the queue is not
 * empty. */
static void take_out_departed(ll_memory *m, const ll_passage *p)
{
    if (m->entrance <= p->now)
        m->queue_count = 0;
    while (m->queue_count > 0 && (int32_t)(p->departures[m->queue_first] - (uint32_t)p->now) <= 0) {
        m->queue_first = (m->queue_first + 1) % p->places;
        m->queue_count--;
    }
}

static ll_time later(ll_time a, ll_time b)
{
    return a > b ? a : b;
}

void ll_stage_limit(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    const ll_link_params *params = p->params;
    if (p->fate != LL_FATE_DELIVERED)
        return;
    take_out_departed(m, p);
    double bits = 8.0 * (double)(p->size + params->packet_overhead_bytes);
    double ms = bits / params->rate_kbps; /* may exceed the range of integer ns */
    bool full = m->queue_count >= params->limit_packets || m->queue_count == p->places;
    if (!full && ms <= params->limit_ms) {
        p->transmission = ll_ms(ms);
        if (later(m->entrance, p->now) - p->now + p->transmission <= ll_ms(params->limit_ms))
            return;
    }
    p->fate = LL_FATE_OVERFLOW;
    stats->queue_drops++;
}

void ll_stage_rate(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    if (p->fate != LL_FATE_DELIVERED || p->reordered)
        return;
    ll_time arrives = p->now + ll_ms(p->delay_ms);
    m->entrance = later(m->entrance, p->now) + p->transmission;
    m->exit = later(m->exit, arrives) + p->transmission;
    LL_ASSERT(m->queue_count < p->places); /* the limit has left room */
    LL_ASSERT(m->exit >= arrives && m->entrance >= p->now);
    p->departures[(m->queue_first + m->queue_count) % p->places] = (uint32_t)m->entrance;
    m->queue_count++;
    p->queued = m->exit - arrives;
    double queued_ms = ll_to_ms(p->queued);
    stats->queue.count++;
    stats->queue.sum_ms += queued_ms;
    stats->queue.max_ms = queued_ms > stats->queue.max_ms ? queued_ms : stats->queue.max_ms;
}

/* The queue that the links of all players share: before the way of each, so that packets enter it in the
 * order of sending. */
void ll_stage_bottleneck(ll_passage *p, ll_memory *m, ll_link_stats *stats)
{
    (void)m;
    if (p->fate != LL_FATE_DELIVERED)
        return;
    ll_bottleneck_fate fate =
        ll_bottleneck_enter(p->bottleneck, p->now, p->size + p->params->packet_overhead_bytes, p->capable);
    if (fate.marked)
        ll_mark(p);
    if (!fate.dropped) {
        p->delay_ms += ll_to_ms(fate.leaves - p->now);
        return;
    }
    p->fate = LL_FATE_OVERFLOW;
    stats->queue_drops++;
}
