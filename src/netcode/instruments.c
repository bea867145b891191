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

void ll_instruments_init(ll_instruments *in, ll_time from)
{
    memset(in, 0, sizeof *in);
    in->from = from;
    for (int i = 0; i < LL_METRICS; i++)
        ll_histogram_init(&in->histogram[i], ll_metric_rows[i].unit);
}

/* ---- truth ---- */

#define TRUTH_CAPACITY 512 /* 8.5 s at 60 steps a second: older than any view */

typedef struct place {
    double x, y;
} place;

typedef struct record {
    ll_time time;
    place at[];
} record;

static size_t record_size(int players)
{
    return sizeof(record) + (size_t)players * sizeof(place);
}

size_t ll_truth_size(int players)
{
    return sizeof(ll_truth) + TRUTH_CAPACITY * record_size(players);
}

void ll_truth_init(ll_truth *truth, int players)
{
    memset(truth, 0, ll_truth_size(players));
    truth->players = players;
    truth->capacity = TRUTH_CAPACITY;
}

static const record *record_at(const ll_truth *truth, int64_t i)
{
    return (const record *)((const char *)(truth + 1) +
                            (size_t)(i & (truth->capacity - 1)) * record_size(truth->players));
}

void ll_truth_add(ll_truth *truth, ll_time time, const ll_world *world)
{
    size_t at = (size_t)(truth->count++ & (truth->capacity - 1)) * record_size(truth->players);
    record *r = (record *)((char *)(truth + 1) + at);
    r->time = time;
    for (int i = 0; i < truth->players; i++)
        r->at[i] = (place){world->entity[i].x, world->entity[i].y};
}

/* The last record at or before `time`; steps are nearly even, so a guess from the newest is nearly right. */
static int64_t find(const ll_truth *truth, ll_time time)
{
    int64_t newest = truth->count - 1;
    int64_t oldest = truth->count > truth->capacity ? truth->count - truth->capacity : 0;
    const record *last = record_at(truth, newest);
    if (time >= last->time || newest == oldest)
        return newest;
    ll_time step = last->time - record_at(truth, newest - 1)->time;
    int64_t i = newest - (step > 0 ? (last->time - time) / step : 0);
    i = i < oldest ? oldest : i > newest ? newest : i;
    while (i > oldest && record_at(truth, i)->time > time)
        i--;
    while (i < newest && record_at(truth, i + 1)->time <= time)
        i++;
    return i;
}

void ll_truth_at(const ll_truth *truth, int player, ll_time time, double *x, double *y)
{
    int64_t i = find(truth, time);
    const record *a = record_at(truth, i), *b = i + 1 < truth->count ? record_at(truth, i + 1) : a;
    double s =
        b->time > a->time && time > a->time ? (double)(time - a->time) / (double)(b->time - a->time) : 0;
    *x = a->at[player].x + s * (b->at[player].x - a->at[player].x);
    *y = a->at[player].y + s * (b->at[player].y - a->at[player].y);
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

void ll_instruments_frame(ll_instruments *in, const ll_client *c, const ll_world *world,
                          const ll_truth *truth, ll_time now, double period_s)
{
    const ll_shown *shown = &c->shown;
    const ll_entity *own = &shown->entity[c->self], *real = &world->entity[c->self];
    bool counts = now >= in->from;
    double own_error = distance(own->x, own->y, real->x, real->y);
    in->own_error = own->x < real->x ? -own_error : own_error;
    in->remote_error = in->view_age = 0;
    if (counts) {
        in->frames++;
        in->held_frames += c->held_now;
        ll_histogram_add(&in->histogram[LL_METRIC_OWN_ERROR], own_error);
    }
    for (int i = 0; i < world->players; i++) {
        if (i == c->self)
            continue;
        const ll_entity *e = &shown->entity[i], *t = &world->entity[i];
        double error = distance(e->x, e->y, t->x, t->y), age = ll_to_ms(now - shown->time[i]), x, y;
        if (error >= magnitude(in->remote_error))
            in->remote_error = e->x < t->x ? -error : error;
        in->view_age = age > in->view_age ? age : in->view_age;
        if (!counts)
            continue;
        ll_histogram_add(&in->histogram[LL_METRIC_VIEW_AGE], age);
        ll_histogram_add(&in->histogram[LL_METRIC_REMOTE_ERROR], error);
        ll_truth_at(truth, i, shown->time[i], &x, &y);
        ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], distance(e->x, e->y, x, y));
        smoothness(&in->smooth[i], e->x, t->x, period_s);
    }
    if (counts && c->has_render)
        ll_histogram_add(&in->histogram[LL_METRIC_BUFFER], shown->buffer_ms);
}
