#include "netcode/metrics/client_metrics.h"

#include <string.h>

#include "base/detmath.h"

#define ROW(id, type, name, unit, bucket, help, null) {#name, bucket},

const ll_metric_row ll_metric_rows[LL_METRICS] = {LL_CLIENT_METRICS(ROW)};

size_t ll_client_metrics_size(int entities)
{
    return sizeof(ll_client_metrics) + (size_t)entities * sizeof(ll_track);
}

void ll_client_metrics_init(ll_client_metrics *in, int entities, ll_time from)
{
    memset(in, 0, ll_client_metrics_size(entities));
    in->observes = LL_OBSERVE_ALL;
    in->entities = entities;
    in->from = from;
    for (int i = 0; i < LL_METRICS; i++)
        ll_histogram_init(&in->histogram[i], ll_metric_rows[i].unit);
    ll_histogram_init(&in->animation_error, 0.1);
    ll_input_history_resync(&in->input_history);
}

/* ---- reports of clients and server ---- */

void ll_client_metrics_acknowledged(ll_client_metrics *in, uint32_t seq, int64_t tick, ll_time made,
                                    ll_time acknowledged, ll_time now)
{
    if ((in->observes & LL_OBSERVE_INPUTS) && ll_input_history_includes(&in->input_history, seq, tick))
        ll_measure(in, LL_METRIC_ACK_RTT, now, ll_to_ms(acknowledged - made));
}

#define VISIBLE_SHARE 0.1 /* of the distance that it moved by its own speed */

void ll_client_metrics_moved(ll_client_metrics *in, double moved, double step)
{
    double least =
        VISIBLE_SHARE * step > in->corrections.pixel_m ? VISIBLE_SHARE * step : in->corrections.pixel_m;
    if (moved > least && moved > in->corrections.visible_m)
        in->corrections.visible_m = moved;
}

static void decide_changes(ll_client_metrics *in)
{
    if (ll_changes_waiting(&in->changes))
        ll_changes_decide(&in->changes, in->histogram, &in->input_history);
}

void ll_client_metrics_never(ll_client_metrics *in, uint32_t first, uint32_t last)
{
    ll_input_history_never(&in->input_history, first, last);
    decide_changes(in);
}

static void step_inputs(ll_client_metrics *in, const ll_stepped *s, ll_time now)
{
    if (s->applies_on_arrival)
        ll_input_history_applied(&in->input_history, s->step, s->unsent_from, now);
    else
        ll_input_history_stepped(&in->input_history, s->step);
    decide_changes(in);
}

void ll_client_metrics_stepped(ll_client_metrics *in, int self, const ll_stepped *s, ll_time now)
{
    const ll_entity *real = &s->world->entity[self];
    int64_t key = s->applies_on_arrival ? s->acked : s->step;
    if (in->observes & LL_OBSERVE_INPUTS)
        step_inputs(in, s, now);
    if (!(in->observes & LL_OBSERVE_VIEWS))
        return;
    const ll_rendered_view truth = {key, now, real->x, real->y};
    ll_rendered_views_made(&in->rendered_views, &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR], &truth,
                           in->from);
    if (s->applies_on_arrival)
        ll_rendered_views_skip(&in->rendered_views, key);
}

void ll_client_metrics_resync(ll_client_metrics *in)
{
    for (int i = 0; i < in->entities; i++)
        in->track[i].awaited.when = 0;
    ll_client_metrics_never(in, 1, in->input_history.newest);
    ll_input_history_resync(&in->input_history);
    ll_changes_resync(&in->changes);
    ll_rendered_views_void(&in->rendered_views, in->from);
}
