/* Fate of a message, drawn packet by packet when it is sent. */
#include "base/assert.h"
#include "link/line/core.h"

/* ---- one packet ---- */

/* For two successive packets. */
static void count_pair(ll_link *l, double delay_ms)
{
    bool follows = l->delay_number == l->packet - 1;
    double step = delay_ms - l->delay_ms;
    l->stats.delay.step_squares += follows ? step * step : 0;
    l->stats.delay.pairs += follows;
    l->delay_number = l->packet;
    l->delay_ms = delay_ms;
}

#define ENTRY (1U << LL_STAGE_DUPLICATE | 1U << LL_STAGE_LOSS | 1U << LL_STAGE_TRACE | 1U << LL_STAGE_CORRUPT)

/* Passes a packet or its copy through the stages. `size`: of the whole message, for which the link must have
 * room. */
static void travel(ll_link *l, uint32_t stages, ll_passage *p, int32_t size)
{
    ll_stages_pass(stages & ENTRY, p, &l->memory, &l->stats);
    if (p->fate == LL_FATE_DELIVERED && !ll_link_has_room(l, size)) {
        p->fate = LL_FATE_OVERFLOW;
        l->stats.overflowed++;
    }
    ll_stages_pass(stages & ~ENTRY, p, &l->memory, &l->stats);
    if (p->fate != LL_FATE_DELIVERED)
        return;
    if (p->damaged) {
        p->fate = LL_FATE_CORRUPTED;
        p->due = p->now + ll_ms(p->delay_ms) + p->queued;
        l->stats.corrupted++;
        return;
    }
    p->due = ll_link_arrival(l, (ll_order)p->params->order, p->now, p->now + ll_ms(p->delay_ms) + p->queued,
                             p->queued > 0 ? p->delay_ms + ll_to_ms(p->queued) : p->delay_ms);
    if (!p->is_copy)
        count_pair(l, ll_to_ms(p->due - p->now));
}

static ll_passage packet(ll_link *l, const ll_link_plan *plan, ll_time now, int32_t size, int32_t fragment)
{
    return (ll_passage){.params = plan->params,
                        .profile = plan->profile,
                        .state = plan->state,
                        .bottleneck = plan->bottleneck,
                        .seed = l->seed,
                        .stream = l->stream,
                        .counter = (uint64_t)l->number + ((uint64_t)fragment << LL_FRAGMENT_SHIFT),
                        .number = l->packet,
                        .now = now,
                        .lag_ms = plan->lag_ms,
                        .delay_ms = plan->delay_ms,
                        .due = now,
                        .departures = ll_link_ring(l),
                        .places = l->places,
                        .size = size,
                        .capable = plan->ecn != 0};
}

/* A copy starts after the stage that made it. */
static ll_passage copy_of(const ll_passage *p, int32_t size)
{
    ll_passage copy = *p;
    copy.counter = ~p->counter;
    copy.delay_ms = p->lag_ms + p->params->delay_ms;
    copy.due = p->now;
    copy.queued = 0;
    copy.fate = LL_FATE_DELIVERED;
    copy.is_copy = true;
    copy.damaged = copy.reordered = copy.marked = false;
    copy.size = size;
    return copy;
}

/* The message of packets; NULL bytes: packets are not stored by themselves. */
typedef struct message {
    const void *bytes;
    int32_t size;
    bool whole; /* in one packet */
    const ll_link_plan *plan;
} message;

/* The message stored last, or a copy of it, came through with a mark. */
static __attribute__((noinline)) void mark(ll_link *l, const message *m)
{
    if (m->plan->ecn != 0)
        ll_link_mark(l, m->size, m->plan->ecn - 1);
}

static void show(const message *m, const ll_link *l, const ll_sending *sent, int32_t index, int32_t count)
{
    if (m->plan->tap)
        m->plan->tap->packet(m->plan->tap->context, &(ll_link_packet){.message = m->bytes,
                                                                      .size = m->size,
                                                                      .number = l->number,
                                                                      .index = index,
                                                                      .count = count,
                                                                      .duplicated = sent->duplicated,
                                                                      .fate = sent->fate,
                                                                      .copy_fate = sent->copy_fate,
                                                                      .due = sent->due,
                                                                      .copy_due = sent->copy_due});
}

static ll_sending pass(ll_link *l, uint32_t stages, ll_passage *p, const message *m)
{
    const int32_t size = p->size; /* cells change it */
    travel(l, stages, p, m->size);
    if (m->whole && p->fate == LL_FATE_DELIVERED) {
        ll_link_put(l, p->now, p->due, m->bytes, m->size);
        if (p->marked)
            mark(l, m);
    }
    ll_sending sending = {.fate = p->fate,
                          .due = p->due,
                          .queued = p->queued,
                          .fragments = 1,
                          .reordered = p->reordered,
                          .duplicated = p->duplicated,
                          .rescued = p->rescued,
                          .marked = p->marked && p->fate == LL_FATE_DELIVERED,
                          .copy_fate = LL_FATE_LOST,
                          .copy_due = p->now};
    if (p->duplicated && !p->rescued) {
        ll_passage copy = copy_of(p, size);
        travel(l, stages & ~(1U << LL_STAGE_DUPLICATE), &copy, m->size);
        if (m->whole && copy.fate == LL_FATE_DELIVERED) {
            ll_link_put(l, copy.now, copy.due, m->bytes, m->size);
            if (copy.marked)
                mark(l, m);
        }
        sending.marked |= copy.marked && copy.fate == LL_FATE_DELIVERED;
        sending.copy_fate = copy.fate;
        sending.copy_due = copy.due;
    }
    l->packet++;
    return sending;
}

/* Whether the packet or its copy arrives, and when the first of them does. */
static bool comes(const ll_sending *s, ll_time *when)
{
    bool first = s->fate == LL_FATE_DELIVERED, second = s->duplicated && s->copy_fate == LL_FATE_DELIVERED;
    *when = second && (!first || s->copy_due < s->due) ? s->copy_due : s->due;
    return first || second;
}

/* ---- messages ---- */

static int32_t packets_of(const ll_link_params *params, int32_t size)
{
    int64_t mtu = params->mtu_bytes;
    return mtu == 0 || size <= mtu ? 1 : (int32_t)((size + mtu - 1) / mtu);
}

static void count_split(ll_link *l, int32_t packets)
{
    l->stats.fragments.split++;
    l->stats.fragments.count += packets;
}

static void count_lost(ll_link *l, int32_t packets)
{
    l->stats.messages_lost++;
    l->stats.fragments.split_lost += packets > 1;
}

static void gather(ll_link *l, ll_sending *all, const ll_sending *one)
{
    ll_time when;
    all->marked |= one->marked; /* RFC 3168: of one fragment, so of the whole */
    if (!comes(one, &when)) {
        l->stats.fragments.lost++;
        if (all->fate == LL_FATE_DELIVERED) {
            all->fate = one->fate;
            all->due = one->due;
        }
    } else if (all->fate == LL_FATE_DELIVERED && when > all->due) {
        all->due = when;
    }
}

/* Sends a sequence of independent packets; the message arrives with the last of them. */
static ll_sending send_split(ll_link *l, const ll_link_plan *plan, ll_time now, const message *m,
                             int32_t packets)
{
    ll_sending all = {.fate = LL_FATE_DELIVERED, .due = now, .fragments = packets};
    int32_t mtu = (int32_t)plan->params->mtu_bytes, left = m->size;
    count_split(l, packets);
    for (int32_t i = 0; i < packets; i++, left -= mtu) {
        int32_t size = (left < mtu ? left : mtu) + LL_FRAGMENT_HEADER;
        ll_passage p = packet(l, plan, now, size, i);
        ll_sending one = pass(l, plan->stages, &p, m);
        show(m, l, &one, i, packets);
        gather(l, &all, &one);
    }
    if (all.fate != LL_FATE_DELIVERED) {
        count_lost(l, packets);
        return all;
    }
    ll_link_put(l, now, all.due, m->bytes, m->size);
    if (all.marked)
        mark(l, m);
    return all;
}

static ll_sending send_impaired(ll_link *l, const ll_link_plan *plan, ll_time now, const message *m)
{
    ll_passage p = packet(l, plan, now, m->size, 0);
    ll_sending sending = pass(l, plan->stages, &p, m);
    ll_time when;
    show(m, l, &sending, 0, 1);
    if (!comes(&sending, &when))
        count_lost(l, 1);
    return sending;
}

/* All packets of the message have one fate. */
static ll_sending show_all(const message *m, const ll_link *l, ll_sending sent)
{
    for (int32_t i = 0; m->plan->tap && i < sent.fragments; i++)
        show(m, l, &sent, i, sent.fragments);
    return sent;
}

static ll_sending refuse(ll_link *l, ll_time now, int32_t packets, const message *m)
{
    l->stats.overflowed += packets;
    l->stats.fragments.lost += packets > 1 ? packets : 0;
    count_lost(l, packets);
    return show_all(m, l, (ll_sending){.fate = LL_FATE_OVERFLOW, .due = now, .fragments = packets});
}

/* Without draws: all packets of a message arrive at one time. */
static ll_sending send_plain(ll_link *l, const ll_link_plan *plan, ll_time now, const message *m,
                             int32_t packets)
{
    const ll_order order = (ll_order)plan->params->order;
    l->packet += packets;
    if (packets > 1)
        count_split(l, packets);
    if (!ll_link_has_room(l, m->size))
        return refuse(l, now, packets, m);
    ll_time due = now + plan->delay;
    for (int32_t i = 0; i < packets; i++)
        due = ll_link_arrival(l, order, now, now + plan->delay, plan->delay_ms);
    ll_link_put(l, now, due, m->bytes, m->size);
    return show_all(m, l, (ll_sending){.fate = LL_FATE_DELIVERED, .due = due, .fragments = packets});
}

ll_link_plan ll_link_plan_of(const ll_link_params *params, double lag_ms)
{
    double delay_ms = lag_ms + params->delay_ms;
    return (ll_link_plan){.params = params,
                          .lag_ms = lag_ms,
                          .delay_ms = delay_ms,
                          .delay = ll_ms(delay_ms),
                          .stages = ll_stages_any(params) ? ll_stages_used(params) : 0};
}

ll_link_plan ll_link_plan_with(const ll_link_params *params, double lag_ms, const ll_link_profile *profile,
                               ll_profile_state *state)
{
    ll_link_plan plan = ll_link_plan_of(params, lag_ms + (profile ? profile->distance_ms : 0));
    plan.profile = profile;
    plan.state = state;
    plan.stages = ll_stages_profiled(params, profile);
    return plan;
}

void ll_link_plan_share(ll_link_plan *plan, ll_bottleneck *queue, ll_profile_state *state)
{
    plan->bottleneck = queue;
    plan->state = state;
    plan->stages |= 1U << LL_STAGE_BOTTLENECK;
}

ll_sending ll_link_send_by(ll_link *l, const ll_link_plan *plan, ll_time now, const void *bytes, int size)
{
    LL_ASSERT(size >= 0 && size <= l->arena);
    int32_t packets = packets_of(plan->params, size);
    l->stats.sent += packets;
    l->stats.bytes += size;
    ll_sending sending;
    message m = {bytes, size, packets == 1, plan};
    if (plan->stages == 0)
        sending = send_plain(l, plan, now, &m, packets);
    else
        sending = packets == 1 ? send_impaired(l, plan, now, &m) : send_split(l, plan, now, &m, packets);
    l->number++;
    LL_VALIDATE(ll_link_valid(l));
    return sending;
}

bool ll_link_send_single(ll_link *l, const ll_link_plan *plan, ll_time now, const void *bytes, int size)
{
    const message m = {bytes, size, true, plan};
    if (plan->stages == 0 || plan->tap || plan->stages & 1U << LL_STAGE_DUPLICATE ||
        packets_of(plan->params, size) != 1)
        return false;
    LL_ASSERT(size >= 0 && size <= l->arena);
    l->stats.sent++;
    l->stats.bytes += size;
    ll_passage p = packet(l, plan, now, size, 0);
    travel(l, plan->stages, &p, size);
    if (p.fate != LL_FATE_DELIVERED) {
        count_lost(l, 1);
    } else {
        ll_link_put(l, now, p.due, bytes, size);
        if (p.marked)
            mark(l, &m);
    }
    l->packet++;
    l->number++;
    LL_VALIDATE(ll_link_valid(l));
    return true;
}
