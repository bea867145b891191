/* A client of 60 Hz that draws one other entity, and the server whose snapshots it gets. */
#pragma once

#include "base/rng.h"
#include "toy.h"

#define RATE 30
#define DELAY (2 * LL_SECOND / RATE + 10 * LL_MS) /* ratio 2, margin 10 ms: the defaults */
#define STATES 4096

/* The server's snapshots as they were, and the client's view of them. */
typedef struct view {
    lone *l;
    ll_freq frame_freq;
    void (*path)(int64_t k, ll_time time, ll_entity *other); /* where the other is in snapshot k */
    int64_t sent; /* snapshots 0 to sent - 1, snapshot k of tick k */
    ll_time time[STATES], arrived[STATES];
    double x[STATES];
    int64_t order[STATES], taken; /* of the received ones, in the order of arrival */
    int64_t frames;
    ll_time now;
} view;

/* Not a path that a straight line would match by chance. */
static inline double path(int64_t k)
{
    return ll_rng_unit(3, 1, (uint64_t)k) * 100;
}

static inline void random_path(int64_t k, ll_time time, ll_entity *other)
{
    (void)time;
    other->x = path(k);
}

static inline view *new_view(const ll_sync_mode *sync)
{
    view *v = calloc(1, sizeof *v);
    v->l = new_lone(2, &toy, sync);
    v->l->config.interpolation = true;
    v->frame_freq = HZ(60);
    v->path = random_path;
    start_lone(v->l, 60, 0, 0);
    return v;
}

static inline void free_view(view *v)
{
    free_lone(v->l);
    free(v);
}

/* The server makes a snapshot every 1/RATE s; each arrives after `lag(k)`, LL_NEVER: lost. Runs both until
 * `until`, and calls `look` after each frame. */
static inline void run(view *v, ll_time until, ll_time (*lag)(int64_t k), void (*look)(view *v))
{
    for (; ll_tick_time(v->frames, v->frame_freq) < until; v->frames++) {
        v->now = ll_tick_time(v->frames, v->frame_freq);
        for (; ll_tick_time(v->sent, HZ(RATE)) <= v->now; v->sent++) {
            int64_t k = v->sent;
            assert_true(k < STATES);
            v->time[k] = ll_tick_time(k, HZ(RATE));
            ll_time way = lag(k);
            v->arrived[k] = way == LL_NEVER ? LL_NEVER : v->time[k] + way;
        }
        for (;;) { /* what has arrived since the last frame, in the order of arrival */
            int64_t next = -1;
            for (int64_t k = v->sent > 200 ? v->sent - 200 : 0; k < v->sent; k++)
                if (v->arrived[k] <= v->now && (next < 0 || v->arrived[k] < v->arrived[next]))
                    next = k;
            if (next < 0)
                break;
            packet p = state_of(next, v->time[next], 0, 2, (double[]){0, 0});
            v->path(next, v->time[next], &p.entity[1]);
            v->x[next] = p.entity[1].x;
            if (give(v->l, &p, v->arrived[next]) == LL_OUTCOME_APPLIED)
                v->order[v->taken++] = next;
            v->arrived[next] = LL_NEVER;
        }
        frame(v->l, v->now, NULL);
        if (look != NULL)
            look(v);
    }
}

static inline const ll_entity *other(const view *v)
{
    return &ll_client_rendered(v->l->client)->entity[1];
}

static inline ll_time shown_time(const view *v)
{
    return ll_client_draw_infos(v->l->client)[1].time;
}

static inline uint32_t shown_flags(const view *v)
{
    return ll_client_draw_infos(v->l->client)[1].flags;
}

static inline ll_time newest_time(const view *v)
{
    return v->time[v->order[v->taken - 1]];
}

static inline bool about(ll_time a, ll_time b)
{
    return a - b <= 2 && b - a <= 2;
}

static inline ll_time lag_50(int64_t k)
{
    (void)k;
    return 50 * LL_MS;
}
