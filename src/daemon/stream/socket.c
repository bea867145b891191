/* The socket of a viewer: bytes in, and the closing handshake. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "daemon/stream/internal.h"

/* After both close frames, or a protocol error: shutting down our half makes the peer close. Its bytes are
 * read until it does, since closing a socket with unread bytes resets it, and the reset would overtake the
 * close frame. */
static void shut_when_done(ws_viewer *viewer)
{
    if (viewer->closing.sent && viewer->ignores_input && !viewer->closing.write_closed &&
        !ll_ws_socket_full(viewer)) {
        viewer->closing.write_closed = true;
        shutdown(viewer->socket.fd, SHUT_WR);
    }
}

void ll_ws_socket_ping(ws_viewer *viewer)
{
    unsigned char bytes[LL_FRAMING_HEAD_SPACE];
    if (viewer->measured_ns != 0 || viewer->closing.code != 0 || ll_ws_socket_full(viewer)) {
        return;
    }
    viewer->measured_ns = viewer->pinged_ns = ll_now_ns();
    ll_ws_socket_write(viewer, bytes + LL_FRAMING_HEAD_SPACE, 0, LL_OPCODE_PING);
}

void ll_ws_socket_send_close(ws_viewer *viewer, int code, const char *reason)
{
    unsigned char bytes[LL_FRAMING_HEAD_SPACE + LL_FRAMING_CONTROL_MAX],
        *payload = bytes + LL_FRAMING_HEAD_SPACE;
    size_t size = 0;
    if (code != LL_FRAMING_NO_CODE) {
        payload[0] = (unsigned char)(code >> 8);
        payload[1] = (unsigned char)code;
        size = strnlen(reason, LL_FRAMING_CONTROL_MAX - 2);
        memcpy(payload + 2, reason, size);
        size += 2;
    }
    ll_ws_socket_write(viewer, payload, size, LL_OPCODE_CLOSE);
    viewer->closing.sent = true;
    shut_when_done(viewer);
}

/* ---- input ---- */

static void take_event(ws_viewer *viewer, ll_framing_event event)
{
    const ll_framing *framing = &viewer->framing;
    switch (event) {
    case LL_FRAMING_PIECE:
        viewer->receiver->piece(viewer, framing);
        break;
    case LL_FRAMING_PING:
        memcpy(viewer->output.pong, framing->bytes, framing->size);
        viewer->output.pong_size = (int)framing->size;
        viewer->receiver->ping(viewer);
        break;
    case LL_FRAMING_PONG:
        viewer->receiver->pong(viewer);
        break;
    case LL_FRAMING_CLOSE:
        viewer->ignores_input = true;
        viewer->receiver->closed(viewer, framing->code);
        shut_when_done(viewer);
        break;
    case LL_FRAMING_FAULT:
        viewer->ignores_input = true;
        if (viewer->closing.code == 0) {
            ll_ws_count(&viewer->thread->counts.closed_policy, 1);
        }
        viewer->receiver->fault(viewer, framing->code, framing->fault);
        shut_when_done(viewer);
        break;
    case LL_FRAMING_NONE:
        break;
    }
}

void ll_ws_socket_take(ws_viewer *viewer, unsigned char *bytes, size_t size)
{
    size_t used = 0;
    viewer->received_ns = viewer->thread->now_ns;
    while (used < size && !viewer->ignores_input && !viewer->dead) {
        take_event(viewer, ll_framing_read(&viewer->framing, bytes, size, &used));
    }
}

static void read_input(ws_viewer *viewer)
{
    unsigned char *input = viewer->thread->input;
    ssize_t size;
    do {
        size = recv(viewer->socket.fd, input, WS_INPUT, MSG_DONTWAIT);
    } while (size < 0 && errno == EINTR);
    if (size > 0) {
        ll_ws_socket_take(viewer, input, (size_t)size);
    } else if (size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) {
        ll_ws_socket_fail(viewer);
    }
}

void ll_ws_socket_event(ws_viewer *viewer, uint32_t events)
{
    if (!viewer->dead && (events & ~(uint32_t)EPOLLOUT) != 0) {
        read_input(viewer);
    }
    if (!viewer->dead && (events & EPOLLOUT) != 0) {
        ll_ws_socket_flush(viewer);
        if (!ll_ws_socket_full(viewer)) {
            ll_ws_socket_set_epoll(viewer, EPOLLIN);
            shut_when_done(viewer);
            viewer->receiver->writable(viewer);
        }
    }
}

/* ---- opening and closing ---- */

bool ll_ws_socket_open(ws_viewer *viewer)
{
    char accept[29], head[400];
    ll_ws_socket_set_epoll(viewer, EPOLLIN);
    if (viewer->dead || viewer->socket.answered) {
        return !viewer->dead;
    }
    if (!ll_framing_accept(viewer->upgrade.key, accept)) {
        return false;
    }
    int size = snprintf(head, sizeof head,
                        "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                        "Sec-WebSocket-Accept: %s\r\nSec-WebSocket-Protocol: %s\r\n\r\n",
                        accept, ll_stream_protocols[viewer->upgrade.format]);
    ll_ws_socket_send_raw(viewer, (unsigned char *)head, (size_t)size);
    return !viewer->dead;
}

void ll_ws_socket_free(ws_viewer *viewer)
{
    if (viewer->events != 0) {
        epoll_ctl(viewer->thread->epoll, EPOLL_CTL_DEL, viewer->socket.fd, NULL);
    }
    ll_ws_release(&viewer->socket);
    free(viewer->output.unsent);
}
