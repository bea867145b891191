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
static ll_time lead(const ll_client *c, const ll_pending_input *p)
{
    int64_t tick = c->tick - (int64_t)(c->seq - p->seq);
    return ll_tick_time(tick, c->clock.freq) - p->made;
}

void ll_dilate_time_follow(ll_client *c, const ll_client_setup *s, const ll_snapshot_message *m, ll_time now)
{
    const ll_pending_input *told = ll_client_pending(c, m->slack_seq), *newest = ll_client_pending(c, c->seq);
    if (m->slack == LL_SLACK_UNKNOWN || told->seq != m->slack_seq || newest->seq != c->seq)
        return;
    ll_time want = s->config->slack_ticks * c->period, change = 0;
    ll_time shifted = lead(c, newest) - lead(c, told) + c->shift + c->debt * c->period;
    ll_time slack = m->slack * c->period + shifted;
    if (c->spare_ns == LL_NEVER)
        c->spare_since = now;
    if (slack < c->spare_ns)
        c->spare_ns = slack;
    if (slack + c->period < want + c->period / REST) /* slack may be up to a tick more */
        change = want - slack;
    else if (now - c->spare_since < WINDOW)
        return;
    else if (c->spare_ns > want + c->period)
        change = want - c->spare_ns;
    c->spare_ns = LL_NEVER;
    c->shift += change;
    ll_time most = TICKS_MAX * c->period, beyond = c->shift > most    ? c->shift - most
                                                   : c->shift < -most ? c->shift + most
                                                                      : 0;
    c->debt += (int32_t)(beyond / c->period);
    c->shift -= beyond / c->period * c->period;
}

void ll_dilate_time(ll_client *c)
{
    if (c->shift == 0) {
        c->scale = 1;
        return;
    }
    ll_time fastest = c->period / 11, slowest = c->period / 9, rest = c->period / REST, by = c->shift;
    if (by > rest || by < -rest)
        by /= 10;
    by = by > fastest ? fastest : by < -slowest ? -slowest : by;
    c->shift -= by;
    c->clock.epoch -= by;
    c->scale = (double)c->period / (double)(c->period - by);
}
