#include "netcode/metrics/instruments.h"

#include <string.h>

#include "base/detmath.h"

const ll_metric_row ll_metric_rows[LL_METRICS] = {
    [LL_METRIC_INPUT_LATENCY] = {"input_latency_ms",
                                 "M1: time until a change of the controls shows on the own screen", 0.1},
    [LL_METRIC_CONFIRMED_LATENCY] = {"confirmed_latency_ms",
                                     "M1: time until it shows there as the server applied it", 0.1},
    [LL_METRIC_SEEN_LATENCY] = {"seen_latency_ms", "M1: time until it shows on another player's screen", 0.1},
    [LL_METRIC_ACK_RTT] = {"ack_rtt_ms", "M2: time until a client learns that its input was applied", 0.1},
    [LL_METRIC_VIEW_AGE] = {"view_age_ms", "M3: age of the others as drawn", 0.1},
    [LL_METRIC_AGE_OF_INFORMATION] = {"age_of_information_ms",
                                      "M3b: age of the newest state that the client has taken in", 0.1},
    [LL_METRIC_OWN_TIMELINE_ERROR] = {"own_timeline_error_m",
                                      "M4: distance of the own entity as drawn from the truth of that tick",
                                      0.001},
    [LL_METRIC_OWN_LEAD] =
        {"own_lead_m", "M4b: distance of the own entity as drawn from the server's now: a lead, no error",
         0.001},
    [LL_METRIC_REMOTE_ERROR] = {"remote_error_m",
                                "M4c: distance of the others as drawn from the server's now", 0.001},
    [LL_METRIC_TIMELINE_ERROR] = {"timeline_error_m",
                                  "M5: distance of the others as drawn from the truth of that time", 0.001},
    [LL_METRIC_CORRECTION] = {"correction_m", "M6: size of a correction of the own entity", 0.001},
    [LL_METRIC_POP] = {"pop_m", "M6b: how far corrections move what is drawn, per frame", 0.001},
    [LL_METRIC_BUFFER] = {"buffer_ms", "M9: how far the newest state is ahead of what is drawn", 0.1},
    [LL_METRIC_UNACKED] = {"unacked", "M2b: inputs that wait for an acknowledgement", 1},
};

size_t ll_instruments_size(int entities)
{
    return sizeof(ll_instruments) + (size_t)entities * sizeof(ll_track);
}

void ll_instruments_init(ll_instruments *in, int entities, ll_time from)
{
    memset(in, 0, ll_instruments_size(entities));
    in->entities = entities;
    in->from = from;
    for (int i = 0; i < LL_METRICS; i++)
        ll_histogram_init(&in->histogram[i], ll_metric_rows[i].unit);
    ll_histogram_init(&in->animation_error, 0.1);
    ll_ledger_meet(&in->ledger);
}

/* ---- what others tell ---- */

void ll_instruments_acknowledged(ll_instruments *in, uint32_t seq, int64_t tick, ll_time made, ll_time told,
                                 ll_time now)
{
    if (ll_ledger_includes(&in->ledger, seq, tick))
        ll_measure(in, LL_METRIC_ACK_RTT, now, ll_to_ms(told - made));
}

#define VISIBLE_SHARE 0.1 /* of the way that it went by itself */

void ll_instruments_moved(ll_instruments *in, double moved, double step)
{
    double least = VISIBLE_SHARE * step > in->pixel_m ? VISIBLE_SHARE * step : in->pixel_m;
    if (moved > least && moved > in->visible_m)
        in->visible_m = moved;
}

static void decide_changes(ll_instruments *in)
{
    if (ll_changes_waiting(&in->changes))
        ll_changes_decide(&in->changes, in->histogram, &in->ledger);
}

void ll_instruments_never(ll_instruments *in, uint32_t first, uint32_t last)
{
    ll_ledger_never(&in->ledger, first, last);
    decide_changes(in);
}

void ll_instruments_stepped(ll_instruments *in, int self, const ll_stepped *s, ll_time now)
{
    const ll_entity *real = &s->world->entity[self];
    int64_t key = s->drains ? s->acked : s->step;
    if (s->drains)
        ll_ledger_drained(&in->ledger, s->step, s->unsent_from, now);
    else
        ll_ledger_stepped(&in->ledger, s->step);
    decide_changes(in);
    ll_pictures_made(&in->pictures, &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR], key, real->x, real->y, now,
                     in->from);
    if (s->drains)
        ll_pictures_skip(&in->pictures, key);
}

void ll_instruments_meet(ll_instruments *in)
{
    for (int i = 0; i < in->entities; i++)
        in->track[i].awaited.when = 0;
    ll_instruments_never(in, 1, in->ledger.newest);
    ll_ledger_meet(&in->ledger);
    ll_changes_meet(&in->changes);
    ll_pictures_void(&in->pictures, in->from);
}
