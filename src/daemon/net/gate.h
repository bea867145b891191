/* Counts open connections, in total and by address, over all who own sockets: acceptor, HTTP, streams.
 *
 * Whoever closes a socket leaves the gate with the pass that it was admitted with. Any thread. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

struct sockaddr;
typedef struct ll_gate ll_gate;

/* An IPv6 address; a mapped one for IPv4. IPv6 peers count by their /64, which is what one customer gets. */
typedef struct ll_gate_pass {
    uint8_t address[16];
    bool valid; /* false: counted nowhere */
    bool many;  /* of a trusted proxy: counted in total only */
} ll_gate_pass;

typedef enum ll_gate_answer { LL_GATE_OPEN, LL_GATE_FULL, LL_GATE_FULL_FOR_IP } ll_gate_answer;

ll_gate *ll_gate_new(int max_total, int max_per_ip); /* NULL without memory */
void ll_gate_free(ll_gate *gate);

ll_gate_pass ll_gate_pass_of(const struct sockaddr *address);
ll_gate_answer ll_gate_enter(ll_gate *gate, const ll_gate_pass *pass);
void ll_gate_leave(ll_gate *gate, const ll_gate_pass *pass);
int ll_gate_count(ll_gate *gate);
