/* Routing of requests, and all refusals that need no handler. */
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>

#include "daemon/http/internal.h"

static ll_text text_of(const char *value)
{
    return (ll_text){value, value != NULL ? strlen(value) : 0};
}

/* ---- patterns ---- */

/* Matches `path` and splits `pieces`, a copy of it, into the parameters. */
static bool match(const char *pattern, char *pieces, const char *parameter[LL_HTTP_PARAMETERS])
{
    int count = 0;
    while (*pattern != '\0') {
        if (*pattern != '{') {
            if (*pattern++ != *pieces++)
                return false;
            continue;
        }
        size_t name = strcspn(pattern, "}");
        bool rest = name > 0 && pattern[name - 1] == '*';
        size_t length = rest ? strlen(pieces) : strcspn(pieces, "/");
        pattern += name + 1;
        if (length == 0 || count == LL_HTTP_PARAMETERS || (*pattern == '\0' && pieces[length] != '\0'))
            return false;
        parameter[count++] = pieces;
        pieces += length;
        if (*pattern != '\0' && *pattern++ != *pieces)
            return false;
        if (*pieces != '\0')
            *pieces++ = '\0';
    }
    return *pieces == '\0';
}

static bool matches(http_exchange *exchange, const ll_http_route *route)
{
    memcpy(exchange->parameters, exchange->path, strlen(exchange->path) + 1);
    memset(exchange->request.parameter, 0, sizeof exchange->request.parameter);
    return match(route->pattern, exchange->parameters, exchange->request.parameter);
}

/* Finds the route; if none, collects the methods that the path has. The first matching pattern wins:
 * `experiments/schema` is not an experiment. */
static const ll_http_route *find(http_exchange *exchange, char *allow, size_t allow_size)
{
    const ll_http_app *app = &exchange->http->app;
    const char *pattern = NULL;
    *allow = '\0';
    for (int i = 0; i < app->route_count; i++) {
        if (pattern != NULL && strcmp(pattern, app->routes[i].pattern) != 0)
            continue;
        if ((exchange->named != HTTP_ITS_ADDRESS && !app->routes[i].document) ||
            !matches(exchange, &app->routes[i]))
            continue;
        pattern = app->routes[i].pattern;
        if (strcmp(app->routes[i].method, exchange->request.method) == 0)
            return &app->routes[i];
        if (strstr(allow, app->routes[i].method) == NULL) {
            size_t used = strlen(allow);
            snprintf(allow + used, allow_size - used, "%s%s%s", used > 0 ? ", " : "", app->routes[i].method,
                     strcmp(app->routes[i].method, "GET") == 0 ? ", HEAD" : "");
        }
    }
    return NULL;
}

/* ---- refusals ---- */

static bool is_type(const char *list, const char *type)
{
    size_t size = strcspn(type, "; \t");
    while (*list != '\0') {
        list += strspn(list, ", ");
        size_t length = strcspn(list, ", ");
        if (length == size && strncasecmp(list, type, size) == 0)
            return true;
        list += length;
    }
    return false;
}

static bool has_body(const http_exchange *exchange, uint64_t *length)
{
    const char *header = ll_http_header(&exchange->request, "Content-Length");
    *length = header != NULL ? strtoull(header, NULL, 10) : 0;
    return *length > 0 || ll_http_header(&exchange->request, "Transfer-Encoding") != NULL;
}

/* Cross-site requests must not change anything, even if the page cannot read the answer. */
static bool origin_refused(http_exchange *exchange)
{
    const ll_allow *allow = &exchange->http->allow;
    ll_text origin = text_of(ll_http_header(&exchange->request, "Origin"));
    ll_text host = text_of(exchange->host);
    const char *site = ll_http_header(&exchange->request, "Sec-Fetch-Site");
    bool reads = strcmp(exchange->request.method, "GET") == 0;
    bool allowed = ll_allow_origin(allow, origin, host);
    exchange->cross_origin = origin.at != NULL && allowed && !ll_allow_origin(&(ll_allow){0}, origin, host);
    if (reads)
        return false;
    if (!allowed || (origin.at == NULL && site != NULL && strcasecmp(site, "cross-site") == 0)) {
        ll_http_refuse(exchange, 403, LL_FORBIDDEN, "Origin",
                       "Origin not allowed to change anything; see --allow-origin");
        return true;
    }
    return false;
}

static bool preflight(http_exchange *exchange, const char *allow)
{
    if (strcmp(exchange->request.method, "OPTIONS") != 0 || *allow == '\0')
        return false;
    char methods[120];
    snprintf(methods, sizeof methods, "%s, OPTIONS", allow);
    exchange->response.status = 204;
    ll_http_set_header(&exchange->response, "Allow", methods);
    if (exchange->cross_origin) {
        ll_http_set_header(&exchange->response, "Access-Control-Allow-Methods", methods);
        ll_http_set_header(
            &exchange->response, "Access-Control-Allow-Headers",
            "Authorization, Content-Type, Idempotency-Key, If-Match, If-None-Match, X-Request-Id");
        ll_http_set_header(&exchange->response, "Access-Control-Max-Age", "600");
    }
    return true;
}

static void refuse_method(http_exchange *exchange, const char *allow)
{
    ll_http_refuse(exchange, 405, LL_BAD_INPUT, "", "method %s not allowed here; must be one of %s",
                   exchange->request.method, allow);
    ll_http_set_header(&exchange->response, "Allow", allow);
}

/* ---- streams ---- */

static enum MHD_Result add_header(void *closure, enum MHD_ValueKind kind, const char *name, size_t name_size,
                                  const char *value, size_t value_size)
{
    (void)kind;
    ll_head_add(closure, (ll_text){name, name_size},
                value != NULL ? (ll_text){value, value_size} : (ll_text){"", 0});
    return MHD_YES;
}

/* Gives the streams a copy of the socket, and the connection's place; the library, which reads nothing of it
 * any more, then closes its own. */
static bool pass_on(http_exchange *exchange, const ll_upgrade *upgrade)
{
    http_connection *watched = exchange->watched;
    int fd = watched != NULL ? fcntl(watched->fd, F_DUPFD_CLOEXEC, 0) : -1, on = 1, off = 0;
    if (fd < 0)
        return false;
    ll_http_set_deadline(watched, 0);
    setsockopt(fd, IPPROTO_TCP, TCP_CORK, &off, sizeof off); /* the library corks it */
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    atomic_fetch_add(&exchange->http->upgrades, 1);
    ll_ws_adopt(exchange->http->ws, upgrade, fd, &watched->pass);
    watched->pass.valid = false;
    return true;
}

/* Requests for a stream's path: an upgrade on a kept connection or with a query, or one that the acceptor
 * refused. */
static void begin_stream(http_exchange *exchange, bool http11)
{
    ll_http *http = exchange->http;
    const ll_http_request *request = &exchange->request;
    ll_head head = {.method = text_of(exchange->head ? "HEAD" : request->method),
                    .target = text_of(exchange->path),
                    .http11 = http11};
    MHD_get_connection_values_n(exchange->connection, MHD_HEADER_KIND, add_header, &head);
    head.host = text_of(exchange->host);
    ll_upgrade upgrade;
    int status;
    ll_status error = ll_upgrade_check(&head, &http->allow, &upgrade, &status);
    if (!ll_failed(&error) && !ll_ws_knows(http->ws, &upgrade)) {
        if (http->app.started != NULL && !http->app.started(http->app.context, request, &exchange->response))
            return;
        error = ll_error(LL_NOT_FOUND, "%s not found", ll_stream_names[upgrade.kind]);
        status = 404;
    }
    if (!ll_failed(&error)) {
        exchange->upgraded = pass_on(exchange, &upgrade);
        if (exchange->upgraded) {
            exchange->response.status = 101;
            return;
        }
        error = ll_error(LL_LIMIT, "no descriptor is left for the stream");
        ll_http_problem_later(&exchange->response, request, 503, 5, &error);
        return;
    }
    ll_http_problem_as(&exchange->response, request, status, &error);
    if (status == 426) {
        ll_http_set_header(&exchange->response, "Upgrade", "websocket");
        ll_http_set_header(&exchange->response, "Sec-WebSocket-Version", "13");
    } else if (status == 405) {
        ll_http_set_header(&exchange->response, "Allow", "GET");
    }
}

/* ---- ambiguous heads ---- */

typedef struct head_counts {
    int length, encoding, host, origin, authorization, type;
    const char *coding; /* the Transfer-Encoding, as the library reads it */
    const ll_head_fault *fault;
    uintptr_t end; /* of the last value, or of the first line */
    bool gap;
} head_counts;

/* RFC 9110 2.5: a higher minor version is as 1.1. */
static bool is_http11(const char *version)
{
    return strcmp(version, "HTTP/1.0") != 0;
}

/* The library has only zeroed the ends of target, names, values and lines in its buffer. If one does not end
 * where the next begins, it had a NUL, or was moved for a line that continues it (RFC 9112 5.2). */
static bool follows(uintptr_t end, uintptr_t next, size_t least, size_t most)
{
    return next >= end + least && next <= end + most;
}

static enum MHD_Result count_header(void *closure, enum MHD_ValueKind kind, const char *name,
                                    size_t name_size, const char *value, size_t value_size)
{
    (void)kind;
    head_counts *counts = closure;
    value = value != NULL ? value : "";
    const ll_head_fault *fault = ll_header_fault((ll_text){name, name_size}, (ll_text){value, value_size});
    counts->fault = counts->fault != NULL ? counts->fault : fault;
    counts->gap = counts->gap || !follows(counts->end, (uintptr_t)name, 1, 2);
    counts->end = (uintptr_t)value + value_size;
    if (strcasecmp(name, "Transfer-Encoding") == 0)
        counts->coding = value;
    const struct {
        const char *name;
        int *count;
    } counted[] = {{"Content-Length", &counts->length},
                   {"Transfer-Encoding", &counts->encoding},
                   {"Host", &counts->host},
                   {"Origin", &counts->origin},
                   {"Content-Type", &counts->type},
                   {"Authorization", &counts->authorization}};
    for (size_t i = 0; i < sizeof counted / sizeof *counted; i++)
        *counted[i].count += strcasecmp(name, counted[i].name) == 0;
    return MHD_YES;
}

static void refuse_head(http_exchange *exchange, int status, const char *field, const char *sentence)
{
    ll_http_refuse(exchange, status, LL_BAD_INPUT, field, "%s", sentence);
    ll_http_set_header(&exchange->response, "Connection", "close");
    exchange->ambiguous = true;
}

/* The method begins the head in the library's buffer. */
static bool ends_head(const http_exchange *exchange, uintptr_t end, const char *method)
{
    const union MHD_ConnectionInfo *info =
        MHD_get_connection_info(exchange->connection, MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE);
    return info == NULL || follows(end, (uintptr_t)method + info->header_size, 2, 4);
}

/* Checks every request of a connection: the acceptor sees only the first one, and of duplicate headers the
 * library uses the first. */
static bool head_refused(http_exchange *exchange, const char *method, const char *version)
{
    uintptr_t first = (uintptr_t)version;
    head_counts n = {.end = first + strlen(version),
                     .gap = exchange->watched != NULL && first != exchange->watched->target_end + 1};
    bool http11 = is_http11(version);
    MHD_get_connection_values_n(exchange->connection, MHD_HEADER_KIND, count_header, &n);
    const char *twice = n.length > 1          ? "Content-Length"
                        : n.encoding > 1      ? "Transfer-Encoding"
                        : n.host > 1          ? "Host"
                        : n.origin > 1        ? "Origin"
                        : n.type > 1          ? "Content-Type"
                        : n.authorization > 1 ? "Authorization"
                                              : NULL;
    if (twice != NULL) {
        refuse_head(exchange, 400, twice, "duplicate header");
    } else if (strspn(method, "ABCDEFGHIJKLMNOPQRSTUVWXYZ") != strlen(method)) {
        refuse_head(exchange, 400, "", "method: must be capital letters");
    } else if (n.fault != NULL) {
        refuse_head(exchange, n.fault->status, n.fault->field, n.fault->text);
    } else if (n.gap || !ends_head(exchange, n.end, method)) {
        refuse_head(exchange, 400, "", "request head: must not have a NUL or lines that continue others");
    } else if (n.coding != NULL && (n.length > 0 || !http11)) {
        refuse_head(exchange, 400, "Transfer-Encoding",
                    "Transfer-Encoding: must be in HTTP/1.1 and without Content-Length");
    } else if (n.coding != NULL && strcasecmp(n.coding, "chunked") != 0) {
        refuse_head(exchange, 501, "Transfer-Encoding", "Transfer-Encoding: must be chunked");
    }
    return exchange->ambiguous;
}

/* ---- before and after the body ---- */

static void begin_body(http_exchange *exchange)
{
    const ll_http_route *route = exchange->route;
    uint64_t length;
    if (!has_body(exchange, &length))
        return;
    const char *type = ll_http_header(&exchange->request, "Content-Type");
    const char *coding = ll_http_header(&exchange->request, "Content-Encoding");
    exchange->body_limit = route->body_limit;
    if (length > route->body_limit || route->body_limit == 0) {
        ll_http_refuse(exchange, 413, LL_LIMIT, "", "body: must have at most %zu bytes", route->body_limit);
    } else if (coding != NULL && strcasecmp(coding, "identity") != 0) {
        ll_http_refuse(exchange, 415, LL_BAD_INPUT, "Content-Encoding",
                       "Content-Encoding: a body must not have one; got %.40s", coding);
        ll_http_set_header(&exchange->response, "Accept-Encoding", "identity");
    } else if (route->types != NULL && (type == NULL || !is_type(route->types, type))) {
        ll_http_refuse(exchange, 415, LL_BAD_INPUT, "Content-Type", "Content-Type: must be one of: %s",
                       route->types);
        ll_http_set_header(&exchange->response,
                           strcmp(exchange->request.method, "PATCH") == 0 ? "Accept-Patch" : "Accept",
                           route->types);
    } else {
        return;
    }
    exchange->refused = true;
}

/* `?shard=` is for the proxy: a request for another shard came by a wrong way. */
static enum MHD_Result check_argument(void *closure, enum MHD_ValueKind kind, const char *name,
                                      const char *value)
{
    (void)kind;
    http_exchange *exchange = closure;
    const char *shard = exchange->http->app.shard;
    const char *names = exchange->route != NULL ? exchange->route->query : ""; /* a stream has none */
    size_t size = strlen(name);
    uint32_t bit = 1; /* of shard; then of each name */
    bool is_shard = shard != NULL && *shard != '\0' && strcmp(name, "shard") == 0, known = is_shard;
    for (const char *at = names; !known && *at != '\0'; at += strcspn(at, ","), at += *at == ',') {
        known = strcspn(at, ",") == size && strncmp(at, name, size) == 0;
        bit <<= 1;
    }
    if (!known) {
        ll_http_refuse(exchange, 400, LL_BAD_INPUT, name, "query: %.60s is unknown; %s%s", name,
                       *names != '\0' ? "must be one of " : "none is allowed", names);
    } else if ((exchange->asked & bit) != 0) {
        ll_http_refuse(exchange, 400, LL_BAD_INPUT, name, "%.60s: must come once in the query", name);
    } else if (is_shard && (value == NULL || strcmp(value, shard) != 0)) {
        ll_http_refuse(exchange, 400, LL_BAD_INPUT, "shard",
                       "shard: must be %s, the name of this daemon; got %.40s", shard,
                       value != NULL ? value : "empty");
    } else {
        exchange->asked |= bit;
        return MHD_YES;
    }
    exchange->refused = true;
    return MHD_NO;
}

static bool query_refused(http_exchange *exchange)
{
    exchange->refused = false;
    if (exchange->route == NULL || exchange->route->query != NULL)
        MHD_get_connection_values(exchange->connection, MHD_GET_ARGUMENT_KIND, check_argument, exchange);
    return exchange->refused;
}

void ll_http_begin(http_exchange *exchange, const char *method, const char *version)
{
    ll_http *http = exchange->http;
    ll_http_request *request = &exchange->request;
    ll_stream_kind kind;
    char allow[96], id[65];
    exchange->refused = true;
    if (head_refused(exchange, method, version))
        return;
    if (ll_http_header(request, "Host") == NULL && is_http11(version)) {
        ll_http_refuse(exchange, 400, LL_BAD_INPUT, "Host", "Host: required in HTTP/1.1");
        return;
    }
    if (exchange->host != NULL && !ll_allow_host(&http->allow, text_of(exchange->host))) {
        ll_http_refuse(exchange, 421, LL_FORBIDDEN, "Host",
                       "Host: must be localhost, an address or a name given by --allow-host");
        return;
    }
    ll_http_take_digest(exchange);
    if (exchange->named == HTTP_ITS_ADDRESS && ll_stream_path(text_of(exchange->path), &kind, id)) {
        if (!query_refused(exchange))
            begin_stream(exchange, is_http11(version));
        exchange->refused = true;
        return;
    }
    exchange->route = find(exchange, allow, sizeof allow);
    bool page = exchange->route == NULL && *allow == '\0';
    if (strcmp(request->method, "OPTIONS") == 0 && exchange->route == NULL) {
        origin_refused(exchange);
        ll_http_clear(&exchange->response);
        if (preflight(exchange, page ? "GET, HEAD" : allow))
            return;
    }
    if (exchange->route == NULL && !page) {
        refuse_method(exchange, allow);
    } else if (page && strcmp(request->method, "GET") != 0) {
        refuse_method(exchange, "GET, HEAD");
    } else if (!origin_refused(exchange)) {
        exchange->refused = false;
        if (exchange->route != NULL) {
            begin_body(exchange);
            if (!exchange->refused)
                query_refused(exchange);
        }
    }
}

bool ll_http_handle(http_exchange *exchange)
{
    ll_http_deadline(exchange, 0);
    exchange->phase = HTTP_READY;
    if (exchange->refused)
        return true;
    if (exchange->route == NULL) {
        ll_http_file(exchange);
        return true;
    }
    exchange->request.body = exchange->body != NULL ? exchange->body : "";
    ll_http_run_on run_on = exchange->route->run_on;
    if (run_on == LL_HTTP_INLINE) {
        ll_http_run_handler(exchange);
        return true;
    }
    if (exchange->request.body_size > HTTP_SHORT_BODY)
        run_on = LL_HTTP_TASK;
    exchange->phase = HTTP_WAITING;
    /* Suspends first: the other thread may finish before this returns. */
    MHD_suspend_connection(exchange->connection);
    ll_status status = ll_ok();
    if (run_on == LL_HTTP_TASK)
        status = ll_http_start_task(exchange->http, exchange);
    else if (!ll_http_queue(exchange->http, exchange))
        status = ll_error(LL_UNAVAILABLE, "too many requests are waiting");
    if (ll_failed(&status)) {
        ll_http_problem(&exchange->response, &exchange->request, &status);
        exchange->phase = HTTP_READY;
        MHD_resume_connection(exchange->connection);
    }
    return false;
}
