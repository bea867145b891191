/* Round trips, losses and time-outs, as far as the protocols share them. */
#include "base/assert.h"
#include "link/transport/core.h"

/* RFC 6298 and RFC 9002, 5.3: they differ in what the other side held. */
void ll_rtt_add(ll_rtt *rtt, ll_time sample, ll_time held)
{
    rtt->latest = sample;
    rtt->least = rtt->samples == 0 || sample < rtt->least ? sample : rtt->least;
    if (sample - held >= rtt->least)
        sample -= held;
    if (rtt->samples++ == 0) {
        rtt->smoothed = sample;
        rtt->variation = sample / 2;
        return;
    }
    ll_time off = sample > rtt->smoothed ? sample - rtt->smoothed : rtt->smoothed - sample;
    rtt->variation += (off - rtt->variation) / 4;
    rtt->smoothed += (sample - rtt->smoothed) / 8;
}

ll_time ll_rto_of(const ll_sender *s, ll_time initial, ll_time granularity, ll_time least, ll_time extra)
{
    ll_time spread = 4 * s->rtt.variation;
    if (s->rtt.samples == 0)
        return initial;
    ll_time rto = s->rtt.smoothed + (spread > granularity ? spread : granularity) + extra;
    return rto > least ? rto : least;
}

void ll_timer_start(const ll_transport *t, ll_sender *s, ll_time from, ll_time now)
{
    ll_time rto = ll_protocol_of(t->kind)->rto(s);
    for (int32_t i = 0; i < s->backoff && rto < LL_RTO_MAX; i++)
        rto *= 2;
    s->expires = from + (rto < LL_RTO_MAX ? rto : LL_RTO_MAX);
    s->expires = s->expires > now ? s->expires : now;
}

/* ---- acknowledged ---- */

ll_acked ll_acked_begin(const ll_transport *t, const ll_sender *s)
{
    bool full = s->limited || s->flight + ll_mss(ll_protocol_of(t->kind)) > s->window.bytes;
    return (ll_acked){.newest = -1, .full = full};
}

void ll_acked_chunk(const ll_transport *t, ll_flow *f, int64_t number, ll_acked *all)
{
    ll_sender *s = &f->sender;
    ll_chunk *c = ll_chunk_of(t, f, number);
    if (c->state == LL_CHUNK_DONE)
        return;
    if (c->state == LL_CHUNK_FLYING) {
        s->flying--;
        s->flight -= c->size;
        if (c->packet >= s->recovery)
            all->bytes += c->size;
    } else {
        s->queued--; /* it counted as lost and has arrived all the same */
    }
    c->state = LL_CHUNK_DONE;
    if (c->sends == 1 && (!all->measured || c->sent > all->sent)) {
        all->sent = c->sent;
        all->measured = true;
    }
    all->newest = c->packet > all->newest ? c->packet : all->newest;
}

static void advance_base(const ll_transport *t, ll_flow *f)
{
    ll_sender *s = &f->sender;
    for (const ll_chunk *c; s->base < s->end; s->base++) {
        c = ll_chunk_of(t, f, s->base);
        if (c->state != LL_CHUNK_DONE)
            break;
        s->kept = c->flags & LL_CHUNK_LAST ? s->base + 1 : s->kept;
    }
    s->scan = s->scan < s->base ? s->base : s->scan;
}

void ll_acked_end(ll_transport *t, int side, const ll_acked *all, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    if (all->newest < 0)
        return;
    int64_t base = s->base;
    s->progress = now;
    advance_base(t, f);
    if (ll_protocol_of(t->kind)->timer_by_packet)
        ll_timer_start(t, s, s->last, now);
    else if (s->base > base) /* RFC 6298, 5.3: what comes beyond a gap does not restart it */
        ll_timer_start(t, s, now, now);
    if (all->bytes > 0)
        ll_window_acked(t, s, (double)all->bytes, all->full, now);
    s->limited = 0;
}

/* ---- lost ---- */

/* The other chunks of a message of which one was given up: they are of no use. Returns its first. */
static int64_t give_up(const ll_transport *t, ll_flow *f, int64_t number)
{
    ll_sender *s = &f->sender;
    int64_t n = number;
    while (n > s->kept && !(ll_chunk_of(t, f, n)->flags & LL_CHUNK_FIRST))
        n--;
    number = n;
    for (bool last = false; !last; n++) {
        ll_chunk *c = ll_chunk_of(t, f, n);
        last = c->flags & LL_CHUNK_LAST;
        s->queued -= c->state == LL_CHUNK_QUEUED;
        s->flying -= c->state == LL_CHUNK_FLYING;
        s->flight -= c->state == LL_CHUNK_FLYING ? c->size : 0;
        c->state = LL_CHUNK_DONE;
    }
    return number;
}

void ll_chunk_lost(ll_transport *t, const ll_transport_env *env, int side, int64_t number, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    ll_chunk *c = ll_chunk_of(t, f, number);
    LL_ASSERT(c->state == LL_CHUNK_FLYING);
    s->flying--;
    s->flight -= c->size;
    if (c->packet >= s->recovery)
        ll_window_lost(t, s, now);
    if (ll_delivery_of(t)->reliable) {
        c->state = LL_CHUNK_QUEUED;
        s->queued++;
        s->scan = number < s->scan ? number : s->scan;
        return;
    }
    c->state = LL_CHUNK_DONE;
    ll_transport_watch(env,
                       &(ll_transport_note){.event = LL_TRANSPORT_LOST,
                                            .side = side,
                                            .type = c->type,
                                            .number = give_up(t, f, number),
                                            .made = c->made},
                       now);
    advance_base(t, f);
}

void ll_count_misses(ll_transport *t, const ll_transport_env *env, int side, int64_t newest, ll_time now)
{
    const ll_flow *f = &t->flow[side];
    for (int64_t n = f->sender.base; n < f->sender.end; n++) {
        ll_chunk *c = ll_chunk_of(t, f, n);
        if (c->state == LL_CHUNK_FLYING && c->packet < newest && ++c->misses >= LL_LOSS_THRESHOLD)
            ll_chunk_lost(t, env, side, n, now);
    }
}

void ll_time_out_all(ll_transport *t, const ll_transport_env *env, int side, ll_time now)
{
    ll_sender *s = &t->flow[side].sender;
    ll_window_collapse(t, s, now);
    for (int64_t n = s->base; n < s->end; n++)
        if (ll_chunk_of(t, &t->flow[side], n)->state == LL_CHUNK_FLYING)
            ll_chunk_lost(t, env, side, n, now);
    s->backoff++;
    ll_timer_start(t, s, now, now);
    ll_transport_push(t, env, side, true, now);
}
