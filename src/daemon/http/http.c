/* libmicrohttpd's callbacks: connections and their watchdog, bodies. */
#include "daemon/http/http.h"

#include <errno.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "base/hash.h"
#include "daemon/http/internal.h"
#include "daemon/net/problem_json.h"

/* ---- connections and their watchdog ---- */

static http_connection *watched_of(struct MHD_Connection *connection)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_SOCKET_CONTEXT);
    return info != NULL ? info->socket_context : NULL;
}

static http_connection *watch_connection(ll_http *http, struct MHD_Connection *connection)
{
    http_connection *watched = calloc(1, sizeof *watched);
    if (watched == NULL)
        return NULL;
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
    const struct sockaddr *address = info != NULL ? info->client_addr : NULL;
    watched->http = http;
    watched->pass = ll_proxies_pass(http->proxies, address);
    watched->proxied = watched->pass.many;
    ll_proxies_peer(address, watched->peer);
    info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    watched->fd = info->connect_fd;
    ll_http_set_deadline(watched, http->config.head_timeout_s);
    pthread_mutex_lock(&http->watch_lock);
    watched->next = http->first;
    if (http->first != NULL)
        http->first->previous = watched;
    http->first = watched;
    pthread_mutex_unlock(&http->watch_lock);
    return watched;
}

/* Called before the library closes the socket: as long as the lock is held, a descriptor in the list still
 * belongs to its connection. */
static void forget_connection(http_connection *watched)
{
    ll_http *http = watched->http;
    pthread_mutex_lock(&http->watch_lock);
    *(watched->previous != NULL ? &watched->previous->next : &http->first) = watched->next;
    if (watched->next != NULL)
        watched->next->previous = watched->previous;
    pthread_mutex_unlock(&http->watch_lock);
    ll_connection_limiter_leave(http->connection_limiter, &watched->pass);
    free(watched);
}

static void on_connection(void *closure, struct MHD_Connection *connection, void **context,
                          enum MHD_ConnectionNotificationCode code)
{
    ll_http *http = closure;
    if (code == MHD_CONNECTION_NOTIFY_STARTED) {
        *context = watch_connection(http, connection);
    } else if (*context != NULL) {
        forget_connection(*context);
        *context = NULL;
    }
}

/* Also true for a half-closed connection, which cannot be distinguished. */
static bool has_hung_up(int fd)
{
    struct pollfd p = {.fd = fd, .events = POLLRDHUP};
    return poll(&p, 1, 0) > 0 && (p.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
}

static bool has_disconnected(int fd)
{
    char byte;
    return recv(fd, &byte, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

/* libmicrohttpd's timeout counts from the last byte, so that one byte at a time would hold a connection
 * without limit. It also misses a FIN that came together with the last request; this checks for both from
 * time to time. */
void ll_http_watch(ll_http *http, int64_t now_ns)
{
    pthread_mutex_lock(&http->watch_lock);
    bool check = http->watch_turn++ % 8 == 0;
    for (http_connection *watched = http->first; watched != NULL; watched = watched->next) {
        if (watched->task != NULL && has_hung_up(watched->fd))
            ll_task_stop(watched->task, LL_TASK_CLIENT_GONE);
        int64_t deadline = atomic_load_explicit(&watched->deadline_ns, memory_order_relaxed);
        bool late = deadline != 0 && now_ns > deadline;
        if (late || (check && atomic_load_explicit(&watched->idle, memory_order_relaxed) &&
                     has_disconnected(watched->fd))) {
            shutdown(watched->fd, SHUT_RDWR);
            atomic_store_explicit(&watched->deadline_ns, 0, memory_order_relaxed);
            atomic_fetch_add(&http->cut, late);
        }
    }
    pthread_mutex_unlock(&http->watch_lock);
}

/* ---- exchanges ---- */

static bool is_request_id(const char *id)
{
    size_t length = strlen(id);
    return length >= 1 && length <= 64 &&
           strspn(id, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") == length;
}

static void name_request(http_exchange *exchange)
{
    ll_http *http = exchange->http;
    const char *given = ll_http_header(&exchange->request, "X-Request-Id");
    if (given != NULL && is_request_id(given)) {
        snprintf(exchange->request.id, sizeof exchange->request.id, "%s", given);
    } else {
        uint64_t serial = atomic_fetch_add_explicit(&http->request_serial, 1, memory_order_relaxed);
        snprintf(exchange->request.id, sizeof exchange->request.id, "%016llx",
                 (unsigned long long)ll_hash_u64(http->request_seed, serial));
    }
}

/* What a trusted proxy says of its client. A host that the header Host may not have is one that the client
 * wrote and the proxy passed on. */
static void name_client(http_exchange *exchange)
{
    ll_http_request *request = &exchange->request;
    const char *clients = ll_http_header(request, "X-Forwarded-For");
    ll_proxies_client(exchange->http->proxies, clients != NULL ? clients : "", request->peer);
    const char *proto = ll_http_header(request, "X-Forwarded-Proto");
    const char *host = ll_http_header(request, "X-Forwarded-Host");
    request->tls = proto != NULL && strcasecmp(proto, "https") == 0;
    if (host != NULL && ll_allow_host(&exchange->http->allow, (ll_text){host, strlen(host)}))
        request->host = host;
}

/* Splits a target in absolute form (RFC 9112 3.2.2): its host counts, and the header Host does not. `url` is
 * decoded; ll_target_fault has refused hosts with a `%`. */
static bool set_target(http_exchange *exchange, const char *url)
{
    size_t scheme = strncasecmp(url, "http://", 7) == 0 ? 7 : strncasecmp(url, "https://", 8) == 0 ? 8 : 0;
    size_t host = scheme != 0 ? strcspn(url + scheme, "/") : 0;
    const char *path = host == 0 ? url : url[scheme + host] == '/' ? url + scheme + host : "/";
    exchange->host = ll_http_header(&exchange->request, "Host");
    exchange->path = strdup(path);
    exchange->parameters = malloc(strlen(path) + 1);
    if (host != 0)
        exchange->host = exchange->authority = strndup(url + scheme, host);
    return exchange->path != NULL && exchange->parameters != NULL && (host == 0 || exchange->host != NULL);
}

static void free_exchange(http_exchange *exchange)
{
    free(exchange->body);
    free(exchange->parameters);
    free(exchange->path);
    free(exchange->authority);
    for (http_value *value = exchange->values, *next; value != NULL; value = next) {
        next = value->next;
        free(value);
    }
    free(exchange);
}

static http_exchange *new_exchange(ll_http *http, struct MHD_Connection *connection, const char *url,
                                   const char *method)
{
    http_exchange *exchange = calloc(1, sizeof *exchange);
    if (exchange == NULL)
        return NULL;
    exchange->http = http;
    exchange->connection = connection;
    exchange->watched = watched_of(connection);
    exchange->begin_ns = ll_now_ns();
    exchange->request.impl = exchange;
    if (!set_target(exchange, url)) {
        free_exchange(exchange);
        return NULL;
    }
    exchange->head = strcmp(method, "HEAD") == 0;
    exchange->request.method = exchange->head ? "GET" : method;
    exchange->request.head = exchange->head;
    exchange->request.path = exchange->path;
    exchange->request.body = "";
    exchange->request.host = exchange->host;
    exchange->response.status = 200;
    if (exchange->watched != NULL) {
        memcpy(exchange->request.peer, exchange->watched->peer, sizeof exchange->request.peer);
        exchange->request.proxied = exchange->watched->proxied;
        if (exchange->request.proxied)
            name_client(exchange);
    }
    name_request(exchange);
    atomic_fetch_add_explicit(&http->requests, 1, memory_order_relaxed);
    return exchange;
}

static void on_completed(void *closure, struct MHD_Connection *connection, void **context,
                         enum MHD_RequestTerminationCode code)
{
    ll_http *http = closure;
    http_exchange *exchange = *context;
    http_connection *watched = watched_of(connection);
    (void)code;
    *context = NULL;
    if (watched != NULL && (exchange == NULL || !exchange->upgraded)) {
        ll_http_set_deadline(watched, http->config.idle_timeout_s);
        atomic_store_explicit(&watched->idle, true, memory_order_relaxed);
    }
    if (exchange == NULL)
        return;
    if (http->app.done != NULL) {
        http->app.done(http->app.context, &exchange->request, exchange->route, exchange->response.status,
                       (double)(ll_now_ns() - exchange->begin_ns) * 1e-9);
    }
    atomic_fetch_sub(&http->answer_bytes, exchange->counted);
    ll_http_clear(&exchange->response);
    free_exchange(exchange);
}

/* All earlier requests of the connection have been answered. The library continues with the head and may fail
 * on it; no handler gets it. */
static void refuse_target(http_connection *watched, const char *fault)
{
    char answer[640];
    ll_status error = ll_error(LL_BAD_INPUT, "%s", fault);
    cJSON *json = ll_http_problem_json(400, &error, NULL);
    char *body = json != NULL ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    watched->faulty = true;
    int size = body == NULL
                   ? 0
                   : snprintf(answer, sizeof answer,
                              "HTTP/1.1 400 Bad Request\r\nContent-Type: application/problem+json\r\n"
                              "Content-Length: %zu\r\nConnection: close\r\n\r\n%s",
                              strlen(body), body);
    cJSON_free(body);
    if (size > 0 && (size_t)size < sizeof answer) {
        ssize_t sent = send(watched->fd, answer, (size_t)size, MSG_NOSIGNAL | MSG_DONTWAIT);
        (void)sent; /* the client is gone; no answer possible */
    }
    shutdown(watched->fd, SHUT_WR);
}

/* The first line of a request has arrived: starts the deadline of its head. */
static void *on_request_line(void *closure, const char *uri, struct MHD_Connection *connection)
{
    ll_http *http = closure;
    http_connection *watched = watched_of(connection);
    if (watched != NULL) {
        const char *fault = uri != NULL ? ll_target_fault(uri) : NULL;
        if (fault != NULL)
            refuse_target(watched, fault);
        watched->target_end = uri != NULL ? (uintptr_t)uri + strlen(uri) : 0;
        ll_http_set_deadline(watched, http->config.head_timeout_s);
        atomic_store_explicit(&watched->idle, false, memory_order_relaxed);
    }
    return NULL;
}

static void take_body(http_exchange *exchange, const char *bytes, size_t size)
{
    ll_http_request *request = &exchange->request;
    if (exchange->refused) {
        exchange->swallowed += size;
        return;
    }
    if (request->body_size + size > exchange->body_limit) {
        ll_http_refuse(exchange, 413, LL_LIMIT, "", "body: must have at most %zu bytes",
                       exchange->body_limit);
        exchange->refused = true;
        return;
    }
    if (request->body_size + size + 1 > exchange->body_capacity) {
        size_t capacity = 2 * (request->body_size + size) + 256;
        char *grown = realloc(exchange->body, capacity);
        if (grown == NULL) {
            exchange->response.failed = true;
            exchange->refused = true;
            return;
        }
        exchange->body = grown;
        exchange->body_capacity = capacity;
    }
    memcpy(exchange->body + request->body_size, bytes, size);
    request->body_size += size;
    exchange->body[request->body_size] = '\0';
}

/* Whether to refuse before the body has arrived: its sender waits for 100-continue (Expect), or the body is
 * too large to read and discard. */
static bool answer_early(const http_exchange *exchange)
{
    const char *length = ll_http_header(&exchange->request, "Content-Length");
    return exchange->ambiguous ||
           (exchange->refused && (ll_http_header(&exchange->request, "Expect") != NULL ||
                                  (length != NULL && strtoull(length, NULL, 10) > HTTP_SWALLOW)));
}

static bool has_body(const http_exchange *exchange)
{
    return ll_http_header(&exchange->request, "Content-Length") != NULL ||
           ll_http_header(&exchange->request, "Transfer-Encoding") != NULL;
}

static void set_idle(http_exchange *exchange, bool idle)
{
    if (exchange->watched != NULL)
        atomic_store_explicit(&exchange->watched->idle, idle, memory_order_relaxed);
}

static enum MHD_Result on_request(void *closure, struct MHD_Connection *connection, const char *url,
                                  const char *method, const char *version, const char *upload,
                                  size_t *upload_size, void **context)
{
    ll_http *http = closure;
    http_exchange *exchange = *context;
    if (exchange == NULL) {
        const http_connection *watched = watched_of(connection);
        if (watched != NULL && watched->faulty)
            return MHD_NO;
        exchange = *context = new_exchange(http, connection, url, method);
        if (exchange == NULL)
            return MHD_NO;
        ll_http_begin(exchange, method, version);
        if (exchange->upgraded)
            return MHD_NO;
        ll_http_deadline(exchange, http->config.body_timeout_s);
        if (answer_early(exchange))
            return ll_http_send(exchange);
        set_idle(exchange, has_body(exchange)); /* do not wait for a client that disconnects meanwhile */
        return MHD_YES;
    }
    if (exchange->phase == HTTP_BODY && *upload_size > 0) {
        take_body(exchange, upload, *upload_size);
        *upload_size = 0;
        return exchange->swallowed > HTTP_SWALLOW ? MHD_NO : MHD_YES;
    }
    set_idle(exchange, false);
    if (exchange->phase == HTTP_BODY)
        return ll_http_handle(exchange) ? ll_http_send(exchange) : MHD_YES;
    return exchange->phase == HTTP_WAITING || exchange->phase == HTTP_READY ? ll_http_send(exchange)
                                                                            : MHD_YES;
}

/* ---- start and stop ---- */

static void discard_log(void *closure, const char *format, va_list arguments)
{
    (void)closure, (void)format, (void)arguments; /* it logs a line for every client error */
}

static struct MHD_Daemon *start_daemon(ll_http *http)
{
    const ll_web_server_config *config = &http->config;
    unsigned threads = (unsigned)config->http_threads;
    /* The connection limiter counts connections; this limit must never take effect, as the library would
     * close without an answer. Each thread gets an equal part of it. */
    unsigned limit = ((unsigned)config->max_connections + 64) * threads;
    struct MHD_OptionItem options[] = {
        {MHD_OPTION_NOTIFY_CONNECTION, (intptr_t)on_connection, http},
        {MHD_OPTION_NOTIFY_COMPLETED, (intptr_t)on_completed, http},
        {MHD_OPTION_URI_LOG_CALLBACK, (intptr_t)on_request_line, http},
        {MHD_OPTION_CONNECTION_LIMIT, (intptr_t)limit, NULL},
        /* Must fit the head, decoded twice, and the head of the answer. */
        {MHD_OPTION_CONNECTION_MEMORY_LIMIT, (intptr_t)(config->max_head_bytes + 16384), NULL},
        {MHD_OPTION_CONNECTION_TIMEOUT, (intptr_t)(unsigned)config->idle_timeout_s + 1, NULL},
        {threads > 1 ? MHD_OPTION_THREAD_POOL_SIZE : MHD_OPTION_END, (intptr_t)threads, NULL},
        {MHD_OPTION_END, 0, NULL},
    };
    /* Without turbo the library would shut down a connection that it has passed on (upgrades). */
    unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_NO_LISTEN_SOCKET | MHD_USE_ITC |
                     MHD_USE_ERROR_LOG | MHD_USE_TURBO | MHD_ALLOW_SUSPEND_RESUME;
    return MHD_start_daemon(flags, 0, NULL, NULL, on_request, http, MHD_OPTION_EXTERNAL_LOGGER, discard_log,
                            NULL, MHD_OPTION_ARRAY, options, MHD_OPTION_END);
}

ll_status ll_http_start(const ll_web_server_config *config, const ll_http_app *app, const ll_allow *allow,
                        const ll_proxies *proxies, ll_connection_limiter *connection_limiter, ll_ws *ws,
                        ll_http **result)
{
    ll_http *http = calloc(1, sizeof *http);
    if (http == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: HTTP");
    http->config = *config;
    http->app = *app;
    http->allow = *allow;
    http->proxies = proxies;
    http->connection_limiter = connection_limiter;
    http->ws = ws;
    pthread_mutex_init(&http->watch_lock, NULL);
    pthread_mutex_init(&http->job_lock, NULL);
    pthread_cond_init(&http->job_there, NULL);
    pthread_cond_init(&http->work_done, NULL);
    if (getrandom(&http->request_seed, sizeof http->request_seed, GRND_NONBLOCK) < 0)
        http->request_seed = (uint64_t)ll_now_ns(); /* ids must only differ */
    while (http->control_threads < config->control_threads && ll_http_start_control(http)) {
    }
    http->daemon = http->control_threads > 0 ? start_daemon(http) : NULL;
    if (http->daemon == NULL) {
        ll_status error = ll_error(LL_IO, "cannot start HTTP threads: %s", strerror(errno));
        ll_http_stop(http);
        return error;
    }
    *result = http;
    return ll_ok();
}

bool ll_http_adopt(ll_http *http, int fd, const struct sockaddr *address, unsigned address_size)
{
    return MHD_add_connection(http->daemon, fd, address, address_size) == MHD_YES;
}

void ll_http_stop(ll_http *http)
{
    ll_http_stop_control(http);
    ll_http_stop_tasks(http); /* both resume suspended connections, as the library requires */
    if (http->daemon != NULL)
        MHD_stop_daemon(http->daemon);
    LL_ASSERT(http->first == NULL);
    pthread_mutex_destroy(&http->watch_lock);
    pthread_mutex_destroy(&http->job_lock);
    pthread_cond_destroy(&http->job_there);
    pthread_cond_destroy(&http->work_done);
    free(http);
}
