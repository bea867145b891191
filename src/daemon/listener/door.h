/* The front door: one TCP port for the page, REST and WebSocket streams.
 *
 *   acceptor thread --- plain HTTP head ---> libmicrohttpd pool --> handlers (http.h)
 *        |                                        | a late upgrade on a kept connection
 *        |                                        v
 *        +------------- valid upgrade -------> stream threads (ws.h)
 *
 * Start order of a daemon: ll_param_defaults(&ll_door_table, &config), set what the command line says,
 * ll_door_open (handlers and hooks may run from here on), ll_ws_stream_open for each session. Stop: readyz
 * turns 503, ll_door_drain, stop publishing workers, ll_door_close.
 *
 * All functions but those of stats may be called by one thread (main) only. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/http/http.h"
#include "daemon/stream/ws.h"
#include "param/param.h"

/* Every setting is a row of ll_door_table: `max_connections` is `--max-connections` on the command line. */
typedef struct ll_door_config {
    char listen[128];         /* ADDR:PORT, [ADDR6]:PORT; port 0 picks a free one */
    char www[512];            /* folder of the page; empty: no page */
    char allow_origin[1024];  /* comma separated: https://lab.example */
    char allow_host[1024];    /* comma separated: lab.example */
    char trusted_proxy[1024]; /* comma separated: 10.0.0.0/8 */
    int64_t http_threads;     /* that read requests and run fast handlers */
    int64_t control_threads;  /* that run the handlers of the lane of control */
    double request_cpu_s;     /* processor time that one request may use */
    int64_t stream_threads;   /* that send frames */
    int64_t max_connections;
    int64_t max_connections_per_ip;
    int64_t max_viewers; /* of one session */
    int64_t max_head_bytes;
    int64_t max_answers_mib;   /* of large answers that are being sent */
    double head_timeout_s;     /* absolute, for a whole request head */
    double body_timeout_s;     /* absolute, for a whole request body */
    double idle_timeout_s;     /* of a kept connection between requests */
    double response_timeout_s; /* absolute, for a whole response */
    int64_t max_message_bytes; /* of a viewer's message */
    double max_messages_per_s; /* of one viewer, sustained; twice that in a burst */
    double hello_timeout_s;    /* a viewer that hosting gave no hello by then is closed */
    double ack_timeout_s;      /* of a viewer that acknowledged before */
    double drain_s;            /* at the end: viewers may take that long to say goodbye */
} ll_door_config;

extern const ll_param_table ll_door_table;

typedef struct ll_door ll_door;

/* What the door counted since it was opened (for /metrics); any thread. */
typedef struct ll_door_stats {
    uint64_t accepted;
    uint64_t refused_total, refused_per_ip; /* 503, 429 */
    uint64_t refused_head;                  /* 400, 408, 431, 505 */
    uint64_t requests;                      /* that reached the HTTP side */
    uint64_t bridged;                       /* upgrades on kept connections */
    uint64_t cut;                           /* slow requests on kept connections */
    uint64_t refused_answers;               /* 503: too much is being sent already */
    uint64_t answer_bytes;                  /* of large answers that are being sent */
    uint64_t connections;                   /* open now, of every kind */
    int control;                            /* requests on the lane of control */
    double control_s;                       /* the longest that one of them has been there */
    ll_ws_stats ws;
} ll_door_stats;

/* Called for what deserves a line in the log; any thread. `level` is "info", "warn" or "error". May be NULL.
 */
typedef void ll_door_log(void *context, const char *level, const char *message);

/* Starts every thread. `routes` must live as long as the door; `config` is copied. */
ll_status ll_door_open(const ll_door_config *config, const ll_http_app *app, const ll_ws_hooks *hooks,
                       ll_door_log *log, void *log_context, ll_door **door);

uint16_t ll_door_port(const ll_door *door);
const char *ll_door_address(const ll_door *door); /* as bound: `127.0.0.1:8080` */
ll_ws *ll_door_ws(ll_door *door);
ll_door_stats ll_door_get_stats(ll_door *door);

/* Closes the listener, says 1001 to all viewers, waits for their goodbye (at most `drain_s`), joins the
 * stream threads: no hook runs after it. Requests on open HTTP connections are still answered. Publishing is
 * harmless and does nothing. */
void ll_door_drain(ll_door *door);

/* Drains if that was not done, joins the rest and frees everything, streams too. NULL is fine. */
void ll_door_close(ll_door *door);
