/* Upgrades that arrive on a connection which libmicrohttpd already owns (a proxy that reuses its
 * connections).
 *
 * libmicrohttpd answers the 101 and gives its socket to the bridge, which relays it to one end of a
 * socketpair; the other end is adopted by the stream side, which gets a request written anew and whose own
 * 101 is swallowed. Buffers are bounded, so backpressure passes through. One thread, started with the first
 * such upgrade. */
#pragma once

#include <stdint.h>

#include "daemon/ws.h"

typedef struct ll_bridge ll_bridge;
struct MHD_Response;
struct ll_upgrade;

ll_bridge *ll_bridge_new(ll_ws *ws); /* NULL without memory */

/* An upgrade that was promised to a client; freed by ll_bridge_forget when the request has ended, whatever
 * became of it. */
typedef struct ll_bridge_offer ll_bridge_offer;

/* A 101 for a valid upgrade, to be queued by the caller with status 101; NULL when the bridge is stopping or
 * has no memory. */
struct MHD_Response *ll_bridge_response(ll_bridge *bridge, const struct ll_upgrade *upgrade,
                                        ll_bridge_offer **offer);
void ll_bridge_forget(ll_bridge_offer *offer); /* NULL is fine */

uint64_t ll_bridge_count(ll_bridge *bridge); /* since the start */

void ll_bridge_stop(ll_bridge *bridge); /* closes all relays and joins; before libmicrohttpd is stopped */
void ll_bridge_free(ll_bridge *bridge); /* after libmicrohttpd was stopped */
