/* A bottleneck behind the delay, as in netem: packets leave it one after the other in the order of sending,
 * each taking its bytes over the rate. So none overtakes, and one that the delay lets come early waits for
 * those that were sent before.
 *
 * The queue's limits come before the delay, and go by what the rate has yet to send as if all had come
 * without one: a long way is not a long queue. (netem's limit counts whatever it holds.) A packet that is let
 * in leaves at most limit_ms after the longest delay: with E the clock of the limits, X that of the rate, at
 * any time X - E is at most the longest delay of the packets since the queue was empty. */
#include "link/stages/stage.h"

/* The ring holds departures modulo 2^32 ns. What is left in it departs after the last sending before now,
 * since that took out all others, and less than 1.25 s from then; so a difference has its sign as long as the
 * queue has not run empty. */
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
    double ms = bits / params->rate_kbps; /* perhaps longer than whole ns can tell */
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
    p->departures[(m->queue_first + m->queue_count) % p->places] = (uint32_t)m->entrance;
    m->queue_count++;
    p->queued = m->exit - arrives;
    double queued_ms = ll_to_ms(p->queued);
    stats->queued++;
    stats->queue_sum_ms += queued_ms;
    stats->queue_max_ms = queued_ms > stats->queue_max_ms ? queued_ms : stats->queue_max_ms;
}
