/* Bytes to viewers. */
#include <errno.h>
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

void ll_ws_socket_set_epoll(ws_viewer *viewer, uint32_t events)
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
    ll_ws_socket_set_epoll(viewer, EPOLLIN | EPOLLOUT);
}

/* ---- kept bytes ---- */

bool ll_ws_socket_full(const ws_viewer *viewer)
{
    return viewer->output.at < viewer->output.end;
}

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

static long send_now(const ws_viewer *viewer, const unsigned char *bytes, size_t size)
{
    ssize_t sent;
    do {
        sent = send(viewer->socket.fd, bytes, size, MSG_DONTWAIT | MSG_NOSIGNAL);
    } while (sent < 0 && errno == EINTR);
    return sent < 0 ? -(long)errno : (long)sent;
}

void ll_ws_socket_flush(ws_viewer *viewer)
{
    ws_viewer_output *output = &viewer->output;
    if (!ll_ws_socket_full(viewer)) {
        return;
    }
    long sent = send_now(viewer, output->unsent + output->at, output->end - output->at);
    if (sent < 0 && sent != -EAGAIN && sent != -EWOULDBLOCK) {
        ll_ws_socket_fail(viewer);
        return;
    }
    output->at += sent > 0 ? (size_t)sent : 0;
    if (!ll_ws_socket_full(viewer)) { /* frees the space of large frames, which few viewers need */
        free(output->unsent);
        output->unsent = NULL;
        output->at = output->end = output->capacity = 0;
    }
}

void ll_ws_socket_send_raw(ws_viewer *viewer, const unsigned char *bytes, size_t size)
{
    long result = ll_ws_socket_full(viewer) ? -EAGAIN : send_now(viewer, bytes, size);
    size_t sent = result > 0 ? (size_t)result : 0;
    if ((result < 0 && result != -EAGAIN && result != -EWOULDBLOCK) ||
        (sent < size && !keep(viewer, bytes + sent, size - sent))) {
        ll_ws_socket_fail(viewer);
    } else if (sent < size) {
        ll_ws_socket_request_writable(viewer);
    }
}

void ll_ws_socket_write(ws_viewer *viewer, unsigned char *payload, size_t size, ll_opcode opcode)
{
    if (!viewer->dead && !viewer->closing.sent) {
        size_t head = ll_framing_put_head(payload, size, opcode);
        ll_ws_socket_send_raw(viewer, payload - head, head + size);
    }
}
