/* Messages between a spectator of a peer-to-peer sync and who sends it the inputs. */
#pragma once

#include "netcode/protocol/wire.h"

/* To a spectator: the settled inputs of all players for `count` ticks from `tick` on. For each player follow
 * the number of its runs (uint32_t) and the runs. Or a whole world, without inputs. */
typedef struct ll_feed_message {
    ll_message_head head; /* LL_MESSAGE_RELAY; seq: the newest settled tick */
    int32_t tick;
    int32_t count;
    uint32_t world; /* other than 0: the world after tick - 1 follows */
} ll_feed_message;

/* From a spectator. */
typedef struct ll_watch_message {
    ll_message_head head; /* LL_MESSAGE_PING; seq: 0 */
    int32_t known;        /* it has the inputs up to this tick */
    uint32_t request;     /* number of its request for a world; 0: it needs none */
} ll_watch_message;

static inline int ll_feed_message_max(int players)
{
    return (int)(sizeof(ll_feed_message) +
                 (size_t)players * (sizeof(uint32_t) + LL_RUNS_MAX * sizeof(ll_input_run)));
}
