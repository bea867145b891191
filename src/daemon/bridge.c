#include "daemon/bridge.h"

#include <errno.h>
#include <fcntl.h>
#include <libwebsockets.h>
#include <microhttpd.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include "base/assert.h"
#include "daemon/gate.h"
#include "daemon/upgrade.h"

#define PIPE_BYTES (16 * 1024)
#define LINGER_TURNS 20 /* of 50 ms: how long a client may take to hang up after the stream did */

/* Bytes on their way in one direction. */
typedef struct pipe_buffer {
    size_t begin, end;
    bool eof;    /* the source is at its end */
    bool passed; /* and the sink was told */
    char bytes[PIPE_BYTES];
} pipe_buffer;

typedef struct relay {
    ll_bridge *bridge;
    struct relay *next, *previous;
    struct MHD_UpgradeResponseHandle *handle;
    int client, stream; /* libmicrohttpd's socket; our end of the pair */
    bool swallowed;     /* the stream side's own 101 is past */
    bool broken;
    int lingering;
    pipe_buffer up, down; /* client to stream, stream to client */
} relay;

struct ll_bridge {
    ll_ws *ws;
    atomic_ullong count;
    pthread_mutex_t lock; /* of `arrived`, `running`, `stopping` */
    relay *arrived;
    bool running, stopping;
    pthread_t thread;
    int epoll, event;
    relay *first; /* the thread only */
};

struct ll_bridge_offer {
    ll_bridge *bridge;
    ll_upgrade upgrade;
};

ll_bridge *ll_bridge_new(ll_ws *ws)
{
    ll_bridge *bridge = calloc(1, sizeof *bridge);
    if (bridge == NULL) {
        return NULL;
    }
    bridge->ws = ws;
    bridge->epoll = epoll_create1(EPOLL_CLOEXEC);
    bridge->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&bridge->lock, NULL);
    struct epoll_event interest = {.events = EPOLLIN, .data.ptr = NULL};
    if (bridge->epoll < 0 || bridge->event < 0 ||
        epoll_ctl(bridge->epoll, EPOLL_CTL_ADD, bridge->event, &interest) != 0) {
        ll_bridge_free(bridge);
        return NULL;
    }
    return bridge;
}

uint64_t ll_bridge_count(ll_bridge *bridge)
{
    return atomic_load(&bridge->count);
}

/* ---- relaying ---- */

/* Both return whether anything moved. */
static bool fill(relay *r, int from, pipe_buffer *pipe)
{
    bool moved = false;
    while (!pipe->eof && pipe->end < PIPE_BYTES) {
        ssize_t size = recv(from, pipe->bytes + pipe->end, PIPE_BYTES - pipe->end, MSG_DONTWAIT);
        if (size > 0) {
            pipe->end += (size_t)size;
            moved = true;
        } else if (size == 0) {
            pipe->eof = true;
        } else if (errno != EINTR) {
            r->broken = r->broken || (errno != EAGAIN && errno != EWOULDBLOCK);
            break;
        }
    }
    return moved;
}

static bool drain(relay *r, pipe_buffer *pipe, int to)
{
    bool moved = false;
    while (pipe->begin < pipe->end) {
        ssize_t size =
            send(to, pipe->bytes + pipe->begin, pipe->end - pipe->begin, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (size > 0) {
            pipe->begin += (size_t)size;
            moved = true;
        } else if (errno != EINTR) {
            r->broken = r->broken || (errno != EAGAIN && errno != EWOULDBLOCK);
            return moved;
        }
    }
    pipe->begin = pipe->end = 0;
    if (pipe->eof && !pipe->passed) {
        pipe->passed = true;
        shutdown(to, SHUT_WR);
    }
    return moved;
}

/* libmicrohttpd has sent the 101 that the client sees; the stream side writes its own, which ends here. */
static void swallow(relay *r)
{
    pipe_buffer *pipe = &r->down;
    char *end = memmem(pipe->bytes, pipe->end, "\r\n\r\n", 4);
    if (end != NULL) {
        r->swallowed = true;
        pipe->begin = (size_t)(end + 4 - pipe->bytes);
    } else if (pipe->eof || pipe->end == PIPE_BYTES) {
        r->broken = true;
    }
}

/* Both sockets are edge-triggered: a turn goes on until nothing moves. */
static void turn(relay *r)
{
    bool moved;
    do {
        moved = fill(r, r->client, &r->up);
        moved = drain(r, &r->up, r->stream) || moved;
        moved = fill(r, r->stream, &r->down) || moved;
        if (!r->swallowed) {
            swallow(r);
        }
        if (r->swallowed) {
            moved = drain(r, &r->down, r->client) || moved;
        }
    } while (moved && !r->broken);
}

static bool is_over(relay *r)
{
    bool both = r->up.passed && r->down.passed;
    return r->broken || both || (r->down.passed && ++r->lingering > LINGER_TURNS);
}

static void end_relay(relay *r)
{
    ll_bridge *bridge = r->bridge;
    *(r->previous != NULL ? &r->previous->next : &bridge->first) = r->next;
    if (r->next != NULL) {
        r->next->previous = r->previous;
    }
    epoll_ctl(bridge->epoll, EPOLL_CTL_DEL, r->client, NULL);
    epoll_ctl(bridge->epoll, EPOLL_CTL_DEL, r->stream, NULL);
    close(r->stream);
    MHD_upgrade_action(r->handle, MHD_UPGRADE_ACTION_CLOSE);
    free(r);
}

static void take_arrived(ll_bridge *bridge)
{
    eventfd_t value;
    eventfd_read(bridge->event, &value);
    pthread_mutex_lock(&bridge->lock);
    relay *arrived = bridge->arrived;
    bridge->arrived = NULL;
    pthread_mutex_unlock(&bridge->lock);
    while (arrived != NULL) {
        relay *r = arrived;
        arrived = r->next;
        r->next = bridge->first;
        r->previous = NULL;
        if (r->next != NULL) {
            r->next->previous = r;
        }
        bridge->first = r;
        struct epoll_event interest = {.events = EPOLLIN | EPOLLOUT | EPOLLRDHUP | EPOLLET, .data.ptr = r};
        if (epoll_ctl(bridge->epoll, EPOLL_CTL_ADD, r->client, &interest) != 0 ||
            epoll_ctl(bridge->epoll, EPOLL_CTL_ADD, r->stream, &interest) != 0) {
            r->broken = true;
        }
        turn(r); /* what came before the sockets were watched */
    }
}

/* Relays that are over are only freed after all events of a batch were looked at: two of them may name the
 * same relay. */
static void *bridge_main(void *argument)
{
    ll_bridge *bridge = argument;
    pthread_setname_np(pthread_self(), "bridge");
    struct epoll_event events[64];
    for (;;) {
        bool linger = false;
        for (relay *r = bridge->first, *next; r != NULL; r = next) {
            next = r->next;
            if (is_over(r)) {
                end_relay(r);
            } else {
                linger = linger || r->down.passed;
            }
        }
        int count = epoll_wait(bridge->epoll, events, 64, linger ? 50 : -1);
        for (int i = 0; i < count; i++) {
            if (events[i].data.ptr != NULL) {
                turn(events[i].data.ptr);
            }
        }
        take_arrived(bridge);
        pthread_mutex_lock(&bridge->lock);
        bool stop = bridge->stopping;
        pthread_mutex_unlock(&bridge->lock);
        if (stop) {
            break;
        }
    }
    while (bridge->first != NULL) {
        end_relay(bridge->first);
    }
    return NULL;
}

/* ---- arriving ---- */

/* Puts a relay that is complete under the thread's eyes; false when the bridge stops. */
static bool register_relay(relay *r)
{
    ll_bridge *bridge = r->bridge;
    pthread_mutex_lock(&bridge->lock);
    if (!bridge->running && !bridge->stopping) {
        bridge->running = pthread_create(&bridge->thread, NULL, bridge_main, bridge) == 0;
    }
    bool taken = bridge->running && !bridge->stopping;
    if (taken) {
        r->next = bridge->arrived;
        bridge->arrived = r;
    }
    pthread_mutex_unlock(&bridge->lock);
    if (taken) {
        eventfd_write(bridge->event, 1);
    }
    return taken;
}

static void on_upgrade(void *closure, struct MHD_Connection *connection, void *context, const char *extra,
                       size_t extra_size, MHD_socket socket, struct MHD_UpgradeResponseHandle *handle)
{
    ll_bridge_offer *offer = closure;
    ll_bridge *bridge = offer->bridge;
    (void)connection, (void)context;
    relay *r = calloc(1, sizeof *r);
    int pair[2];
    if (r == NULL || extra_size > PIPE_BYTES ||
        socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair) != 0) {
        free(r);
        MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
        return;
    }
    /* Small, so that a slow client is felt by the stream side soon. */
    int buffer = PIPE_BYTES;
    setsockopt(pair[0], SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    setsockopt(pair[1], SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    r->bridge = bridge;
    r->handle = handle;
    r->client = socket;
    r->stream = pair[0];
    r->up.end = extra_size;
    memcpy(r->up.bytes, extra, extra_size);
    if (!register_relay(r)) {
        close(pair[0]);
        close(pair[1]);
        free(r);
        MHD_upgrade_action(handle, MHD_UPGRADE_ACTION_CLOSE);
        return;
    }
    atomic_fetch_add(&bridge->count, 1);
    /* Not counted by the gate: the client's own connection is. */
    ll_ws_adopt(bridge->ws, &offer->upgrade, pair[1], &(ll_gate_pass){.valid = false});
}

/* RFC 6455 4.2.2: the SHA-1 of the key and a fixed text. */
static bool accept_key(const char *key, char accept[32])
{
    char text[64];
    unsigned char digest[20];
    int size = snprintf(text, sizeof text, "%s258EAFA5-E914-47DA-95CA-C5AB0DC85B11", key);
    lws_SHA1((unsigned char *)text, (size_t)size, digest);
    return lws_b64_encode_string((const char *)digest, 20, accept, 32) > 0;
}

struct MHD_Response *ll_bridge_response(ll_bridge *bridge, const ll_upgrade *upgrade, ll_bridge_offer **offer)
{
    char accept[32];
    *offer = NULL;
    pthread_mutex_lock(&bridge->lock);
    bool open = !bridge->stopping;
    pthread_mutex_unlock(&bridge->lock);
    ll_bridge_offer *made = open && accept_key(upgrade->key, accept) ? malloc(sizeof *made) : NULL;
    if (made == NULL) {
        return NULL;
    }
    *made = (ll_bridge_offer){.bridge = bridge, .upgrade = *upgrade};
    struct MHD_Response *response = MHD_create_response_for_upgrade(on_upgrade, made);
    if (response == NULL || MHD_add_response_header(response, "Upgrade", "websocket") == MHD_NO ||
        MHD_add_response_header(response, "Sec-WebSocket-Accept", accept) == MHD_NO ||
        MHD_add_response_header(response, "Sec-WebSocket-Protocol", ll_stream_protocols[upgrade->format]) ==
            MHD_NO) {
        if (response != NULL) {
            MHD_destroy_response(response);
        }
        free(made);
        return NULL;
    }
    *offer = made;
    return response;
}

void ll_bridge_forget(ll_bridge_offer *offer)
{
    free(offer);
}

/* ---- the end ---- */

void ll_bridge_stop(ll_bridge *bridge)
{
    pthread_mutex_lock(&bridge->lock);
    bool running = bridge->running;
    bridge->stopping = true;
    pthread_mutex_unlock(&bridge->lock);
    if (running) {
        eventfd_write(bridge->event, 1);
        pthread_join(bridge->thread, NULL);
        bridge->running = false;
    }
}

void ll_bridge_free(ll_bridge *bridge)
{
    if (bridge == NULL) {
        return;
    }
    LL_ASSERT(!bridge->running && bridge->first == NULL);
    if (bridge->epoll >= 0) {
        close(bridge->epoll);
    }
    if (bridge->event >= 0) {
        close(bridge->event);
    }
    pthread_mutex_destroy(&bridge->lock);
    free(bridge);
}
