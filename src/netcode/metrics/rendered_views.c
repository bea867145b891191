#include "netcode/metrics/rendered_views.h"

#include "base/detmath.h"

static ll_rendered_view *kept(ll_rendered_views *p, int64_t key)
{
    _Static_assert((LL_RENDERED_VIEWS_RING & (LL_RENDERED_VIEWS_RING - 1)) == 0, "a mask finds the place");
    return &p->ring[key & (LL_RENDERED_VIEWS_RING - 1)];
}

static void drop(ll_rendered_views *p, ll_rendered_view *view, ll_time from)
{
    p->voided += view->key != 0 && view->shown >= from;
    view->key = 0;
}

void ll_rendered_views_keep(ll_rendered_views *p, const ll_rendered_view *view, ll_time from)
{
    ll_rendered_view *slot = kept(p, view->key);
    if (slot->key != view->key)
        drop(p, slot, from);
    *slot = *view;
}

void ll_rendered_views_compare(ll_rendered_views *p, ll_histogram *errors, const ll_rendered_view *view,
                               const ll_rendered_view *truth, ll_time from)
{
    double dx = view->x - truth->x, dy = view->y - truth->y;
    p->error_m = dx == 0 && dy == 0 ? 0 : ll_sqrt(dx * dx + dy * dy);
    p->lead_ms = ll_to_ms(truth->shown - view->shown);
    if (view->shown < from)
        return;
    ll_histogram_add(errors, p->error_m);
    ll_running_stats_add(&p->leads_ms, p->lead_ms);
}

void ll_rendered_views_made(ll_rendered_views *p, ll_histogram *errors, const ll_rendered_view *truth,
                            ll_time from)
{
    ll_rendered_view *view = kept(p, truth->key);
    if (truth->key == 0 || view->key != truth->key)
        return;
    view->key = 0;
    ll_rendered_views_compare(p, errors, view, truth, from);
}

void ll_rendered_views_skip(ll_rendered_views *p, int64_t key)
{
    int64_t first = key - p->skipped < LL_RENDERED_VIEWS_RING ? p->skipped : key - LL_RENDERED_VIEWS_RING;
    for (int64_t k = first; k < key; k++)
        if (kept(p, k)->key == k)
            kept(p, k)->key = 0;
    p->skipped = key;
}

void ll_rendered_views_void(ll_rendered_views *p, ll_time from)
{
    p->skipped = 0;
    for (int i = 0; i < LL_RENDERED_VIEWS_RING; i++)
        drop(p, &p->ring[i], from);
}
