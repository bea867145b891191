/* Where others on the network reach the daemon: origins such as `http://192.168.1.20:8080`, the most likely
 * first. A pure choice, and the list of this machine's interfaces. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum { LL_ORIGINS_MAX = 8, LL_ORIGIN_TEXT = 300, LL_INTERFACES_MAX = 32 };

typedef struct ll_interface {
    char name[32], address[48]; /* `eth0`, `192.168.1.20` or `2001:db8::1` */
} ll_interface;

typedef struct ll_origins {
    char text[LL_ORIGINS_MAX][LL_ORIGIN_TEXT];
    int count;
    bool local; /* only this machine reaches it */
} ll_origins;

typedef struct ll_origins_request {
    const char *bound; /* address that the daemon listens on: `0.0.0.0:8080`, `[::]:8080`, `127.0.0.1:8080` */
    uint16_t port;
    const char *host; /* where the client asked; NULL: unknown */
    bool proxied;     /* through a trusted proxy: only its address counts */
    bool tls;         /* by https */
    const ll_interface *interfaces;
    int interface_count;
} ll_origins_request;

/* Loopback only where there is nothing else. */
void ll_origins_choose(const ll_origins_request *request, ll_origins *origins);

/* Addresses of the interfaces that are up, without loopback and link-local ones. */
int ll_interfaces_list(ll_interface interfaces[LL_INTERFACES_MAX]);
