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
    [LL_METRIC_POP] = {"pop_m", "M6b: jump of the own entity as drawn when a state is taken", 0.001},
    [LL_METRIC_BUFFER] = {"buffer_ms", "M9: how far the newest state is ahead of what is drawn", 0.1},
    [LL_METRIC_UNACKED] = {"unacked", "M2b: inputs that wait for an acknowledgement", 1},
};

size_t ll_instruments_size(int entities)
{
    return sizeof(ll_instruments) + (size_t)entities * sizeof(ll_smoothness);
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

/* Differences of the positions drawn: speed, acceleration, jerk; and whether a picture stands still while the
 * truth moves. */
static void smoothness(ll_smoothness *s, double x, double truth, double dt)
{
    double v1 = x - s->x[0], v0 = s->x[0] - s->x[1], vb = s->x[1] - s->x[2];
    double moved = magnitude(truth - s->truth);
    if (s->samples >= 3) {
        double a1 = (v1 - v0) / (dt * dt), a0 = (v0 - vb) / (dt * dt), jerk = (a1 - a0) / dt;
        s->acceleration += a1 * a1;
        s->jerk += jerk * jerk;
        s->frames++;
        s->step_max = magnitude(v1) > s->step_max ? magnitude(v1) : s->step_max;
        s->truth_step_sum += moved;
        s->moving += moved > 0;
        s->frozen += moved > 0 && v1 == 0;
        s->reversals += v1 * v0 < 0;
    }
    s->x[2] = s->x[1];
    s->x[1] = s->x[0];
    s->x[0] = x;
    s->truth = truth;
    s->samples++;
}

static void measure_own(ll_instruments *in, const ll_entity *own, const ll_entity *real, bool counts)
{
    double error = distance(own->x, own->y, real->x, real->y);
    in->own_error = own->x < real->x ? -error : error;
    if (counts)
        ll_histogram_add(&in->histogram[LL_METRIC_OWN_ERROR], error);
}

void ll_instruments_frame(ll_instruments *in, const ll_client *c, const ll_world *world,
                          const ll_history *history, ll_time now, double period_s)
{
    const ll_world *shown = ll_client_shown_const(c);
    const ll_mark *marks = ll_client_marks_const(c);
    bool counts = now >= in->from;
    ll_moment moment = {0};
    ll_time found = LL_NEVER;
    measure_own(in, &shown->entity[c->self], &world->entity[c->self], counts);
    in->remote_error = in->view_age = 0;
    for (int i = 0; i < world->entities; i++) {
        if (i == c->self)
            continue;
        const ll_entity *e = &shown->entity[i], *t = &world->entity[i];
        double error = distance(e->x, e->y, t->x, t->y), age = ll_to_ms(now - marks[i].time), x, y;
        if (error >= magnitude(in->remote_error))
            in->remote_error = e->x < t->x ? -error : error;
        in->view_age = age > in->view_age ? age : in->view_age;
        if (!counts)
            continue;
        if (marks[i].time != found) {
            found = marks[i].time;
            moment = ll_history_find(history, found);
        }
        ll_history_at(history, moment, i, &x, &y);
        ll_histogram_add(&in->histogram[LL_METRIC_VIEW_AGE], age);
        ll_histogram_add(&in->histogram[LL_METRIC_REMOTE_ERROR], error);
        ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], distance(e->x, e->y, x, y));
        smoothness(&in->smooth[i], e->x, t->x, period_s);
    }
    if (!counts)
        return;
    in->frames++;
    in->held_frames += c->held_now;
    if (c->has_render)
        ll_histogram_add(&in->histogram[LL_METRIC_BUFFER], c->buffer_ms);
}
