/* Functions of the streams for any thread: publications, messages to viewers, start and stop. */
#include "daemon/stream/ws.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/assert.h"
#include "daemon/stream/internal.h"

static void post_text(ll_ws *ws, ll_ws_viewer viewer, ws_command_kind kind, int code, const char *text,
                      size_t size)
{
    int index = (int)(viewer >> 16 & 0xff);
    ws_command *command = viewer != 0 && index < ws->threads ? ll_ws_command_new(kind, text, size) : NULL;
    if (command == NULL)
        return;
    command->viewer = viewer;
    command->code = code;
    if (!ll_ws_submit(&ws->thread[index], command))
        free(command);
}

void ll_ws_hello(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length)
{
    post_text(ws, viewer, WS_COMMAND_HELLO, 0, text, length);
}

void ll_ws_subscribe(ll_ws *ws, ll_ws_viewer viewer, const ll_ws_subscription *subscription)
{
    int index = (int)(viewer >> 16 & 0xff);
    ws_command *command =
        viewer != 0 && index < ws->threads ? ll_ws_command_new(WS_COMMAND_SUBSCRIBE, NULL, 0) : NULL;
    if (command == NULL)
        return;
    command->viewer = viewer;
    command->subscription = *subscription;
    if (!ll_ws_submit(&ws->thread[index], command))
        free(command);
}

void ll_ws_send(ll_ws *ws, ll_ws_viewer viewer, const char *text, size_t length)
{
    post_text(ws, viewer, WS_COMMAND_SEND, 0, text, length);
}

void ll_ws_ping(ll_ws *ws, ll_ws_viewer viewer)
{
    post_text(ws, viewer, WS_COMMAND_PING, 0, NULL, 0);
}

void ll_ws_close(ll_ws *ws, ll_ws_viewer viewer, int code, const char *reason)
{
    post_text(ws, viewer, WS_COMMAND_CLOSE, code, reason, strlen(reason));
}

int ll_ws_viewers(const ll_ws_stream *stream)
{
    return atomic_load_explicit(&stream->viewers, memory_order_relaxed);
}

/* ---- frames ---- */

static bool any_is_due(unsigned long long every, uint32_t seq)
{
    for (uint32_t n = 1; n <= LL_FRAME_HZ; n++)
        if (every >> n & 1 && seq % n == 0)
            return true;
    return false;
}

void ll_ws_wants(ll_ws_stream *stream, uint32_t seq, uint32_t generation, bool whole,
                 ll_record_request *request)
{
    if (atomic_load_explicit(&stream->asked, memory_order_acquire)) /* before the wants are read */
        atomic_exchange_explicit(&stream->asked, false, memory_order_acq_rel);
    bool jump = !atomic_load_explicit(&stream->published, memory_order_relaxed) ||
                atomic_load_explicit(&stream->generation, memory_order_relaxed) != generation;
    unsigned channels = atomic_load_explicit(&stream->missing, memory_order_relaxed);
    for (int c = 0; c < LL_CHANNELS; c++) {
        unsigned long long every = atomic_load_explicit(&stream->every[c], memory_order_relaxed);
        if (every != 0 && (whole || jump || any_is_due(every, seq)))
            channels |= 1U << c;
    }
    request->channels = (uint16_t)channels;
    request->anew = jump || atomic_load_explicit(&stream->anew, memory_order_relaxed);
    request->from_event =
        jump ? LL_NO_EVENT : atomic_load_explicit(&stream->from_event, memory_order_relaxed);
    request->viewers = (uint32_t)ll_ws_viewers(stream);
    request->deltas = atomic_load_explicit(&stream->binary_viewers, memory_order_relaxed) > 0;
}

void ll_ws_publish(ll_ws_stream *stream, ll_frame *frame)
{
    ws_thread *thread = stream->thread;
    ll_frame *late = frame;
    ll_frame_retain(frame);
    pthread_mutex_lock(&thread->lock);
    if (!thread->stopped) {
        late = NULL;
        if (stream->pending_count == 0) {
            stream->next_dirty = thread->dirty;
            thread->dirty = stream;
        }
        if (stream->pending_count == WS_PENDING) {
            late = stream->pending[0];
            memmove(stream->pending, stream->pending + 1, (WS_PENDING - 1) * sizeof(ll_frame *));
            stream->pending_count--;
        }
        stream->pending[stream->pending_count++] = frame;
    }
    pthread_mutex_unlock(&thread->lock);
    if (!atomic_load_explicit(&stream->published, memory_order_relaxed) ||
        atomic_load_explicit(&stream->generation, memory_order_relaxed) != frame->generation) {
        atomic_store_explicit(&stream->generation, frame->generation, memory_order_relaxed);
        atomic_store_explicit(&stream->published, true, memory_order_relaxed);
    }
    if (late != NULL) {
        ll_ws_count(&thread->counts.dropped, 1);
        ll_frame_release(late);
    }
}

void ll_ws_flush(ll_ws *ws)
{
    for (int i = 0; i < ws->threads; i++) {
        ws_thread *thread = &ws->thread[i];
        pthread_mutex_lock(&thread->lock);
        bool dirty = thread->dirty != NULL && !thread->stopped;
        pthread_mutex_unlock(&thread->lock);
        if (dirty)
            ll_ws_wake(thread);
    }
}

/* ---- for the web server ---- */

void ll_ws_adopt(ll_ws *ws, const ll_upgrade *upgrade, int fd, const ll_connection_limiter_pass *pass)
{
    ws_command *command = ll_ws_command_new(WS_COMMAND_ADOPT, NULL, 0);
    if (command != NULL) {
        command->fd = fd;
        command->pass = *pass;
        command->upgrade = *upgrade;
        if (ll_ws_submit(ll_ws_thread_of(ws, upgrade->id), command))
            return;
    }
    free(command);
    close(fd);
    ll_connection_limiter_leave(ws->connection_limiter, pass);
}

ll_ws_stats ll_ws_get_stats(ll_ws *ws)
{
    ll_ws_stats stats = {.streams = (uint64_t)atomic_load(&ws->stream_count)};
    for (int i = 0; i < ws->threads; i++) {
        ws_counts *counts = &ws->thread[i].counts;
        stats.viewers += atomic_load(&counts->viewers);
        stats.opened += atomic_load(&counts->opened);
        stats.frames += atomic_load(&counts->frames);
        stats.bytes += atomic_load(&counts->bytes);
        stats.skipped += atomic_load(&counts->skipped);
        stats.messages += atomic_load(&counts->messages);
        stats.closed_slow += atomic_load(&counts->closed_slow);
        stats.closed_policy += atomic_load(&counts->closed_policy);
        stats.dropped += atomic_load(&counts->dropped);
    }
    return stats;
}

static ll_status start_thread(ws_thread *thread)
{
    if (!ll_ws_thread_prepare(thread))
        return ll_error(LL_IO, "cannot start stream thread: %s", strerror(errno));
    thread->context = ll_ws_context_new(thread);
    if (thread->context == NULL) {
        return ll_error(LL_IO,
                        "cannot start stream thread: libwebsockets finds no plug-in for libev; it is in "
                        "Debian's package libwebsockets-evlib-ev");
    }
    thread->started = pthread_create(&thread->handle, NULL, ll_ws_thread_main, thread) == 0;
    return thread->started ? ll_ok() : ll_error(LL_IO, "cannot start stream thread");
}

ll_status ll_ws_start(const ll_web_server_config *config, ll_connection_limiter *connection_limiter,
                      ll_ws **result)
{
    int threads = (int)config->stream_threads;
    ll_ws *ws = calloc(1, sizeof *ws + (size_t)threads * sizeof(ws_thread));
    if (ws == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: streams");
    ws->config = *config;
    ws->connection_limiter = connection_limiter;
    ws->threads = threads;
    pthread_mutex_init(&ws->registry_lock, NULL);
    for (int i = 0; i < threads; i++) {
        ws->thread[i] = (ws_thread){.ws = ws, .index = i, .event_fd = -1};
        pthread_mutex_init(&ws->thread[i].lock, NULL);
    }
    for (int i = 0; i < threads; i++) {
        ll_status error = start_thread(&ws->thread[i]);
        if (ll_failed(&error)) {
            ll_ws_drain(ws, 0);
            ll_ws_free(ws);
            return error;
        }
    }
    *result = ws;
    return ll_ok();
}

void ll_ws_drain(ll_ws *ws, double seconds)
{
    if (ws->drained)
        return;
    ws->drained = true;
    ws->config.drain_s = seconds;
    for (int i = 0; i < ws->threads; i++) {
        atomic_store(&ws->thread[i].drain, true);
        ll_ws_wake(&ws->thread[i]);
    }
    for (int i = 0; i < ws->threads; i++) {
        ws_thread *thread = &ws->thread[i];
        if (thread->started)
            pthread_join(thread->handle, NULL);
    }
}

void ll_ws_free(ll_ws *ws)
{
    LL_ASSERT(ws->drained);
    for (int b = 0; b < WS_BUCKETS; b++) {
        for (ll_ws_stream *stream = ws->bucket[b], *next; stream != NULL; stream = next) {
            next = stream->next_in_bucket;
            ll_ws_stream_free(stream);
        }
    }
    for (int i = 0; i < ws->threads; i++) {
        ws_thread *thread = &ws->thread[i];
        if (thread->context != NULL) /* it was not started */
            lws_context_destroy(thread->context);
        if (thread->loop != NULL)
            ev_loop_destroy(thread->loop);
        if (thread->event_fd >= 0)
            close(thread->event_fd);
        free(thread->message.bytes);
        pthread_mutex_destroy(&thread->lock);
    }
    pthread_mutex_destroy(&ws->registry_lock);
    free(ws);
}
