/* Rules for the interpolation delay. */
#include "netcode/view/view.h"

static ll_time interval(const ll_client *c)
{
    return (ll_time)(1e9 / c->latest.update_hz);
}

static ll_time ratio(const ll_client *c, const ll_player_config *config)
{
    return (ll_time)(config->interpolation_ratio / c->latest.update_hz * 1e9) +
           ll_ms(config->jitter_margin_ms);
}

const ll_interpolation_delay ll_interpolation_delay_ratio = {
    .name = "ratio",
    .help = "interpolation_ratio / update_hz + jitter_margin_ms.",
    .delay = ratio,
};

#define INTERVALS_MAX 6
#define STEPS_PER_FRAME 10 /* largest change, as a part of a frame */

/* After Netcode for Entities: average gap between snapshots + 1.25 x its mean deviation, at most six
 * intervals, changed by at most a tenth of a frame per frame. Chosen over Mirror's rule (1 + a tolerance of 1
 * + deviation / interval, in intervals), which is never below two intervals, even on a perfect link. There,
 * gaps are of send times, which show only loss, and time counts from the average snapshot. Here they are of
 * arrivals, which also show jitter, and time counts from the fastest snapshot, so the average lateness
 * relative to it is added. */
static ll_time adaptive(const ll_client *c, const ll_player_config *config)
{
    ll_time want = (ll_time)(c->arrivals.gap + 1.25 * c->arrivals.gap_deviation + c->arrivals.late),
            most = INTERVALS_MAX * interval(c), step = c->displays.elapsed / STEPS_PER_FRAME;
    want = (want < most ? want : most) + ll_ms(config->jitter_margin_ms);
    if (!c->view.has_render)
        return ratio(c, config); /* no gap is known yet */
    return want > c->view.delay + step   ? c->view.delay + step
           : want < c->view.delay - step ? c->view.delay - step
                                         : want;
}

const ll_interpolation_delay ll_interpolation_delay_adaptive = {
    .name = "adaptive",
    .help = "The average gap between snapshots, 1.25 times its deviation and the average lateness, at most "
            "six update intervals, + jitter_margin_ms; it changes by at most a tenth of a frame per frame.",
    .delay = adaptive,
};
