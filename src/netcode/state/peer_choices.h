/* What a peer keeps for choices that few scenarios make: a mesh, frames that are lengthened, an input delay
 * that adapts. A block has it by itself, and only where one of them is made. */
#pragma once

#include <stdint.h>

#include "base/vtime.h"
#include "netcode/protocol/config.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

#define LL_WAY_WINDOW 256 /* samples of a delay that are kept: some seconds */
#define LL_WAY_TICKS 64   /* a longer delay counts as this, less one */
#define LL_WAY_RING 64    /* ticks; as many as a peer keeps worlds of */

/* What a client knows of its way to another player. Leads are in 1/256 tick; INT16_MIN: unknown. */
typedef struct ll_peer_way {
    int64_t acked; /* over a mesh: that player has the client's inputs up to this tick, as last reported */
    int64_t away;  /* it has left: the server makes its inputs, and takes those of the client in its place */
    int64_t samples;   /* of its delay to that player, all that came */
    int16_t lead;      /* of this client over that player, when the newest packet of it came */
    int16_t latest;    /* ticks from an input of that player to its arrival, of the last report the longest */
    uint32_t reported; /* that has been reported */
    uint16_t counts[LL_WAY_TICKS]; /* of the samples kept, by their ticks */
    uint8_t window[LL_WAY_WINDOW];
} ll_peer_way;

typedef struct ll_peer_choices {
    int64_t budget;                   /* ticks that a rollback may resimulate */
    int64_t delay;                    /* input delay now, where it adapts */
    int64_t changed_at;               /* its tick at the last change of that */
    int64_t want, checks;             /* the longest wanted in the last checks, and their number */
    int64_t delay_changes;            /* from the warm-up on */
    int64_t deep;                     /* from then on too: rollbacks that resimulated more than the budget */
    int64_t stretching;               /* frames are lengthened until the lead is gone */
    ll_time longer;                   /* the last frame, by this much */
    double stretched;                 /* ticks by which frames were lengthened since the game began */
    double stretched_at[LL_WAY_RING]; /* the same when a tick was made */
    ll_peer_way way[LL_PEERS_MAX];
} ll_peer_choices;

#pragma GCC diagnostic pop
