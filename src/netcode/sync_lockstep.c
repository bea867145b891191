/* Lockstep as the paper means it (Figure 10): the server makes step k one interval after the last player's
 * input for k has come, and clients draw what it has confirmed. Nothing is guessed, so nothing is corrected;
 * one slow player slows everybody. */
#include "netcode/client.h"
#include "netcode/server.h"

static ll_time due(const ll_server *server)
{
    int64_t k = server->step + 1;
    ll_time ready = server->stepped;
    for (int i = 0; i < server->players; i++) {
        const ll_input_slot *slot = &server->seats[i].slots[k & (LL_INPUT_RING - 1)];
        if (slot->tick != k)
            return LL_NEVER;
        if (slot->came > ready)
            ready = slot->came;
    }
    return ready + ll_tick_time(1, server->clock.freq);
}

static void step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past, ll_time now)
{
    ll_action actions[LL_PLAYERS_MAX];
    int64_t k = ++server->step;
    ll_time interval = ll_tick_time(1, server->clock.freq);
    if (now - server->stepped > interval)
        server->stalled += now - server->stepped - interval;
    for (int i = 0; i < server->players; i++) {
        ll_seat *seat = &server->seats[i];
        const ll_input_slot *slot = &seat->slots[k & (LL_INPUT_RING - 1)];
        actions[i] = seat->held = slot->action;
        seat->acked = slot->seq;
        ll_server_measure(past, i, slot, now);
        ll_seat_done(seat, slot->seq, !ll_seat_replaced(seat, k));
    }
    game->step(ll_server_world(server), env, actions, now, past);
    server->stepped = now;
}

const ll_sync ll_sync_lockstep = {
    .name = "lockstep",
    .help = "The server waits for every player's input; clients draw what it has confirmed.",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .waits = true,
    .sends_idle = true,
    .tells_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .due = due,
    .step = step,
    .take = ll_server_receive,
    .compose = ll_server_compose,
    .receive = ll_client_receive,
    .frame = ll_client_frame,
    .interpolate = ll_interpolate_server_time,
};
