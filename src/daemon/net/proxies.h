/* Which proxies may say whom they speak for, and for whom they do. Pure functions.
 *
 * A trusted proxy adds the address that it sees to X-Forwarded-For. The client is the last address of that
 * list that is not a trusted proxy's: what stands before it was written by the client itself. */
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

bool ll_proxies_trust(const ll_proxies *proxies, const uint8_t address[16]);
void ll_proxies_address(const struct sockaddr *from, uint8_t address[16]);

/* Replaces `peer`, the text of a trusted proxy's address, by its client's. `forwarded` is what all
 * X-Forwarded-For headers hold, in their order, comma separated. It stays where that names nobody. */
void ll_proxies_client(const ll_proxies *proxies, const char *forwarded, char peer[LL_PEER_TEXT]);

/* How the gate counts a connection from there: those of a trusted proxy in total only. */
ll_connection_limiter_pass ll_proxies_pass(const ll_proxies *proxies, const struct sockaddr *from);
