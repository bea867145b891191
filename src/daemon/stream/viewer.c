/* One viewer: opening, messages, closing. Runs on its stream's thread. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "daemon/net/problem_json.h"
#include "daemon/stream/internal.h"

#define CLOSE_TIMEOUT_NS INT64_C(3000000000) /* time for a viewer to complete the closing handshake */

/* Without data: sends a ping after PING_NS, drops the viewer after IDLE_TIMEOUT_NS. */
#define PING_NS INT64_C(20000000000)
#define IDLE_TIMEOUT_NS INT64_C(30000000000)

static const ll_ws_hooks *hooks_of(const ws_viewer *viewer)
{
    return &viewer->thread->ws->hooks[viewer->upgrade.kind];
}

void ll_ws_viewer_hello(ws_viewer *viewer, ws_command *hello)
{
    bool first = !viewer->frames.ready && viewer->closing.code == 0 && !viewer->dead;
    ll_ws_viewer_send(viewer, hello);
    if (first && viewer->closing.code == 0) {
        viewer->frames.ready = true;
        viewer->stream->wants_changed = true;
        viewer->frames.hello_ns = viewer->thread->now_ns;
        atomic_fetch_add(&viewer->stream->viewers, 1);
        atomic_fetch_add(&viewer->stream->binary_viewers, viewer->upgrade.format == LL_FRAME_BINARY);
        ll_ws_viewer_send_newest(viewer);
    }
}

void ll_ws_viewer_writable(ws_viewer *viewer)
{
    ll_ws_messages_flush(viewer);
    ll_ws_viewer_send_newest(viewer);
}

/* ---- messages from the viewer ---- */

static const char *skip_space(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

/* Recognises exactly {"ack":N}: a JSON parser would cost too much at 60 per second from every viewer. */
static bool is_ack(const char *text, uint32_t *seq)
{
    text = skip_space(text);
    if (*text != '{')
        return false;
    text = skip_space(text + 1);
    if (strncmp(text, "\"ack\"", 5) != 0)
        return false;
    text = skip_space(text + 5);
    if (*text != ':')
        return false;
    text = skip_space(text + 1);
    uint64_t value = 0;
    int digits = 0;
    while (*text >= '0' && *text <= '9' && digits < 11) {
        value = 10 * value + (uint64_t)(*text++ - '0');
        digits++;
    }
    text = skip_space(text);
    if (digits == 0 || *text != '}' || *skip_space(text + 1) != '\0' || value > UINT32_MAX)
        return false;
    *seq = (uint32_t)value;
    return true;
}

/* Token bucket of messages; large ones cost more. */
static bool within_rate(ws_viewer *viewer, size_t size)
{
    double rate = viewer->thread->ws->config.max_messages_per_s;
    int64_t now = viewer->thread->now_ns;
    viewer->messages.tokens += (double)(now - viewer->messages.tokens_ns) * 1e-9 * rate;
    viewer->messages.tokens = viewer->messages.tokens > 2 * rate ? 2 * rate : viewer->messages.tokens;
    viewer->messages.tokens_ns = now;
    viewer->messages.tokens -= 1 + (double)size / 4096;
    return viewer->messages.tokens >= 0;
}

/* Does not wait for what it still sends. */
static void refuse_message(ws_viewer *viewer, int code, const char *reason)
{
    ll_ws_count(&viewer->thread->counts.closed_policy, 1);
    viewer->closing.hangs_up = true;
    ll_ws_viewer_close(viewer, code, reason);
}

static void refuse_rate(ws_viewer *viewer)
{
    ll_status error = ll_error(LL_LIMIT, "messages: must be at most %g/s (max_messages_per_s)",
                               viewer->thread->ws->config.max_messages_per_s);
    cJSON *json = cJSON_CreateObject();
    cJSON_AddStringToObject(json, "type", "error");
    cJSON_AddItemToObject(json, "problem", ll_http_problem_json(429, &error, NULL));
    ll_ws_viewer_send_json(viewer, json);
    refuse_message(viewer, LL_WS_POLICY, error.text);
}

static void take_message(ws_viewer *viewer, const char *text, size_t size)
{
    uint32_t seq;
    ll_ws_count(&viewer->thread->counts.messages, 1);
    if (!within_rate(viewer, size)) {
        refuse_rate(viewer);
    } else if (is_ack(text, &seq)) {
        ll_ws_viewer_acknowledge(viewer, seq);
    } else if (hooks_of(viewer)->message != NULL) {
        hooks_of(viewer)->message(hooks_of(viewer)->context, viewer->stream->session, viewer->handle, text,
                                  size);
    }
}

void ll_ws_viewer_pong(ws_viewer *viewer)
{
    if (viewer->stream == NULL || viewer->closing.code != 0)
        return;
    viewer->flow.answered = true;
    if (!within_rate(viewer, 0)) {
        refuse_rate(viewer);
    } else if (viewer->measured_ns != 0) {
        int64_t round_trip = viewer->received_ns - viewer->measured_ns;
        viewer->measured_ns = 0;
        if (hooks_of(viewer)->pong != NULL) {
            hooks_of(viewer)->pong(hooks_of(viewer)->context, viewer->stream->session, viewer->handle,
                                   round_trip);
        }
    }
}

static bool keep_piece(ws_viewer *viewer, const char *bytes, size_t more)
{
    size_t size = viewer->messages.received_size + more;
    if (size + 1 > viewer->messages.received_capacity) {
        size_t capacity = size < 256 ? 256 : 2 * size;
        char *grown = realloc(viewer->messages.received, capacity);
        if (grown == NULL)
            return false;
        viewer->messages.received = grown;
        viewer->messages.received_capacity = capacity;
    }
    LL_ASSERT(size < viewer->messages.received_capacity); /* and a terminator */
    if (more > 0)
        memcpy(viewer->messages.received + viewer->messages.received_size, bytes, more);
    viewer->messages.received_size = size;
    return true;
}

void ll_ws_viewer_receive(ws_viewer *viewer, const char *bytes, size_t size)
{
    size_t limit = (size_t)viewer->thread->ws->config.max_message_bytes;
    bool last = lws_is_final_fragment(viewer->wsi) != 0,
         ends_frame = lws_remaining_packet_payload(viewer->wsi) == 0;
    char text[100];
    if (viewer->stream == NULL || viewer->closing.code != 0 || viewer->dead)
        return; /* it is closing: ignore its messages */
    if (lws_is_first_fragment(viewer->wsi) != 0)
        viewer->messages.received_size = 0;
    if (lws_frame_is_binary(viewer->wsi) != 0) {
        refuse_message(viewer, LL_WS_UNSUPPORTED, "messages: must be text");
    } else if (viewer->messages.received_size + size > limit) {
        snprintf(text, sizeof text, "message: must have at most %zu bytes (max_message_bytes)", limit);
        refuse_message(viewer, LL_WS_TOO_BIG, text);
    } else if (ends_frame && !last && !within_rate(viewer, 0)) {
        refuse_rate(viewer); /* empty fragments cost as much as messages */
    } else if (!keep_piece(viewer, bytes, size)) {
        ll_ws_viewer_close(viewer, 1011, "out of memory: message");
    } else if (last) {
        viewer->messages.received[viewer->messages.received_size] = '\0';
        take_message(viewer, viewer->messages.received, viewer->messages.received_size);
        viewer->messages.received_size = 0;
    }
}

/* ---- opening and closing ---- */

ws_viewer *ll_ws_viewer_of(ws_thread *thread, ll_ws_viewer handle)
{
    int slot = (int)(handle & 0xffff);
    ws_viewer *viewer = slot < thread->slots ? thread->slot[slot] : NULL;
    return viewer != NULL && viewer->handle == handle ? viewer : NULL;
}

static bool give_handle(ws_thread *thread, ws_viewer *viewer)
{
    int slot = 0;
    while (slot < thread->slots && thread->slot[slot] != NULL)
        slot++;
    if (slot == thread->slots) {
        int slots = thread->slots > 0 ? 2 * thread->slots : 64;
        ws_viewer **grown = slots <= 65536 ? realloc(thread->slot, (size_t)slots * sizeof *grown) : NULL;
        if (grown == NULL)
            return false;
        memset(grown + thread->slots, 0, (size_t)(slots - thread->slots) * sizeof *grown);
        thread->slot = grown;
        thread->slots = slots;
    }
    thread->slot[slot] = viewer;
    viewer->handle = ++thread->serial << 24 | (uint64_t)thread->index << 16 | (uint64_t)slot;
    return true;
}

void ll_ws_stream_release_if_done(ll_ws_stream *stream)
{
    if (stream->closing && stream->first == NULL)
        ll_ws_stream_destroy(stream);
}

static void leave_stream(ws_viewer *viewer)
{
    ll_ws_stream *stream = viewer->stream;
    ll_ws_messages_drop(viewer);
    free(viewer->messages.received);
    viewer->messages.received = NULL;
    viewer->messages.received_capacity = 0;
    if (stream == NULL)
        return;
    ll_ws_viewer_release_sections(viewer);
    if (viewer->frames.ready) {
        atomic_fetch_sub(&stream->viewers, 1);
        atomic_fetch_sub(&stream->binary_viewers, viewer->upgrade.format == LL_FRAME_BINARY);
    }
    if (viewer->next != NULL)
        viewer->next->previous = viewer->previous;
    *(viewer->previous != NULL ? &viewer->previous->next : &stream->first) = viewer->next;
    viewer->stream = NULL;
    stream->viewer_count--;
    LL_ASSERT((stream->viewer_count == 0) == (stream->first == NULL));
    atomic_fetch_sub_explicit(&viewer->thread->counts.viewers, 1, memory_order_relaxed);
    if (hooks_of(viewer)->closed != NULL)
        hooks_of(viewer)->closed(hooks_of(viewer)->context, stream->session, viewer->handle);
    ll_ws_stream_release_if_done(stream);
}

ws_viewer *ll_ws_viewer_new(ws_thread *thread, const ws_command *adopt)
{
    ws_viewer *viewer = calloc(1, sizeof *viewer);
    if (viewer == NULL || !give_handle(thread, viewer)) {
        free(viewer);
        return NULL;
    }
    viewer->thread = thread;
    viewer->pass = adopt->pass;
    viewer->upgrade = adopt->upgrade;
    viewer->received_ns = viewer->pinged_ns = thread->now_ns;
    thread->sockets++;
    return viewer;
}

void ll_ws_viewer_free(ws_viewer *viewer)
{
    ws_thread *thread = viewer->thread;
    leave_stream(viewer);
    thread->slot[viewer->handle & 0xffff] = NULL;
    ll_connection_limiter_leave(thread->ws->connection_limiter, &viewer->pass);
    thread->sockets--;
    free(viewer);
}

void ll_ws_viewer_open(ws_viewer *viewer)
{
    ws_thread *thread = viewer->thread;
    ll_ws *ws = thread->ws;
    /* It may have been closed since the upgrade was accepted. */
    ll_ws_stream *stream = ll_ws_find_stream(ws, viewer->upgrade.kind, viewer->upgrade.id);
    viewer->opened_ns = viewer->messages.tokens_ns = thread->now_ns;
    viewer->messages.tokens = 2 * ws->config.max_messages_per_s;
    char text[100];
    if (stream == NULL) {
        snprintf(text, sizeof text, "the %s was deleted", ll_stream_names[viewer->upgrade.kind]);
        ll_ws_viewer_close(viewer, LL_WS_NO_SESSION, text);
        return;
    }
    if (stream->viewer_count >= ws->config.max_viewers) {
        snprintf(text, sizeof text, "limit of %d viewers of one stream reached (max_viewers)",
                 (int)ws->config.max_viewers);
        ll_ws_count(&thread->counts.closed_policy, 1);
        ll_ws_viewer_close(viewer, LL_WS_TOO_MANY, text);
        return;
    }
    viewer->stream = stream;
    viewer->frames.fresh = true;
    viewer->next = stream->first;
    if (stream->first != NULL)
        stream->first->previous = viewer;
    stream->first = viewer;
    stream->viewer_count++;
    ll_ws_count(&thread->counts.opened, 1);
    ll_ws_count(&thread->counts.viewers, 1);
    hooks_of(viewer)->opened(hooks_of(viewer)->context, stream->session, viewer->handle,
                             viewer->upgrade.format);
}

void ll_ws_viewer_ends(ws_viewer *viewer, int code)
{
    if (viewer->closing.code == 0) {
        viewer->closing.code = code;
        viewer->closing.since_ns = viewer->thread->now_ns;
    }
    leave_stream(viewer);
}

static void check_alive(ws_viewer *viewer)
{
    int64_t now = viewer->thread->now_ns, silent = now - viewer->received_ns;
    if (silent > IDLE_TIMEOUT_NS)
        ll_ws_socket_cut(viewer);
    else if (silent > PING_NS && now - viewer->pinged_ns > PING_NS && !ll_ws_socket_full(viewer))
        ll_ws_socket_ping(viewer);
}

/* Since the oldest frame in flight was sent or, later, the last acknowledgement: who acknowledges one after
 * the other over a slow line is only slow. */
static double unacknowledged_s(const ws_viewer *viewer)
{
    const ws_viewer_flow *flow = &viewer->flow;
    if (flow->acked_ns == 0 || flow->outstanding_count == 0)
        return 0;
    int64_t sent_ns = flow->outstanding[0].sent_ns;
    return (double)(viewer->thread->now_ns - (sent_ns > flow->acked_ns ? sent_ns : flow->acked_ns)) * 1e-9;
}

void ll_ws_viewer_sweep(ws_viewer *viewer)
{
    const ll_web_server_config *config = &viewer->thread->ws->config;
    int64_t now = viewer->thread->now_ns;
    if (viewer->dead)
        return;
    if (viewer->closing.code != 0) {
        if (now - viewer->closing.since_ns > CLOSE_TIMEOUT_NS)
            ll_ws_socket_cut(viewer);
        return;
    }
    check_alive(viewer);
    if (viewer->stream == NULL || viewer->dead)
        return;
    if (!viewer->frames.ready && (double)(now - viewer->opened_ns) > config->hello_timeout_s * 1e9) {
        ll_ws_viewer_close(viewer, LL_WS_TRY_LATER, "session busy; try again later");
    } else if (unacknowledged_s(viewer) > config->ack_timeout_s) {
        ll_ws_count(&viewer->thread->counts.closed_slow, 1);
        ll_ws_viewer_close(viewer, LL_WS_TRY_LATER, "no acknowledgement for too long (ack_timeout_s)");
    } else {
        ll_ws_viewer_sweep_frames(viewer);
    }
}
