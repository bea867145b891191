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
#include "daemon/net/config.h"
#include "daemon/stream/ws.h"

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
