#include "daemon/net/connection_limiter.h"

#include <netinet/in.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

#include "base/assert.h"
#include "base/hash.h"

/* Open addressing over addresses with at least one connection. At most `max_total` are in use; the table has
 * at least twice as many places. */
typedef struct connection_limiter_slot {
    uint8_t address[16];
    int count; /* 0: free */
} connection_limiter_slot;

struct ll_connection_limiter {
    pthread_mutex_t lock;
    int total, max_total, max_per_ip;
    uint32_t mask;
    connection_limiter_slot place[];
};

ll_connection_limiter *ll_connection_limiter_new(int max_total, int max_per_ip)
{
    uint32_t places = 64;
    while (places < 2 * (uint32_t)max_total)
        places *= 2;
    ll_connection_limiter *connection_limiter =
        calloc(1, sizeof *connection_limiter + places * sizeof(connection_limiter_slot));
    if (connection_limiter == NULL)
        return NULL;
    pthread_mutex_init(&connection_limiter->lock, NULL);
    connection_limiter->max_total = max_total;
    connection_limiter->max_per_ip = max_per_ip;
    connection_limiter->mask = places - 1;
    return connection_limiter;
}

void ll_connection_limiter_free(ll_connection_limiter *connection_limiter)
{
    if (connection_limiter != NULL) {
        pthread_mutex_destroy(&connection_limiter->lock);
        free(connection_limiter);
    }
}

ll_connection_limiter_pass ll_connection_limiter_pass_of(const struct sockaddr *address)
{
    ll_connection_limiter_pass pass = {.valid = true};
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

static uint32_t home_of(const ll_connection_limiter *connection_limiter, const uint8_t address[16])
{
    return (uint32_t)ll_hash(0, address, 16) & connection_limiter->mask;
}

/* The place of the address, or the free place for it. */
static uint32_t find(const ll_connection_limiter *connection_limiter, const uint8_t address[16])
{
    uint32_t at = home_of(connection_limiter, address);
    while (connection_limiter->place[at].count > 0 &&
           memcmp(connection_limiter->place[at].address, address, 16) != 0)
        at = (at + 1) & connection_limiter->mask;
    return at;
}

/* Fills the hole at `hole` by moving later entries back (Knuth 6.4, algorithm R). */
static void remove_at(ll_connection_limiter *connection_limiter, uint32_t hole)
{
    for (uint32_t at = (hole + 1) & connection_limiter->mask; connection_limiter->place[at].count > 0;
         at = (at + 1) & connection_limiter->mask) {
        uint32_t home = home_of(connection_limiter, connection_limiter->place[at].address);
        if (((at - home) & connection_limiter->mask) >= ((at - hole) & connection_limiter->mask)) {
            connection_limiter->place[hole] = connection_limiter->place[at];
            hole = at;
        }
    }
    connection_limiter->place[hole].count = 0;
}

ll_connection_limiter_answer ll_connection_limiter_enter(ll_connection_limiter *connection_limiter,
                                                         const ll_connection_limiter_pass *pass)
{
    if (!pass->valid)
        return LL_CONNECTION_LIMITER_OPEN;
    ll_connection_limiter_answer answer = LL_CONNECTION_LIMITER_OPEN;
    pthread_mutex_lock(&connection_limiter->lock);
    connection_limiter_slot *place =
        pass->many ? NULL : &connection_limiter->place[find(connection_limiter, pass->address)];
    if (connection_limiter->total >= connection_limiter->max_total) {
        answer = LL_CONNECTION_LIMITER_FULL;
    } else if (place == NULL) {
        connection_limiter->total++;
    } else if (place->count >= connection_limiter->max_per_ip) {
        answer = LL_CONNECTION_LIMITER_FULL_FOR_IP;
    } else {
        memcpy(place->address, pass->address, 16);
        place->count++;
        connection_limiter->total++;
    }
    pthread_mutex_unlock(&connection_limiter->lock);
    return answer;
}

void ll_connection_limiter_leave(ll_connection_limiter *connection_limiter,
                                 const ll_connection_limiter_pass *pass)
{
    if (!pass->valid)
        return;
    pthread_mutex_lock(&connection_limiter->lock);
    LL_ASSERT(connection_limiter->total > 0);
    connection_limiter->total--;
    if (!pass->many) {
        uint32_t at = find(connection_limiter, pass->address);
        LL_ASSERT(connection_limiter->place[at].count > 0);
        if (--connection_limiter->place[at].count == 0)
            remove_at(connection_limiter, at);
    }
    pthread_mutex_unlock(&connection_limiter->lock);
}

int ll_connection_limiter_count(ll_connection_limiter *connection_limiter)
{
    pthread_mutex_lock(&connection_limiter->lock);
    int total = connection_limiter->total;
    pthread_mutex_unlock(&connection_limiter->lock);
    return total;
}
