/* A stream thread: its loop, and its end.
 *
 * Every turn costs, and with many viewers data comes all the time: 60 acks per second from each. The thread
 * therefore serves its sockets at most once in TURN_NS on average; in between it only waits for publications,
 * which it writes at once. This also bounds what a viewer can cost that sends all it can: a turn reads little
 * of each (events.c). Few sockets may be served ahead of time, so that a message is not delayed. */
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "daemon/stream/internal.h"

#define TURN_NS INT64_C(4000000)
#define FEW_SOCKETS 8
#define AHEAD_NS (10 * TURN_NS)
#define SWEEP_S 0.25

/* ---- the loop ---- */

static void sweep(struct ev_loop *loop, ev_timer *timer, int events)
{
    ws_thread *thread = ev_userdata(loop);
    (void)timer, (void)events;
    thread->now_ns = ll_now_ns();
    for (int i = 0; i < thread->slots; i++)
        if (thread->slot[i] != NULL)
            ll_ws_viewer_sweep(thread->slot[i]);
}

static void close_stream(ll_ws_stream *stream, int code, const char *reason)
{
    stream->closing = true;
    for (ws_viewer *viewer = stream->first; viewer != NULL; viewer = viewer->next)
        ll_ws_viewer_close(viewer, code, reason);
    ll_ws_stream_release_if_done(stream);
}

static void run_command(ws_thread *thread, ws_command *command)
{
    ws_viewer *viewer = command->viewer != 0 ? ll_ws_viewer_of(thread, command->viewer) : NULL;
    bool present = viewer != NULL && viewer->stream != NULL;
    switch (command->kind) {
    case WS_COMMAND_ADOPT:
        ll_ws_adopt_viewer(thread, command);
        break;
    case WS_COMMAND_CLOSE_STREAM:
        close_stream(command->stream, command->code, (const char *)command->text);
        break;
    case WS_COMMAND_CLOSE:
        if (present)
            ll_ws_viewer_close(viewer, command->code, (const char *)command->text);
        break;
    case WS_COMMAND_HELLO:
        if (present) {
            ll_ws_viewer_hello(viewer, command);
            return;
        }
        break;
    case WS_COMMAND_PING:
        if (present)
            ll_ws_socket_measure(viewer);
        break;
    case WS_COMMAND_SUBSCRIBE:
        if (present)
            ll_ws_viewer_subscribe(viewer, &command->subscription);
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

static void clear_wake(struct ev_loop *loop, ev_io *event, int events)
{
    eventfd_t value;
    (void)loop, (void)events;
    eventfd_read(event->fd, &value);
}

/* Sleeps until a wake-up or `until_ns`. */
static void wait_until(ws_thread *thread, int64_t until_ns)
{
    struct pollfd event = {.fd = thread->event_fd, .events = POLLIN};
    struct timespec time = {.tv_nsec = until_ns - thread->now_ns};
    if (ppoll(&event, 1, &time, NULL) > 0)
        clear_wake(thread->loop, &thread->woken, 0);
}

bool ll_ws_thread_prepare(ws_thread *thread)
{
    thread->event_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    thread->loop = thread->event_fd >= 0 ? ev_loop_new(EVBACKEND_EPOLL | EVFLAG_NOENV) : NULL;
    if (thread->loop == NULL)
        return false;
    ev_set_userdata(thread->loop, thread);
    ev_io_init(&thread->woken, clear_wake, thread->event_fd, EV_READ);
    ev_io_start(thread->loop, &thread->woken);
    ev_timer_init(&thread->sweep, sweep, SWEEP_S, SWEEP_S);
    return true;
}

static void send_close_frame(ws_thread *thread)
{
    for (int i = 0; i < thread->slots; i++)
        if (thread->slot[i] != NULL && thread->slot[i]->stream != NULL)
            ll_ws_viewer_close(thread->slot[i], LL_WS_GOING_AWAY, "the daemon stops");
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
            close(command->fd);
            ll_connection_limiter_leave(thread->ws->connection_limiter, &command->pass);
        } else if (command->kind == WS_COMMAND_CLOSE_STREAM) {
            command->stream->closing = true;
            ll_ws_stream_release_if_done(command->stream);
        }
        free(command);
    }
    lws_context_destroy(thread->context); /* frees all viewers */
    thread->context = NULL;
    free(thread->slot);
    thread->slot = NULL;
    thread->slots = 0;
}

/* One turn, which waits for the first event. */
static void serve_sockets(ws_thread *thread)
{
    if (thread->sockets > 0)
        ev_timer_start(thread->loop, &thread->sweep);
    else
        ev_timer_stop(thread->loop, &thread->sweep);
    ev_run(thread->loop, EVRUN_ONCE);
}

void *ll_ws_thread_main(void *argument)
{
    ws_thread *thread = argument;
    int64_t due_ns = 0, end_ns = 0; /* of the next turn; of the thread */
    pthread_setname_np(pthread_self(), "stream");
    for (;;) {
        if (atomic_load(&thread->wake_pending))
            process_pending(thread);
        if (atomic_load(&thread->drain) && end_ns == 0) {
            send_close_frame(thread);
            end_ns = ll_now_ns() + (int64_t)(thread->ws->config.drain_s * 1e9);
        }
        thread->now_ns = ll_now_ns();
        if (end_ns != 0 && (thread->sockets == 0 || thread->now_ns >= end_ns))
            break;
        int64_t begin_ns = due_ns - (thread->sockets > FEW_SOCKETS ? 0 : AHEAD_NS);
        if (thread->now_ns < begin_ns) {
            wait_until(thread, begin_ns);
            continue;
        }
        due_ns = (due_ns > thread->now_ns ? due_ns : thread->now_ns) + TURN_NS;
        serve_sockets(thread);
    }
    finish(thread);
    return NULL;
}
