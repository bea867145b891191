#include "daemon/net/gate.h"

#include <netinet/in.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "base/assert.h"
#include "base/hash.h"

/* Open addressing over addresses with at least one connection. At most `max_total` are in use, of at least
 * twice as many places. */
typedef struct gate_place {
    uint8_t address[16];
    int count; /* 0: free */
} gate_place;

struct ll_gate {
    pthread_mutex_t lock;
    int total, max_total, max_per_ip;
    uint32_t mask;
    gate_place place[];
};

ll_gate *ll_gate_new(int max_total, int max_per_ip)
{
    uint32_t places = 64;
    while (places < 2 * (uint32_t)max_total) {
        places *= 2;
    }
    ll_gate *gate = calloc(1, sizeof *gate + places * sizeof(gate_place));
    if (gate == NULL) {
        return NULL;
    }
    pthread_mutex_init(&gate->lock, NULL);
    gate->max_total = max_total;
    gate->max_per_ip = max_per_ip;
    gate->mask = places - 1;
    return gate;
}

void ll_gate_free(ll_gate *gate)
{
    if (gate != NULL) {
        pthread_mutex_destroy(&gate->lock);
        free(gate);
    }
}

ll_gate_pass ll_gate_pass_of(const struct sockaddr *address)
{
    ll_gate_pass pass = {.valid = true};
    if (address != NULL && address->sa_family == AF_INET) {
        const struct sockaddr_in *in = (const void *)address;
        pass.address[10] = pass.address[11] = 0xff;
        memcpy(pass.address + 12, &in->sin_addr, 4);
    } else if (address != NULL && address->sa_family == AF_INET6) {
        const struct sockaddr_in6 *in = (const void *)address;
        const uint8_t *bytes = in->sin6_addr.s6_addr;
        bool whole = IN6_IS_ADDR_V4MAPPED(&in->sin6_addr) || IN6_IS_ADDR_LOOPBACK(&in->sin6_addr);
        memcpy(pass.address, bytes, whole ? 16 : 8);
    }
    return pass;
}

static uint32_t home_of(const ll_gate *gate, const uint8_t address[16])
{
    return (uint32_t)ll_hash(0, address, 16) & gate->mask;
}

/* The place of the address, or the free one where it belongs. */
static uint32_t find(const ll_gate *gate, const uint8_t address[16])
{
    uint32_t at = home_of(gate, address);
    while (gate->place[at].count > 0 && memcmp(gate->place[at].address, address, 16) != 0) {
        at = (at + 1) & gate->mask;
    }
    return at;
}

/* Closes the hole at `hole` by moving back what was pushed beyond it (Knuth 6.4, algorithm R). */
static void remove_at(ll_gate *gate, uint32_t hole)
{
    for (uint32_t at = (hole + 1) & gate->mask; gate->place[at].count > 0; at = (at + 1) & gate->mask) {
        uint32_t home = home_of(gate, gate->place[at].address);
        if (((at - home) & gate->mask) >= ((at - hole) & gate->mask)) {
            gate->place[hole] = gate->place[at];
            hole = at;
        }
    }
    gate->place[hole].count = 0;
}

ll_gate_answer ll_gate_enter(ll_gate *gate, const ll_gate_pass *pass)
{
    if (!pass->valid) {
        return LL_GATE_OPEN;
    }
    ll_gate_answer answer = LL_GATE_OPEN;
    pthread_mutex_lock(&gate->lock);
    gate_place *place = pass->many ? NULL : &gate->place[find(gate, pass->address)];
    if (gate->total >= gate->max_total) {
        answer = LL_GATE_FULL;
    } else if (place == NULL) {
        gate->total++;
    } else if (place->count >= gate->max_per_ip) {
        answer = LL_GATE_FULL_FOR_IP;
    } else {
        memcpy(place->address, pass->address, 16);
        place->count++;
        gate->total++;
    }
    pthread_mutex_unlock(&gate->lock);
    return answer;
}

void ll_gate_leave(ll_gate *gate, const ll_gate_pass *pass)
{
    if (!pass->valid) {
        return;
    }
    pthread_mutex_lock(&gate->lock);
    gate->total--;
    if (!pass->many) {
        uint32_t at = find(gate, pass->address);
        LL_ASSERT(gate->place[at].count > 0);
        if (--gate->place[at].count == 0) {
            remove_at(gate, at);
        }
    }
    pthread_mutex_unlock(&gate->lock);
}

int ll_gate_count(ll_gate *gate)
{
    pthread_mutex_lock(&gate->lock);
    int total = gate->total;
    pthread_mutex_unlock(&gate->lock);
    return total;
}
