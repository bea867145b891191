/* Acknowledgements by chunk: all before a number, and blocks of those that came beyond a gap (RFC 2018, RFC
 * 9260). */
#include "link/transport/core.h"

int ll_blocks_of(const ll_transport *t, const ll_flow *f, ll_range *blocks, int most)
{
    const ll_receiver *r = &f->receiver;
    int count = 0;
    for (int64_t n = r->highest - 1; n > r->next && count < most; count++) {
        ll_range block = {.last = n};
        while (n > r->next && ll_arrived(t, f, n))
            n--;
        block.first = n + 1;
        blocks[count] = block;
        while (n > r->next && !ll_arrived(t, f, n))
            n--;
    }
    for (int i = 0; i < count / 2; i++) {
        ll_range other = blocks[i];
        blocks[i] = blocks[count - 1 - i];
        blocks[count - 1 - i] = other;
    }
    return count;
}

int64_t ll_take_blocks(ll_transport *t, const ll_transport_env *env, int side, int64_t next,
                       const ll_range *blocks, int count, ll_time now)
{
    ll_flow *f = &t->flow[side];
    ll_sender *s = &f->sender;
    ll_acked all = ll_acked_begin(t, s);
    bool again = false; /* a gap is filled: how long what follows was held back says nothing */
    for (int64_t n = s->base; n < next && n < s->end; n++) {
        again |= ll_chunk_of(t, f, n)->sends > 1;
        ll_acked_chunk(t, f, n, &all);
    }
    for (int i = 0; i < count; i++)
        for (int64_t n = blocks[i].first < s->base ? s->base : blocks[i].first;
             n <= blocks[i].last && n < s->end; n++)
            ll_acked_chunk(t, f, n, &all);
    if (all.measured && !again) {
        ll_rtt_add(&s->rtt, now - all.sent, 0);
        s->backoff = 0;
    }
    ll_acked_end(t, side, &all, now);
    if (all.newest >= 0)
        ll_count_misses(t, env, side, all.newest, now);
    return all.newest;
}
