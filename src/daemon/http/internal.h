/* What http.c (the library's callbacks), daemon/api/table.c (which handler), lanes.c (on which thread),
 * send.c (answers), upgrade.c (late upgrades) and files.c (the page) share. */
#pragma once

#include <microhttpd.h>
#include <pthread.h>
#include <stdatomic.h>

#include "daemon/http/http.h"
#include "daemon/http/http_problem.h"
#include "daemon/net/config.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/proxies.h"
#include "daemon/net/upgrade.h"
#include "daemon/stream/ws.h"
#include "daemon/support/tasks.h"

#define HTTP_LARGE_BODY (64u << 10) /* to read and check it is work */
#define HTTP_SWALLOW (8u << 20)     /* of a refused body, so that its sender sees the answer */

/* A connection, for the watchdog. */
typedef struct http_connection {
    ll_http *http;
    struct http_connection *next, *previous;
    int fd;
    ll_connection_limiter_pass pass;
    char peer[48];
    bool faulty;                 /* its request was answered before its head was read */
    bool proxied;                /* a trusted proxy's */
    _Atomic int64_t deadline_ns; /* 0: none */
    atomic_bool idle;            /* between two requests, or within a body: what comes next is the client's */
    ll_task *task;               /* watch_lock: what works for it */
} http_connection;

typedef enum http_phase {
    HTTP_BODY,    /* the body is being read */
    HTTP_WAITING, /* suspended, a handler of another lane works */
    HTTP_READY,   /* the response is complete */
    HTTP_QUEUED,
} http_phase;

/* An upgrade that was promised to a client; freed when its request has ended, whatever became of it. */
typedef struct http_offer http_offer;

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
    char *parameters; /* a copy of the path, cut into pieces */
    char *body;
    size_t body_capacity, body_limit, swallowed;
    bool refused;      /* the response is there before the body */
    bool ambiguous;    /* two readers could see two requests in it: the connection ends */
    bool head;         /* HEAD */
    bool cross_origin; /* an allowed origin that is not ours: may read the answer */
    int64_t begin_ns;
    http_offer *offer;
    struct MHD_Response *upgrade; /* 101 */
    int file;                     /* descriptor of a file to send, or -1 */
    uint64_t file_size;
    struct http_exchange *next_job;
    int64_t queued_ns; /* on the lane of control */
    int64_t counted;   /* of the answer, in answer_bytes */
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
    atomic_llong answer_bytes; /* of large answers that are being sent */
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
    int64_t busy_since[64]; /* of each; 0: it waits */
};

int64_t ll_http_now(void);
void ll_http_set_deadline(http_connection *connection, double seconds);
void ll_http_deadline(http_exchange *exchange, double seconds); /* 0: none */

/* Routing: what can be said before the body is there. Sets `route` or a response with `refused`. */
void ll_http_begin(http_exchange *exchange, const char *version);
/* The whole request is there. True: the response is ready to be sent. False: the connection was suspended,
 * and is resumed when a handler of another lane has made the response; the exchange must then not be touched
 * by the caller. */
bool ll_http_handle(http_exchange *exchange);
void ll_http_run_handler(http_exchange *exchange);

bool ll_http_submit(ll_http *http,
                    http_exchange *exchange); /* to the lane of control; false when it is full */
/* To the lane of work. On an error nobody else has the exchange. */
ll_status ll_http_work(ll_http *http, http_exchange *exchange);

bool ll_http_start_control(ll_http *http); /* one thread more */
void ll_http_stop_control(ll_http *http);
void ll_http_end_work(ll_http *http); /* drains the tasks, and waits for those of requests */

enum MHD_Result ll_http_send(http_exchange *exchange);
void ll_http_compress(http_exchange *exchange); /* the answer, if its client and its kind are for it */
void ll_http_refuse(http_exchange *exchange, int status, ll_code code, const char *field, const char *format,
                    ...) __attribute__((format(printf, 5, 6)));

/* A 101 for a valid upgrade; NULL without memory. */
struct MHD_Response *ll_http_offer_upgrade(ll_http *http, const ll_upgrade *upgrade, http_offer **offer);

/* The page: fills the response (a file, 304 or 404). */
void ll_http_file(http_exchange *exchange);
