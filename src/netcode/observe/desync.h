/* M12: where a client's world leaves the server's, and how far it goes.
 *
 * The observer sees both sides: it holds the hashes of every confirmed tick against each other, and from the
 * first that differs on it steps the true world beside the client's, so that both are there for the same
 * tick. While nothing differs it costs nothing. Part of a simulation's block: no pointers. */
#pragma once

#include "netcode/server/server.h"
#include "netcode/state/peer.h"

/* The numbers of an entity, in the order of ll_entity. */
enum { LL_FIELDS = 7 };
extern const char
    *const ll_field_names[LL_FIELDS + 2]; /* the last stands for the game's tail; NULL-terminated */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_desync {
    int64_t compared;                   /* the confirmed tick up to which both were compared */
    int64_t tick;                       /* the first that differs; -1: none */
    int32_t entity;                     /* the first of it that differs, -1: only the game's tail does; */
    int32_t field;                      /* and its first field: index into ll_field_names */
    double ulps;                        /* distance of that field: steps between neighbouring doubles */
    double ulps_1s, ulps_10s, ulps_max; /* the same a second and ten later, and the largest so far */
    double error, error_max;            /* m, of the entity that is furthest off, at `compared` */
    /* then the true world of `compared` */
} ll_desync;

#pragma GCC diagnostic pop

size_t ll_desync_size(size_t world_size);
void ll_desync_start(ll_desync *desync, int64_t step);
void ll_desync_observe(ll_desync *desync, const ll_client *client, const ll_client_setup *setup,
                       const ll_server *server);

/* How many doubles lie between two, and one: 0 when they are equal. */
double ll_ulps(double a, double b);
