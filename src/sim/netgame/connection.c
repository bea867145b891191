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

void ll_netgame_connection_metrics(const ll_netgame *g, int player, cJSON *metrics)
{
    const ll_connection *n = &ll_netgame_client(g, player)->connection;
    const ll_client_slot *client_slot = &ll_netgame_server(g)->client_slots[player];
    cJSON *o = cJSON_AddObjectToObject(metrics, "connection");
    cJSON_AddStringToObject(o, "state", ll_connection_state_names[n->state]);
    cJSON_AddBoolToObject(o, "connected", client_slot->connected);
    ll_netgame_number(o, "joins", (double)n->joins);
    ll_netgame_number(o, "time_outs", (double)n->time_outs);
    ll_netgame_number(o, "drops", (double)client_slot->drops);
    cJSON *seconds = cJSON_AddObjectToObject(o, "seconds");
    for (int state = 0; state < LL_CONNECTION_STATES; state++)
        ll_netgame_number(seconds, ll_connection_state_names[state], in_state_s(g, n, state));
    ll_netgame_number(o, "round_trip_ms", ll_to_ms(ll_clock_sync_round_trip(&n->clock)));
    ll_netgame_number(o, "clock_error_ms", clock_error_ms(g, player));
    ll_netgame_number(o, "clock_snaps", (double)n->clock.snaps);
}
