/* Messages of one viewer to the owner and their answers, over a connection of its own: keys and inputs of a
 * session's viewers, and everything of the streams of classes and experiments. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "daemon/relay/internal.h"
#include "daemon/stream/requests.h"

enum { WAITING_MOST = 256 << 10 /* bytes of one viewer */ };

#define OWN_ID "laglab.relay" /* of messages that the relay itself sends */

static bool passes_all(const relay_tunnel *t)
{
    return t->source->kind != LL_STREAM_SESSION;
}

/* ---- from viewers ---- */

static relay_tunnel *find(const relay_source *s, ll_ws_viewer viewer)
{
    relay_tunnel *t = s->tunnels;
    while (t != NULL && (t->viewer != viewer || t->gone))
        t = t->next;
    return t;
}

/* With the lock held. */
static ll_status find_or_make(relay_source *s, ll_ws_viewer viewer, relay_tunnel **result)
{
    relay_streams *streams = s->streams;
    *result = find(s, viewer);
    if (*result != NULL)
        return ll_ok();
    if (s->ended)
        return ll_error(LL_UNAVAILABLE, "The relay ends this stream; connect again.");
    if (streams->tunnels >= streams->config->max_tunnels)
        return ll_error(LL_LIMIT,
                        "The relay passes messages of at most %d viewers on (max_tunnels); the "
                        "owner is %.100s",
                        (int)streams->config->max_tunnels, streams->owner->url);
    relay_tunnel *t = calloc(1, sizeof *t);
    if (t == NULL)
        return ll_error(LL_NO_MEMORY, "Out of memory.");
    t->source = s;
    t->viewer = viewer;
    t->end = &t->first;
    t->next = s->tunnels;
    s->tunnels = t;
    streams->tunnels++;
    *result = t;
    return ll_ok();
}

static ll_status append(relay_tunnel *t, const char *text, size_t size)
{
    relay_text *one = t->bytes + size <= WAITING_MOST ? malloc(sizeof *one + size) : NULL;
    if (one == NULL)
        return ll_error(LL_LIMIT, "Too many messages wait for the owner, %.100s.",
                        t->source->streams->owner->url);
    one->next = NULL;
    one->size = size;
    memcpy(one->text, text, size);
    *t->end = one;
    t->end = &one->next;
    t->bytes += size;
    return ll_ok();
}

static ll_status open_and_append(relay_source *s, ll_ws_viewer viewer, const char *text, size_t size)
{
    relay_tunnel *t;
    relay_streams *streams = s->streams;
    pthread_mutex_lock(&streams->lock);
    ll_status status = find_or_make(s, viewer, &t);
    if (text != NULL)
        LL_THEN(status, append(t, text, size));
    streams->dirty = true;
    pthread_mutex_unlock(&streams->lock);
    ll_upstreams_wake(streams->upstreams);
    return status;
}

ll_status ll_relay_tunnel_send(relay_source *s, ll_ws_viewer viewer, const char *text, size_t size)
{
    return open_and_append(s, viewer, text, size);
}

ll_status ll_relay_tunnel_open(relay_source *s, ll_ws_viewer viewer)
{
    return open_and_append(s, viewer, NULL, 0);
}

/* ---- to the owner ---- */

static relay_text *take_texts(relay_tunnel *t)
{
    pthread_mutex_t *lock = &t->source->streams->lock;
    pthread_mutex_lock(lock);
    relay_text *first = t->first;
    t->first = NULL;
    t->end = &t->first;
    t->bytes = 0;
    pthread_mutex_unlock(lock);
    return first;
}

static void free_texts(relay_text *text)
{
    while (text != NULL) {
        relay_text *next = text->next;
        free(text);
        text = next;
    }
}

/* Keeps the message of a key, to be sent again on another connection. */
static void note_key(relay_tunnel *t, const relay_text *text)
{
    if (passes_all(t) || memmem(text->text, text->size, "\"auth\"", 6) == NULL)
        return;
    cJSON *json = cJSON_ParseWithLength(text->text, text->size);
    const cJSON *key = cJSON_GetObjectItemCaseSensitive(json, "auth");
    if (cJSON_IsString(key)) {
        cJSON *again = cJSON_CreateObject();
        cJSON_AddStringToObject(again, "auth", key->valuestring);
        cJSON_AddStringToObject(again, "id", OWN_ID);
        free(t->key);
        t->key = cJSON_PrintUnformatted(again);
        cJSON_Delete(again);
    }
    cJSON_Delete(json);
}

static void send_texts(relay_tunnel *t)
{
    relay_text *text = take_texts(t);
    for (const relay_text *one = text; one != NULL && t->upstream != NULL; one = one->next) {
        note_key(t, one);
        ll_upstream_send(t->upstream, one->text, one->size); /* may find that it has ended */
    }
    free_texts(text);
}

/* ---- of the owner ---- */

static void on_opened(void *context)
{
    static const char nothing[] = "{\"subscribe\":{},\"id\":\"" OWN_ID "\"}"; /* no frames */
    relay_tunnel *t = context;
    t->open = true;
    if (!passes_all(t))
        ll_upstream_send(t->upstream, nothing, sizeof nothing - 1);
    if (t->upstream != NULL && t->key != NULL)
        ll_upstream_send(t->upstream, t->key, strlen(t->key));
    send_texts(t);
}

static bool is_type(const cJSON *json, const char *type)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, "type");
    return cJSON_IsString(item) && strcmp(item->valuestring, type) == 0;
}

/* Whether the message answers one of the viewer's. */
static bool is_answer(const cJSON *json)
{
    const cJSON *id = cJSON_GetObjectItemCaseSensitive(json, "id");
    return (is_type(json, "reply") || is_type(json, "error") || is_type(json, "pong")) &&
           !(cJSON_IsString(id) && strcmp(id->valuestring, OWN_ID) == 0);
}

static void on_text(void *context, const char *text, size_t size)
{
    relay_tunnel *t = context;
    ll_ws *ws = t->source->streams->ws;
    cJSON *json = cJSON_ParseWithLength(text, size);
    if (passes_all(t) && is_type(json, "hello"))
        ll_ws_hello(ws, t->viewer, text, size);
    else if (passes_all(t) ? !is_type(json, "bye") : is_answer(json))
        ll_ws_send(ws, t->viewer, text, size);
    cJSON_Delete(json);
}

static void on_binary(void *context, const void *bytes, size_t size)
{
    (void)context, (void)bytes, (void)size;
}

static int close_code(int code)
{
    if (code == 404)
        return LL_WS_NO_SESSION;
    return code == LL_WS_NORMAL || code == LL_WS_GOING_AWAY || code == 1012 || code >= 4000 ? code
                                                                                            : LL_WS_TRY_LATER;
}

static void on_closed(void *context, int code, const char *reason)
{
    relay_tunnel *t = context;
    const relay_streams *streams = t->source->streams;
    t->upstream = NULL;
    t->open = false;
    free_texts(take_texts(t));
    if (passes_all(t)) {
        t->failed = true;
        ll_ws_close(streams->ws, t->viewer, close_code(code), reason);
        return;
    }
    ll_status error =
        ll_error(LL_UNAVAILABLE, "The owner, %.100s, does not answer: %.80s; messages may be lost.",
                 streams->owner->url, reason);
    ll_request_refuse(streams->ws, t->viewer, "", 503, &error);
}

static const ll_upstream_hooks tunnel_hooks = {
    .opened = on_opened, .text = on_text, .binary = on_binary, .closed = on_closed};

/* ---- the thread ---- */

static bool has_texts(relay_tunnel *t)
{
    pthread_mutex_t *lock = &t->source->streams->lock;
    pthread_mutex_lock(lock);
    bool has = t->first != NULL;
    pthread_mutex_unlock(lock);
    return has;
}

static void step(relay_tunnel *t)
{
    static const char *const folders[LL_STREAM_KINDS] = {[LL_STREAM_SESSION] = "sessions",
                                                         [LL_STREAM_EXPERIMENT] = "experiments",
                                                         [LL_STREAM_CLASS] = "classes"};
    char path[120];
    if (t->open) {
        send_texts(t);
    } else if (t->upstream == NULL && !t->failed && (passes_all(t) || has_texts(t))) {
        snprintf(path, sizeof path, "/api/v1/%s/%s/stream", folders[t->source->kind], t->source->id);
        t->upstream = ll_upstream_open(t->source->streams->upstreams, path,
                                       passes_all(t) ? "laglab.v2.json" : "laglab.v2.bin", &tunnel_hooks, t);
        if (t->upstream == NULL)
            on_closed(t, LL_UPSTREAM_CUT, "out of memory");
    }
}

static void free_tunnel(relay_tunnel *t)
{
    ll_upstream_close(t->upstream);
    free_texts(t->first);
    free(t->key);
    free(t);
}

/* Takes those out whose viewers have left, or all. Returns their list. */
static relay_tunnel *take_gone(relay_source *s, bool all)
{
    relay_tunnel *gone = NULL;
    pthread_mutex_lock(&s->streams->lock);
    for (relay_tunnel **link = &s->tunnels; *link != NULL;) {
        relay_tunnel *t = *link;
        if (!t->gone && !all) {
            link = &t->next;
            continue;
        }
        *link = t->next;
        t->next = gone;
        gone = t;
        s->streams->tunnels--;
    }
    pthread_mutex_unlock(&s->streams->lock);
    return gone;
}

static void free_list(relay_tunnel *t)
{
    while (t != NULL) {
        relay_tunnel *next = t->next;
        free_tunnel(t);
        t = next;
    }
}

void ll_relay_tunnels_step(relay_source *s)
{
    free_list(take_gone(s, false));
    pthread_mutex_lock(&s->streams->lock);
    relay_tunnel *first = s->tunnels; /* only this thread takes out; others add before it */
    pthread_mutex_unlock(&s->streams->lock);
    for (relay_tunnel *t = first; t != NULL; t = t->next)
        step(t);
}

void ll_relay_tunnels_free(relay_source *s)
{
    free_list(take_gone(s, true));
}
