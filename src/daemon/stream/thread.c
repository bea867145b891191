/* A stream thread: its loop, and opening and closing of viewers.
 *
 * Every wait costs, and with many viewers data comes all the time: 60 acks per second from each. With more
 * than a few open sockets the thread therefore polls them at most once in POLL_INTERVAL_NS; in between it
 * only waits for publications, which it writes at once. */
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "daemon/stream/internal.h"

#define POLL_INTERVAL_NS INT64_C(4000000)
#define POLL_MIN_SOCKETS 8
#define SWEEP_NS INT64_C(250000000)
#define EVENTS 256 /* handled in one turn */

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
    ll_ws_socket_free(viewer);
    ll_connection_limiter_leave(thread->ws->connection_limiter, &viewer->pass);
    thread->sockets--;
    free(viewer);
}

/* Before the end of a turn an event or a loop over a stream may still refer to them. */
static void free_dead(ws_thread *thread)
{
    while (thread->first_dead != NULL) {
        ws_viewer *viewer = thread->first_dead;
        thread->first_dead = viewer->next_dead;
        destroy_viewer(viewer);
    }
}

static void adopt(ws_thread *thread, ws_command *command)
{
    ws_viewer *viewer = calloc(1, sizeof *viewer);
    if (viewer == NULL) {
        ll_ws_release(&command->socket);
        ll_connection_limiter_leave(thread->ws->connection_limiter, &command->pass);
        return;
    }
    viewer->thread = thread;
    viewer->receiver = &ll_ws_viewer_receiver;
    viewer->socket = command->socket;
    viewer->pass = command->pass;
    viewer->upgrade = command->upgrade;
    viewer->received_ns = viewer->pinged_ns = thread->now_ns;
    thread->sockets++;
    if (!give_handle(thread, viewer) || !ll_ws_socket_open(viewer)) {
        ll_ws_socket_fail(viewer);
        return;
    }
    ll_ws_viewer_open(viewer);
    ll_ws_socket_take(viewer, command->text, command->size);
}

bool ll_ws_thread_prepare(ws_thread *thread)
{
    struct epoll_event interest = {.events = EPOLLIN, .data.ptr = NULL};
    thread->epoll = epoll_create1(EPOLL_CLOEXEC);
    thread->input = malloc(WS_INPUT);
    return thread->epoll >= 0 && thread->input != NULL &&
           epoll_ctl(thread->epoll, EPOLL_CTL_ADD, thread->event_fd, &interest) == 0;
}

/* ---- the loop ---- */

static void sweep(ws_thread *thread)
{
    for (int i = 0; i < thread->slots; i++) {
        if (thread->slot[i] != NULL) {
            ll_ws_viewer_sweep(thread->slot[i]);
        }
    }
}

static void close_stream(ll_ws_stream *stream, int code, const char *reason)
{
    stream->closing = true;
    for (ws_viewer *viewer = stream->first; viewer != NULL; viewer = viewer->next) {
        ll_ws_viewer_close(viewer, code, reason);
    }
    ll_ws_stream_release_if_done(stream);
}

static void run_command(ws_thread *thread, ws_command *command)
{
    ws_viewer *viewer = command->viewer != 0 ? viewer_of(thread, command->viewer) : NULL;
    bool present = viewer != NULL && viewer->stream != NULL;
    switch (command->kind) {
    case WS_COMMAND_ADOPT:
        adopt(thread, command);
        break;
    case WS_COMMAND_CLOSE_STREAM:
        close_stream(command->stream, command->code, (const char *)command->text);
        break;
    case WS_COMMAND_CLOSE:
        if (present) {
            ll_ws_viewer_close(viewer, command->code, (const char *)command->text);
        }
        break;
    case WS_COMMAND_HELLO:
        if (present) {
            ll_ws_viewer_hello(viewer, command);
            return;
        }
        break;
    case WS_COMMAND_PING:
        if (present) {
            ll_ws_socket_ping(viewer);
        }
        break;
    case WS_COMMAND_SUBSCRIBE:
        if (present) {
            ll_ws_viewer_subscribe(viewer, &command->subscription);
        }
        break;
    case WS_COMMAND_SEND:
        if (present) {
            ll_ws_viewer_send(viewer, command);
            return;
        }
        break;
    }
    free(command);
}

/* Takes the publications of all streams at once: publishers wait for this lock. Returns their list. */
static ll_ws_stream *take_publications(ws_thread *thread)
{
    ll_ws_stream *first = thread->dirty;
    thread->dirty = NULL;
    for (ll_ws_stream *stream = first; stream != NULL; stream = stream->next_taken) {
        stream->next_taken = stream->next_dirty;
        stream->taken_count = stream->pending_count;
        memcpy(stream->taken, stream->pending, (size_t)stream->pending_count * sizeof(ll_frame *));
        stream->pending_count = 0;
    }
    return first;
}

/* Handles publications and commands of other threads. Publications first: a stream that is closed after its
 * last frame still sends that frame. */
static void process_pending(ws_thread *thread)
{
    atomic_store(&thread->wake_pending, false);
    thread->now_ns = ll_now_ns();
    pthread_mutex_lock(&thread->lock);
    ws_command *command = thread->first_command;
    thread->first_command = thread->last_command = NULL;
    ll_ws_stream *published = take_publications(thread);
    pthread_mutex_unlock(&thread->lock);
    while (published != NULL) {
        ll_ws_stream *stream = published;
        published = stream->next_taken;
        ll_ws_stream_distribute(stream, stream->taken, stream->taken_count);
    }
    while (command != NULL) {
        ws_command *next = command->next;
        run_command(thread, command);
        command = next;
    }
}

static void clear_wake(ws_thread *thread)
{
    eventfd_t value;
    eventfd_read(thread->event_fd, &value);
}

/* Sleeps until a wake-up or `until_ns`. */
static void wait_until(ws_thread *thread, int64_t until_ns)
{
    int64_t left = until_ns - ll_now_ns();
    if (left > 0) {
        struct pollfd event = {.fd = thread->event_fd, .events = POLLIN};
        struct timespec time = {.tv_nsec = left < POLL_INTERVAL_NS ? left : POLL_INTERVAL_NS};
        ppoll(&event, 1, &time, NULL);
    }
    clear_wake(thread);
}

/* Handles socket events. `wait_ns`: longest wait for the first. */
static void serve_sockets(ws_thread *thread, int64_t wait_ns)
{
    struct epoll_event events[EVENTS];
    int wait_ms = wait_ns < 0 ? -1 : (int)((wait_ns + 999999) / 1000000);
    int count = epoll_wait(thread->epoll, events, EVENTS, wait_ms);
    thread->now_ns = ll_now_ns();
    for (int i = 0; i < count; i++) {
        ws_viewer *viewer = events[i].data.ptr;
        if (viewer != NULL) {
            ll_ws_socket_event(viewer, events[i].events);
            thread->now_ns = ll_now_ns(); /* acks are timed by it */
        } else {
            clear_wake(thread);
        }
    }
}

static void send_close_frame(ws_thread *thread)
{
    for (int i = 0; i < thread->slots; i++) {
        if (thread->slot[i] != NULL && thread->slot[i]->stream != NULL) {
            ll_ws_viewer_close(thread->slot[i], LL_WS_GOING_AWAY, "the daemon stops");
        }
    }
}

static void finish(ws_thread *thread)
{
    pthread_mutex_lock(&thread->lock);
    thread->stopped = true;
    ws_command *command = thread->first_command;
    thread->first_command = thread->last_command = NULL;
    thread->dirty = NULL; /* their publications are freed with the streams */
    pthread_mutex_unlock(&thread->lock);
    for (ws_command *next; command != NULL; command = next) {
        next = command->next;
        if (command->kind == WS_COMMAND_ADOPT) {
            ll_ws_release(&command->socket);
            ll_connection_limiter_leave(thread->ws->connection_limiter, &command->pass);
        } else if (command->kind == WS_COMMAND_CLOSE_STREAM) {
            command->stream->closing = true;
            ll_ws_stream_release_if_done(command->stream);
        }
        free(command);
    }
    for (int i = 0; i < thread->slots; i++) {
        if (thread->slot[i] != NULL) {
            ll_ws_socket_fail(thread->slot[i]);
        }
    }
    free_dead(thread);
    free(thread->slot);
    thread->slot = NULL;
    thread->slots = 0;
}

void *ll_ws_thread_main(void *argument)
{
    ws_thread *thread = argument;
    int64_t served_ns = 0, swept_ns = 0, end_ns = 0;
    pthread_setname_np(pthread_self(), "stream");
    for (;;) {
        if (atomic_load(&thread->wake_pending)) {
            process_pending(thread);
        }
        if (atomic_load(&thread->drain) && end_ns == 0) {
            send_close_frame(thread);
            end_ns = ll_now_ns() + (int64_t)(thread->ws->config.drain_s * 1e9);
        }
        thread->now_ns = ll_now_ns();
        if (thread->sockets > 0 && thread->now_ns - swept_ns >= SWEEP_NS) {
            swept_ns = thread->now_ns;
            sweep(thread);
        }
        free_dead(thread);
        if (end_ns != 0 && (thread->sockets == 0 || thread->now_ns >= end_ns)) {
            break;
        }
        if (thread->sockets > POLL_MIN_SOCKETS && thread->now_ns < served_ns + POLL_INTERVAL_NS) {
            wait_until(thread, served_ns + POLL_INTERVAL_NS);
            continue;
        }
        served_ns = thread->now_ns;
        serve_sockets(thread, thread->sockets == 0 ? -1 : swept_ns + SWEEP_NS - thread->now_ns);
        free_dead(thread);
    }
    finish(thread);
    return NULL;
}
