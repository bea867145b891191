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
    int64_t tick = c->inputs.tick - (int64_t)(c->inputs.seq - p->seq);
    return ll_tick_time(tick, c->ticks.clock.freq) - p->made;
}

void ll_dilate_time_follow(ll_client *c, const ll_client_setup *s, const ll_snapshot_message *m, ll_time now)
{
    const ll_pending_input *reported = ll_client_pending(c, m->slack_seq),
                           *newest = ll_client_pending(c, c->inputs.seq);
    if (m->slack == LL_SLACK_UNKNOWN || reported->seq != m->slack_seq || newest->seq != c->inputs.seq)
        return;
    ll_time want = s->config->slack_ticks * c->ticks.period, change = 0;
    ll_time shifted = time_to_step(c, newest) - time_to_step(c, reported) + c->inputs.correction +
                      c->inputs.extra * c->ticks.period;
    ll_time slack = m->slack * c->ticks.period + shifted;
    if (c->inputs.least_slack_ns == LL_NEVER)
        c->inputs.least_slack_since = now;
    if (slack < c->inputs.least_slack_ns)
        c->inputs.least_slack_ns = slack;
    if (slack + c->ticks.period < want + c->ticks.period / REST) /* slack may be up to a tick more */
        change = want - slack;
    else if (now - c->inputs.least_slack_since < WINDOW)
        return;
    else if (c->inputs.least_slack_ns > want + c->ticks.period)
        change = want - c->inputs.least_slack_ns;
    c->inputs.least_slack_ns = LL_NEVER;
    c->inputs.correction += change;
    ll_time most = TICKS_MAX * c->ticks.period,
            excess = c->inputs.correction > most    ? c->inputs.correction - most
                     : c->inputs.correction < -most ? c->inputs.correction + most
                                                    : 0;
    c->inputs.extra += (int32_t)(excess / c->ticks.period);
    c->inputs.correction -= excess / c->ticks.period * c->ticks.period;
}

void ll_dilate_time(ll_client *c)
{
    if (c->inputs.correction == 0) {
        c->inputs.scale = 1;
        return;
    }
    ll_time fastest = c->ticks.period / 11, slowest = c->ticks.period / 9, rest = c->ticks.period / REST,
            by = c->inputs.correction;
    if (by > rest || by < -rest)
        by /= 10;
    by = by > fastest ? fastest : by < -slowest ? -slowest : by;
    c->inputs.correction -= by;
    c->ticks.clock.epoch -= by;
    c->inputs.scale = (double)c->ticks.period / (double)(c->ticks.period - by);
}
