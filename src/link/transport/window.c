/* The congestion window: what reno and cubic share (RFC 5681, RFC 9002). In bytes of messages. */
#include "link/transport/core.h"

static const ll_congestion *const controls[LL_CONGESTION_KINDS] = {&ll_congestion_reno, &ll_congestion_cubic};

#define WINDOW_MIN 2 /* mss */

static double mss_of(const ll_transport *t)
{
    return ll_mss(ll_protocol_of(t->kind));
}

void ll_window_init(ll_window *w, double mss)
{
    *w = (ll_window){.bytes = LL_INITIAL_WINDOW * mss, .threshold = 1e12, .since = LL_LONG_AGO};
}

void ll_window_acked(const ll_transport *t, ll_sender *s, double bytes, bool full, ll_time now)
{
    ll_window *w = &s->window;
    if (!full)
        return; /* what is not used does not grow: RFC 9002, 7.8 */
    if (w->bytes < w->threshold)
        w->bytes += bytes;
    else
        controls[t->congestion]->grow(w, &s->rtt, mss_of(t), bytes, now);
}

static void reduce(const ll_transport *t, ll_sender *s, ll_time now)
{
    const ll_congestion *control = controls[t->congestion];
    ll_window *w = &s->window;
    double least = WINDOW_MIN * mss_of(t);
    control->lost(w, mss_of(t), now);
    w->threshold = w->bytes * control->kept;
    w->threshold = w->threshold > least ? w->threshold : least;
    s->recovery = s->packet;
}

void ll_window_lost(const ll_transport *t, ll_sender *s, ll_time now)
{
    reduce(t, s, now);
    s->window.bytes = s->window.threshold;
}

bool ll_window_marked(const ll_transport *t, ll_sender *s, int64_t newest, ll_time now)
{
    if (newest < s->recovery)
        return false; /* it left before the last reduction: once a round trip */
    ll_window_lost(t, s, now);
    return true;
}

void ll_window_collapse(const ll_transport *t, ll_sender *s, ll_time now)
{
    if (s->backoff == 0)
        reduce(t, s, now); /* a second time-out in a row does not reduce the threshold again */
    s->recovery = s->packet;
    s->window.bytes = mss_of(t);
}
