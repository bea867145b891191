/* All streams that are passed on: hooks of their viewers, which run on the threads of the streams, and the
 * thread that reads from the owner. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "daemon/net/problem_json.h"
#include "daemon/relay/internal.h"
#include "daemon/stream/requests.h"
#include "session/scenario.h"

#define SWEEP_NS INT64_C(100000000)
enum { WAIT_MS = 100, WAIT_SHORT_MS = 10 };

static void notify(relay_streams *streams)
{
    pthread_mutex_lock(&streams->lock);
    streams->dirty = true;
    pthread_mutex_unlock(&streams->lock);
    ll_upstreams_wake(streams->upstreams);
}

/* ---- streams that viewers ask for ---- */

static relay_source *new_source(relay_streams *streams, ll_stream_kind kind, const char *id)
{
    relay_source *s = calloc(1, sizeof *s);
    if (s == NULL)
        return NULL;
    s->streams = streams;
    s->kind = kind;
    snprintf(s->id, sizeof s->id, "%s", id);
    s->idle_ns = ll_relay_now();
    s->divisor = 1;
    return s;
}

/* Any id: whether the owner has it is known later. */
static ll_ws_known on_unknown(void *context, ll_stream_kind kind, const char *id)
{
    relay_streams *streams = context;
    bool opened = false;
    pthread_mutex_lock(&streams->lock);
    bool may = streams->started && !atomic_load(&streams->stopping) &&
               streams->sources < streams->config->max_streams;
    relay_source *s = may ? new_source(streams, kind, id) : NULL;
    if (s != NULL) {
        ll_status status = ll_ws_stream_open(streams->ws, kind, id, s, &s->stream);
        opened = status.code == LL_OK || status.code == LL_CONFLICT; /* another viewer came first */
        if (ll_failed(&status)) {
            free(s);
        } else {
            s->next = streams->fresh;
            streams->fresh = s;
            streams->sources++;
            streams->dirty = true;
        }
    }
    pthread_mutex_unlock(&streams->lock);
    if (opened)
        ll_upstreams_wake(streams->upstreams);
    return opened ? LL_WS_OPEN : LL_WS_UNKNOWN;
}

/* ---- viewers ---- */

static void add_viewer(relay_source *s, ll_ws_viewer viewer, ll_frame_format format)
{
    relay_viewer *added = calloc(1, sizeof *added);
    if (added == NULL)
        return; /* without a hello it is closed */
    *added = (relay_viewer){.next = s->watching, .viewer = viewer, .format = format};
    s->watching = added;
    s->waiting++;
}

static void remove_viewer(relay_source *s, ll_ws_viewer viewer)
{
    relay_viewer **link = &s->watching;
    while (*link != NULL && (*link)->viewer != viewer)
        link = &(*link)->next;
    relay_viewer *gone = *link;
    if (gone == NULL)
        return;
    *link = gone->next;
    s->waiting -= !gone->greeted;
    free(gone);
}

static void on_opened(void *context, void *session, ll_ws_viewer viewer, ll_frame_format format)
{
    relay_streams *streams = context;
    relay_source *s = session;
    pthread_mutex_lock(&streams->lock);
    s->viewers++;
    if (s->kind == LL_STREAM_SESSION)
        add_viewer(s, viewer, format);
    pthread_mutex_unlock(&streams->lock);
    if (s->kind == LL_STREAM_SESSION) {
        notify(streams);
        return;
    }
    ll_status status = ll_relay_tunnel_open(s, viewer);
    if (ll_failed(&status))
        ll_ws_close(streams->ws, viewer, LL_WS_TRY_LATER, status.text);
}

static void on_closed(void *context, void *session, ll_ws_viewer viewer)
{
    relay_streams *streams = context;
    relay_source *s = session;
    pthread_mutex_lock(&streams->lock);
    s->viewers--;
    s->idle_ns = ll_relay_now();
    remove_viewer(s, viewer);
    for (relay_tunnel *t = s->tunnels; t != NULL; t = t->next)
        if (t->viewer == viewer)
            t->gone = true;
    pthread_mutex_unlock(&streams->lock); /* the thread sees it when it next looks */
}

static void on_wanted(void *context, void *session)
{
    relay_streams *streams = context;
    relay_source *s = session;
    pthread_mutex_lock(&streams->lock);
    s->wanted = streams->dirty = true;
    pthread_mutex_unlock(&streams->lock);
    ll_upstreams_wake(streams->upstreams);
}

static void on_released(void *context, void *session)
{
    (void)context;
    ll_relay_source_free(session);
}

/* ---- messages ---- */

/* Whether the message has `name` and at most an id as well. */
static bool is_only(const cJSON *json, const char *name)
{
    const cJSON *member;
    if (!cJSON_IsObject(json) || cJSON_GetObjectItemCaseSensitive(json, name) == NULL)
        return false;
    int others = 0;
    cJSON_ArrayForEach(member, json)
    {
        others += strcmp(member->string, name) != 0 && strcmp(member->string, "id") != 0;
    }
    return others == 0;
}

/* Subscriptions and pings are the relay's; all else is for the owner to answer, mistakes too. */
static ll_status take_message(relay_source *s, ll_ws_viewer viewer, const cJSON *json, const char *text,
                              size_t length, char reply_id[LL_REPLY_ID])
{
    relay_streams *streams = s->streams;
    const char *own = is_only(json, "subscribe") ? "subscribe" : is_only(json, "ping") ? "ping" : NULL;
    if (own == NULL)
        return ll_relay_tunnel_send(s, viewer, text, length);
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(json, own);
    LL_TRY(ll_request_id(json, reply_id));
    if (own[0] == 's') {
        ll_ws_subscription subscription;
        LL_TRY(ll_request_rates(value, &subscription));
        ll_ws_subscribe(streams->ws, viewer, &subscription);
        ll_request_send(streams->ws, viewer, ll_request_granted(&subscription, reply_id));
    } else {
        LL_TRY(ll_request_ping(value));
        int64_t wall_ns = ll_relay_now() + atomic_load(&streams->clock_ns);
        ll_request_send(streams->ws, viewer, ll_request_pong(value, wall_ns, reply_id));
    }
    return ll_ok();
}

static void on_message(void *context, void *session, ll_ws_viewer viewer, const char *text, size_t length)
{
    relay_streams *streams = context;
    relay_source *s = session;
    char reply_id[LL_REPLY_ID] = "";
    cJSON *json = NULL;
    ll_status status = ll_ok();
    if (s->kind != LL_STREAM_SESSION) {
        status = ll_relay_tunnel_send(s, viewer, text, length);
    } else {
        status = ll_json_parse(text, length, &json);
        LL_THEN(status, take_message(s, viewer, json, text, length, reply_id));
    }
    if (ll_failed(&status))
        ll_request_refuse(streams->ws, viewer, reply_id, ll_http_problem_status(status.code), &status);
    cJSON_Delete(json);
}

ll_ws_hooks ll_relay_hooks(relay_streams *streams)
{
    return (ll_ws_hooks){.context = streams,
                         .opened = on_opened,
                         .message = on_message,
                         .closed = on_closed,
                         .wanted = on_wanted,
                         .unknown = on_unknown,
                         .released = on_released,
                         .every_kind = true};
}

/* ---- the thread ---- */

static void take_fresh(relay_streams *streams)
{
    pthread_mutex_lock(&streams->lock);
    relay_source *fresh = streams->fresh;
    streams->fresh = NULL;
    pthread_mutex_unlock(&streams->lock);
    while (fresh != NULL) {
        relay_source *s = fresh;
        fresh = s->next;
        s->next = streams->first;
        streams->first = s;
        atomic_fetch_add(&streams->counts.sources, 1);
    }
}

static bool is_idle(relay_source *s, int64_t now)
{
    relay_streams *streams = s->streams;
    double idle_s = (double)(now - s->idle_ns) * 1e-9;
    return s->viewers == 0 && idle_s > streams->config->linger_s;
}

/* Whether the stream is to be closed; from then on no viewer can be added to it. */
static bool ends(relay_source *s, int64_t now)
{
    pthread_mutex_lock(&s->streams->lock);
    s->ended = s->end_code != 0 || is_idle(s, now);
    if (s->ended)
        s->streams->sources--;
    bool ended = s->ended;
    pthread_mutex_unlock(&s->streams->lock);
    return ended;
}

static void end_source(relay_source *s)
{
    ll_relay_source_disconnect(s);
    atomic_fetch_sub(&s->streams->counts.sources, 1);
    /* Who has come just now comes again. */
    if (s->end_code != 0) {
        char reason[sizeof s->end_reason];
        memcpy(reason, s->end_reason, sizeof reason);
        ll_ws_stream_close(s->stream, s->end_code, reason);
    } else {
        ll_ws_stream_close(s->stream, LL_WS_TRY_LATER, "no viewer was left; connect again");
    }
}

static void sweep(relay_streams *streams, int64_t now)
{
    take_fresh(streams);
    for (relay_source **link = &streams->first; *link != NULL;) {
        relay_source *s = *link;
        ll_relay_tunnels_step(s);
        ll_relay_source_step(s, now);
        if (ends(s, now)) {
            *link = s->next;
            end_source(s);
        } else {
            link = &s->next;
        }
    }
}

static void flush(relay_streams *streams)
{
    if (streams->published)
        ll_ws_flush(streams->ws);
    streams->published = false;
}

static bool take_dirty(relay_streams *streams)
{
    pthread_mutex_lock(&streams->lock);
    bool dirty = streams->dirty;
    streams->dirty = false;
    atomic_store_explicit(&streams->counts.tunnels, streams->tunnels, memory_order_relaxed);
    pthread_mutex_unlock(&streams->lock);
    return dirty;
}

static void *run(void *argument)
{
    relay_streams *streams = argument;
    bool soon = false; /* a viewer has come: it may have to wait for some milliseconds */
    pthread_setname_np(pthread_self(), "owner");
    while (!atomic_load(&streams->stopping)) {
        ll_upstreams_serve(streams->upstreams, soon ? WAIT_SHORT_MS : WAIT_MS);
        flush(streams);
        int64_t now = ll_relay_now();
        bool dirty = take_dirty(streams);
        if (dirty || soon || now - streams->swept_ns > SWEEP_NS) {
            streams->swept_ns = now;
            sweep(streams, now);
            flush(streams);
        }
        soon = dirty;
    }
    return NULL;
}

/* ---- start and stop ---- */

ll_status ll_relay_streams_new(const ll_relay_config *config, ll_owner *owner, relay_streams **result)
{
    relay_streams *streams = calloc(1, sizeof *streams);
    if (streams == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: streams");
    streams->config = config;
    streams->owner = owner;
    pthread_mutex_init(&streams->lock, NULL);
    ll_status status = ll_upstreams_new(owner, &streams->upstreams);
    if (ll_failed(&status)) {
        pthread_mutex_destroy(&streams->lock);
        free(streams);
        return status;
    }
    *result = streams;
    return status;
}

ll_status ll_relay_streams_start(relay_streams *streams, ll_ws *ws)
{
    pthread_mutex_lock(&streams->lock);
    streams->ws = ws;
    streams->started = pthread_create(&streams->thread, NULL, run, streams) == 0;
    bool started = streams->started;
    pthread_mutex_unlock(&streams->lock);
    return started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start the thread that reads from the owner");
}

void ll_relay_streams_stop(relay_streams *streams)
{
    if (streams == NULL)
        return;
    atomic_store(&streams->stopping, true);
    atomic_store(&streams->owner->stopping, true);
    ll_upstreams_wake(streams->upstreams);
    pthread_mutex_lock(&streams->lock);
    bool started = streams->started;
    streams->started = false;
    pthread_mutex_unlock(&streams->lock);
    if (started)
        pthread_join(streams->thread, NULL);
    take_fresh(streams);
    for (relay_source *s = streams->first; s != NULL; s = s->next)
        ll_relay_source_disconnect(s);
}

void ll_relay_streams_free(relay_streams *streams)
{
    if (streams == NULL)
        return;
    for (relay_source *s = streams->first, *next; s != NULL; s = next) {
        next = s->next;
        ll_relay_source_free(s); /* its stream was freed with the others, without being released */
    }
    ll_upstreams_free(streams->upstreams);
    ll_row_set_free(&streams->space);
    pthread_mutex_destroy(&streams->lock);
    free(streams);
}
