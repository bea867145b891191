/* Snapshot interpolation on the server's time stamps (paper, "Interpolation").
 *
 * The client draws others at a server time that lies ratio / update rate + margin behind the newest it could
 * know: the server's clock as brought by the fastest packet of the last two seconds. That render time moves
 * forward only; it runs at most a tenth faster or slower to follow, waits at the newest state when the buffer
 * has run dry, and jumps ahead when it is far behind. */
#include "netcode/client.h"

#define JUMP (250 * LL_MS)

void ll_interpolate_heard(ll_client *c, const ll_received *state)
{
    ll_time sample = state->time - state->arrived;
    int64_t quarter = state->arrived / (LL_SECOND / 4);
    if (c->offset_quarter < 0 || quarter - c->offset_quarter >= LL_OFFSET_WINDOW) {
        for (int i = 0; i < LL_OFFSET_WINDOW; i++)
            c->offset_window[i] = sample;
    } else {
        for (int64_t q = c->offset_quarter + 1; q <= quarter; q++)
            c->offset_window[q % LL_OFFSET_WINDOW] = sample;
    }
    c->offset_quarter = quarter;
    ll_time *now = &c->offset_window[quarter % LL_OFFSET_WINDOW];
    if (sample > *now)
        *now = sample;
    c->offset = sample;
    for (int i = 0; i < LL_OFFSET_WINDOW; i++)
        if (c->offset_window[i] > c->offset)
            c->offset = c->offset_window[i];
}

void ll_blend(ll_client *c, const ll_received *a, const ll_received *b, double alpha)
{
    const ll_world *wa = (const ll_world *)(a + 1), *wb = (const ll_world *)(b + 1);
    ll_world *shown = ll_client_shown(c);
    c->alpha = alpha;
    for (int i = 0; i < wa->entities; i++) {
        if (i == c->self)
            continue;
        const ll_entity *p = &wa->entity[i], *q = &wb->entity[i];
        ll_entity *e = &shown->entity[i];
        *e = *p;
        if (((p->flags ^ q->flags) & LL_ENTITY_ACTIVE) ==
            0) { /* otherwise a flight began or ended in between */
            e->x += alpha * (q->x - p->x);
            e->y += alpha * (q->y - p->y);
            e->vx += alpha * (q->vx - p->vx);
            e->vy += alpha * (q->vy - p->vy);
            e->angle += alpha * (q->angle - p->angle);
            e->spin += alpha * (q->spin - p->spin);
        }
        ll_client_marks(c)[i].flags = LL_SHOWN_INTERPOLATED;
    }
}

static void advance_render_time(ll_client *c, ll_time target, ll_time newest)
{
    ll_time error = target - (c->render + c->period);
    ll_time tenth = c->period / 10;
    if (!c->has_render || error > JUMP)
        c->render = target;
    else if (error > -JUMP)
        c->render += c->period + (error > tenth ? tenth : error < -tenth ? -tenth : error);
    c->has_render = 1;
    c->held_now = c->render > newest;
    if (c->held_now)
        c->render = newest;
}

void ll_interpolate_server_time(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_time delay =
        (ll_time)(s->config->interpolation_ratio / c->update_hz * 1e9) + ll_ms(s->config->jitter_margin_ms);
    const ll_received *newest = ll_client_state(c, c->newest - 1);
    bool held_before = c->held_now;
    advance_render_time(c, now + c->offset - delay, newest->time);
    if (c->held_now && !held_before && now >= s->instruments->from)
        s->instruments->underruns++;

    int64_t oldest = c->newest > LL_STATE_RING ? c->newest - LL_STATE_RING : 0;
    int64_t i = c->newest - 1;
    while (i > oldest && ll_client_state(c, i)->time > c->render)
        i--;
    const ll_received *a = ll_client_state(c, i), *b = i + 1 < c->newest ? ll_client_state(c, i + 1) : a;
    double alpha = 0;
    if (b->time > a->time && c->render > a->time)
        alpha = (double)(c->render - a->time) / (double)(b->time - a->time);
    ll_blend(c, a, b, alpha);
    ll_time drawn = a->time > c->render ? a->time : c->render;
    ll_mark *marks = ll_client_marks(c);
    for (int p = 0; p < ll_client_latest(c)->entities; p++) {
        if (p == c->self)
            continue;
        marks[p].time = drawn;
        if (c->held_now)
            marks[p].flags |= LL_SHOWN_HELD;
    }
    c->buffer_ms = ll_to_ms(newest->time - drawn);
}
