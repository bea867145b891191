/* Streams by kind and id, from opening until the last viewer has left. */
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "base/hash.h"
#include "daemon/stream/internal.h"

static uint64_t hash_of(const char *id)
{
    return ll_hash(0, id, strlen(id));
}

ws_thread *ll_ws_thread_of(ll_ws *ws, const char *id)
{
    return &ws->thread[hash_of(id) / WS_BUCKETS % (uint64_t)ws->threads];
}

static bool is_stream(const ll_ws_stream *stream, ll_stream_kind kind, const char *id)
{
    return stream->kind == kind && strcmp(stream->id, id) == 0;
}

ll_ws_stream *ll_ws_find_stream(ll_ws *ws, ll_stream_kind kind, const char *id)
{
    pthread_mutex_lock(&ws->registry_lock);
    ll_ws_stream *stream = ws->bucket[hash_of(id) % WS_BUCKETS];
    while (stream != NULL && !is_stream(stream, kind, id))
        stream = stream->next_in_bucket;
    pthread_mutex_unlock(&ws->registry_lock);
    return stream;
}

bool ll_ws_knows(ll_ws *ws, const ll_upgrade *upgrade)
{
    return ll_ws_find_stream(ws, upgrade->kind, upgrade->id) != NULL;
}

static bool is_stream_id(const char *id)
{
    size_t length = strlen(id);
    return length >= 1 && length <= 64 &&
           strspn(id, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") == length;
}

void ll_ws_set_hooks(ll_ws *ws, ll_stream_kind kind, const ll_ws_hooks *hooks)
{
    ws->hooks[kind] = *hooks;
}

ll_status ll_ws_stream_open(ll_ws *ws, ll_stream_kind kind, const char *id, void *session,
                            ll_ws_stream **result)
{
    if (!is_stream_id(id))
        return ll_field_error(LL_BAD_INPUT, "id", "id: must have 1 to 64 characters of A-Z a-z 0-9 _ -");
    ll_ws_stream *stream = calloc(1, sizeof *stream);
    if (stream == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: stream");
    uint64_t hash = hash_of(id);
    stream->ws = ws;
    stream->thread = ll_ws_thread_of(ws, id);
    stream->session = session;
    stream->kind = kind;
    memcpy(stream->id, id, strlen(id));
    pthread_mutex_lock(&ws->registry_lock);
    ll_ws_stream **bucket = &ws->bucket[hash % WS_BUCKETS], *other = *bucket;
    while (other != NULL && !is_stream(other, kind, id))
        other = other->next_in_bucket;
    if (other == NULL) {
        stream->next_in_bucket = *bucket;
        *bucket = stream;
    }
    pthread_mutex_unlock(&ws->registry_lock);
    if (other != NULL) {
        free(stream);
        return ll_error(LL_CONFLICT, "id has a stream already");
    }
    atomic_fetch_add(&ws->stream_count, 1);
    *result = stream;
    return ll_ok();
}

static void unregister(ll_ws_stream *stream)
{
    ll_ws *ws = stream->ws;
    pthread_mutex_lock(&ws->registry_lock);
    ll_ws_stream **at = &ws->bucket[hash_of(stream->id) % WS_BUCKETS];
    while (*at != NULL && *at != stream)
        at = &(*at)->next_in_bucket;
    LL_ASSERT(*at == stream);
    *at = stream->next_in_bucket;
    pthread_mutex_unlock(&ws->registry_lock);
    atomic_fetch_sub(&ws->stream_count, 1);
}

void ll_ws_stream_free(ll_ws_stream *stream)
{
    for (int i = 0; i < stream->pending_count; i++)
        ll_frame_release(stream->pending[i]);
    ll_frame_release(stream->latest);
    free(stream);
}

void ll_ws_stream_destroy(ll_ws_stream *stream)
{
    const ll_ws_hooks *hooks = &stream->ws->hooks[stream->kind];
    void *session = stream->session;
    ll_ws_stream_free(stream);
    if (hooks->released != NULL)
        hooks->released(hooks->context, session);
}

void ll_ws_stream_close(ll_ws_stream *stream, int code, const char *reason)
{
    unregister(stream);
    ws_command *command = ll_ws_command_new(WS_COMMAND_CLOSE_STREAM, reason, strlen(reason));
    if (command != NULL) {
        command->stream = stream;
        command->code = code;
    }
    /* If the command cannot be allocated, the stream leaks: its viewers stay connected and get nothing
     * more. */
    if (command != NULL && !ll_ws_submit(stream->thread, command)) {
        free(command);
        ll_ws_stream_destroy(stream);
    }
}
