/* The listener: reads the head of each new connection without consuming it (MSG_PEEK) and hands the socket
 * over to HTTP or to the streams.
 *
 * One thread with an edge-triggered epoll. It answers some errors itself, as problem documents: heads that
 * take too long (408), are too large (431) or are not HTTP/1 (400, 505), and connections beyond the limits
 * (503, 429). After handing a socket over it never uses it again. */
#pragma once

#include <stdint.h>

#include "base/status.h"
#include "daemon/http/http.h"
#include "daemon/net/connection_limiter.h"
#include "daemon/net/upgrade.h"
#include "daemon/stream/ws.h"

typedef struct ll_acceptor ll_acceptor;
struct ll_web_server_config;

typedef struct ll_acceptor_counts {
    uint64_t accepted, refused_total, refused_per_ip, refused_head;
} ll_acceptor_counts;

/* Binds and listens (so that the port is known), without accepting yet. `inherited` >= 0 is a socket that
 * already listens; it is closed if this fails. */
ll_status ll_acceptor_listen(const struct ll_web_server_config *config, int inherited,
                             ll_acceptor **acceptor);
struct ll_proxies;
ll_status ll_acceptor_start(ll_acceptor *acceptor, const ll_allow *allow, const struct ll_proxies *proxies,
                            ll_connection_limiter *connection_limiter, ll_http *http, ll_ws *ws);

const char *ll_acceptor_address(const ll_acceptor *acceptor);
uint16_t ll_acceptor_port(const ll_acceptor *acceptor);
ll_acceptor_counts ll_acceptor_get_counts(ll_acceptor *acceptor);

/* Closes the listener; drops connections whose head is incomplete. The thread continues to watch HTTP
 * connections. */
void ll_acceptor_close_listener(ll_acceptor *acceptor);
void ll_acceptor_stop(ll_acceptor *acceptor); /* joins and frees */
