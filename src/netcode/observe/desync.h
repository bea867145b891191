/* Desync detection: the tick at which a client's world departs from the server's, and how far it goes.
 *
 * The observer sees both sides. It compares the hashes of every confirmed tick. From the first tick that
 * differs on, it steps the true world along with the client's, so that both are available for the same tick.
 * While nothing differs it costs nothing. Part of a simulation's block: no pointers. */
#pragma once

#include "netcode/server/server.h"
#include "netcode/state/peer.h"

/* Number of fields of an entity, in the order of ll_entity. */
enum { LL_FIELDS = 7 };
extern const char
    *const ll_field_names[LL_FIELDS + 2]; /* the last name stands for the game's tail; NULL-terminated */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_desync {
    int64_t compared; /* the confirmed tick up to which both were compared */
    int64_t tick;     /* the first that differs; -1: none */
    int32_t entity;   /* first entity that differs in it; -1: only the game's tail does */
    int32_t field;    /* first field of that entity that differs: index into ll_field_names */
    double ulps;      /* difference of that field, in representable doubles */
    double ulps_1s, ulps_10s, ulps_max; /* the same 1 s and 10 s later, and the largest so far */
    double error, error_max;            /* m, of the entity with the largest error, at `compared` */
    /* then the true world of `compared` */
} ll_desync;

#pragma GCC diagnostic pop

size_t ll_desync_size(size_t world_size);
void ll_desync_start(ll_desync *desync, int64_t step);
void ll_desync_observe(ll_desync *desync, const ll_client *client, const ll_client_setup *setup,
                       const ll_server *server);

/* Number of representable doubles from one to the other: 0 if they are equal. */
double ll_ulps(double a, double b);
