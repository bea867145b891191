/* Bytes to viewers. What a turn writes is queued, once where several get the same, and sent at its end. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "base/assert.h"
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

static bool has_kept(const ws_viewer *viewer)
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

/* What the socket did with bytes; `result` as of a call. */
static void note_result(ws_viewer *viewer, const unsigned char *bytes, size_t size, long result)
{
    size_t sent = result > 0 ? (size_t)result : 0;
    if ((result < 0 && result != -EAGAIN && result != -EWOULDBLOCK) ||
        (sent < size && !keep(viewer, bytes + sent, size - sent))) {
        ll_ws_socket_fail(viewer);
    } else if (sent < size) {
        ll_ws_socket_request_writable(viewer);
    }
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
    if (!has_kept(viewer)) { /* frees the space of large frames, which few viewers need */
        free(output->unsent);
        output->unsent = NULL;
        output->at = output->end = output->capacity = 0;
    }
}

/* ---- the queue ---- */

void ll_ws_queue_send(ws_thread *thread)
{
    ws_queue *queue = &thread->queue;
    if (queue->count == 0) {
        return;
    }
    for (int i = 0; i < queue->count; i++) {
        ws_viewer *viewer = queue->viewer[i];
        const unsigned char *bytes = (const unsigned char *)queue->bytes.bytes + queue->at[i];
        viewer->output.queued = false;
        note_result(viewer, bytes, queue->size[i], send_now(viewer, bytes, queue->size[i]));
    }
    queue->count = 0;
    queue->bytes.size = 0;
    queue->sent++;
}

bool ll_ws_socket_full(ws_viewer *viewer)
{
    if (viewer->output.queued) {
        ll_ws_queue_send(viewer->thread);
    }
    return has_kept(viewer);
}

static void enqueue(ws_viewer *viewer, size_t at, size_t size)
{
    ws_queue *queue = &viewer->thread->queue;
    LL_ASSERT(!viewer->output.queued && queue->count < WS_QUEUE_MAX && at + size <= queue->bytes.size);
    queue->viewer[queue->count] = viewer;
    queue->at[queue->count] = at;
    queue->size[queue->count] = size;
    queue->count++;
    viewer->output.queued = true;
}

void ll_ws_socket_send_raw(ws_viewer *viewer, const unsigned char *bytes, size_t size)
{
    ws_queue *queue = &viewer->thread->queue;
    if (ll_ws_socket_full(viewer)) {
        note_result(viewer, bytes, size, -EAGAIN);
        return;
    }
    if (queue->count == WS_QUEUE_MAX || queue->bytes.size + size > WS_QUEUED_BYTES) {
        ll_ws_queue_send(viewer->thread);
    }
    char *to = size <= WS_QUEUED_BYTES ? ll_buffer_grow(&queue->bytes, size) : NULL;
    if (to == NULL) {
        queue->bytes.failed = false;
        note_result(viewer, bytes, size, send_now(viewer, bytes, size));
        return;
    }
    memcpy(to, bytes, size);
    enqueue(viewer, queue->bytes.size - size, size);
}

void ll_ws_socket_write(ws_viewer *viewer, unsigned char *payload, size_t size, ll_opcode opcode)
{
    if (!viewer->dead && !viewer->closing.sent) {
        size_t head = ll_framing_put_head(payload, size, opcode);
        ll_ws_socket_send_raw(viewer, payload - head, head + size);
    }
}

void ll_ws_socket_repeat(ws_viewer *viewer, int entry)
{
    ws_queue *queue = &viewer->thread->queue;
    LL_ASSERT(entry < queue->count && !viewer->dead && !viewer->closing.sent);
    enqueue(viewer, queue->at[entry], queue->size[entry]);
}
