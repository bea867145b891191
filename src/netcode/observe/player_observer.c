#include "netcode/observe/player_observer.h"

#include <string.h>

#include "base/detmath.h"
#include "netcode/state/peer.h"

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

static void measure_own(ll_client_metrics *in, const ll_entity *own, const ll_entity *real, int self,
                        ll_frame_length frame, bool counts)
{
    double lead = distance(own->x, own->y, real->x, real->y);
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
    double x, y;
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
        ll_history_at(t->history, ll_history_step(drawn.key), c->self, &x, &y);
        *truth = (ll_rendered_view){drawn.key, ll_history_time(t->history, drawn.key), x, y};
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

/* What is drawn belongs to a time. Where a client steps a world of its own it belongs to a step, coded as a
 * negative number: step 0 is -1. */
static int64_t render_key(const ll_client *c, int entity)
{
    return c->view_step >= 0 ? -1 - c->view_step : ll_client_draw_infos_const(c)[entity].time;
}

static int64_t step_of(int64_t when)
{
    return -1 - when;
}

static bool is_past(const ll_history *history, int64_t when, ll_time now)
{
    return when < 0 ? step_of(when) < history->count : when <= now;
}

static ll_moment moment_of(const ll_history *history, int64_t when)
{
    return when < 0 ? ll_history_step(step_of(when)) : ll_history_find(history, when);
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
    double x, y;
    if (a->when != 0 && is_past(history, a->when, now)) {
        ll_history_at(history, moment_of(history, a->when), entity, &x, &y);
        ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], distance(a->x, a->y, x, y));
        a->when = 0;
    }
    if (a->when == 0 && !is_past(history, when, now))
        *a = (ll_awaited){when, drawn->x, drawn->y};
}

static void measure_motion(ll_client_metrics *in, ll_track *track, const ll_entity *drawn,
                           const ll_entity *real, double dt)
{
    double off = ll_smoothness_add(&track->smooth, drawn, real->x, real->y, dt);
    if (off >= 0)
        ll_histogram_add(&in->animation_error,
                         in->corrections.pixel_m > 0 ? off / in->corrections.pixel_m : off);
}

/* What the entities have in common that are drawn at one time. */
typedef struct drawn_at {
    int64_t when;
    double age; /* ms */
    bool past;
    double share;                            /* of the way between these; only of the past */
    const ll_history_record *before, *after; /* around it */
} drawn_at;

static drawn_at find_drawn_at(int64_t when, const ll_history *history, ll_time now)
{
    drawn_at d = {.when = when, .age = ll_to_ms(now - drawn_time(when, history, now))};
    d.past = is_past(history, when, now);
    if (!d.past)
        return d;
    ll_moment moment = moment_of(history, when);
    d.share = moment.share;
    d.before = ll_history_record_at(history, moment.before);
    d.after = ll_history_record_at(history, moment.after);
    return d;
}

/* The timeline error of an entity drawn at a time of the past. */
static double timeline_error(const drawn_at *d, int entity, const ll_entity *drawn)
{
    const ll_history_place *a = &d->before->at[entity], *b = &d->after->at[entity];
    return distance(drawn->x, drawn->y, a->x + d->share * (b->x - a->x), a->y + d->share * (b->y - a->y));
}

static __attribute__((noinline)) void measure_nearness(const ll_truth *truth, int self, const ll_entity *e,
                                                       double error)
{
    const ll_entity *own = &truth->world->entity[self];
    const bool far = distance(own->x, own->y, e->x, e->y) > truth->nearness->near_m;
    truth->nearness->sum[far] += error;
    truth->nearness->count[far]++;
}

/* A display of a client, compared with the truth entity by entity. */
typedef struct comparison {
    ll_client_metrics *in;
    const ll_client *c;
    const ll_truth *truth;
    const ll_world *shown;
    ll_time now;
    ll_frame_length frame;
    drawn_at drawn; /* of the entity before */
} comparison;

static inline void measure_other(comparison *by, int i)
{
    ll_client_metrics *in = by->in;
    const ll_entity *e = &by->shown->entity[i], *t = &by->truth->world->entity[i];
    const ll_history *history = by->truth->history;
    ll_track *track = &in->track[i];
    int64_t when = render_key(by->c, i);
    double error = distance(e->x, e->y, t->x, t->y);
    if (when != by->drawn.when)
        by->drawn = find_drawn_at(when, history, by->now);
    const drawn_at *drawn = &by->drawn;
    if (error >= magnitude(in->last.remote_error))
        in->last.remote_error = e->x < t->x ? -error : error;
    in->last.view_age = drawn->age > in->last.view_age ? drawn->age : in->last.view_age;
    if (by->now < in->from)
        return;
    ll_histogram_add(&in->histogram[LL_METRIC_VIEW_AGE], drawn->age > 0 ? drawn->age : 0);
    ll_histogram_add(&in->histogram[LL_METRIC_REMOTE_ERROR], error);
    if (by->truth->nearness)
        measure_nearness(by->truth, by->c->self, t, error);
    if (!drawn->past || track->awaited.when != 0)
        measure_ahead(in, i, e, when, history, by->now);
    if (drawn->past)
        ll_histogram_add(&in->histogram[LL_METRIC_TIMELINE_ERROR], timeline_error(drawn, i, e));
    ll_inconsistency_in(&in->server, &track->server, error, by->frame);
    measure_motion(in, track, e, t, by->frame.s);
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
        if (list.entity[k] != by->c->self)
            measure_other(by, list.entity[k]);
    }
}

static void measure_others(ll_client_metrics *in, const ll_client *c, const ll_truth *truth, ll_time now,
                           ll_frame_length frame)
{
    comparison by = {in, c, truth, ll_client_rendered_const(c), now, frame, {.when = LL_NEVER}};
    if (truth->known) {
        measure_known(&by);
        return;
    }
    for (int i = 0; i < truth->world->entities; i++)
        if (i != c->self && !(by.shown->entity[i].flags & LL_ENTITY_UNKNOWN))
            measure_other(&by, i);
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
    in->last.remote_error = in->last.view_age = 0;
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
        *last = (ll_drawn_tick){time, ll_history_find(t->history, time).before};
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

/* The drawn positions of one entity, a view each, and the box around them. */
typedef struct drawn_positions {
    int count;
    double x[LL_PLAYERS_MAX], y[LL_PLAYERS_MAX];
    double x0, x1, y0, y1;
} drawn_positions;

static void find_drawn(drawn_positions *d, const ll_entity *const *shown, int count, int e)
{
    d->count = count;
    double x0 = shown[0][e].x, x1 = x0, y0 = shown[0][e].y, y1 = y0;
    for (int i = 0; i < count; i++) {
        double x = shown[i][e].x, y = shown[i][e].y;
        x0 = x < x0 ? x : x0;
        x1 = x > x1 ? x : x1;
        y0 = y < y0 ? y : y0;
        y1 = y > y1 ? y : y1;
        d->x[i] = x;
        d->y[i] = y;
    }
    d->x0 = x0;
    d->x1 = x1;
    d->y0 = y0;
    d->y1 = y1;
}

static double square_of(double dx, double dy)
{
    return dx * dx + dy * dy;
}

/* Whether all lie within the distance that counts as no inconsistency: the usual case for an entity at rest.
 */
static bool agree(const drawn_positions *d)
{
    return square_of(d->x1 - d->x0, d->y1 - d->y0) <= LL_DIVERGENCE_EPISODE_M * LL_DIVERGENCE_EPISODE_M;
}

/* Of positions on a line, the farthest from any is one of the ends: the distances, without roots. */
static void farthest_on_line(const drawn_positions *d, double *far)
{
    for (int i = 0; i < d->count; i++) {
        double left = d->x[i] - d->x0, right = d->x1 - d->x[i];
        far[i] = left > right ? left : right;
    }
}

static void farthest_others(const drawn_positions *d, double *far)
{
    for (int j = 0; j < d->count; j++) {
        far[j] = 0;
        for (int i = 0; i < j; i++) {
            double square = square_of(d->x[i] - d->x[j], d->y[i] - d->y[j]);
            far[i] = square > far[i] ? square : far[i];
            far[j] = square > far[j] ? square : far[j];
        }
    }
    for (int i = 0; i < d->count; i++)
        far[i] = ll_sqrt(far[i]);
}

/* Of one entity, in the views of `count` clients. */
static void measure_between(ll_client_metrics *const *in, const ll_entity *const *shown, int count, int e,
                            ll_frame_length frame)
{
    double far[LL_PLAYERS_MAX];
    drawn_positions drawn;
    find_drawn(&drawn, shown, count, e);
    if (agree(&drawn)) {
        for (int i = 0; i < count; i++)
            in[i]->track[e].clients = (ll_divergence_episode){0};
        return;
    }
    (drawn.y0 == drawn.y1 ? farthest_on_line : farthest_others)(&drawn, far);
    for (int i = 0; i < count; i++)
        ll_inconsistency_in(&in[i]->clients, &in[i]->track[e].clients, far[i], frame);
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
