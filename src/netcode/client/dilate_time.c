/* Time dilation: the client follows its input slack by shorter or longer frames, so that it neither doubles
 * nor skips inputs (Overwatch, "Gameplay Architecture and Netcode"; Netcode for Entities).
 *
 * The scale is that of Netcode for Entities: clamp(1 + 0.1 x ticks behind, 0.9, 1.1). A snapshot reports the
 * slack of an input made a round trip ago. The clock corrections since then, made and pending, are added, so
 * that no error is corrected twice. Corrections beyond ten ticks are made at once, by doubled or skipped
 * inputs. Time is corrected in whole ns: nothing is accumulated in floating point. */
#include "netcode/state/client.h"

#define WINDOW (2 * LL_SECOND)
#define TICKS_MAX 10
#define REST 100 /* smallest correction, as a part of a tick */

/* Time from making an input to the end of its step, by a clock at the server's rate. */
static ll_time time_to_step(const ll_client *c, const ll_pending_input *p)
{
    int64_t tick = c->tick - (int64_t)(c->seq - p->seq);
    return ll_tick_time(tick, c->clock.freq) - p->made;
}

void ll_dilate_time_follow(ll_client *c, const ll_client_setup *s, const ll_snapshot_message *m, ll_time now)
{
    const ll_pending_input *reported = ll_client_pending(c, m->slack_seq),
                           *newest = ll_client_pending(c, c->seq);
    if (m->slack == LL_SLACK_UNKNOWN || reported->seq != m->slack_seq || newest->seq != c->seq)
        return;
    ll_time want = s->config->slack_ticks * c->period, change = 0;
    ll_time shifted = time_to_step(c, newest) - time_to_step(c, reported) + c->clock_correction +
                      c->extra_inputs * c->period;
    ll_time slack = m->slack * c->period + shifted;
    if (c->least_slack_ns == LL_NEVER)
        c->least_slack_since = now;
    if (slack < c->least_slack_ns)
        c->least_slack_ns = slack;
    if (slack + c->period < want + c->period / REST) /* slack may be up to a tick more */
        change = want - slack;
    else if (now - c->least_slack_since < WINDOW)
        return;
    else if (c->least_slack_ns > want + c->period)
        change = want - c->least_slack_ns;
    c->least_slack_ns = LL_NEVER;
    c->clock_correction += change;
    ll_time most = TICKS_MAX * c->period, excess = c->clock_correction > most    ? c->clock_correction - most
                                                   : c->clock_correction < -most ? c->clock_correction + most
                                                                                 : 0;
    c->extra_inputs += (int32_t)(excess / c->period);
    c->clock_correction -= excess / c->period * c->period;
}

void ll_dilate_time(ll_client *c)
{
    if (c->clock_correction == 0) {
        c->scale = 1;
        return;
    }
    ll_time fastest = c->period / 11, slowest = c->period / 9, rest = c->period / REST,
            by = c->clock_correction;
    if (by > rest || by < -rest)
        by /= 10;
    by = by > fastest ? fastest : by < -slowest ? -slowest : by;
    c->clock_correction -= by;
    c->clock.epoch -= by;
    c->scale = (double)c->period / (double)(c->period - by);
}
