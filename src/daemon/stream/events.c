/* What libwebsockets calls: it answers the upgrade, reads frames, and closes. */
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "daemon/stream/internal.h"

#define READ_BYTES 1024      /* of a viewer in one turn: all that it can cost (thread.c) */
#define SEND_BYTES (1 << 20) /* in one call; frames above it are sent in parts, and copied */

/* The library has found a fault in what the viewer sent, and closes. */
static void note_fault(ws_viewer *viewer)
{
    if (viewer->closing.code == 0 && lws_get_close_length(viewer->wsi) > 0) {
        const unsigned char *code = lws_get_close_payload(viewer->wsi);
        ll_ws_count(&viewer->thread->counts.closed_policy, 1);
        viewer->closing.hangs_up = true;
        ll_ws_viewer_ends(viewer, code[0] << 8 | code[1]);
    }
}

/* Who was closed for what he sends need not answer. His bytes are read until he closes, since closing a
 * socket with unread bytes resets it, and the reset would overtake the close frame. */
static void close_frame_sent(ws_viewer *viewer)
{
    note_fault(viewer);
    if (viewer->closing.hangs_up)
        shutdown(lws_get_socket_fd(viewer->wsi), SHUT_WR);
}

static int code_of(const unsigned char *payload, size_t size)
{
    return size >= 2 ? payload[0] << 8 | payload[1] : LWS_CLOSE_STATUS_NO_STATUS;
}

static void hear(ws_viewer *viewer)
{
    viewer->thread->now_ns = viewer->received_ns = ll_now_ns(); /* acks are timed by it */
}

/* -1: the library closes the connection, after a close frame if there is a reason for one. */
static int writable(ws_viewer *viewer)
{
    if (viewer->dead)
        return -1;
    if (lws_get_close_length(viewer->wsi) > 0) {
        close_frame_sent(viewer);
        return 0;
    }
    ll_ws_viewer_writable(viewer);
    if (viewer->closing.code == 0 || viewer->messages.first != NULL || ll_ws_socket_full(viewer))
        return 0;
    lws_close_reason(viewer->wsi, (enum lws_close_status)viewer->closing.code,
                     (unsigned char *)viewer->closing.reason, strlen(viewer->closing.reason));
    ll_ws_viewer_ends(viewer, viewer->closing.code);
    return -1;
}

/* Also called for the library's own connections, which have no viewer. */
static int on_event(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *bytes, size_t size)
{
    ws_viewer *viewer = lws_get_opaque_user_data(wsi);
    (void)user;
    switch ((int)reason) {
    case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED: {
        ws_thread *thread = lws_context_user(lws_get_context(wsi));
        lws_set_opaque_user_data(wsi, thread->adopting);
        thread->adopting->wsi = wsi;
        thread->adopting = NULL;
        return 0;
    }
    case LWS_CALLBACK_ESTABLISHED:
        ll_ws_viewer_open(viewer);
        return 0;
    case LWS_CALLBACK_RECEIVE:
        hear(viewer);
        ll_ws_viewer_receive(viewer, bytes, size);
        return 0;
    case LWS_CALLBACK_RECEIVE_PONG:
        hear(viewer);
        ll_ws_viewer_pong(viewer);
        return 0;
    case LWS_CALLBACK_WS_PEER_INITIATED_CLOSE: /* the library answers */
        ll_ws_viewer_ends(viewer, code_of(bytes, size));
        return 0;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return writable(viewer);
    case LWS_CALLBACK_CLOSED:
        note_fault(viewer);
        return 0;
    case LWS_CALLBACK_WSI_DESTROY:
        if (viewer != NULL)
            ll_ws_viewer_free(viewer);
        return 0;
    default:
        return 0;
    }
}

/* The request was checked (upgrade.h); what the library reads of it is written here, the same for
 * connections whose head was read by HTTP. */
void ll_ws_adopt_viewer(ws_thread *thread, const ws_command *command)
{
    char head[400];
    ws_viewer *viewer = ll_ws_viewer_new(thread, command);
    if (viewer == NULL) {
        close(command->fd);
        ll_connection_limiter_leave(thread->ws->connection_limiter, &command->pass);
        return;
    }
    int size = snprintf(head, sizeof head,
                        "GET / HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: %s\r\n"
                        "Sec-WebSocket-Protocol: %s\r\n\r\n",
                        viewer->upgrade.key, ll_stream_protocols[viewer->upgrade.format]);
    thread->adopting = viewer;
    lws_adopt_socket_readbuf(thread->context, command->fd, head, (size_t)size); /* closes it when it fails */
    if (thread->adopting != NULL) {
        thread->adopting = NULL;
        ll_ws_viewer_free(viewer);
    }
}

struct lws_context *ll_ws_context_new(ws_thread *thread)
{
    static const struct lws_protocols protocols[] = {{.name = "laglab.v2.bin",
                                                      .callback = on_event,
                                                      .rx_buffer_size = READ_BYTES,
                                                      .tx_packet_size = SEND_BYTES},
                                                     {.name = "laglab.v2.json",
                                                      .callback = on_event,
                                                      .rx_buffer_size = READ_BYTES,
                                                      .tx_packet_size = SEND_BYTES},
                                                     {0}};
    static const lws_retry_bo_t no_timers = {0}; /* of the library: viewer.c has its own */
    void *loops[] = {thread->loop};
    struct lws_context_creation_info info = {.port = CONTEXT_PORT_NO_LISTEN_SERVER,
                                             .protocols = protocols,
                                             .options = LWS_SERVER_OPTION_LIBEV |
                                                        LWS_SERVER_OPTION_VALIDATE_UTF8 |
                                                        LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME,
                                             .foreign_loops = loops,
                                             .retry_and_idle_policy = &no_timers,
                                             .gid = -1,
                                             .uid = -1,
                                             .user = thread};
    lws_set_log_level(0, NULL);
    return lws_create_context(&info);
}
