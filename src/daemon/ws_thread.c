/* A stream thread: one libwebsockets context, its loop and its callbacks.
 *
 * The library's poll costs a walk over all sockets each time, so with many of them it must not be entered for
 * every ack. While more than a few sockets are open the thread therefore naps between polls: publications
 * wake it at once and are written directly, without any poll, and what viewers send waits for the next poll,
 * at most NAP_NS. With few sockets it just sleeps in the library. */
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/assert.h"
#include "daemon/ws_internal.h"

#define NAP_NS INT64_C(4000000)
#define NAP_SOCKETS 8
#define SWEEP_US (250 * LWS_USEC_PER_SEC / 1000)

/* ---- viewers ---- */

static ws_viewer *viewer_of(ws_thread *thread, ll_ws_viewer handle)
{
    int slot = (int)(handle & 0xffff);
    ws_viewer *viewer = slot < thread->slots ? thread->slot[slot] : NULL;
    return viewer != NULL && viewer->handle == handle ? viewer : NULL;
}

static bool give_handle(ws_thread *thread, ws_viewer *viewer)
{
    int slot = 0;
    while (slot < thread->slots && thread->slot[slot] != NULL) {
        slot++;
    }
    if (slot == thread->slots) {
        int slots = thread->slots > 0 ? 2 * thread->slots : 64;
        ws_viewer **grown = slots <= 65536 ? realloc(thread->slot, (size_t)slots * sizeof *grown) : NULL;
        if (grown == NULL) {
            return false;
        }
        memset(grown + thread->slots, 0, (size_t)(slots - thread->slots) * sizeof *grown);
        thread->slot = grown;
        thread->slots = slots;
    }
    thread->slot[slot] = viewer;
    viewer->handle = ++thread->serial << 24 | (uint64_t)thread->index << 16 | (uint64_t)slot;
    return true;
}

static void destroy_viewer(ws_viewer *viewer)
{
    ws_thread *thread = viewer->thread;
    ll_ws_viewer_gone(viewer);
    if (viewer->handle != 0) {
        thread->slot[viewer->handle & 0xffff] = NULL;
    }
    ll_gate_leave(thread->ws->gate, &viewer->pass);
    free(viewer);
}

/* The request as the library is to see it: the acceptor or libmicrohttpd has read and checked the client's
 * own, whose cookies and other headers would only meet the library's limits. */
static void adopt(ws_thread *thread, const ws_mail *mail)
{
    char head[512];
    int size = snprintf(head, sizeof head,
                        "GET /api/v1/sessions/%s/stream HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\n"
                        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: %s\r\n"
                        "Sec-WebSocket-Protocol: %s\r\n\r\n",
                        mail->upgrade.id, mail->upgrade.key, ll_stream_protocols[mail->upgrade.format]);
    LL_ASSERT(size > 0 && (size_t)size < sizeof head);
    ws_viewer *viewer = calloc(1, sizeof *viewer);
    if (viewer == NULL) {
        close(mail->fd);
        ll_gate_leave(thread->ws->gate, &mail->pass);
        return;
    }
    viewer->thread = thread;
    viewer->pass = mail->pass;
    viewer->upgrade = mail->upgrade;
    /* The library calls back before it returns; `arriving` is taken by the first callback about the new
     * socket, which from then on owns the viewer. The descriptor is the library's, whatever happens. */
    thread->arriving = viewer;
    lws_adopt_socket_vhost_readbuf(thread->vhost, mail->fd, head, (size_t)size);
    if (thread->arriving != NULL) {
        thread->arriving = NULL;
        destroy_viewer(viewer);
    }
}

/* ---- the library's callbacks ---- */

static int on_event(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    (void)user;
    ws_thread *thread = lws_context_user(lws_get_context(wsi));
    ws_viewer *viewer;
    switch (reason) {
    case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED:
        viewer = thread->arriving;
        if (viewer == NULL) {
            return -1;
        }
        thread->arriving = NULL;
        thread->sockets++;
        viewer->wsi = wsi;
        lws_set_opaque_user_data(wsi, viewer);
        return give_handle(thread, viewer) ? 0 : -1;
    case LWS_CALLBACK_WSI_DESTROY:
        viewer = lws_get_opaque_user_data(wsi);
        if (viewer != NULL) {
            lws_set_opaque_user_data(wsi, NULL);
            thread->sockets--;
            destroy_viewer(viewer);
        }
        return 0;
    case LWS_CALLBACK_ESTABLISHED:
        viewer = lws_get_opaque_user_data(wsi);
        return viewer != NULL && ll_ws_viewer_open(viewer) ? 0 : -1;
    case LWS_CALLBACK_CLOSED:
        viewer = lws_get_opaque_user_data(wsi);
        if (viewer != NULL) {
            viewer->dead = true;
            ll_ws_viewer_gone(viewer);
        }
        return 0;
    case LWS_CALLBACK_WS_PEER_INITIATED_CLOSE: /* the library answers it; nothing may be sent after that */
        viewer = lws_get_opaque_user_data(wsi);
        if (viewer != NULL && viewer->close_code == 0) {
            viewer->close_code = LL_WS_NORMAL;
            viewer->close_ns = thread->now_ns;
        }
        return 0;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        viewer = lws_get_opaque_user_data(wsi);
        return viewer != NULL && ll_ws_viewer_writable(viewer) ? 0 : -1;
    case LWS_CALLBACK_RECEIVE_PONG: /* asked for or not */
        viewer = lws_get_opaque_user_data(wsi);
        if (viewer != NULL) {
            thread->now_ns = ll_ws_now();
            ll_ws_viewer_pong(viewer);
        }
        return 0;
    case LWS_CALLBACK_RECEIVE: {
        viewer = lws_get_opaque_user_data(wsi);
        thread->now_ns = ll_ws_now(); /* the poll before may have slept: acks are timed by it */
        bool last = lws_is_final_fragment(wsi) && lws_remaining_packet_payload(wsi) == 0;
        return viewer != NULL && ll_ws_viewer_receive(viewer, in, size, lws_is_first_fragment(wsi) != 0, last)
                   ? 0
                   : -1;
    }
    case LWS_CALLBACK_HTTP: /* no plain request gets here */
        return -1;
    default:
        return 0;
    }
}

static const struct lws_protocols protocols[] = {
    /* tx_packet_size: a bigger frame is copied to the library's own buffer beyond that many bytes. */
    {.name = "laglab.v1.bin", .callback = on_event, .rx_buffer_size = 4096, .tx_packet_size = 1 << 20},
    {.name = "laglab.v1.json", .callback = on_event, .rx_buffer_size = 4096, .tx_packet_size = 1 << 20},
    {.name = NULL},
};

static const lws_retry_bo_t idle_policy = {.secs_since_valid_ping = 20, .secs_since_valid_hangup = 30};

bool ll_ws_thread_prepare(ws_thread *thread)
{
    struct lws_context_creation_info info = {
        .port = CONTEXT_PORT_NO_LISTEN_SERVER,
        .protocols = protocols,
        .user = thread,
        .options = LWS_SERVER_OPTION_VALIDATE_UTF8 | LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME |
                   LWS_SERVER_OPTION_EXPLICIT_VHOSTS,
        .retry_and_idle_policy = &idle_policy,
        .timeout_secs = 5,
        .vhost_name = "streams",
    };
    struct lws_context *context = lws_create_context(&info);
    if (context == NULL) {
        return false;
    }
    thread->vhost = lws_create_vhost(context, &info);
    thread->context = context;
    return thread->vhost != NULL;
}

/* ---- the loop ---- */

static void sweep(lws_sorted_usec_list_t *sul)
{
    ws_thread *thread = lws_container_of(sul, ws_thread, sweep);
    thread->now_ns = ll_ws_now();
    for (int i = 0; i < thread->slots; i++) {
        if (thread->slot[i] != NULL) {
            ll_ws_viewer_sweep(thread->slot[i]);
        }
    }
    lws_sul_schedule(thread->context, 0, &thread->sweep, sweep, SWEEP_US);
}

static void close_stream(ll_ws_stream *stream, int code, const char *reason)
{
    stream->closing = true;
    for (ws_viewer *viewer = stream->first; viewer != NULL; viewer = viewer->next) {
        ll_ws_viewer_close(viewer, code, reason);
    }
    ll_ws_stream_release_if_done(stream);
}

static void take_mail(ws_thread *thread, ws_mail *mail)
{
    ws_viewer *viewer = mail->viewer != 0 ? viewer_of(thread, mail->viewer) : NULL;
    bool present = viewer != NULL && viewer->stream != NULL;
    switch (mail->kind) {
    case WS_MAIL_ADOPT:
        adopt(thread, mail);
        break;
    case WS_MAIL_CLOSE_STREAM:
        close_stream(mail->stream, mail->code, (const char *)mail->text);
        break;
    case WS_MAIL_CLOSE:
        if (present) {
            ll_ws_viewer_close(viewer, mail->code, (const char *)mail->text);
        }
        break;
    case WS_MAIL_HELLO:
        if (present) {
            ll_ws_viewer_hello(viewer, mail);
            return;
        }
        break;
    case WS_MAIL_SEND:
        if (present) {
            ll_ws_viewer_send(viewer, mail);
            return;
        }
        break;
    }
    free(mail);
}

/* Takes what other threads left: publications first, as a stream that is closed after its last frame shows
 * that frame. */
static void take_news(ws_thread *thread)
{
    atomic_store(&thread->wake_pending, false);
    thread->now_ns = ll_ws_now();
    pthread_mutex_lock(&thread->lock);
    ws_mail *mail = thread->first_mail;
    thread->first_mail = thread->last_mail = NULL;
    ll_ws_stream *dirty = thread->dirty;
    thread->dirty = NULL;
    pthread_mutex_unlock(&thread->lock);
    while (dirty != NULL) {
        ws_publication *taken[WS_PENDING];
        ll_ws_stream *stream = dirty;
        pthread_mutex_lock(&thread->lock);
        int count = stream->pending_count;
        memcpy(taken, stream->pending, (size_t)count * sizeof *taken);
        stream->pending_count = 0;
        dirty = stream->next_dirty;
        pthread_mutex_unlock(&thread->lock);
        ll_ws_stream_distribute(stream, taken, count);
    }
    while (mail != NULL) {
        ws_mail *next = mail->next;
        take_mail(thread, mail);
        mail = next;
    }
}

/* Sleeps until somebody wakes the thread or `until_ns`. */
static void nap(ws_thread *thread, int64_t until_ns)
{
    atomic_store(&thread->napping, true);
    int64_t left = until_ns - ll_ws_now();
    if (!atomic_load(&thread->wake_pending) && left > 0) {
        struct pollfd event = {.fd = thread->event_fd, .events = POLLIN};
        struct timespec time = {.tv_nsec = left < NAP_NS ? left : NAP_NS};
        ppoll(&event, 1, &time, NULL);
    }
    eventfd_t value;
    eventfd_read(thread->event_fd, &value);
    atomic_store(&thread->napping, false);
}

static void say_goodbye(ws_thread *thread)
{
    for (int i = 0; i < thread->slots; i++) {
        if (thread->slot[i] != NULL && thread->slot[i]->stream != NULL) {
            ll_ws_viewer_close(thread->slot[i], LL_WS_GOING_AWAY, "the daemon stops");
        }
    }
}

static void finish(ws_thread *thread)
{
    struct lws_context *context = thread->context;
    pthread_mutex_lock(&thread->lock);
    thread->stopped = true;
    ws_mail *mail = thread->first_mail;
    thread->first_mail = thread->last_mail = NULL;
    thread->dirty = NULL; /* their publications are freed with the streams */
    pthread_mutex_unlock(&thread->lock);
    pthread_mutex_lock(&thread->wake_lock);
    thread->context = NULL;
    pthread_mutex_unlock(&thread->wake_lock);
    for (ws_mail *next; mail != NULL; mail = next) {
        next = mail->next;
        if (mail->kind == WS_MAIL_ADOPT) {
            close(mail->fd);
            ll_gate_leave(thread->ws->gate, &mail->pass);
        } else if (mail->kind == WS_MAIL_CLOSE_STREAM) {
            mail->stream->closing = true;
            ll_ws_stream_release_if_done(mail->stream);
        }
        free(mail);
    }
    lws_context_destroy(context);
    free(thread->slot);
    thread->slot = NULL;
    thread->slots = 0;
}

void *ll_ws_thread_main(void *argument)
{
    ws_thread *thread = argument;
    int64_t last_poll = 0, end = 0;
    pthread_setname_np(pthread_self(), "stream");
    bool was_sweeping = false;
    for (;;) {
        if (atomic_load(&thread->wake_pending)) {
            take_news(thread);
        }
        if (atomic_load(&thread->drain) && end == 0) {
            say_goodbye(thread);
            end = ll_ws_now() + (int64_t)(thread->ws->config.drain_s * 1e9);
        }
        if (end != 0 && (thread->sockets == 0 || ll_ws_now() >= end)) {
            break;
        }
        bool sweeping = thread->sockets > 0;
        if (sweeping && !was_sweeping) {
            lws_sul_schedule(thread->context, 0, &thread->sweep, sweep, SWEEP_US);
        } else if (!sweeping && was_sweeping) {
            lws_sul_cancel(&thread->sweep);
        }
        was_sweeping = sweeping;
        bool busy = thread->sockets > NAP_SOCKETS || end != 0;
        if (busy && ll_ws_now() < last_poll + NAP_NS) {
            nap(thread, last_poll + NAP_NS);
            continue;
        }
        last_poll = thread->now_ns = ll_ws_now();
        /* A negative timeout polls without waiting; 0 waits for a socket, a timer or ll_ws_wake. */
        if (lws_service(thread->context, busy || atomic_load(&thread->wake_pending) ? -1 : 0) < 0) {
            break;
        }
    }
    lws_sul_cancel(&thread->sweep);
    finish(thread);
    return NULL;
}
