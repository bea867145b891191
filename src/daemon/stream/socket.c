/* The socket of a viewer: bytes in and out, and the closing handshake. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "daemon/stream/internal.h"

/* The caller may continue with the viewer: it is freed at the end of the turn. */
void ll_ws_socket_fail(ws_viewer *viewer)
{
    if (!viewer->dead) {
        viewer->dead = true;
        viewer->next_dead = viewer->thread->first_dead;
        viewer->thread->first_dead = viewer;
    }
}

static void set_epoll_events(ws_viewer *viewer, uint32_t events)
{
    struct epoll_event interest = {.events = events, .data.ptr = viewer};
    if (viewer->events == events || viewer->dead) {
        return;
    }
    int op = viewer->events == 0 ? EPOLL_CTL_ADD : EPOLL_CTL_MOD;
    viewer->events = events;
    if (epoll_ctl(viewer->thread->epoll, op, viewer->socket.fd, &interest) != 0) {
        ll_ws_socket_fail(viewer);
    }
}

void ll_ws_socket_request_writable(ws_viewer *viewer)
{
    set_epoll_events(viewer, EPOLLIN | EPOLLOUT);
}

bool ll_ws_socket_full(const ws_viewer *viewer)
{
    return viewer->output.at < viewer->output.end;
}

/* ---- output ---- */

static bool keep(ws_viewer *viewer, const unsigned char *bytes, size_t size)
{
    if (viewer->output.end + size > viewer->output.capacity) {
        unsigned char *grown = realloc(viewer->output.unsent, viewer->output.end + size);
        if (grown == NULL) {
            return false;
        }
        viewer->output.unsent = grown;
        viewer->output.capacity = viewer->output.end + size;
    }
    memcpy(viewer->output.unsent + viewer->output.end, bytes, size);
    viewer->output.end += size;
    return true;
}

/* Bytes that the socket accepted; -1 when it failed. */
static ssize_t send_some(ws_viewer *viewer, const unsigned char *bytes, size_t size)
{
    ssize_t sent;
    do {
        sent = send(viewer->socket.fd, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    } while (sent < 0 && errno == EINTR);
    return sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK) ? 0 : sent;
}

static void write_bytes(ws_viewer *viewer, const unsigned char *bytes, size_t size)
{
    ssize_t sent = ll_ws_socket_full(viewer) ? 0 : send_some(viewer, bytes, size);
    if (sent < 0 || ((size_t)sent < size && !keep(viewer, bytes + sent, size - (size_t)sent))) {
        ll_ws_socket_fail(viewer);
    } else if ((size_t)sent < size) {
        ll_ws_socket_request_writable(viewer);
    }
}

void ll_ws_socket_write(ws_viewer *viewer, unsigned char *payload, size_t size, ll_opcode opcode)
{
    if (!viewer->dead && !viewer->closing.sent) {
        size_t head = ll_framing_put_head(payload, size, opcode);
        write_bytes(viewer, payload - head, head + size);
    }
}

static void flush(ws_viewer *viewer)
{
    if (!ll_ws_socket_full(viewer)) {
        return;
    }
    ssize_t sent =
        send_some(viewer, viewer->output.unsent + viewer->output.at, viewer->output.end - viewer->output.at);
    if (sent < 0) {
        ll_ws_socket_fail(viewer);
        return;
    }
    viewer->output.at += (size_t)sent;
    if (!ll_ws_socket_full(viewer)) { /* frees the space of large frames, which few viewers need */
        free(viewer->output.unsent);
        viewer->output.unsent = NULL;
        viewer->output.at = viewer->output.end = viewer->output.capacity = 0;
    }
}

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
    viewer->measured_ns = viewer->pinged_ns = ll_ws_now();
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

static void read_some(ws_viewer *viewer)
{
    unsigned char *input = viewer->thread->input;
    ssize_t size = recv(viewer->socket.fd, input, WS_INPUT, MSG_DONTWAIT);
    if (size > 0) {
        viewer->thread->now_ns = ll_ws_now(); /* the wait may have been long, and acks are timed by it */
        ll_ws_socket_take(viewer, input, (size_t)size);
    } else if (size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)) {
        ll_ws_socket_fail(viewer);
    }
}

void ll_ws_socket_event(ws_viewer *viewer, uint32_t events)
{
    if (!viewer->dead && (events & ~(uint32_t)EPOLLOUT) != 0) {
        read_some(viewer);
    }
    if (!viewer->dead && (events & EPOLLOUT) != 0) {
        flush(viewer);
        if (!ll_ws_socket_full(viewer)) {
            set_epoll_events(viewer, EPOLLIN);
            shut_when_done(viewer);
            viewer->receiver->writable(viewer);
        }
    }
}

/* ---- opening and closing ---- */

bool ll_ws_socket_open(ws_viewer *viewer)
{
    char accept[29], head[400];
    set_epoll_events(viewer, EPOLLIN);
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
    write_bytes(viewer, (unsigned char *)head, (size_t)size);
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
