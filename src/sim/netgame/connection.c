/* Reports of a player's connection and of its measured clock. */
#include <cjson/cJSON.h>

#include "sim/netgame/netgame.h"

/* Includes the time of the lobby, before time 0. */
static double in_state_s(const ll_netgame *g, const ll_connection *n, int state)
{
    return ll_to_s(n->in_state[state] + (n->state == state ? g->now - n->since : 0));
}

/* Offset in use minus the true offset of the clocks. */
static double clock_error_ms(const ll_netgame *g, int player)
{
    ll_client_setup s = {.config = &g->config.players[player]};
    const ll_clock_sync *clock = &ll_netgame_client(g, player)->connection.clock;
    return ll_to_ms(clock->offset + ll_client_local(&s, g->now) - g->now);
}

#define CONNECTION(X)                                                                                        \
    X(text, state, NULL, ll_connection_state_names[n->state],                                                \
      "state of the connection, as the client has it", NULL)                                                 \
    X(flag, connected, NULL, client_slot->connection.connected,                                              \
      "whether the server has the player as connected", NULL)                                                \
    X(count, joins, NULL, n->joins, "times that the client joined the game", NULL)                           \
    X(events, time_outs, NULL, n->time_outs, "connections that the client gave up after a time-out", NULL)   \
    X(events, drops, NULL, client_slot->connection.drops, "times that the server dropped the player", NULL)  \
    X(by_name, seconds, "s",                                                                                 \
      ((ll_metric_reading){                                                                                  \
          .number = LL_CONNECTION_STATES, .numbers = seconds, .names = ll_connection_state_names}),          \
      "time that the client spent in each state of the connection", NULL)                                    \
    X(number, round_trip_ms, "ms", ll_to_ms(ll_clock_sync_round_trip(&n->clock)),                            \
      "longest round-trip time of the last eight pings", NULL)                                               \
    X(number, clock_error_ms, "ms", clock_error_ms(g, player),                                               \
      "error of clock synchronisation: the client's estimate of the server's clock less that clock", NULL)   \
    X(events, clock_snaps, NULL, n->clock.snaps,                                                             \
      "times that the client's estimate of the server's clock jumped", NULL)

const ll_metric_table ll_netgame_connection_table = {LL_OF_PLAYERS(".connection"),
                                                     .help = "The player's connection, the lobby included.",
                                                     LL_METRICS_FROM(CONNECTION)};

void ll_netgame_connection_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    const ll_connection *n = &ll_netgame_client(g, player)->connection;
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[player];
    double seconds[LL_CONNECTION_STATES];
    for (int state = 0; state < LL_CONNECTION_STATES; state++)
        seconds[state] = in_state_s(g, n, state);
    LL_METRICS_PUT(cJSON_AddObjectToObject(metrics, "connection"), &ll_netgame_connection_table, CONNECTION);
}
