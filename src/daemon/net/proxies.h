/* Trusted proxies, and the clients whose requests they forward. Pure functions.
 *
 * A trusted proxy appends the address that it sees to X-Forwarded-For. The client is the last address of that
 * list that is not a trusted proxy's; anything before it may be forged by the client. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "daemon/net/connection_limiter.h"

enum { LL_PROXIES_MAX = 64, LL_PEER_TEXT = 48 };

typedef struct ll_network {
    uint8_t address[16]; /* IPv4 mapped */
    int bits;
} ll_network;

typedef struct ll_proxies {
    ll_network network[LL_PROXIES_MAX];
    int count;
} ll_proxies;

/* `text`: addresses and networks, comma separated: `10.0.0.0/8, ::1`. Empty: none. */
ll_status ll_proxies_parse(const char *text, ll_proxies *proxies);

/* The address of a client as text, of IPv6 the /64, by which clients are counted; `?`: not known. */
void ll_proxies_peer(const struct sockaddr *from, char peer[LL_PEER_TEXT]);

/* Replaces `peer`, the address of a trusted proxy as text, by that of its client. `forwarded` is the content
 * of all X-Forwarded-For headers in order, comma separated. No change if it has no valid address. */
void ll_proxies_client(const ll_proxies *proxies, const char *forwarded, char peer[LL_PEER_TEXT]);

/* The pass for a connection from this address: those of a trusted proxy are counted in total only. */
ll_connection_limiter_pass ll_proxies_pass(const ll_proxies *proxies, const struct sockaddr *from);
