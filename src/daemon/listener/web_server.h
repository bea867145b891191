/* The web server: one TCP port for the page, REST and WebSocket streams.
 *
 *   acceptor thread --- plain HTTP head ---> libmicrohttpd pool --> handlers (http.h)
 *        |                                        | an upgrade on a kept connection, or with a query
 *        |                                        v
 *        +------------- valid upgrade -------> stream threads (ws.h)
 *
 * Start order of a daemon: ll_param_defaults(&ll_web_server_table, &config), set the command line's options,
 * ll_web_server_open (handlers may run from here on), ll_ws_set_hooks, ll_ws_stream_open for each session.
 * Stop: readyz returns 503, ll_web_server_drain, stop publishing workers, ll_web_server_close.
 *
 * Only one thread (main) may call these functions, except those of statistics. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/http/http.h"
#include "daemon/net/config.h"
#include "daemon/stream/ws.h"

typedef struct ll_web_server ll_web_server;

/* Counters of the web server since its start (for /metrics); any thread. */
typedef struct ll_web_server_stats {
    uint64_t accepted;
    uint64_t refused_total, refused_per_ip; /* 503, 429 */
    uint64_t refused_head;                  /* 400, 408, 431, 505 */
    uint64_t requests;                      /* that reached the HTTP side */
    uint64_t bridged;                       /* upgrades on kept connections, or with a query */
    uint64_t cut;                           /* slow requests on kept connections */
    uint64_t refused_answers;               /* 503: max_answers_mib reached */
    uint64_t answer_bytes;                  /* of large answers being sent */
    uint64_t connections;                   /* open now, of every kind */
    int control;                            /* requests for the thread pool */
    double control_s;                       /* age of the oldest of them */
    double stalled_s;                       /* since there are some and none ended */
    ll_ws_stats ws;
} ll_web_server_stats;

/* Starts all threads. `routes` must live as long as the web server; `config` is copied. */
ll_status ll_web_server_open(const ll_web_server_config *config, const ll_http_app *app,
                             ll_web_server **web_server);

uint16_t ll_web_server_port(const ll_web_server *web_server);
const char *ll_web_server_address(const ll_web_server *web_server); /* as bound: `127.0.0.1:8080` */
ll_ws *ll_web_server_ws(ll_web_server *web_server);
ll_web_server_stats ll_web_server_get_stats(ll_web_server *web_server);

/* Closes the listener, sends 1001 to all viewers, waits for their close frames (at most `drain_s`), joins the
 * stream threads: no hook runs afterwards. Requests on open HTTP connections are still answered. Publishing
 * has no effect then. */
void ll_web_server_drain(ll_web_server *web_server);

/* Drains if not done yet, joins the other threads and frees everything, streams too. NULL: no effect. */
void ll_web_server_close(ll_web_server *web_server);
