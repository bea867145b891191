/* How render time follows its target. */
#include "netcode/view/view.h"

/* ---- proportional ---- */

static ll_time proportional(ll_client *c, ll_time error)
{
    ll_time most = c->displays.elapsed / 10;
    return error > most ? most : error < -most ? -most : error;
}

static ll_time quarter_second(const ll_client *c)
{
    (void)c;
    return 250 * LL_MS;
}

const ll_time_scale ll_time_scale_proportional = {
    .name = "proportional",
    .help = "Faster or slower by what the error needs, at most a tenth.",
    .extra = proportional,
    .limit = quarter_second,
};

/* ---- catch-up ---- */

#define DRIFT_S 1.0 /* over which the error is averaged */

/* Mirror's rule: real time while the averaged error is within one update interval, otherwise 2 % faster or 4
 * % slower; slower by more, so that the buffer does not run empty. */
static ll_time by_states(ll_client *c, ll_time error)
{
    double share = ll_to_s(c->displays.elapsed) / DRIFT_S, interval = 1e9 / c->latest.update_hz;
    c->view.drift += ((double)error - c->view.drift) * (share < 1 ? share : 1);
    double extra = c->view.drift > interval ? 0.02 : c->view.drift < -interval ? -0.04 : 0;
    return (ll_time)(extra * (double)c->displays.elapsed);
}

static ll_time one_delay(const ll_client *c)
{
    ll_time interval = (ll_time)(1e9 / c->latest.update_hz);
    return c->view.delay > interval ? c->view.delay : interval;
}

const ll_time_scale ll_time_scale_catch_up = {
    .name = "catch_up",
    .help =
        "In real time while it is within one update interval of its target, then 2 % faster or 4 % slower.",
    .extra = by_states,
    .limit = one_delay,
};
