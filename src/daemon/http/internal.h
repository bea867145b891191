/* Shared by http.c (the library's callbacks), routes.c (selects the handler), dispatch.c (runs handlers),
 * files.c (the page) and send.c (answers). */
#pragma once

#include <microhttpd.h>
#include <pthread.h>
#include <stdatomic.h>

#include "daemon/http/documents.h"
#include "daemon/http/http.h"
#include "daemon/net/config.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/proxies.h"
#include "daemon/net/upgrade.h"
#include "daemon/stream/ws.h"
#include "daemon/support/tasks.h"
#include "threads/clock.h"

#define HTTP_SHORT_BODY (4u << 10) /* bytes; reading and checking a larger body runs as a task */
/* bytes of a refused body that are read, so that its sender sees the answer */
#define HTTP_SWALLOW (8u << 20)

/* A connection, for the watchdog. */
typedef struct http_connection {
    ll_http *http;
    struct http_connection *next, *previous;
    int fd;
    ll_connection_limiter_pass pass;
    char peer[48];
    bool faulty;                 /* its request was answered before its head was complete */
    uintptr_t target_end;        /* of its request, in the library's buffer */
    bool proxied;                /* from a trusted proxy */
    _Atomic int64_t deadline_ns; /* 0: none */
    atomic_bool idle;            /* between two requests, or within a body: the client has to send next */
    ll_task *task;               /* guarded by watch_lock: the task of its request */
} http_connection;

typedef enum http_phase {
    HTTP_BODY,    /* reading the body */
    HTTP_WAITING, /* suspended: a handler runs on another thread */
    HTTP_READY,   /* the response is complete */
    HTTP_QUEUED,
} http_phase;

/* A header's value that is not in the library's buffer as it is. */
typedef struct http_value {
    struct http_value *next;
    char text[];
} http_value;

/* One request and its response. */
typedef struct http_exchange {
    ll_http *http;
    struct MHD_Connection *connection;
    http_connection *watched;
    http_phase phase;
    ll_http_request request;
    ll_http_response response;
    const ll_http_route *route;
    char *path;       /* decoded */
    const char *host; /* whose the request is: of an absolute target, or the header Host; NULL: none */
    char *authority;  /* `host` of an absolute target */
    char *parameters; /* a copy of the path, split into segments */
    http_value *values;
    char *body;
    size_t body_capacity, body_limit, swallowed;
    uint32_t asked; /* names that the query has had, by their place among those of the route */
    bool refused;   /* the response was made before the body arrived */
    bool ambiguous; /* two parsers could read it as two requests: the connection must end */
    bool head;      /* HEAD */
    enum { HTTP_ITS_ADDRESS, HTTP_OUR_DIGEST, HTTP_OTHER_DIGEST } named; /* see documents.h */
    bool cross_origin; /* an allowed foreign origin: may read the answer */
    int64_t begin_ns;
    bool upgraded; /* a stream thread has a copy of the socket: the library only closes its own */
    struct http_exchange *next_job;
    int64_t queued_ns; /* when it was queued for the pool */
    int64_t counted;   /* bytes counted in answer_bytes */
} http_exchange;

struct ll_http {
    struct MHD_Daemon *daemon;
    ll_web_server_config config;
    ll_http_app app;
    ll_allow allow;
    const ll_proxies *proxies;
    ll_connection_limiter *connection_limiter;
    ll_ws *ws;
    atomic_ullong requests, cut, request_serial, refused_answers, upgrades;
    atomic_llong answer_bytes; /* of large answers being sent */
    uint64_t request_seed;

    pthread_mutex_t watch_lock;
    http_connection *first;
    unsigned watch_turn;

    pthread_mutex_t job_lock;
    pthread_cond_t job_there;
    pthread_cond_t work_done;
    http_exchange *first_job, *last_job;
    int jobs, working; /* working: tasks of requests */
    bool jobs_end;
    int control_threads;
    pthread_t control[64];
    int64_t busy_since[64]; /* of each thread; 0: it waits */
    int64_t ended_ns;       /* when one of them last ended a job */
};

void ll_http_set_deadline(http_connection *connection, double seconds);
void ll_http_deadline(http_exchange *exchange, double seconds); /* 0: none */

/* Routes a request before its body arrives. Sets `route`, or a response with `refused`. `method` and
 * `version`: the library's own texts. */
void ll_http_begin(http_exchange *exchange, const char *method, const char *version);
/* Called when the whole request has arrived. True: the response is ready to be sent. False: the connection is
 * suspended, and is resumed when a handler on another thread has made the response; the caller must not use
 * the exchange then. */
bool ll_http_handle(http_exchange *exchange);
void ll_http_run_handler(http_exchange *exchange);

bool ll_http_queue(ll_http *http,
                   http_exchange *exchange); /* to the thread pool; false when its queue is full */
/* Starts a task. On an error the exchange stays the caller's. */
ll_status ll_http_start_task(ll_http *http, http_exchange *exchange);

bool ll_http_start_control(ll_http *http); /* starts one more thread */
void ll_http_stop_control(ll_http *http);
void ll_http_stop_tasks(ll_http *http); /* drains the tasks, and waits for those of requests */

void ll_http_take_digest(http_exchange *exchange); /* off a second address of a document: sets `named` */
void ll_http_file(http_exchange *exchange); /* fills the response: a file of the page, a redirect or 404 */

enum MHD_Result ll_http_send(http_exchange *exchange);
void ll_http_compress(http_exchange *exchange); /* compresses the answer if the client accepts it and the type
                                                   compresses well */
void ll_http_refuse(http_exchange *exchange, int status, ll_code code, const char *field, const char *format,
                    ...) __attribute__((format(printf, 5, 6)));
