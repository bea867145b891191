/* A handler runs where its row says (ll_http_run_on). What may compute for more than a millisecond, with any
 * body, is a task (tasks.h) from its first byte. Handlers that are short but may wait, for the store or a
 * session, run in a thread pool, so that no computation ever delays them: with bodies up to 4 KiB, larger
 * ones are tasks. A pool handler that would take long in a rare case requests to be called again as a task
 * (ll_http_become_task). A handler fills the response; it reports errors only as RFC 9457
 * problem documents.
 *
 * Done here before a handler is called: method and path, 404, 405 with Allow, Host allow-list (421), Origin
 * and Sec-Fetch-Site of changing requests (403), Content-Type (415), body limit (413); a missing
 * Content-Length is accepted (chunked). Done after it: HEAD, gzip, X-Request-Id, security headers,
 * Content-Length or chunks, keep-alive. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

#define LL_HTTP_PARAMETERS 4 /* {names} of a path */

typedef struct ll_http_request {
    const char *method;                        /* HEAD arrives as GET */
    bool head;                                 /* HEAD: an expensive body need not be made */
    const char *path;                          /* decoded, without query */
    const char *parameter[LL_HTTP_PARAMETERS]; /* values of the pattern's {..} in order; the wildcard last */
    const char *body;                          /* NUL-terminated beyond `body_size`; never NULL */
    size_t body_size;
    char peer[48]; /* address of the client, without port; behind a trusted proxy, the address that it
                      forwards */
    bool proxied;  /* it came through a trusted proxy, whose X-Forwarded headers are true */
    bool tls;      /* the client reached that proxy by https */
    const char
        *host;   /* where the client asked: Host, or what a trusted proxy has in its place; may be NULL */
    char id[65]; /* X-Request-Id as received, or generated */
    struct ll_task *task; /* for LL_HTTP_TASK; else NULL */
    uint32_t begun;       /* called again as a task: what the first call left in the response's */
    void *impl;
} ll_http_request;

/* NULL when absent; several lines of one name are one list. The text lives as long as the request. */
const char *ll_http_query(const ll_http_request *request, const char *name);
const char *ll_http_header(const ll_http_request *request, const char *name);

/* Whether the request's Accept header allows `type` (`text/csv`); without header: any. `quality` (may be
 * NULL) gets its q value, 0 to 1. */
bool ll_http_accepts(const ll_http_request *request, const char *type, double *quality);

/* Whether Accept-Encoding allows gzip. */
bool ll_http_takes_gzip(const ll_http_request *request);

/* Whether a value of If-None-Match (may be NULL) names `tag`, compared weakly (RFC 9110 13.1.2). */
bool ll_http_matches_tag(const char *header, const char *tag);

/* Called repeatedly on an HTTP thread until it returns 0 (end) or -1 (abort); writes at most `capacity`
 * bytes. */
typedef int64_t ll_http_reader(void *context, uint64_t offset, char *buffer, size_t capacity);

typedef struct ll_http_header_line {
    char name[40], value[256];
} ll_http_header_line;

#define LL_HTTP_HEADERS 12

/* Initially status 200 without body. */
typedef struct ll_http_response {
    int status;
    char type[64]; /* Content-Type; empty: none */
    char *bytes;   /* malloc'ed, owned by the response */
    size_t size, capacity;
    ll_http_reader *reader; /* instead of bytes: a body of unknown size, sent in chunks */
    void *reader_context;
    void (*reader_free)(void *context); /* called once, also when the client disconnected */
    FILE *file;                         /* instead of bytes: `file_size` bytes of it from `file_from` on */
    uint64_t file_from, file_size;
    struct ll_document *document; /* instead of bytes: see documents.h */
    size_t held;                  /* bytes of memory held by reader or file */
    ll_http_header_line header[LL_HTTP_HEADERS];
    int headers;
    bool failed; /* out of memory while writing: becomes a 503 */
    bool to_work;
    uint32_t begun; /* what a handler has done before it becomes a task; 0: nothing */
} ll_http_response;

void ll_http_set_header(ll_http_response *response, const char *name, const char *value);
void ll_http_append(ll_http_response *response, const void *bytes, size_t size); /* appends to the body */
void ll_http_printf(ll_http_response *response, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Turns the response into a problem document. The HTTP status follows from the code; `errors` names the
 * field. */
void ll_http_problem(ll_http_response *response, const ll_http_request *request, const ll_status *error);

/* The same with an explicit HTTP status; `error` has field and message. */
void ll_http_problem_as(ll_http_response *response, const ll_http_request *request, int status,
                        const ll_status *error);

/* 429 and 503 with Retry-After. */
void ll_http_problem_later(ll_http_response *response, const ll_http_request *request, int status,
                           int retry_after_s, const ll_status *error);

void ll_http_clear(ll_http_response *response); /* frees body and reader; status 200 again, headers cleared */

/* True: the handler must return, and is called again as a task; what it has changed it leaves in `begun`. */
bool ll_http_become_task(const ll_http_request *request, ll_http_response *response);

struct cJSON;
/* Answers of type `application/json`. */
void ll_http_json(ll_http_response *response, int status, struct cJSON *json); /* takes ownership */
void ll_http_text(ll_http_response *response, int status, const char *text);   /* copies it */
/* For HEAD: headers of an answer whose body was not made; its length is not sent. */
void ll_http_no_body(ll_http_response *response, const char *type);

typedef void ll_http_handler(void *context, const ll_http_request *request, ll_http_response *response);

typedef enum ll_http_run_on {
    LL_HTTP_INLINE, /* on the thread that reads requests: within a millisecond, without waiting */
    LL_HTTP_POOL,   /* in a thread pool: short, but may wait until its change is stored */
    LL_HTTP_TASK,   /* as a task (tasks.h): may take long */
} ll_http_run_on;

typedef struct ll_http_route {
    const char *method;  /* GET answers HEAD too */
    const char *pattern; /* `/api/v1/sessions/{id}/state`; {name} is one segment, a final {name*} is the rest
                            (not empty) */
    ll_http_handler *handler;
    bool document;     /* it answers with a constant document, and has its second address */
    size_t body_limit; /* bytes; 0: a body is a 413 */
    const char *types; /* accepted Content-Types, comma separated; NULL: any. If set, a body without
                          Content-Type is a 415 */
    ll_http_run_on run_on;
    const char *query; /* allowed names in the query, comma separated; others are a 400. NULL: any */
} ll_http_route;

typedef struct ll_http_app {
    const ll_http_route *routes; /* the first match wins */
    int route_count;
    void *context; /* of the handlers */
    /* Whether all that is stored has its stream; if not it answers 503. NULL: it has. */
    bool (*started)(void *context, const ll_http_request *request, ll_http_response *response);
    const char *shard; /* of this daemon: each request may say ?shard= with it. Empty or NULL: none may */
    struct ll_documents *documents; /* NULL: none */
    struct ll_tasks *tasks;         /* for LL_HTTP_TASK */
    /* Called after each answer, for logs and metrics; on an HTTP thread. `route` is NULL for files and
     * unmatched requests. May be NULL. */
    void (*done)(void *context, const ll_http_request *request, const ll_http_route *route, int status,
                 double seconds);
} ll_http_app;

/* ---- for the web server only ---- */

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

/* Takes over a connection: HTTP owns `fd` from here on, whether it succeeds or not. Any thread. */
bool ll_http_adopt(ll_http *http, int fd, const struct sockaddr *address, unsigned address_size);

/* Cuts connections whose request takes too long. Called a few times per second, from one thread. */
void ll_http_watch(ll_http *http, int64_t now_ns);

typedef struct ll_http_counted {
    uint64_t requests, cut;
    uint64_t upgrades; /* on kept connections, or with a query */
    uint64_t refused_answers, answer_bytes;
    int control;      /* requests for the pool, waiting or running */
    double control_s; /* age of the oldest of them */
    double stalled_s; /* since there are some and none ended */
} ll_http_counted;

ll_http_counted ll_http_counts(ll_http *http);
void ll_http_stop(ll_http *http); /* drains the tasks, waits for handlers; frees */
