/* CUBIC, RFC 9438, without fast convergence and HyStart: W(t) = C (t - K)^3 + W_max in mss and s, and never
 * below what Reno would have. */
#include "base/detmath.h"
#include "link/transport/core.h"

#define C 0.4
#define BETA 0.7
#define RENO_SHARE (3 * (1 - BETA) / (1 + BETA)) /* mss per round trip with which Reno has the same mean */

static double cube_root(double x)
{
    return x > 0 ? ll_exp(ll_detmath_log(x) / 3) : 0;
}

static void begin(ll_window *w, double mss, ll_time now)
{
    w->since = now;
    if (w->plateau * mss < w->bytes)
        w->plateau = w->bytes / mss;
    w->root = cube_root((w->plateau - w->bytes / mss) / C);
}

static void grow(ll_window *w, const ll_rtt *rtt, double mss, double bytes, ll_time now)
{
    if (w->since == LL_LONG_AGO)
        begin(w, mss, now);
    double round_trip = ll_to_s(rtt->smoothed), t = ll_to_s(now - w->since), d = t + round_trip - w->root;
    double target = C * d * d * d + w->plateau, now_mss = w->bytes / mss;
    double reno = w->plateau * BETA + (round_trip > 0 ? RENO_SHARE * t / round_trip : 0);
    target = target > 1.5 * now_mss ? 1.5 * now_mss : target;
    if (target > now_mss)
        now_mss += (target - now_mss) / now_mss * (bytes / mss);
    if (reno > now_mss)
        now_mss = reno;
    w->bytes = now_mss * mss;
}

static void lost(ll_window *w, double mss, ll_time now)
{
    (void)now;
    w->plateau = w->bytes / mss;
    w->since = LL_LONG_AGO;
}

const ll_congestion ll_congestion_cubic = {.kept = BETA, .grow = grow, .lost = lost};
