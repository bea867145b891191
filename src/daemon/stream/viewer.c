/* One viewer: its coming and going, its messages, its goodbye. Everything here runs on its stream's
 * thread. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "daemon/stream/internal.h"

#define GOODBYE_NS INT64_C(3000000000) /* how long a viewer may take to let itself be closed */

/* Of silence: after PING_NS it is asked whether it is there, after HANG_UP_NS it is not. */
#define PING_NS INT64_C(20000000000)
#define HANG_UP_NS INT64_C(30000000000)

static const ll_ws_hooks *hooks_of(const ws_viewer *viewer)
{
    return &viewer->thread->ws->hooks[viewer->upgrade.kind];
}

/* ---- messages to the viewer ---- */

static void drop_messages(ws_viewer *viewer)
{
    while (viewer->first_message != NULL) {
        ws_mail *message = viewer->first_message;
        viewer->first_message = message->next;
        free(message);
    }
    viewer->last_message = NULL;
    viewer->message_count = 0;
    viewer->message_bytes = 0;
}

static void flush_messages(ws_viewer *viewer)
{
    while (viewer->first_message != NULL && !viewer->dead && !ll_ws_socket_full(viewer)) {
        ws_mail *message = viewer->first_message;
        ll_ws_socket_write(viewer, message->text, message->size, LL_OPCODE_TEXT);
        viewer->first_message = message->next;
        viewer->last_message = message->next != NULL ? viewer->last_message : NULL;
        viewer->message_count--;
        viewer->message_bytes -= message->size;
        free(message);
    }
}

static void enqueue(ws_viewer *viewer, ws_mail *message)
{
    message->next = NULL;
    if (viewer->last_message != NULL) {
        viewer->last_message->next = message;
    } else {
        viewer->first_message = message;
    }
    viewer->last_message = message;
    viewer->message_count++;
    viewer->message_bytes += message->size;
}

static ws_mail *message_of(cJSON *json) /* takes it */
{
    char *text = json != NULL ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    size_t size = text != NULL ? strlen(text) : 0;
    ws_mail *message = text != NULL ? calloc(1, sizeof *message + size + 1) : NULL;
    if (message != NULL) {
        memcpy(message->text, text, size);
        message->size = size;
    }
    cJSON_free(text);
    return message;
}

void ll_ws_viewer_close(ws_viewer *viewer, int code, const char *reason)
{
    if (viewer->close_code != 0 || viewer->dead) {
        return;
    }
    viewer->close_code = code;
    snprintf(viewer->close_reason, sizeof viewer->close_reason, "%s", reason);
    cJSON *bye = cJSON_CreateObject();
    cJSON_AddStringToObject(bye, "type", "bye");
    cJSON_AddStringToObject(bye, "reason", viewer->close_reason);
    ws_mail *message = message_of(bye);
    if (message != NULL) {
        enqueue(viewer, message);
    }
    /* The close frame leaves when the messages have. One that does not read is cut (ll_ws_viewer_sweep). */
    viewer->close_ns = viewer->thread->now_ns;
    ll_ws_socket_want(viewer);
}

void ll_ws_viewer_send(ws_viewer *viewer, ws_mail *message)
{
    if (viewer->close_code != 0 || viewer->dead) {
        free(message);
        return;
    }
    if (viewer->message_count >= WS_MAX_MESSAGES ||
        viewer->message_bytes + message->size > WS_MAX_MESSAGE_BYTES) {
        free(message);
        drop_messages(viewer);
        ll_ws_count(&viewer->thread->counts.closed_slow, 1);
        ll_ws_viewer_close(viewer, LL_WS_TRY_LATER, "messages piled up: this viewer reads too slowly");
        return;
    }
    enqueue(viewer, message);
    flush_messages(viewer);
}

void ll_ws_viewer_say(ws_viewer *viewer, cJSON *json)
{
    ws_mail *message = message_of(json);
    if (message != NULL) {
        ll_ws_viewer_send(viewer, message);
    }
}

void ll_ws_viewer_hello(ws_viewer *viewer, ws_mail *hello)
{
    bool first = !viewer->ready && viewer->close_code == 0 && !viewer->dead;
    ll_ws_viewer_send(viewer, hello);
    if (first && viewer->close_code == 0) {
        viewer->ready = true;
        viewer->greeted_ns = viewer->thread->now_ns;
        atomic_fetch_add(&viewer->stream->viewers, 1);
        ll_ws_viewer_try(viewer);
    }
}

void ll_ws_viewer_writable(ws_viewer *viewer)
{
    flush_messages(viewer);
    if (viewer->first_message != NULL || ll_ws_socket_full(viewer) || viewer->dead || viewer->said) {
        return;
    }
    if (viewer->close_code != 0) {
        ll_ws_socket_say_close(viewer, viewer->close_code, viewer->close_reason);
        return;
    }
    if (viewer->pong_wanted) {
        unsigned char bytes[LL_FRAMING_ROOM + LL_FRAMING_CONTROL];
        memcpy(bytes + LL_FRAMING_ROOM, viewer->pong, (size_t)viewer->pong_size);
        viewer->pong_wanted = false;
        ll_ws_socket_write(viewer, bytes + LL_FRAMING_ROOM, (size_t)viewer->pong_size, LL_OPCODE_PONG);
    }
    ll_ws_viewer_try(viewer);
}

/* ---- messages from the viewer ---- */

static const char *skip_space(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

/* Exactly {"ack":N}: what arrives sixty times a second from every viewer is not worth a JSON parser. */
static bool is_ack(const char *text, uint32_t *seq)
{
    text = skip_space(text);
    if (*text != '{') {
        return false;
    }
    text = skip_space(text + 1);
    if (strncmp(text, "\"ack\"", 5) != 0) {
        return false;
    }
    text = skip_space(text + 5);
    if (*text != ':') {
        return false;
    }
    text = skip_space(text + 1);
    uint64_t value = 0;
    int digits = 0;
    while (*text >= '0' && *text <= '9' && digits < 11) {
        value = 10 * value + (uint64_t)(*text++ - '0');
        digits++;
    }
    text = skip_space(text);
    if (digits == 0 || *text != '}' || *skip_space(text + 1) != '\0' || value > UINT32_MAX) {
        return false;
    }
    *seq = (uint32_t)value;
    return true;
}

/* A token bucket of messages; big ones cost more. */
static bool within_rate(ws_viewer *viewer, size_t size)
{
    double rate = viewer->thread->ws->config.max_messages_per_s;
    int64_t now = viewer->thread->now_ns;
    viewer->tokens += (double)(now - viewer->tokens_ns) * 1e-9 * rate;
    viewer->tokens = viewer->tokens > 2 * rate ? 2 * rate : viewer->tokens;
    viewer->tokens_ns = now;
    viewer->tokens -= 1 + (double)size / 4096;
    return viewer->tokens >= 0;
}

/* What it still sends is not waited for. */
static void refuse_message(ws_viewer *viewer, int code, const char *reason)
{
    ll_ws_count(&viewer->thread->counts.closed_policy, 1);
    viewer->deaf = true;
    ll_ws_viewer_close(viewer, code, reason);
}

static void refuse_rate(ws_viewer *viewer)
{
    char text[120];
    snprintf(text, sizeof text, "more than %g messages a second (max_messages_per_s)",
             viewer->thread->ws->config.max_messages_per_s);
    cJSON *error = cJSON_CreateObject(), *problem = cJSON_AddObjectToObject(error, "problem");
    cJSON_AddStringToObject(error, "type", "error");
    cJSON_AddStringToObject(problem, "type", "about:blank");
    cJSON_AddStringToObject(problem, "title", "Too Many Requests");
    cJSON_AddNumberToObject(problem, "status", 429);
    cJSON_AddStringToObject(problem, "detail", text);
    ll_ws_viewer_say(viewer, error);
    refuse_message(viewer, LL_WS_POLICY, text);
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
    if (viewer->stream != NULL && viewer->close_code == 0 && !within_rate(viewer, 0)) {
        refuse_rate(viewer);
    }
}

/* RFC 6455 5.5.3: of several pings only the last needs an answer. So those that pile up while the socket is
 * full cost no memory. */
void ll_ws_viewer_ping(ws_viewer *viewer)
{
    ll_ws_viewer_pong(viewer);
    if (viewer->close_code == 0) {
        viewer->pong_wanted = true;
        ll_ws_viewer_writable(viewer);
    }
}

static bool keep_piece(ws_viewer *viewer, const ll_framing *piece)
{
    size_t size = viewer->received_size + piece->size;
    if (size + 1 > viewer->received_capacity) {
        size_t capacity = size < 256 ? 256 : 2 * size;
        char *grown = realloc(viewer->received, capacity);
        if (grown == NULL) {
            return false;
        }
        viewer->received = grown;
        viewer->received_capacity = capacity;
    }
    memcpy(viewer->received + viewer->received_size, piece->bytes, piece->size);
    viewer->received_size = size;
    return true;
}

void ll_ws_viewer_receive(ws_viewer *viewer, const ll_framing *piece)
{
    size_t limit = (size_t)viewer->thread->ws->config.max_message_bytes;
    char text[100];
    if (viewer->stream == NULL || viewer->close_code != 0) {
        return; /* it is on its way out: what it says is not heard */
    }
    if (piece->first) {
        viewer->received_size = 0;
    }
    if (piece->binary) {
        refuse_message(viewer, LL_WS_UNSUPPORTED, "messages are text");
    } else if (viewer->received_size + piece->size > limit) {
        snprintf(text, sizeof text, "a message may have %zu bytes (max_message_bytes)", limit);
        refuse_message(viewer, LL_WS_TOO_BIG, text);
    } else if (!piece->last && !within_rate(viewer, piece->size)) {
        refuse_rate(viewer); /* pieces of nothing cost as much as messages */
    } else if (!keep_piece(viewer, piece)) {
        ll_ws_viewer_close(viewer, 1011, "no memory for a message");
    } else if (piece->last) {
        viewer->received[viewer->received_size] = '\0';
        take_message(viewer, viewer->received, viewer->received_size);
        viewer->received_size = 0;
    }
}

/* ---- coming and going ---- */

void ll_ws_viewer_open(ws_viewer *viewer)
{
    ws_thread *thread = viewer->thread;
    ll_ws *ws = thread->ws;
    ll_ws_stream *stream = ll_ws_find_stream(ws, viewer->upgrade.kind, viewer->upgrade.id);
    viewer->opened_ns = viewer->tokens_ns = thread->now_ns;
    viewer->tokens = 2 * ws->config.max_messages_per_s;
    if (stream == NULL) {
        ll_ws_viewer_close(viewer, LL_WS_NO_SESSION, "it was deleted");
        return;
    }
    if (stream->arrived >= ws->config.max_viewers) {
        char text[100];
        snprintf(text, sizeof text, "this stream has %d viewers already (max_viewers)",
                 (int)ws->config.max_viewers);
        ll_ws_count(&thread->counts.closed_policy, 1);
        ll_ws_viewer_close(viewer, LL_WS_TOO_MANY, text);
        return;
    }
    viewer->stream = stream;
    viewer->fresh = true;
    viewer->next = stream->first;
    if (stream->first != NULL) {
        stream->first->previous = viewer;
    }
    stream->first = viewer;
    stream->arrived++;
    ll_ws_count(&thread->counts.opened, 1);
    ll_ws_count(&thread->counts.viewers, 1);
    hooks_of(viewer)->opened(hooks_of(viewer)->context, stream->session, viewer->handle,
                             viewer->upgrade.format);
}

void ll_ws_stream_release_if_done(ll_ws_stream *stream)
{
    if (stream->closing && stream->first == NULL) {
        ll_ws_stream_destroy(stream);
    }
}

void ll_ws_viewer_gone(ws_viewer *viewer)
{
    ll_ws_stream *stream = viewer->stream;
    drop_messages(viewer);
    free(viewer->received);
    viewer->received = NULL;
    viewer->received_capacity = 0;
    if (stream == NULL) {
        return;
    }
    ll_ws_viewer_forget(viewer);
    if (viewer->ready) {
        atomic_fetch_sub(&stream->viewers, 1);
    }
    if (viewer->next != NULL) {
        viewer->next->previous = viewer->previous;
    }
    *(viewer->previous != NULL ? &viewer->previous->next : &stream->first) = viewer->next;
    viewer->stream = NULL;
    stream->arrived--;
    atomic_fetch_sub_explicit(&viewer->thread->counts.viewers, 1, memory_order_relaxed);
    if (hooks_of(viewer)->closed != NULL) {
        hooks_of(viewer)->closed(hooks_of(viewer)->context, stream->session, viewer->handle);
    }
    ll_ws_stream_release_if_done(stream);
}

/* Nothing of ours may follow our own close frame, which answers its. */
void ll_ws_viewer_left(ws_viewer *viewer, int code)
{
    if (viewer->said) {
        return;
    }
    drop_messages(viewer);
    viewer->close_code = code;
    viewer->close_ns = viewer->thread->now_ns;
    ll_ws_viewer_gone(viewer);
    ll_ws_socket_say_close(viewer, code, "");
}

static void look_for_life(ws_viewer *viewer)
{
    unsigned char bytes[LL_FRAMING_ROOM];
    int64_t now = viewer->thread->now_ns, silent = now - viewer->heard_ns;
    if (silent > HANG_UP_NS) {
        ll_ws_socket_fail(viewer);
    } else if (silent > PING_NS && now - viewer->pinged_ns > PING_NS && !ll_ws_socket_full(viewer)) {
        viewer->pinged_ns = now;
        ll_ws_socket_write(viewer, bytes + LL_FRAMING_ROOM, 0, LL_OPCODE_PING);
    }
}

void ll_ws_viewer_sweep(ws_viewer *viewer)
{
    const ll_door_config *config = &viewer->thread->ws->config;
    int64_t now = viewer->thread->now_ns;
    if (viewer->dead) {
        return;
    }
    if (viewer->close_code != 0) {
        if (now - viewer->close_ns > GOODBYE_NS) {
            ll_ws_socket_fail(viewer);
        }
        return;
    }
    look_for_life(viewer);
    if (viewer->stream == NULL || viewer->dead) {
        return;
    }
    if (!viewer->ready && (double)(now - viewer->opened_ns) > config->hello_timeout_s * 1e9) {
        ll_ws_viewer_close(viewer, LL_WS_TRY_LATER, "the session is busy: try again later");
    } else if (viewer->acked_once && viewer->outstanding_count > 0 &&
               (double)(now - viewer->outstanding[0].sent_ns) > config->ack_timeout_s * 1e9) {
        ll_ws_count(&viewer->thread->counts.closed_slow, 1);
        ll_ws_viewer_close(viewer, LL_WS_TRY_LATER, "no frame was acknowledged for too long (ack_timeout_s)");
    } else {
        ll_ws_viewer_sweep_frames(viewer);
    }
}
