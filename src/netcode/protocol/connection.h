/* A client's connection to the server: one state machine for all sync modes.
 *
 *   connecting -> synchronising -> playing <-> stalled -> disconnected -> resynchronising -> playing
 *                                     ^-- resynchronising <--'
 *
 * A client that is connecting or disconnected sends a connect request every LL_CONNECT_RETRY. The server's
 * answer starts a new epoch of this player. Then pings measure the clock, LL_SYNC_EVERY apart at first and
 * LL_PING_EVERY apart later. A ping is also sent if nothing else was sent for LL_KEEP_ALIVE. A client that
 * receives nothing for LL_NOTICE is stalled, and disconnected after `timeout_s`.
 *
 * Inputs are made when playing, stalled and resynchronising. All of this costs packets on the player's link.
 */
#pragma once

#include <stdbool.h>

#include "netcode/protocol/clock_sync.h"
#include "netcode/protocol/config.h"

#define LL_LOBBY (10 * LL_SECOND) /* before time 0, for players to connect and to measure their clocks */
#define LL_CONNECT_RETRY (LL_SECOND / 2)
#define LL_SYNC_EVERY (50 * LL_MS)
#define LL_SYNC_SAMPLES 5 /* samples until the clock counts as measured */
#define LL_PING_EVERY (LL_SECOND / 4)
#define LL_KEEP_ALIVE (LL_SECOND / 10)
#define LL_NOTICE (LL_SECOND / 2)

typedef enum ll_connection_state {
    LL_CONNECTION_CONNECTING,
    LL_CONNECTION_SYNCHRONISING,
    LL_CONNECTION_PLAYING,
    LL_CONNECTION_STALLED,
    LL_CONNECTION_RESYNCHRONISING,
    LL_CONNECTION_DISCONNECTED,
    LL_CONNECTION_STATES
} ll_connection_state;

extern const char *const ll_connection_state_names[LL_CONNECTION_STATES + 1]; /* NULL-terminated */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_connection {
    ll_clock_sync clock;
    ll_time since;         /* when the state began */
    ll_time last_received; /* when the last packet of the server arrived */
    ll_time sent;          /* when the last packet of any kind was sent */
    ll_time asks;          /* when the next connect or ping is due */
    ll_time seen;          /* server time of the newest answer received; LL_NEVER: none */
    uint32_t attempt;
    uint32_t pings;
    int32_t measured; /* clock samples since the state began */
    uint16_t epoch;   /* as sent by the server */
    uint8_t state;    /* ll_connection_state */
    uint8_t joined;   /* has played before */
    int64_t joins, time_outs;
    ll_time in_state[LL_CONNECTION_STATES]; /* time spent in each state that has ended */
} ll_connection;

#pragma GCC diagnostic pop

void ll_connection_init(ll_connection *connection, ll_time now);

static inline bool ll_connection_plays(const ll_connection *connection)
{
    return connection->state == LL_CONNECTION_PLAYING || connection->state == LL_CONNECTION_STALLED ||
           connection->state == LL_CONNECTION_RESYNCHRONISING;
}
