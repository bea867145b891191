/* Snapshot interpolation on the server's time stamps (paper, "Interpolation").
 *
 * The client draws others at a render time one interpolation delay behind the newest server time that it
 * could know: the server's clock as brought by the fastest packet of the last two seconds. Render time only
 * increases, and follows its target by its time scale. When the buffer is empty, it continues by
 * extrapolation up to a limit, and waits there. */
#include "netcode/view/view.h"

#define GAIN 0.25 /* of the averages of gaps and lateness, as in Netcode for Entities */

static void average_gaps(ll_client *c, const ll_snapshot_entry *state, ll_time sample)
{
    c->late += GAIN * ((double)(c->offset - sample) - c->late);
    if (c->last_arrival >= 0) {
        double gap = (double)(state->arrived - c->last_arrival);
        if (c->gap < 0)
            c->gap = gap;
        double off = gap > c->gap ? gap - c->gap : c->gap - gap;
        c->gap_deviation += GAIN * (off - c->gap_deviation);
        c->gap += GAIN * (gap - c->gap);
    }
    c->last_arrival = state->arrived;
}

void ll_interpolate_heard(ll_client *c, const ll_snapshot_entry *state)
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
    average_gaps(c, state, sample);
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

static place find(ll_client *c, ll_time time)
{
    int64_t oldest = c->newest > LL_STATE_RING ? c->newest - LL_STATE_RING : 0, i = c->newest - 1;
    while (i > oldest && ll_client_state(c, i)->time > time)
        i--;
    place p = {.index = i, .a = ll_client_state(c, i)};
    p.b = i + 1 < c->newest ? ll_client_state(c, i + 1) : p.a;
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

static void pose(const ll_client_setup *s, const place *p, int i, ll_entity *out)
{
    if (p->beyond_s > 0)
        ll_extrapolate(s, entity_of(p->a, i), p->beyond_s, out);
    else
        between(ll_interpolations[s->config->interpolation_method], p, i, out);
}

void ll_blend(ll_client *c, const ll_snapshot_entry *a, const ll_snapshot_entry *b, double alpha)
{
    const place p = {.a = a, .b = b, .alpha = alpha};
    c->alpha = alpha;
    for (int i = 0; i < ll_client_rendered(c)->entities; i++) {
        if (i == c->self)
            continue;
        between(&ll_interpolation_linear, &p, i, &ll_client_rendered(c)->entity[i]);
        ll_client_draw_infos(c)[i].flags = LL_RENDERED_INTERPOLATED;
    }
}

/* ---- a frame ---- */

/* New snapshots show where the others were when the last frame extrapolated them. */
static void correct_extrapolation(ll_client *c, const ll_client_setup *s)
{
    if (c->drawn_newest == c->newest || !c->has_render || !c->extrapolated)
        return;
    const place p = find(c, c->render);
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
    const ll_time_scale *rule = ll_time_scales[s->config->time_scale];
    ll_time error = target - (c->render + c->elapsed), limit = rule->limit(c);
    if (!c->has_render || error > limit) {
        *jumped = c->has_render;
        c->render = target;
        c->time_scale = 1;
        c->drift = 0;
        return LL_VIEW_NORMAL;
    }
    ll_time step = error > -limit ? c->elapsed + rule->extra(c, error) : 0;
    c->render += step;
    c->time_scale = c->elapsed > 0 ? (double)step / (double)c->elapsed : 1;
    return c->time_scale > 1.005   ? LL_VIEW_CATCHING_UP
           : c->time_scale < 0.995 ? LL_VIEW_SLOWING
                                   : LL_VIEW_NORMAL;
}

/* Stops render time where nothing newer is known, and counts under-runs and overruns. */
static void take_stock(ll_client *c, const ll_client_setup *s, ll_view_state moved, bool jumped, ll_time now)
{
    ll_time newest = ll_client_state(c, c->newest - 1)->time,
            reach = newest + ll_ms(s->config->extrapolation_ms);
    bool was_dry = c->underrun;
    c->held_now = c->render > reach;
    if (c->held_now) {
        c->render = reach;
        c->time_scale = 0;
    }
    c->has_render = 1;
    c->extrapolated = c->render > newest;
    c->underrun =
        c->held_now || (c->extrapolated && s->config->interpolation); /* without a delay there is no buffer */
    c->view_state = (uint8_t)(c->held_now       ? LL_VIEW_STARVED
                              : c->extrapolated ? LL_VIEW_EXTRAPOLATING
                                                : moved);
    c->drawn_newest = c->newest;
    if (now >= s->client_metrics->from) {
        s->client_metrics->underruns += c->underrun && !was_dry;
        s->client_metrics->overruns += jumped && !c->held_now;
    }
}

static void draw_others(ll_client *c, const ll_client_setup *s)
{
    const place p = find(c, c->render);
    ll_world *shown = ll_client_rendered(c);
    ll_draw_info mark = {.time = p.a->time > c->render ? p.a->time : c->render,
                         .flags = c->extrapolated ? LL_RENDERED_EXTRAPOLATED : LL_RENDERED_INTERPOLATED};
    if (c->held_now)
        mark.flags |= LL_RENDERED_HELD;
    for (int i = 0; i < shown->entities; i++) {
        if (i == c->self)
            continue;
        pose(s, &p, i, &shown->entity[i]);
        ll_client_draw_infos(c)[i] = mark;
    }
    c->alpha = p.alpha;
    c->depth = c->newest - 1 - p.index;
    c->buffer_ms = ll_to_ms(ll_client_state(c, c->newest - 1)->time - mark.time);
}

/* The newest server time that could be known. With interpolation: that of a snapshot as fast as the fastest.
 * Without: the server's present by the client's estimate of its clock. */
static ll_time reference(const ll_client *c, const ll_client_setup *s, ll_time now)
{
    if (s->config->interpolation || s->config->extrapolation_clock == LL_CLOCK_ARRIVAL)
        return now + c->offset;
    return ll_client_local(s, now) + c->connection.clock.offset;
}

void ll_interpolate_server_time(ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_player_config *config = s->config;
    bool jumped = false;
    correct_extrapolation(c, s);
    c->delay =
        config->interpolation ? ll_interpolation_delays[config->interpolation_delay]->delay(c, config) : 0;
    ll_view_state moved = move(c, s, reference(c, s, now) - c->delay, &jumped);
    take_stock(c, s, moved, jumped, now);
    draw_others(c, s);
}
