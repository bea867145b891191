/* Additive increase, multiplicative decrease: RFC 5681, RFC 6582. */
#include "link/transport/core.h"

static void grow(ll_window *w, const ll_rtt *rtt, double mss, double bytes, ll_time now)
{
    (void)rtt;
    (void)now;
    w->bytes += mss * bytes / w->bytes;
}

static void lost(ll_window *w, double mss, ll_time now)
{
    (void)w;
    (void)mss;
    (void)now;
}

const ll_congestion ll_congestion_reno = {.kept = 0.5, .grow = grow, .lost = lost};
