/* HTTP: a table of routes over libmicrohttpd, and the files of the page.
 *
 * A handler runs on the run_on of its row (ll_http_run_on). What is short but may wait, for the store or a
 * session, has threads of its own, so that nothing that computes is ever before it; what may take long is a
 * task (tasks.h). A handler of the run_on of control that finds that it would take long asks to be called
 * again as a task (ll_http_become_task), and so is one whose body is large. A handler fills the response; it
 * cannot fail in any other way than by a problem document (http_problem.h).
 *
 * Done here, before a handler is called: method and path, 404, 405 with Allow, Host allow-list (421), Origin
 * and Sec-Fetch-Site of requests that change something (403), Content-Type (415), body limit (413),
 * Content-Length missing is fine (chunked). Done after it: HEAD, gzip, X-Request-Id, security headers,
 * Content-Length or chunks, keep-alive. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

#define LL_HTTP_PARAMETERS 4 /* {names} of a path */

typedef struct ll_http_request {
    const char *method; /* HEAD arrives as GET */
    bool head;          /* only the head of the answer is wanted: what is dear need not be made */
    const char *path;   /* decoded, without query */
    const char *parameter[LL_HTTP_PARAMETERS]; /* texts that stood for {..} in the pattern, in its order; the
                                                  wildcard last */
    const char *body;                          /* NUL-terminated beyond `body_size`; never NULL */
    size_t body_size;
    char peer[48]; /* address of the client, without port: the other end, or whom a trusted proxy names */
    char id[65];   /* X-Request-Id as given, or one that was made */
    struct ll_task *task; /* on the lane of work; else NULL */
    const void *impl;
} ll_http_request;

/* NULL when absent. The text lives as long as the request. */
const char *ll_http_query(const ll_http_request *request, const char *name);
const char *ll_http_header(const ll_http_request *request, const char *name);

/* Whether the request's Accept header lets `type` (`text/csv`) be sent; a missing header lets everything.
 * `quality` (may be NULL) gets its q value, 0 to 1. */
bool ll_http_accepts(const ll_http_request *request, const char *type, double *quality);

/* Whether Accept-Encoding takes `encoding` (`gzip`). */
bool ll_http_takes_encoding(const ll_http_request *request, const char *encoding);

/* Whether a value of If-None-Match (may be NULL) names `tag`, compared weakly (RFC 9110 13.1.2). */
bool ll_http_matches_tag(const char *header, const char *tag);

/* Called again and again on an HTTP thread until it returns 0 (the end) or -1 (break off); fills at most
 * `capacity` bytes. */
typedef int64_t ll_http_reader(void *context, uint64_t offset, char *buffer, size_t capacity);

typedef struct ll_http_header_line {
    char name[40], value[256];
} ll_http_header_line;

#define LL_HTTP_HEADERS 12

/* A handler gets it as status 200 without body. */
typedef struct ll_http_response {
    int status;
    char type[64]; /* Content-Type; empty: none */
    char *bytes;   /* malloc'ed, owned by the response */
    size_t size, capacity;
    ll_http_reader *reader; /* instead of bytes: a body of unknown size, sent in chunks */
    void *reader_context;
    void (*reader_free)(void *context); /* called once, also when the client went away */
    FILE *file;                         /* instead of bytes: `file_size` of its bytes, from `file_from` on */
    uint64_t file_from, file_size;
    size_t held; /* bytes of memory that reader or file hold */
    ll_http_header_line header[LL_HTTP_HEADERS];
    int headers;
    bool failed; /* memory ran out while it was written: becomes a 503 */
    bool to_work;
} ll_http_response;

void ll_http_set_header(ll_http_response *response, const char *name, const char *value);
void ll_http_append(ll_http_response *response, const void *bytes, size_t size); /* to the body */
void ll_http_printf(ll_http_response *response, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void ll_http_clear(
    ll_http_response *response); /* frees the body and the reader; status 200 again, headers gone */

/* True: the handler returns, having changed nothing, and is called again as a task. */
bool ll_http_become_task(const ll_http_request *request, ll_http_response *response);

struct cJSON;
void ll_http_json(ll_http_response *response, int status,
                  const struct cJSON *json); /* prints it, `application/json` */
void ll_http_text(ll_http_response *response, int status, const char *type, const char *text); /* copies it */
/* For HEAD: the head of an answer that was not made; how long it would be is not told. */
void ll_http_no_body(ll_http_response *response, const char *type);
/* Takes `bytes` (malloc'ed). */
void ll_http_take(ll_http_response *response, int status, const char *type, char *bytes, size_t size);

typedef void ll_http_handler(void *context, const ll_http_request *request, ll_http_response *response);

typedef enum ll_http_run_on {
    LL_HTTP_INLINE, /* on the thread that reads requests: within a millisecond, without waiting */
    LL_HTTP_POOL,   /* short, but may wait until its change is stored */
    LL_HTTP_TASK,   /* a task */
} ll_http_run_on;

typedef struct ll_http_route {
    const char *method;  /* GET answers HEAD too */
    const char *pattern; /* `/api/v1/sessions/{id}/state`; {name} is one segment, a last {name*} all the rest
                            (not empty) */
    ll_http_handler *handler;
    size_t body_limit; /* bytes; 0: no body is read (one that is sent is a 413) */
    const char *types; /* accepted Content-Types, comma separated; NULL: any. A body without Content-Type is a
                          415 if set */
    ll_http_run_on run_on;
    const char *query; /* names that its query may have, comma separated; others are a 400. NULL: any */
} ll_http_route;

typedef struct ll_http_app {
    const ll_http_route *routes; /* the first match wins */
    int route_count;
    void *context;          /* of the handlers */
    struct ll_tasks *tasks; /* for the lane of work */
    /* After each answer, for logs and metrics; on an HTTP thread. `route` is NULL for files and for what no
     * route took. May be NULL. */
    void (*done)(void *context, const ll_http_request *request, const ll_http_route *route, int status,
                 double seconds);
} ll_http_app;

/* ---- for the door only ---- */

typedef struct ll_http ll_http;
struct ll_web_server_config;
struct ll_connection_limiter;
struct ll_allow;
struct ll_proxies;
struct ll_ws;
struct sockaddr;

ll_status ll_http_start(const struct ll_web_server_config *config, const ll_http_app *app,
                        const struct ll_allow *allow, const struct ll_proxies *proxies,
                        struct ll_connection_limiter *connection_limiter, struct ll_ws *ws, ll_http **http);

/* Hands a connection over: the HTTP side owns `fd` from here on, whatever is returned. Any thread. */
bool ll_http_adopt(ll_http *http, int fd, const struct sockaddr *address, unsigned address_size);

/* Cuts connections whose request takes too long. Call it a few times a second, from one thread. */
void ll_http_watch(ll_http *http, int64_t now_ns);

typedef struct ll_http_counted {
    uint64_t requests, cut;
    uint64_t upgrades; /* of kept connections */
    uint64_t refused_answers, answer_bytes;
    int control;      /* requests on the lane of control, waiting or in hand */
    double control_s; /* the longest that one of them has been there */
} ll_http_counted;

ll_http_counted ll_http_counts(ll_http *http);
void ll_http_stop(ll_http *http); /* drains the tasks, waits for handlers; frees */
