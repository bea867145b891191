#include "netcode/server/by_clock.h"

ll_time ll_by_clock_due(const ll_server *server)
{
    return ll_clock_time(&server->clock, server->step + 1);
}

void ll_by_clock_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                      ll_time now)
{
    ll_action actions[LL_PLAYERS_MAX];
    int64_t k = ++server->step;
    for (int i = 0; i < server->players; i++) {
        ll_client_slot *client_slot = &server->client_slots[i];
        const ll_input_slot *slot = &client_slot->inputs.ring[k & (LL_INPUT_RING - 1)];
        bool begun = client_slot->connection.connected && client_slot->inputs.newest >= 0 &&
                     k + client_slot->inputs.seq_minus_tick > 0;
        actions[i] = ll_server_action(server, i, k);
        if (slot->tick != k && begun)
            client_slot->counts.starved++;
        ll_server_measure(past, i, slot, now);
        if (!begun)
            continue;
        client_slot->inputs.acked = (uint32_t)(k + client_slot->inputs.seq_minus_tick);
        ll_client_slot_done(client_slot, client_slot->inputs.acked,
                            slot->tick == k && !ll_client_slot_replaced(client_slot, k));
    }
    game->step(ll_server_world(server), env, actions, now, past);
    server->stepped = now;
}
