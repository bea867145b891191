/* The congestion window (RFC 5681, RFC 9002), in bytes of messages, and its controls. */
#include "base/detmath.h"
#include "link/transport/core.h"

typedef struct congestion {
    double kept; /* share of the window after a loss */
    /* Growth in congestion avoidance for `bytes` acknowledged; slow start is common to all. */
    void (*grow)(ll_window *window, const ll_rtt *rtt, double mss, double bytes, ll_time now);
    void (*lost)(ll_window *window, double mss, ll_time now); /* before the window is reduced */
} congestion;

/* ---- reno: additive increase, multiplicative decrease: RFC 5681, RFC 6582 ---- */

static void reno_grow(ll_window *w, const ll_rtt *rtt, double mss, double bytes, ll_time now)
{
    (void)rtt, (void)now;
    w->bytes += mss * bytes / w->bytes;
}

static void reno_lost(ll_window *w, double mss, ll_time now)
{
    (void)w, (void)mss, (void)now;
}

/* ---- cubic: RFC 9438, without fast convergence and HyStart: W(t) = C (t - K)^3 + W_max in mss and s, and
 * never below what Reno would have ---- */

#define CUBIC_C 0.4
#define CUBIC_BETA 0.7
/* mss per round trip with which Reno has the same mean */
#define RENO_SHARE (3 * (1 - CUBIC_BETA) / (1 + CUBIC_BETA))

static double cube_root(double x)
{
    return x > 0 ? ll_exp(ll_detmath_log(x) / 3) : 0;
}

static void cubic_begin(ll_window *w, double mss, ll_time now)
{
    w->since = now;
    if (w->plateau * mss < w->bytes)
        w->plateau = w->bytes / mss;
    w->root = cube_root((w->plateau - w->bytes / mss) / CUBIC_C);
}

static void cubic_grow(ll_window *w, const ll_rtt *rtt, double mss, double bytes, ll_time now)
{
    if (w->since == LL_LONG_AGO)
        cubic_begin(w, mss, now);
    double round_trip = ll_to_s(rtt->smoothed), t = ll_to_s(now - w->since), d = t + round_trip - w->root;
    double target = CUBIC_C * d * d * d + w->plateau, now_mss = w->bytes / mss;
    double reno = w->plateau * CUBIC_BETA + (round_trip > 0 ? RENO_SHARE * t / round_trip : 0);
    target = target > 1.5 * now_mss ? 1.5 * now_mss : target;
    if (target > now_mss)
        now_mss += (target - now_mss) / now_mss * (bytes / mss);
    if (reno > now_mss)
        now_mss = reno;
    w->bytes = now_mss * mss;
}

static void cubic_lost(ll_window *w, double mss, ll_time now)
{
    (void)now;
    w->plateau = w->bytes / mss;
    w->since = LL_LONG_AGO;
}

static const congestion controls[LL_CONGESTION_KINDS] = {
    [LL_CONGESTION_RENO] = {.kept = 0.5, .grow = reno_grow, .lost = reno_lost},
    [LL_CONGESTION_CUBIC] = {.kept = CUBIC_BETA, .grow = cubic_grow, .lost = cubic_lost}};

/* ---- the window ---- */

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
        controls[t->congestion].grow(w, &s->rtt, mss_of(t), bytes, now);
}

static void reduce(const ll_transport *t, ll_sender *s, ll_time now)
{
    const congestion *control = &controls[t->congestion];
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
