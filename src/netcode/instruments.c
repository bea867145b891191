#include "netcode/instruments.h"

#include <string.h>

#include "base/detmath.h"
#include "netcode/client.h"

const ll_metric_row ll_metric_rows[LL_METRICS] = {
    [LL_METRIC_INPUT_LATENCY] = {"input_latency_ms",
                                 "M1: time until an input's effect is first drawn by its own client", 0.1},
    [LL_METRIC_ACK_RTT] = {"ack_rtt_ms", "M2: time until a client learns that its input was applied", 0.1},
    [LL_METRIC_VIEW_AGE] = {"view_age_ms", "M3: age of the others as drawn", 0.1},
    [LL_METRIC_OWN_ERROR] = {"own_error_m", "M4: distance of the own entity as drawn from the server's now",
                             0.001},
    [LL_METRIC_REMOTE_ERROR] = {"remote_error_m", "M4: distance of the others as drawn from the server's now",
                                0.001},
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
}

/* ---- a frame ---- */

static double distance(double ax, double ay, double bx, double by)
{
    double dx = ax - bx, dy = ay - by;
    if (dy == 0)
        return dx < 0 ? -dx : dx;
    return ll_sqrt(dx * dx + dy * dy);
}

static double magnitude(double x)
{
    return x < 0 ? -x : x;
}

static void measure_own(ll_instruments *in, const ll_entity *own, const ll_entity *real, int self,
                        ll_time elapsed, bool counts)
{
    double error = distance(own->x, own->y, real->x, real->y);
    in->own_error = own->x < real->x ? -error : error;
    if (!counts)
        return;
    ll_histogram_add(&in->histogram[LL_METRIC_OWN_ERROR], error);
    ll_inconsistency_add(&in->server, &in->track[self].server, error, elapsed);
}

static void measure_buffer(ll_instruments *in, const ll_client *c, ll_time now)
{
    in->held_frames += c->held_now;
    in->extrapolated_frames += c->extrapolated;
    if (c->view_state == LL_VIEW_NEWEST)
        return;
    ll_histogram_add(&in->histogram[LL_METRIC_BUFFER], c->buffer_ms > 0 ? c->buffer_ms : 0);
    ll_gauge_add(&in->depth, (double)c->depth);
    ll_gauge_add(&in->delay_ms, ll_to_ms(now + c->offset - c->render));
    ll_gauge_add(&in->time_scale, c->time_scale);
}

/* What is drawn is of a time, or, where a client steps a world of its own, of a step: that is told as a
 * negative number. */
static int64_t when_of(const ll_client *c, int entity)
{
    return c->view_step >= 0 ? -c->view_step : ll_client_marks_const(c)[entity].time;
}

static bool has_been(const ll_history *history, int64_t when, ll_time now)
{
    return when < 0 ? -when < history->count : when <= now;
}

static ll_moment moment_of(const ll_history *history, int64_t when)
{
    return when < 0 ? ll_history_step(-when) : ll_history_find(history, when);
}

static ll_time drawn_time(const ll_client *c, int entity, const ll_history *history, ll_time now)
{
    int64_t when = when_of(c, entity);
    if (when < 0 && has_been(history, when, now))
        return ll_history_time(history, -when);
    return ll_client_marks_const(c)[entity].time;
}

/* M5 of what is drawn ahead of the server. */
static void measure_ahead(ll_instruments *in, int entity, const ll_entity *drawn, int64_t when,
                          const ll_history *history, ll_time now)
{
    ll_awaited *a = &in->track[entity].awaited;
    double x, y;
    if (a->when != 0 && has_been(history, a->when, now)) {
        ll_history_at(history, moment_of(history, a->when), entity, &x, &y);
        ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], distance(a->x, a->y, x, y));
        a->when = 0;
    }
    if (a->when == 0 && !has_been(history, when, now))
        *a = (ll_awaited){when, drawn->x, drawn->y};
}

void ll_instruments_meet(ll_instruments *in)
{
    for (int i = 0; i < in->entities; i++)
        in->track[i].awaited.when = 0;
}

void ll_instruments_frame(ll_instruments *in, const ll_client *c, const ll_world *world,
                          const ll_history *history, ll_time now)
{
    const ll_world *shown = ll_client_shown_const(c);
    bool counts = now >= in->from;
    ll_moment moment = {0};
    int64_t found = LL_NEVER;
    measure_own(in, &shown->entity[c->self], &world->entity[c->self], c->self, c->elapsed, counts);
    in->remote_error = in->view_age = 0;
    for (int i = 0; i < world->entities; i++) {
        if (i == c->self)
            continue;
        const ll_entity *e = &shown->entity[i], *t = &world->entity[i];
        ll_track *track = &in->track[i];
        int64_t when = when_of(c, i);
        double error = distance(e->x, e->y, t->x, t->y), x, y;
        double age = ll_to_ms(now - drawn_time(c, i, history, now));
        if (error >= magnitude(in->remote_error))
            in->remote_error = e->x < t->x ? -error : error;
        in->view_age = age > in->view_age ? age : in->view_age;
        if (!counts)
            continue;
        ll_histogram_add(&in->histogram[LL_METRIC_VIEW_AGE], age > 0 ? age : 0);
        ll_histogram_add(&in->histogram[LL_METRIC_REMOTE_ERROR], error);
        measure_ahead(in, i, e, when, history, now);
        if (has_been(history, when, now)) {
            if (when != found) {
                found = when;
                moment = moment_of(history, found);
            }
            ll_history_at(history, moment, i, &x, &y);
            ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], distance(e->x, e->y, x, y));
        }
        ll_inconsistency_add(&in->server, &track->server, error, c->elapsed);
        ll_smoothness_add(&track->smooth, e->x, e->y, t->x, t->y, ll_to_s(c->elapsed));
    }
    if (!counts)
        return;
    in->frames++;
    in->measured += c->elapsed;
    measure_buffer(in, c, now);
}

/* ---- between clients ---- */

/* All pictures of entity `e` lie within the distance that is no inconsistency: mostly so for what rests. */
static bool agree(const ll_client *const *clients, int count, int e)
{
    const ll_entity *first = &ll_client_shown_const(clients[0])->entity[e];
    double x0 = first->x, x1 = x0, y0 = first->y, y1 = y0;
    for (int i = 1; i < count; i++) {
        const ll_entity *other = &ll_client_shown_const(clients[i])->entity[e];
        x0 = other->x < x0 ? other->x : x0;
        x1 = other->x > x1 ? other->x : x1;
        y0 = other->y < y0 ? other->y : y0;
        y1 = other->y > y1 ? other->y : y1;
    }
    return (x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0) <= LL_EXCURSION_M * LL_EXCURSION_M;
}

static void farthest_others(const ll_client *const *clients, int count, int e, double *squares)
{
    for (int i = 0; i < count; i++)
        squares[i] = 0;
    for (int i = 0; i < count; i++)
        for (int j = i + 1; j < count; j++) {
            const ll_entity *a = &ll_client_shown_const(clients[i])->entity[e],
                            *b = &ll_client_shown_const(clients[j])->entity[e];
            double square = (a->x - b->x) * (a->x - b->x) + (a->y - b->y) * (a->y - b->y);
            squares[i] = square > squares[i] ? square : squares[i];
            squares[j] = square > squares[j] ? square : squares[j];
        }
}

void ll_instruments_between(ll_instruments *const *in, const ll_client *const *clients, int count,
                            ll_time now, ll_time elapsed)
{
    if (now < in[0]->from)
        return;
    for (int e = 0; e < in[0]->entities; e++) {
        double squares[LL_PLAYERS_MAX] = {0};
        if (!agree(clients, count, e))
            farthest_others(clients, count, e, squares);
        for (int i = 0; i < count; i++)
            ll_inconsistency_add(&in[i]->clients, &in[i]->track[e].clients, ll_sqrt(squares[i]), elapsed);
    }
}
