#include "daemon/listener/acceptor.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cjson/cJSON.h>

#include "daemon/listener/web_server.h"
#include "daemon/net/problem_json.h"
#include "daemon/net/proxies.h"
#include "threads/clock.h"

#define TICK_NS INT64_C(100000000) /* interval of deadline checks */
#define LINGER_NS                                                                                            \
    INT64_C(1000000000) /* after a refusal, so that the client can read it before the socket is closed */
#define MANY_PEEKS 32   /* a head with more segments than that is peeked at only once per tick */
#define NOTSENT_BYTES (16 * 1024)

/* A connection whose head is incomplete, or to which a refusal was sent. Both lists are ordered by
 * deadline. */
typedef struct pending_connection {
    struct pending_connection *next, *previous;
    struct pending_list *list;
    int fd;
    ll_connection_limiter_pass pass;
    struct sockaddr_storage address;
    socklen_t address_size;
    int64_t deadline_ns;
    int peeks;
} pending_connection;

typedef struct pending_list {
    pending_connection *first, *last;
} pending_list;

struct ll_acceptor {
    ll_web_server_config config;
    ll_allow allow;
    const ll_proxies *proxies;
    ll_connection_limiter *connection_limiter;
    ll_http *http;
    ll_ws *ws;
    int listener, epoll, event;
    char address[80];
    uint16_t port;
    pthread_t thread;
    bool started;
    atomic_bool close_listener, stop;
    atomic_bool listener_closed;
    pthread_mutex_t closed_lock;
    pthread_cond_t closed_there;
    atomic_ullong accepted, refused_total, refused_per_ip, refused_head;
    pending_list reading, lingering;
    int64_t pause_until_ns; /* accepting is paused: no descriptors were left */
    bool listening;         /* the listening socket is in the epoll set */
    char head[];            /* max_head_bytes + 1 */
};

/* ---- accepted connections ---- */

static void put(pending_list *list, pending_connection *a)
{
    a->list = list;
    a->next = NULL;
    a->previous = list->last;
    *(list->last != NULL ? &list->last->next : &list->first) = a;
    list->last = a;
}

static void take(pending_connection *a)
{
    pending_list *list = a->list;
    *(a->previous != NULL ? &a->previous->next : &list->first) = a->next;
    *(a->next != NULL ? &a->next->previous : &list->last) = a->previous;
}

static void drop(ll_acceptor *acceptor, pending_connection *a)
{
    take(a);
    close(a->fd); /* also removes it from epoll: it has no other reference */
    ll_connection_limiter_leave(acceptor->connection_limiter, &a->pass);
    free(a);
}

/* Sends a whole answer in one call. A fresh socket's buffer holds it; if not, the rest is dropped. */
static void send_problem(int fd, int status, const char *field, const char *detail)
{
    char answer[1024];
    ll_status error = ll_field_error(LL_BAD_INPUT, field, "%s", detail);
    cJSON *json = ll_http_problem_json(status, &error, NULL);
    char *body = json != NULL ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    if (body == NULL)
        return;
    int size = snprintf(answer, sizeof answer,
                        "HTTP/1.1 %d %s\r\nContent-Type: application/problem+json\r\nContent-Length: %zu\r\n"
                        "Connection: close\r\n%s\r\n%s",
                        status, ll_http_reason(status), strlen(body),
                        status == 503 || status == 429 ? "Retry-After: 5\r\n" : "", body);
    cJSON_free(body);
    if (size > 0 && (size_t)size < sizeof answer &&
        send(fd, answer, (size_t)size, MSG_NOSIGNAL | MSG_DONTWAIT) < 0)
        return; /* the client is gone; no answer possible */
}

/* Discards input that still arrives; closing with unread bytes would reset the connection and lose the
 * answer. */
static bool drain_input(int fd)
{
    char bytes[4096];
    ssize_t size;
    do {
        size = recv(fd, bytes, sizeof bytes, MSG_DONTWAIT);
    } while (size > 0);
    return size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

static void refuse(ll_acceptor *acceptor, pending_connection *a, int status, const char *field,
                   const char *detail)
{
    atomic_fetch_add(&acceptor->refused_head, 1);
    send_problem(a->fd, status, field, detail);
    shutdown(a->fd, SHUT_WR);
    if (drain_input(a->fd)) {
        drop(acceptor, a);
        return;
    }
    take(a);
    a->deadline_ns = ll_now_ns() + LINGER_NS;
    put(&acceptor->lingering, a);
}

static void hand_over(ll_acceptor *acceptor, pending_connection *a, const ll_upgrade *upgrade,
                      size_t head_size)
{
    pending_connection gone = *a;
    epoll_ctl(acceptor->epoll, EPOLL_CTL_DEL, a->fd, NULL);
    take(a);
    free(a);
    if (upgrade == NULL) {
        /* HTTP also takes over the pass of the connection limiter, and returns it when the connection
         * ends. */
        if (!ll_http_adopt(acceptor->http, gone.fd, (struct sockaddr *)&gone.address, gone.address_size))
            ll_connection_limiter_leave(acceptor->connection_limiter, &gone.pass);
        return;
    }
    /* The head was only peeked at; now exactly its bytes are read. */
    if (recv(gone.fd, acceptor->head, head_size, MSG_DONTWAIT) == (ssize_t)head_size) {
        ll_ws_adopt(acceptor->ws, upgrade, gone.fd, &gone.pass);
    } else {
        close(gone.fd);
        ll_connection_limiter_leave(acceptor->connection_limiter, &gone.pass);
    }
}

/* Routes a complete head: valid upgrades to the streams, all others, also invalid upgrades, to HTTP, which
 * alone checks queries. */
static void route(ll_acceptor *acceptor, pending_connection *a, const ll_head *head)
{
    ll_upgrade upgrade;
    int status;
    ll_status error = ll_upgrade_check(head, &acceptor->allow, &upgrade, &status);
    bool stream = !ll_failed(&error) && memchr(head->target.at, '?', head->target.size) == NULL &&
                  ll_ws_knows(acceptor->ws, &upgrade);
    hand_over(acceptor, a, stream ? &upgrade : NULL, head->size);
}

static void peek(ll_acceptor *acceptor, pending_connection *a)
{
    size_t limit = (size_t)acceptor->config.max_head_bytes;
    ssize_t size = recv(a->fd, acceptor->head, limit + 1, MSG_PEEK | MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR))
        return;
    if (size <= 0) {
        drop(acceptor, a);
        return;
    }
    ll_head head;
    char detail[100];
    switch (ll_head_parse(acceptor->head, (size_t)size, &head)) {
    case LL_HEAD_WHOLE:
        route(acceptor, a, &head);
        return;
    case LL_HEAD_INVALID:
        if (head.fault != NULL)
            refuse(acceptor, a, head.fault->status, head.fault->field, head.fault->text);
        else
            refuse(acceptor, a, 400, "", "not a request of HTTP/1.1");
        return;
    case LL_HEAD_VERSION:
        refuse(acceptor, a, 505, "", "HTTP version: must be 1.1");
        return;
    case LL_HEAD_PARTIAL:
        break;
    }
    if ((size_t)size > limit) {
        snprintf(detail, sizeof detail, "request head: must have at most %zu bytes (max_head_bytes)", limit);
        refuse(acceptor, a, 431, "", detail);
    } else if (++a->peeks == MANY_PEEKS) {
        /* Each peek copies the whole head, which would be quadratic for a client that sends a byte at a time:
         * from now on peek once per tick. */
        epoll_ctl(acceptor->epoll, EPOLL_CTL_MOD, a->fd,
                  &(struct epoll_event){.events = EPOLLET, .data.ptr = a});
    }
}

/* ---- the listener ---- */

static void listen_to(ll_acceptor *acceptor, bool on)
{
    if (acceptor->listener < 0 || acceptor->listening == on)
        return;
    acceptor->listening = on;
    struct epoll_event interest = {.events = EPOLLIN, .data.ptr = &acceptor->listener};
    epoll_ctl(acceptor->epoll, on ? EPOLL_CTL_ADD : EPOLL_CTL_DEL, acceptor->listener, &interest);
}

static void prepare(int fd)
{
    int on = 1, notsent = NOTSENT_BYTES;
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &on, sizeof on);
    /* Keeps unsent frames here, where the newest can be chosen, and not in the kernel. */
    setsockopt(fd, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &notsent, sizeof notsent);
}

static void refuse_at_connection_limiter(ll_acceptor *acceptor, int fd, ll_connection_limiter_answer answer)
{
    char detail[120];
    bool total = answer == LL_CONNECTION_LIMITER_FULL;
    atomic_fetch_add(total ? &acceptor->refused_total : &acceptor->refused_per_ip, 1);
    snprintf(detail, sizeof detail,
             total ? "limit of %lld connections reached (max_connections)"
                   : "limit of %lld connections of one address reached (max_connections_per_ip)",
             (long long)(total ? acceptor->config.max_connections : acceptor->config.max_connections_per_ip));
    send_problem(fd, total ? 503 : 429, "", detail);
    shutdown(fd, SHUT_WR);
    drain_input(fd); /* closes at once: clients over the limit get no more descriptors */
    close(fd);
}

static void admit(ll_acceptor *acceptor, int fd, const struct sockaddr_storage *address,
                  socklen_t address_size)
{
    ll_connection_limiter_pass pass = ll_proxies_pass(acceptor->proxies, (const struct sockaddr *)address);
    ll_connection_limiter_answer answer = ll_connection_limiter_enter(acceptor->connection_limiter, &pass);
    if (answer != LL_CONNECTION_LIMITER_OPEN) {
        refuse_at_connection_limiter(acceptor, fd, answer);
        return;
    }
    pending_connection *a = calloc(1, sizeof *a);
    if (a == NULL) {
        close(fd);
        ll_connection_limiter_leave(acceptor->connection_limiter, &pass);
        return;
    }
    prepare(fd);
    a->fd = fd;
    a->pass = pass;
    a->address = *address;
    a->address_size = address_size;
    a->deadline_ns = ll_now_ns() + (int64_t)(acceptor->config.head_timeout_s * 1e9);
    put(&acceptor->reading, a);
    struct epoll_event interest = {.events = EPOLLIN | EPOLLRDHUP | EPOLLET, .data.ptr = a};
    if (epoll_ctl(acceptor->epoll, EPOLL_CTL_ADD, fd, &interest) != 0)
        drop(acceptor, a);
}

static void accept_connections(ll_acceptor *acceptor)
{
    for (int i = 0; i < 64; i++) {
        struct sockaddr_storage address = {0};
        socklen_t size = sizeof address;
        int fd =
            accept4(acceptor->listener, (struct sockaddr *)&address, &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd >= 0) {
            atomic_fetch_add(&acceptor->accepted, 1);
            admit(acceptor, fd, &address, size);
        } else if (errno == EMFILE || errno == ENFILE || errno == ENOMEM || errno == ENOBUFS) {
            /* The listener stays readable: without a pause this would spin. */
            listen_to(acceptor, false);
            acceptor->pause_until_ns = ll_now_ns() + TICK_NS;
            return;
        } else if (errno != EINTR && errno != ECONNABORTED) {
            return;
        }
    }
}

/* ---- the thread ---- */

static void drop_all(ll_acceptor *acceptor, pending_list *list)
{
    while (list->first != NULL)
        drop(acceptor, list->first);
}

static void shut_listener(ll_acceptor *acceptor)
{
    listen_to(acceptor, false);
    close(acceptor->listener);
    acceptor->listener = -1;
    drop_all(acceptor, &acceptor->reading);
    pthread_mutex_lock(&acceptor->closed_lock);
    atomic_store(&acceptor->listener_closed, true);
    pthread_cond_broadcast(&acceptor->closed_there);
    pthread_mutex_unlock(&acceptor->closed_lock);
}

static void tick(ll_acceptor *acceptor)
{
    int64_t now = ll_now_ns();
    char detail[100];
    if (acceptor->pause_until_ns != 0 && now >= acceptor->pause_until_ns) {
        acceptor->pause_until_ns = 0;
        listen_to(acceptor, true);
    }
    while (acceptor->reading.first != NULL && acceptor->reading.first->deadline_ns <= now) {
        snprintf(detail, sizeof detail, "request head not complete after %g s (head_timeout_s)",
                 acceptor->config.head_timeout_s);
        refuse(acceptor, acceptor->reading.first, 408, "", detail);
    }
    for (pending_connection *a = acceptor->reading.first, *next; a != NULL; a = next) {
        next = a->next;
        if (a->peeks >= MANY_PEEKS)
            peek(acceptor, a);
    }
    while (acceptor->lingering.first != NULL && acceptor->lingering.first->deadline_ns <= now)
        drop(acceptor, acceptor->lingering.first);
    ll_http_watch(acceptor->http, now);
}

static void on_socket(ll_acceptor *acceptor, pending_connection *a)
{
    if (a->list == &acceptor->reading)
        peek(acceptor, a);
    else if (drain_input(a->fd))
        drop(acceptor, a);
}

static void *acceptor_main(void *argument)
{
    ll_acceptor *acceptor = argument;
    pthread_setname_np(pthread_self(), "acceptor");
    struct epoll_event events[128];
    int64_t next_tick = ll_now_ns() + TICK_NS;
    listen_to(acceptor, true);
    while (!atomic_load(&acceptor->stop)) {
        int count = epoll_wait(acceptor->epoll, events, 128, (int)(TICK_NS / 1000000));
        /* Each socket has one event in a batch, so closing one cannot invalidate a later event. */
        for (int i = 0; i < count; i++) {
            void *about = events[i].data.ptr;
            if (about == &acceptor->listener) {
                if (acceptor->listening)
                    accept_connections(acceptor);
            } else if (about == &acceptor->event) {
                eventfd_t value;
                eventfd_read(acceptor->event, &value);
            } else {
                on_socket(acceptor, about);
            }
        }
        if (atomic_load(&acceptor->close_listener) && acceptor->listener >= 0)
            shut_listener(acceptor);
        if (ll_now_ns() >= next_tick) {
            next_tick = ll_now_ns() + TICK_NS;
            tick(acceptor);
        }
    }
    drop_all(acceptor, &acceptor->reading);
    drop_all(acceptor, &acceptor->lingering);
    return NULL;
}

/* ---- start and stop ---- */

/* `host:port`, `[host6]:port` or `:port`. */
static bool split_address(const char *text, char host[128], char port[8])
{
    const char *colon = strrchr(text, ':');
    size_t length = colon != NULL ? (size_t)(colon - text) : 0;
    if (colon == NULL || length >= 128 || strlen(colon + 1) > 5 || colon[1] == '\0' ||
        strspn(colon + 1, "0123456789") != strlen(colon + 1) || atoi(colon + 1) > 65535)
        return false;
    bool brackets = length >= 2 && text[0] == '[' && text[length - 1] == ']';
    snprintf(host, 128, "%.*s", (int)(length - (brackets ? 2 : 0)), text + (brackets ? 1 : 0));
    snprintf(port, 8, "%s", colon + 1);
    return brackets || strchr(host, ':') == NULL;
}

static int listen_on(const struct addrinfo *info)
{
    int fd = socket(info->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), on = 1;
    if (fd < 0)
        return -1;
    setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    if (bind(fd, info->ai_addr, info->ai_addrlen) != 0 || listen(fd, 1024) != 0) {
        int error = errno;
        close(fd);
        errno = error;
        return -1;
    }
    return fd;
}

static ll_status bind_listener(ll_acceptor *acceptor)
{
    const char *text = acceptor->config.listen;
    char host[128], port[8];
    if (!split_address(text, host, port)) {
        return ll_field_error(LL_BAD_INPUT, "listen",
                              "listen: must be ADDR:PORT or [ADDR6]:PORT with a port of 0 to 65535: %s",
                              text);
    }
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE | AI_NUMERICSERV},
                    *found = NULL;
    int failed = getaddrinfo(host[0] != '\0' ? host : NULL, port, &hints, &found);
    if (failed != 0)
        return ll_field_error(LL_BAD_INPUT, "listen", "cannot listen on %s: %s", text, gai_strerror(failed));
    errno = 0;
    for (const struct addrinfo *info = found; info != NULL && acceptor->listener < 0; info = info->ai_next)
        acceptor->listener = listen_on(info);
    freeaddrinfo(found);
    if (acceptor->listener < 0)
        return ll_field_error(LL_IO, "listen", "cannot listen on %s: %s", text, strerror(errno));
    return ll_ok();
}

static void read_address(ll_acceptor *acceptor)
{
    struct sockaddr_storage address = {0};
    socklen_t size = sizeof address;
    char text[INET6_ADDRSTRLEN] = "?";
    getsockname(acceptor->listener, (struct sockaddr *)&address, &size);
    if (address.ss_family == AF_INET6) {
        const struct sockaddr_in6 *in = (const void *)&address;
        acceptor->port = ntohs(in->sin6_port);
        inet_ntop(AF_INET6, &in->sin6_addr, text, sizeof text);
        snprintf(acceptor->address, sizeof acceptor->address, "[%s]:%u", text, acceptor->port);
    } else {
        const struct sockaddr_in *in = (const void *)&address;
        acceptor->port = ntohs(in->sin_port);
        inet_ntop(AF_INET, &in->sin_addr, text, sizeof text);
        snprintf(acceptor->address, sizeof acceptor->address, "%s:%u", text, acceptor->port);
    }
}

ll_status ll_acceptor_listen(const ll_web_server_config *config, int inherited, ll_acceptor **result)
{
    ll_acceptor *acceptor = calloc(1, sizeof *acceptor + (size_t)config->max_head_bytes + 1);
    if (acceptor == NULL) {
        if (inherited >= 0)
            close(inherited);
        return ll_error(LL_NO_MEMORY, "out of memory: listener");
    }
    acceptor->config = *config;
    acceptor->listener = inherited;
    pthread_mutex_init(&acceptor->closed_lock, NULL);
    pthread_cond_init(&acceptor->closed_there, NULL);
    acceptor->epoll = epoll_create1(EPOLL_CLOEXEC);
    acceptor->event = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    struct epoll_event interest = {.events = EPOLLIN, .data.ptr = &acceptor->event};
    ll_status status = ll_ok();
    if (acceptor->epoll < 0 || acceptor->event < 0 ||
        epoll_ctl(acceptor->epoll, EPOLL_CTL_ADD, acceptor->event, &interest) != 0)
        status = ll_error(LL_IO, "cannot create the listener's event queue: %s", strerror(errno));
    else if (inherited < 0)
        status = bind_listener(acceptor);
    if (ll_failed(&status)) {
        ll_acceptor_stop(acceptor);
        return status;
    }
    read_address(acceptor);
    *result = acceptor;
    return status;
}

ll_status ll_acceptor_start(ll_acceptor *acceptor, const ll_allow *allow, const ll_proxies *proxies,
                            ll_connection_limiter *connection_limiter, ll_http *http, ll_ws *ws)
{
    acceptor->allow = *allow;
    acceptor->proxies = proxies;
    acceptor->connection_limiter = connection_limiter;
    acceptor->http = http;
    acceptor->ws = ws;
    acceptor->started = pthread_create(&acceptor->thread, NULL, acceptor_main, acceptor) == 0;
    return acceptor->started ? ll_ok() : ll_error(LL_IO, "cannot start listener thread");
}

const char *ll_acceptor_address(const ll_acceptor *acceptor)
{
    return acceptor->address;
}

uint16_t ll_acceptor_port(const ll_acceptor *acceptor)
{
    return acceptor->port;
}

ll_acceptor_counts ll_acceptor_get_counts(ll_acceptor *acceptor)
{
    return (ll_acceptor_counts){atomic_load(&acceptor->accepted), atomic_load(&acceptor->refused_total),
                                atomic_load(&acceptor->refused_per_ip), atomic_load(&acceptor->refused_head)};
}

void ll_acceptor_close_listener(ll_acceptor *acceptor)
{
    atomic_store(&acceptor->close_listener, true);
    eventfd_write(acceptor->event, 1);
    pthread_mutex_lock(&acceptor->closed_lock);
    while (acceptor->started && !atomic_load(&acceptor->listener_closed))
        pthread_cond_wait(&acceptor->closed_there, &acceptor->closed_lock);
    pthread_mutex_unlock(&acceptor->closed_lock);
}

void ll_acceptor_stop(ll_acceptor *acceptor)
{
    if (acceptor->started) {
        atomic_store(&acceptor->stop, true);
        eventfd_write(acceptor->event, 1);
        pthread_join(acceptor->thread, NULL);
    }
    if (acceptor->listener >= 0)
        close(acceptor->listener);
    if (acceptor->epoll >= 0)
        close(acceptor->epoll);
    if (acceptor->event >= 0)
        close(acceptor->event);
    pthread_mutex_destroy(&acceptor->closed_lock);
    pthread_cond_destroy(&acceptor->closed_there);
    free(acceptor);
}
