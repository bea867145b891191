#include "netcode/observe/player_observer.h"

#include <string.h>

#include "base/detmath.h"
#include "base/pair.h"
#include "netcode/state/peer.h"

/* Two numbers that lie side by side: the x and y of an entity or of a place. */
static inline ll_pair pair_at(const double *first)
{
    return *(const ll_pair *)(const void *)first;
}

static inline double length(ll_pair d)
{
    if (d[1] == 0)
        return __builtin_fabs(d[0]); /* exactly the root */
    return ll_sqrt(d[0] * d[0] + d[1] * d[1]);
}

static inline double distance(const double *a, const double *b)
{
    return length(pair_at(a) - pair_at(b));
}

static void measure_own(ll_client_metrics *in, const ll_entity *own, const ll_entity *real, int self,
                        ll_frame_length frame, bool counts)
{
    double lead = distance(&own->x, &real->x);
    in->last.own_lead = own->x < real->x ? -lead : lead;
    if (!counts)
        return;
    ll_histogram_add(&in->histogram[LL_METRIC_OWN_LEAD], lead);
    ll_inconsistency_in(&in->server, &in->track[self].server, lead, frame);
}

static bool predicts(const ll_client *c, const ll_truth *t)
{
    return c->predicting != 0 && !t->peers;
}

/* The tick that the own entity is drawn at. */
static int64_t own_tick(const ll_client *c, const ll_truth *t)
{
    return t->peers ? c->view_step : predicts(c, t) ? c->prediction.tick : c->latest.tick;
}

/* Where inputs are applied on arrival, a predicted view belongs to the input that was applied last. The state
 * after that input is the server's newest, or the server has not made it yet. */
static __attribute__((noinline)) void measure_own_played(ll_client_metrics *in, const ll_client *c,
                                                         const ll_truth *t, const ll_rendered_view *drawn)
{
    const ll_entity *real = &t->world->entity[c->self];
    const ll_rendered_view truth = {t->acked, ll_history_newest(t->history), real->x, real->y};
    if (t->acked == c->prediction.played)
        ll_rendered_views_compare(&in->rendered_views, &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR], drawn,
                                  &truth, in->from);
    else if (c->prediction.played > t->acked)
        ll_rendered_views_keep(&in->rendered_views, drawn, in->from);
}

static void measure_own_view(ll_client_metrics *in, const ll_client *c, const ll_truth *t, ll_time now)
{
    const ll_entity *own = &ll_client_rendered_const(c)->entity[c->self];
    ll_rendered_view drawn = {own_tick(c, t), now, own->x, own->y};
    if (t->applies_on_arrival && predicts(c, t)) {
        drawn.key = c->prediction.played;
        measure_own_played(in, c, t, &drawn);
        return;
    }
    if (drawn.key >= t->history->count) {
        ll_rendered_views_keep(&in->rendered_views, &drawn, in->from);
        return;
    }
    ll_rendered_view *truth = &in->rendered_views.truth;
    bool known = drawn.key > t->history->count - LL_HISTORY_STEPS;
    if (!known && drawn.key != truth->key)
        return; /* the truth of that tick is no longer kept */
    if (known) {
        const ll_history_record *made = ll_history_record_at(t->history, drawn.key);
        *truth = (ll_rendered_view){drawn.key, made->time, made->at[c->self].x, made->at[c->self].y};
    }
    ll_rendered_views_compare(&in->rendered_views, &in->histogram[LL_METRIC_OWN_TIMELINE_ERROR], &drawn,
                              truth, in->from);
}

/* The newest tick for which the client has all inputs or the server's snapshot. */
static int64_t sure_tick(const ll_client *c, const ll_truth *t)
{
    return t->peers ? ll_client_peer(c)->confirmed : c->latest.tick;
}

static void measure_age(ll_client_metrics *in, const ll_client *c, const ll_truth *t, ll_time now,
                        bool counts)
{
    ll_time newest = c->latest.time;
    if (t->peers) /* a client may have confirmed a tick that the server has not made */
        newest = sure_tick(c, t) < t->history->count ? ll_history_time(t->history, sure_tick(c, t)) : now;
    in->last.age_of_information = ll_to_ms(now - newest);
    if (counts)
        ll_histogram_add(&in->histogram[LL_METRIC_AGE_OF_INFORMATION],
                         in->last.age_of_information > 0 ? in->last.age_of_information : 0);
}

static void measure_changes(ll_client_metrics *in, const ll_client *c, const ll_truth *t, ll_time now)
{
    if (!ll_changes_waiting(&in->changes))
        return;
    int64_t sure = sure_tick(c, t), tick = t->peers ? c->view_step : c->latest.tick;
    ll_included included = {.seq = predicts(c, t) ? c->prediction.played : 0,
                            .tick = tick,
                            .sure_tick = sure < tick ? sure : tick};
    ll_changes_shown(&in->changes, in->histogram, &included, now + t->device);
}

static void measure_buffer(ll_client_metrics *in, const ll_client *c, ll_time now)
{
    in->buffer.held_frames += c->view.held;
    in->buffer.extrapolated_frames += c->view.extrapolated;
    if (c->view.state == LL_VIEW_NEWEST)
        return;
    ll_histogram_add(&in->histogram[LL_METRIC_BUFFER], c->drawing.buffer_ms > 0 ? c->drawing.buffer_ms : 0);
    ll_running_stats_add(&in->buffer.depth, (double)c->drawing.depth);
    ll_running_stats_add(&in->buffer.delay_ms, ll_to_ms(now + c->view.offset - c->view.render));
    ll_running_stats_add(&in->buffer.time_scale, c->drawing.time_scale);
}

/* What is drawn belongs to a time, its render key. Where a client steps a world of its own it belongs to a
 * step, coded as a negative number: step 0 is -1. */
static int64_t step_of(int64_t when)
{
    return -1 - when;
}

static bool is_past(const ll_history *history, int64_t when, ll_time now)
{
    return when < 0 ? step_of(when) < history->count : when <= now;
}

static ll_moment moment_of(const ll_history *history, int64_t when, int64_t near)
{
    return when < 0 ? ll_history_step(step_of(when)) : ll_history_find_near(history, when, near);
}

/* A step that the server has not made has no time yet: the present counts. */
static ll_time drawn_time(int64_t when, const ll_history *history, ll_time now)
{
    if (when >= 0)
        return when;
    return is_past(history, when, now) ? ll_history_time(history, step_of(when)) : now;
}

/* Timeline error of entities drawn ahead of the server. */
static __attribute__((noinline)) void measure_ahead(ll_client_metrics *in, int entity, const ll_entity *drawn,
                                                    int64_t when, const ll_history *history, ll_time now)
{
    ll_awaited *a = &in->track[entity].awaited;
    ll_history_place real;
    if (a->when != 0 && is_past(history, a->when, now)) {
        ll_history_at(history, moment_of(history, a->when, in->drawn_tick), entity, &real.x, &real.y);
        ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], distance(&a->x, &real.x));
        a->when = 0;
    }
    if (a->when == 0 && !is_past(history, when, now))
        *a = (ll_awaited){when, drawn->x, drawn->y};
}

/* What the entities have in common that are drawn at one time. */
typedef struct drawn_at {
    int64_t when;
    double age; /* ms */
    bool past;
    double share;                            /* of the way between these; only of the past */
    const ll_history_record *before, *after; /* around it */
} drawn_at;

static inline void find_drawn_at(drawn_at *d, int64_t when, const ll_history *history, ll_time now,
                                 int64_t *tick)
{
    d->when = when;
    d->age = ll_to_ms(now - drawn_time(when, history, now));
    d->past = is_past(history, when, now);
    if (!d->past)
        return;
    ll_moment moment = moment_of(history, when, *tick);
    *tick = moment.before;
    d->share = moment.share;
    d->before = ll_history_record_at(history, moment.before);
    d->after = ll_history_record_at(history, moment.after);
}

/* The timeline error of an entity drawn at a time of the past. */
static inline double timeline_error(const drawn_at *d, int entity, const ll_entity *drawn)
{
    const ll_pair a = pair_at(&d->before->at[entity].x), b = pair_at(&d->after->at[entity].x);
    return length(pair_at(&drawn->x) - (a + d->share * (b - a)));
}

static __attribute__((noinline)) void measure_nearness(const ll_truth *truth, int self, const ll_entity *e,
                                                       double error)
{
    const ll_entity *own = &truth->world->entity[self];
    const bool far = distance(&own->x, &e->x) > truth->nearness->near_m;
    truth->nearness->sum[far] += error;
    truth->nearness->count[far]++;
}

/* A display of a client, compared with the truth entity by entity. */
typedef struct comparison {
    ll_client_metrics *in;
    const ll_truth *truth;
    const ll_entity *shown, *real;
    int self;
    bool counts;
    ll_time now;
    /* The render key of entity i, `stride` bytes after that of the one before: all are at one place where the
     * client steps a world of its own. */
    const char *whens;
    int64_t stride, step;
    ll_frame_length frame;
    double pixel_m;    /* 1 where the scene has no width */
    drawn_at drawn;    /* of the entity before */
    bool plain;        /* it counts, is of the past, and no near entities are apart from far ones */
    int alike;         /* entities before drawn at that time, whose age the histogram does not have yet */
    int worst;         /* the entity farthest off; -1: none yet */
    double error, age; /* the largest */
} comparison;

static inline void add_ages(comparison *by)
{
    ll_histogram *ages = &by->in->histogram[LL_METRIC_VIEW_AGE];
    if (by->alike > 0 && by->counts)
        ll_histogram_add_times(ages, by->drawn.age > 0 ? by->drawn.age : 0, by->alike);
    by->alike = 0;
}

/* The entities from this one on are drawn at another time than those before. */
static __attribute__((noinline)) void turn_to(comparison *by, int64_t when)
{
    add_ages(by);
    find_drawn_at(&by->drawn, when, by->truth->history, by->now, &by->in->drawn_tick);
    by->plain = by->counts && by->drawn.past && !by->truth->nearness;
    by->age = by->drawn.age > by->age ? by->drawn.age : by->age;
}

/* An entity of a comparison. */
typedef struct compared {
    const ll_entity *shown, *real;
    ll_track *track;
    const int64_t *when; /* its render key */
    int index;
} compared;

static inline void measure_timeline(const comparison *by, const compared *e)
{
    ll_histogram_add(&by->in->histogram[LL_METRIC_TIMELINE_ERROR],
                     timeline_error(&by->drawn, e->index, e->shown));
}

/* The errors where not all is plain. */
static __attribute__((noinline)) void measure_apart(const comparison *by, compared e, double error)
{
    ll_histogram_add(&by->in->histogram[LL_METRIC_REMOTE_ERROR], error);
    if (by->truth->nearness)
        measure_nearness(by->truth, by->self, e.real, error);
    measure_ahead(by->in, e.index, e.shown, by->drawn.when, by->truth->history, by->now);
    if (by->drawn.past)
        measure_timeline(by, &e);
}

static inline void measure_motion(const comparison *by, const compared *e)
{
    const double off = ll_smoothness_add(&e->track->smooth, e->shown, &e->real->x, by->frame.s);
    if (off >= 0)
        ll_histogram_add(&by->in->animation_error, off / by->pixel_m);
}

static inline __attribute__((always_inline)) void measure_other(comparison *by, const compared *e)
{
    const double error = distance(&e->shown->x, &e->real->x);
    if (*e->when != by->drawn.when)
        turn_to(by, *e->when);
    by->alike++;
    if (error >= by->error) {
        by->error = error;
        by->worst = e->index;
    }
    if (by->plain && e->track->awaited.when == 0) {
        ll_histogram_add(&by->in->histogram[LL_METRIC_REMOTE_ERROR], error);
        measure_timeline(by, e);
    } else if (by->counts) {
        measure_apart(by, *e, error);
    } else {
        return;
    }
    ll_inconsistency_in(&by->in->server, &e->track->server, error, by->frame);
    measure_motion(by, e);
}

static inline const int64_t *when_of(const comparison *by, int i)
{
    return (const int64_t *)(const void *)(by->whens + i * by->stride);
}

static __attribute__((noinline)) void measure_all(comparison *by, int entities)
{
    const int self = by->self;
    const int64_t stride = by->stride;
    const char *when = by->whens;
    const ll_entity *shown = by->shown, *real = by->real;
    ll_track *track = by->in->track;
    for (int i = 0; i < entities; i++, shown++, real++, track++, when += stride)
        if (i != self && !(shown->flags & LL_ENTITY_UNKNOWN))
            measure_other(by, &(compared){shown, real, track, (const int64_t *)(const void *)when, i});
}

/* Of the entities that the client has. */
static __attribute__((noinline)) void measure_known(comparison *by)
{
    ll_entity_list list;
    ll_entity_list_of(&list, by->truth->known);
    for (int k = 0; k < list.count; k++) {
        const int ahead = list.entity[k + LL_FETCH_AHEAD];
        ll_fetch(&by->in->track[ahead], sizeof by->in->track[ahead]);
        if (by->drawn.past) {
            ll_fetch(&by->drawn.before->at[ahead], sizeof by->drawn.before->at[ahead]);
            ll_fetch(&by->drawn.after->at[ahead], sizeof by->drawn.after->at[ahead]);
        }
        const int i = list.entity[k];
        if (i != by->self)
            measure_other(by, &(compared){&by->shown[i], &by->real[i], &by->in->track[i], when_of(by, i), i});
    }
}

static void measure_others(ll_client_metrics *in, const ll_client *c, const ll_truth *truth, ll_time now,
                           ll_frame_length frame)
{
    const bool steps = c->view_step >= 0;
    comparison by;
    by.in = in;
    by.truth = truth;
    by.shown = ll_client_rendered_const(c)->entity;
    by.real = truth->world->entity;
    by.self = c->self;
    by.counts = now >= in->from;
    by.now = now;
    by.step = -1 - c->view_step;
    by.whens = steps ? (const char *)&by.step : (const char *)&ll_client_draw_infos_const(c)->time;
    by.stride = steps ? 0 : (int64_t)sizeof(ll_draw_info);
    by.frame = frame;
    by.pixel_m = in->corrections.pixel_m > 0 ? in->corrections.pixel_m : 1;
    by.drawn.when = LL_NEVER;
    by.drawn.past = by.plain = false;
    by.alike = 0;
    by.worst = -1;
    by.error = by.age = 0;
    if (truth->known)
        measure_known(&by);
    else
        measure_all(&by, truth->world->entities);
    add_ages(&by);
    const bool behind = by.worst >= 0 && by.shown[by.worst].x < by.real[by.worst].x;
    in->last.remote_error = behind ? -by.error : by.error;
    in->last.view_age = by.age;
}

/* The display against the truth. */
static void measure_view(ll_client_metrics *in, const ll_client *c, const ll_truth *truth, ll_time now)
{
    const ll_world *shown = ll_client_rendered_const(c), *world = truth->world;
    const ll_frame_length frame = ll_frame_length_of(c->displays.elapsed);
    const bool counts = now >= in->from;
    measure_own_view(in, c, truth, now);
    measure_age(in, c, truth, now, counts);
    measure_own(in, &shown->entity[c->self], &world->entity[c->self], c->self, frame, counts);
    measure_others(in, c, truth, now, frame);
    if (counts)
        measure_buffer(in, c, now);
}

void ll_client_metrics_frame(ll_client_metrics *in, const ll_client *c, const ll_truth *truth, ll_time now)
{
    if (in->observes & LL_OBSERVE_VIEWS)
        measure_view(in, c, truth, now);
    if (in->observes & LL_OBSERVE_INPUTS)
        measure_changes(in, c, truth, now);
    ll_client_metrics_drawn(in, c->displays.elapsed, now);
}

/* The last tick at or before the time that is drawn. */
static int64_t drawn_tick(const ll_client *by, int entity, const ll_truth *t, ll_drawn_tick *last)
{
    if (t->peers)
        return by->view_step;
    ll_time time = ll_client_draw_infos_const(by)[entity].time;
    if (time != last->time)
        *last = (ll_drawn_tick){time, ll_history_find_near(t->history, time, last->tick).before};
    return last->tick;
}

void ll_client_metrics_seen(ll_client_metrics *in, int self, const ll_client *by, const ll_truth *t,
                            ll_drawn_tick *last, ll_time now)
{
    int64_t received = t->peers ? ll_client_peer(by)->player[self].known : by->latest.tick;
    int64_t drawn = drawn_tick(by, self, t, last);
    ll_changes_seen(&in->changes, in->histogram, &in->input_history, by->self,
                    received < drawn ? received : drawn, now + t->device);
}

/* Of positions on a line, the farthest from any is one of the ends: the distances, without roots. */
static inline void measure_on_line(ll_client_metrics *const *in, const ll_entity *const *shown, int count,
                                   int e, const ll_pair *ends, ll_frame_length frame)
{
    for (int i = 0; i < count; i++) {
        const double left = shown[i][e].x - ends[0][0], right = ends[1][0] - shown[i][e].x;
        ll_inconsistency_in(&in[i]->clients, &in[i]->track[e].clients, left > right ? left : right, frame);
    }
}

static double square_of(ll_pair d)
{
    return d[0] * d[0] + d[1] * d[1];
}

static void farthest_others(const ll_entity *const *shown, int count, int e, double *far)
{
    for (int j = 0; j < count; j++) {
        const ll_pair at = pair_at(&shown[j][e].x);
        far[j] = 0;
        for (int i = 0; i < j; i++) {
            double square = square_of(pair_at(&shown[i][e].x) - at);
            far[i] = square > far[i] ? square : far[i];
            far[j] = square > far[j] ? square : far[j];
        }
    }
    for (int i = 0; i < count; i++)
        far[i] = ll_sqrt(far[i]);
}

static void measure_apart_from(ll_client_metrics *const *in, const ll_entity *const *shown, int count, int e,
                               ll_frame_length frame)
{
    double far[LL_PLAYERS_MAX];
    farthest_others(shown, count, e, far);
    for (int i = 0; i < count; i++)
        ll_inconsistency_in(&in[i]->clients, &in[i]->track[e].clients, far[i], frame);
}

/* Of one entity, in the views of `count` clients. Where all lie within the distance that counts as no
 * inconsistency, the usual case for an entity at rest, there is no more to do. */
static inline void measure_between(ll_client_metrics *const *in, const ll_entity *const *shown, int count,
                                   int e, ll_frame_length frame)
{
    ll_pair ends[2] = {pair_at(&shown[0][e].x), pair_at(&shown[0][e].x)}; /* of the box around them */
    for (int i = 1; i < count; i++) {
        const ll_pair at = pair_at(&shown[i][e].x);
        ends[0] = (ll_pair){at[0] < ends[0][0] ? at[0] : ends[0][0], at[1] < ends[0][1] ? at[1] : ends[0][1]};
        ends[1] = (ll_pair){at[0] > ends[1][0] ? at[0] : ends[1][0], at[1] > ends[1][1] ? at[1] : ends[1][1]};
    }
    const ll_pair size = ends[1] - ends[0];
    if (square_of(size) <= LL_DIVERGENCE_EPISODE_M * LL_DIVERGENCE_EPISODE_M)
        for (int i = 0; i < count; i++)
            in[i]->track[e].clients = (ll_divergence_episode){0};
    else if (size[1] == 0)
        measure_on_line(in, shown, count, e, ends, frame);
    else
        measure_apart_from(in, shown, count, e, frame);
}

__attribute__((noinline)) void ll_client_metrics_between(ll_client_metrics *const *in,
                                                         const ll_client *const *clients, int count,
                                                         ll_time now, ll_time elapsed)
{
    const ll_entity *shown[LL_PLAYERS_MAX];
    const ll_frame_length frame = ll_frame_length_of(elapsed);
    if (now < in[0]->from)
        return;
    for (int i = 0; i < count; i++)
        shown[i] = ll_client_rendered_const(clients[i])->entity;
    for (int e = 0; e < in[0]->entities; e++)
        measure_between(in, shown, count, e, frame);
}

/* Of word `word` of the entities: which clients have each of them, in the order of the clients. */
typedef struct viewers {
    int count[64];
    uint8_t client[64][LL_PLAYERS_MAX];
} viewers;

/* Views of which each has only some entities. */
typedef struct partial_views {
    ll_client_metrics *const *in;
    const uint64_t *const *known; /* a bit per entity, of each client */
    const ll_entity *shown[LL_PLAYERS_MAX];
    int count;
} partial_views;

/* Fetches ahead what is drawn and noted of them. */
static void find_viewers(const partial_views *p, int word, viewers *v)
{
    memset(v->count, 0, sizeof v->count);
    for (int i = 0; i < p->count; i++)
        for (uint64_t left = p->known[i][word]; left != 0; left &= left - 1) {
            const int bit = __builtin_ctzll(left), e = 64 * word + bit;
            v->client[bit][v->count[bit]++] = (uint8_t)i;
            ll_fetch(&p->shown[i][e], 2 * sizeof(double));
            ll_fetch(&p->in[i]->track[e].clients, sizeof p->in[i]->track[e].clients);
        }
}

static void measure_viewers(const partial_views *p, const viewers *v, int e, ll_frame_length frame)
{
    const ll_entity *shown[LL_PLAYERS_MAX];
    ll_client_metrics *of[LL_PLAYERS_MAX];
    const int viewing = v->count[e & 63];
    for (int k = 0; k < viewing; k++) {
        shown[k] = p->shown[v->client[e & 63][k]];
        of[k] = p->in[v->client[e & 63][k]];
    }
    if (viewing > 0)
        measure_between(of, shown, viewing, e, frame);
}

void ll_client_metrics_between_some(ll_client_metrics *const *in, const ll_client *const *clients,
                                    const uint64_t *const *known, int count, ll_time now, ll_time elapsed)
{
    const ll_frame_length frame = ll_frame_length_of(elapsed);
    const int entities = in[0]->entities, words = (entities + 63) / 64;
    partial_views p = {.in = in, .known = known, .count = count};
    viewers v[2];
    if (now < in[0]->from)
        return;
    for (int i = 0; i < count; i++)
        p.shown[i] = ll_client_rendered_const(clients[i])->entity;
    find_viewers(&p, 0, &v[0]);
    for (int word = 0; word < words; word++) {
        if (word + 1 < words)
            find_viewers(&p, word + 1, &v[(word + 1) & 1]);
        for (int e = 64 * word; e < 64 * word + 64 && e < entities; e++)
            measure_viewers(&p, &v[word & 1], e, frame);
    }
}
