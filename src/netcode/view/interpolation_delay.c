/* The rules of the interpolation delay. */
#include "netcode/view/view.h"

static ll_time interval(const ll_client *c)
{
    return (ll_time)(1e9 / c->update_hz);
}

static ll_time ratio(const ll_client *c, const ll_player_config *config)
{
    return (ll_time)(config->interpolation_ratio / c->update_hz * 1e9) + ll_ms(config->jitter_margin_ms);
}

const ll_interpolation_delay ll_interpolation_delay_ratio = {
    .name = "ratio",
    .help = "interpolation_ratio / update_hz + jitter_margin_ms.",
    .delay = ratio,
};

#define INTERVALS_MAX 6
#define STEPS_PER_FRAME 10 /* a change is at most so small a part of a frame */

/* After Netcode for Entities: average gap between states + 1.25 x its mean deviation, at most six intervals,
 * changed by at most a tenth of a frame per frame. It was chosen over Mirror's (1 + a tolerance of 1 +
 * deviation / interval, in intervals) since that never comes below two intervals, however clean the link.
 * There, gaps are of send times, which tell of loss alone, and time counts from where an average state is.
 * Here they are of arrivals, which tell of jitter too, and time counts from the fastest state, so that the
 * average lateness against it is added. */
static ll_time adaptive(const ll_client *c, const ll_player_config *config)
{
    ll_time want = (ll_time)(c->gap + 1.25 * c->gap_deviation + c->late), most = INTERVALS_MAX * interval(c),
            step = c->elapsed / STEPS_PER_FRAME;
    want = (want < most ? want : most) + ll_ms(config->jitter_margin_ms);
    if (!c->has_render)
        return ratio(c, config); /* nothing is known of the gaps yet */
    return want > c->delay + step ? c->delay + step : want < c->delay - step ? c->delay - step : want;
}

const ll_interpolation_delay ll_interpolation_delay_adaptive = {
    .name = "adaptive",
    .help = "The average gap between states, 1.25 times its deviation and the average lateness, at most six "
            "update "
            "intervals, + jitter_margin_ms; it moves by at most a tenth of a frame per frame.",
    .delay = adaptive,
};
