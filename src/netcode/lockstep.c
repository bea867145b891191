#include "netcode/lockstep.h"

static const ll_input_slot *slot_of(const ll_seat *seat, int64_t k)
{
    return &seat->slots[k & (LL_INPUT_RING - 1)];
}

ll_time ll_lockstep_due(const ll_server *server)
{
    int64_t k = server->step + 1;
    ll_time interval = ll_tick_time(1, server->clock.freq), ready = LL_NEVER;
    for (int i = 0; i < server->players; i++) {
        const ll_seat *seat = &server->seats[i];
        const ll_input_slot *slot = slot_of(seat, k);
        if (!seat->connected)
            continue;
        if (slot->tick != k)
            return LL_NEVER;
        if (ready == LL_NEVER || slot->came > ready)
            ready = slot->came;
    }
    if (ready == LL_NEVER)
        return LL_NEVER; /* nobody plays */
    ll_time due = ready + interval, soonest = server->stepped + interval / LL_LOCKSTEP_CATCH_UP;
    return due > soonest ? due : soonest;
}

/* Step k waited for the last of its inputs. */
static void stall(ll_server *server, int64_t k, ll_time waited)
{
    ll_seat *last = NULL;
    server->stalled += waited;
    for (int i = 0; i < server->players; i++) {
        ll_seat *seat = &server->seats[i];
        if (seat->connected && (!last || slot_of(seat, k)->came > slot_of(last, k)->came))
            last = seat;
    }
    if (last)
        last->waited += waited;
}

void ll_lockstep_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                      ll_time now)
{
    ll_action actions[LL_PLAYERS_MAX];
    int64_t k = ++server->step;
    ll_time interval = ll_tick_time(1, server->clock.freq);
    if (now - server->stepped > interval)
        stall(server, k, now - server->stepped - interval);
    for (int i = 0; i < server->players; i++) {
        ll_seat *seat = &server->seats[i];
        const ll_input_slot *slot = slot_of(seat, k);
        actions[i] = seat->connected ? ll_server_action(server, i, k) : (ll_action){0};
        if (!seat->connected)
            continue;
        seat->acked = slot->seq;
        ll_server_measure(past, i, slot, now);
        ll_seat_done(seat, slot->seq, !ll_seat_replaced(seat, k));
    }
    game->step(ll_server_world(server), env, actions, now, past);
    server->stepped = now;
}
