/* Snapshot interpolation on the server's time stamps (paper, "Interpolation").
 *
 * The client draws others at a render time one interpolation delay behind the newest server time that it
 * could know: the server's clock as brought by the fastest packet of the last two seconds. Render time only
 * increases, and follows its target by its time scale. When the buffer is empty, it continues by
 * extrapolation up to a limit, and waits there. */
#include <string.h>

#include "netcode/view/view.h"

#define GAIN 0.25 /* of the averages of gaps and lateness, as in Netcode for Entities */

static void average_gaps(ll_client_arrivals *arrivals, ll_time arrived, ll_time late)
{
    arrivals->late += GAIN * ((double)late - arrivals->late);
    if (arrivals->last >= 0) {
        double gap = (double)(arrived - arrivals->last);
        if (arrivals->gap < 0)
            arrivals->gap = gap;
        double off = gap > arrivals->gap ? gap - arrivals->gap : arrivals->gap - gap;
        arrivals->gap_deviation += GAIN * (off - arrivals->gap_deviation);
        arrivals->gap += GAIN * (gap - arrivals->gap);
    }
    arrivals->last = arrived;
}

void ll_interpolate_heard(ll_client *c, const ll_snapshot_entry *state)
{
    ll_client_arrivals *arrivals = &c->arrivals;
    ll_time sample = state->time - state->arrived;
    int64_t quarter = state->arrived / (LL_SECOND / 4);
    if (arrivals->quarter < 0 || quarter - arrivals->quarter >= LL_OFFSET_WINDOW)
        for (int i = 0; i < LL_OFFSET_WINDOW; i++)
            arrivals->offsets[i] = sample;
    else
        for (int64_t q = arrivals->quarter + 1; q <= quarter; q++)
            arrivals->offsets[q % LL_OFFSET_WINDOW] = sample;
    arrivals->quarter = quarter;
    ll_time *now = &arrivals->offsets[quarter % LL_OFFSET_WINDOW];
    if (sample > *now)
        *now = sample;
    c->view.offset = sample;
    for (int i = 0; i < LL_OFFSET_WINDOW; i++)
        if (arrivals->offsets[i] > c->view.offset)
            c->view.offset = arrivals->offsets[i];
    average_gaps(arrivals, state->arrived, c->view.offset - sample);
}

/* ---- a position in the buffer ---- */

/* Position of a server time in the buffer: between two snapshots, or after the newest. At the ends both are
 * the same one. */
typedef struct place {
    int64_t index; /* of `a` */
    const ll_snapshot_entry *a, *b;
    double alpha, span_s; /* fraction of the way from a to b, and its length */
    double beyond_s;      /* after the newest */
} place;

static inline place find(ll_client *c, ll_time time)
{
    int64_t oldest = ll_client_oldest(c), i = c->snapshots.received - 1;
    place p = {.a = ll_client_state(c, i)};
    p.b = p.a;
    while (p.a->time > time && i > oldest) {
        p.b = p.a;
        p.a = ll_client_state(c, --i);
    }
    p.index = i;
    if (p.b->time > p.a->time && time > p.a->time) {
        p.alpha = (double)(time - p.a->time) / (double)(p.b->time - p.a->time);
        p.span_s = ll_to_s(p.b->time - p.a->time);
    } else if (p.a == p.b && time > p.a->time) {
        p.beyond_s = ll_to_s(time - p.a->time);
    }
    return p;
}

static const ll_entity *entity_of(const ll_snapshot_entry *state, int i)
{
    return &((const ll_world *)(state + 1))->entity[i];
}

static void between(const ll_interpolation *method, const place *p, int i, ll_entity *out)
{
    const ll_entity *a = entity_of(p->a, i), *b = entity_of(p->b, i);
    *out = *a;
    if (p->alpha > 0 &&
        ((a->flags ^ b->flags) & LL_ENTITY_ACTIVE) == 0) /* otherwise a flight began or ended */
        method->between(a, b, p->alpha, p->span_s, out);
}

/* Extrapolation (dead reckoning): an entity continues from the newest snapshot at the velocity that it has
 * there. The error is a t^2 / 2 after t seconds of an unknown acceleration a, and larger across contacts
 * (Fiedler: fine for 50 to 250 ms of ballistic motion, wrong for rigid bodies). */
static void extrapolate(const ll_client_setup *s, const ll_entity *from, double dt, ll_entity *out)
{
    *out = *from;
    if (s->game->coast) {
        s->game->coast(s->env, out, dt);
        return;
    }
    out->x += from->vx * dt;
    out->y += from->vy * dt;
    out->angle += from->angular_velocity * dt;
}

static void pose(const ll_client_setup *s, const place *p, int i, ll_entity *out)
{
    if (p->beyond_s > 0)
        extrapolate(s, entity_of(p->a, i), p->beyond_s, out);
    else
        between(ll_interpolations[s->config->interpolation_method], p, i, out);
}

/* Draws the others at a place that is not after the newest. */
static void draw_between(ll_client *c, const ll_interpolation *method, const place *p)
{
    ll_world *shown = ll_client_rendered(c);
    const ll_stretch stretch = {.a = entity_of(p->a, 0),
                                .b = entity_of(p->b, 0),
                                .out = shown->entity,
                                .count = shown->entities,
                                .self = c->self,
                                .alpha = p->alpha,
                                .span_s = p->span_s};
    method->all(&stretch);
}

void ll_blend(ll_client *c, const ll_snapshot_entry *a, const ll_snapshot_entry *b, double alpha)
{
    const place p = {.a = a, .b = b, .alpha = alpha};
    c->drawing.alpha = alpha;
    draw_between(c, &ll_interpolation_linear, &p);
    for (int i = 0; i < ll_client_rendered(c)->entities; i++)
        if (i != c->self)
            ll_client_draw_infos(c)[i].flags = LL_RENDERED_INTERPOLATED;
}

/* ---- a frame ---- */

/* New snapshots show where the others were when the last frame extrapolated them. */
static __attribute__((noinline)) void correct_extrapolation(ll_client *c, const ll_client_setup *s)
{
    const place p = find(c, c->view.render);
    for (int i = 0; i < ll_client_rendered(c)->entities; i++) {
        const ll_view_error *e = &ll_client_errors(c)[i];
        ll_entity drawn = ll_client_rendered(c)->entity[i], right;
        if (!(ll_client_draw_infos(c)[i].flags & LL_RENDERED_EXTRAPOLATED))
            continue; /* the own, or predicted */
        pose(s, &p, i, &right);
        drawn.x -= e->x;
        drawn.y -= e->y;
        drawn.angle -= e->angle;
        ll_smooth_correct(c, i, &drawn, &right);
    }
}

/* Moves render time towards `target` and returns how; `jumped`: it was too far behind. */
static ll_view_state move(ll_client *c, const ll_client_setup *s, ll_time target, bool *jumped)
{
    ll_client_view *view = &c->view;
    const ll_time_scale *rule = ll_time_scales[s->config->time_scale];
    ll_time error = target - (view->render + c->displays.elapsed), limit = rule->limit(c);
    if (!view->has_render || error > limit) {
        *jumped = view->has_render;
        view->render = target;
        c->drawing.time_scale = 1;
        view->drift = 0;
        return LL_VIEW_NORMAL;
    }
    ll_time step = error > -limit ? c->displays.elapsed + rule->extra(c, error) : 0;
    view->render += step;
    c->drawing.time_scale = c->displays.elapsed > 0 ? (double)step / (double)c->displays.elapsed : 1;
    return c->drawing.time_scale > 1.005   ? LL_VIEW_CATCHING_UP
           : c->drawing.time_scale < 0.995 ? LL_VIEW_SLOWING
                                           : LL_VIEW_NORMAL;
}

/* Stops render time where nothing newer is known, and counts under-runs and overruns. */
static inline void take_stock(ll_client *c, const ll_client_setup *s, ll_time newest, ll_view_state moved,
                              bool jumped, ll_time now)
{
    ll_client_view *view = &c->view;
    ll_time reach = newest + ll_ms(s->config->extrapolation_ms);
    bool was_dry = view->underrun;
    view->held = view->render > reach;
    if (view->held) {
        view->render = reach;
        c->drawing.time_scale = 0;
    }
    view->has_render = 1;
    view->extrapolated = view->render > newest;
    view->underrun = view->held || (view->extrapolated &&
                                    s->config->interpolation); /* without a delay there is no buffer */
    view->state = (uint8_t)(view->held           ? LL_VIEW_STARVED
                            : view->extrapolated ? LL_VIEW_EXTRAPOLATING
                                                 : moved);
    c->drawing.received = c->snapshots.received;
    if (now >= s->client_metrics->from) {
        s->client_metrics->buffer.underruns += view->underrun && !was_dry;
        s->client_metrics->buffer.overruns += jumped && !view->held;
    }
}

static __attribute__((noinline)) void extrapolate_others(ll_client *c, const ll_client_setup *s,
                                                         const place *p)
{
    ll_world *shown = ll_client_rendered(c);
    for (int i = 0; i < shown->entities; i++)
        if (i != c->self)
            extrapolate(s, entity_of(p->a, i), p->beyond_s, &shown->entity[i]);
}

/* Whether states that are equal at both ends are drawn as they are, everywhere between them and at once. */
static bool settles(const ll_client_setup *s, const place *p)
{
    return p->beyond_s == 0 && ll_interpolations[s->config->interpolation_method]->settles &&
           !s->recent->minus;
}

static bool has_error(const ll_view_error *e)
{
    uint64_t word[3];
    memcpy(word, e, sizeof word);
    return (word[0] | word[1] | word[2]) != 0;
}

/* Draws what may not be drawn yet as in the last display that settled. False: that may be any. */
static __attribute__((noinline)) bool draw_recent(ll_client *c, const ll_client_setup *s, const place *p)
{
    ll_recent *r = s->recent;
    ll_entity_list list;
    const ll_interpolation *method = ll_interpolations[s->config->interpolation_method];
    ll_entity *shown = ll_client_rendered(c)->entity;
    if (!settles(s, p))
        return false;
    r->drawn = p->index + 1;
    if (r->settled > r->drawn || !ll_recent_since(r, r->settled, r->shown))
        return false;
    r->shows = 1;
    for (int e = 0; c->view.has_errors && e < r->entities; e++)
        if (has_error(&ll_client_errors(c)[e]))
            r->shown[e >> 6] |= UINT64_C(1) << (e & 63);
    r->shown[c->self >> 6] &= ~(UINT64_C(1) << (c->self & 63));
    ll_entity_list_of(&list, r->shown);
    for (int k = 0; k < list.count; k++) {
        const int ahead = list.entity[k + LL_FETCH_AHEAD], e = list.entity[k];
        ll_entity_fetch(entity_of(p->a, ahead));
        ll_entity_fetch(entity_of(p->b, ahead));
        ll_entity_fetch(&shown[ahead]);
        between(method, p, e, &shown[e]);
    }
    r->shown[c->self >> 6] |= UINT64_C(1) << (c->self & 63);
    return true;
}

static inline void draw_others(ll_client *c, const ll_client_setup *s, ll_time newest)
{
    ll_client_view *view = &c->view;
    const place p = find(c, view->render);
    const ll_world *shown = ll_client_rendered(c);
    ll_draw_info mark = {.time = p.a->time > view->render ? p.a->time : view->render,
                         .flags = view->extrapolated ? LL_RENDERED_EXTRAPOLATED : LL_RENDERED_INTERPOLATED};
    if (view->held)
        mark.flags |= LL_RENDERED_HELD;
    const bool drawn = s->recent && draw_recent(c, s, &p);
    if (!drawn && p.beyond_s > 0)
        extrapolate_others(c, s, &p);
    else if (!drawn)
        draw_between(c, ll_interpolations[s->config->interpolation_method], &p);
    ll_draw_info *marks = ll_client_draw_infos(c);
    const ll_draw_info own = marks[c->self];
    for (int i = 0; i < shown->entities; i++)
        marks[i] = mark;
    marks[c->self] = own;
    c->drawing.alpha = p.alpha;
    c->drawing.depth = c->snapshots.received - 1 - p.index;
    c->drawing.buffer_ms = ll_to_ms(newest - mark.time);
}

/* The newest server time that could be known. With interpolation: that of a snapshot as fast as the fastest.
 * Without: the server's present by the client's estimate of its clock. */
static ll_time reference(const ll_client *c, const ll_client_setup *s, ll_time now)
{
    if (s->config->interpolation || s->config->extrapolation_clock == LL_CLOCK_ARRIVAL)
        return now + c->view.offset;
    return ll_client_server_time(c, s, now);
}

void ll_interpolate_server_time(ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_player_config *config = s->config;
    bool jumped = false;
    if (c->drawing.received != c->snapshots.received && c->view.has_render && c->view.extrapolated)
        correct_extrapolation(c, s);
    c->view.delay =
        config->interpolation ? ll_interpolation_delays[config->interpolation_delay]->delay(c, config) : 0;
    ll_view_state moved = move(c, s, reference(c, s, now) - c->view.delay, &jumped);
    const ll_time newest = ll_client_state(c, c->snapshots.received - 1)->time;
    take_stock(c, s, newest, moved, jumped, now);
    draw_others(c, s, newest);
}
