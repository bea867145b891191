#include "netcode/server/lockstep.h"

#include "base/assert.h"

#define RHYTHM_GAP (60 * LL_MS)
#define RHYTHM_MANY 4 /* minimum number of inputs in flight when a client stops making them */
#define RHYTHM_KEPT (4 * LL_SECOND)
#define RHYTHM_BLUR 256 /* accepted lateness of a step, as a part of an interval: links have jitter */

static const ll_input_slot *slot_of(const ll_client_slot *client_slot, int64_t k)
{
    return &client_slot->inputs.ring[k & (LL_INPUT_RING - 1)];
}

/* Time at which the player's inputs arrive, relative to the ticks of the clock that the game began with. The
 * server measures the part within an interval; the client reports the number of whole intervals. */
static ll_time offset_of(const ll_server *server, const ll_client_slot *client_slot)
{
    ll_time came = slot_of(client_slot, client_slot->inputs.newest)->came - server->clock.epoch;
    int64_t whole = ll_tick_at(came > 0 ? came : 0, server->clock.freq);
    return came - ll_tick_time(whole, server->clock.freq) +
           ll_tick_time(client_slot->connection.offset, server->clock.freq);
}

/* The player whose inputs arrived last at the start: the farthest one, its clock's phase included. */
static const ll_client_slot *farthest(const ll_server *server)
{
    const ll_client_slot *last = NULL;
    ll_time most = -1;
    for (int i = 0; i < server->players; i++) {
        const ll_client_slot *client_slot = &server->client_slots[i];
        if (!client_slot->connection.connected || client_slot->inputs.newest < 0)
            continue;
        ll_time offset = offset_of(server, client_slot);
        if (offset > most) {
            most = offset;
            last = client_slot;
        }
    }
    return last;
}

/* In steady state any player's inputs may be the last of an interval, those of the others arriving up to an
 * interval earlier; which one depends on the history. After an outage, steps are made again when the inputs
 * of the farthest player arrive: less than one interval later than possible. */
static ll_time align_to_farthest(const ll_server *server, ll_time due)
{
    ll_time interval = ll_tick_time(1, server->clock.freq), blur = interval / RHYTHM_BLUR;
    const ll_client_slot *last = farthest(server);
    if (last == NULL || slot_of(last, server->step + 1)->came + interval == due)
        return due;
    ll_time beyond = (due - slot_of(last, last->inputs.newest)->came) % interval, behind = blur / 2;
    beyond += beyond < 0 ? interval : 0;
    if (beyond > blur)
        beyond -= interval;
    return beyond < behind ? due + behind - beyond : due; /* its next input has certainly arrived by then */
}

/* One interval after the last input for the next step; LL_NEVER: that input has not arrived, or no player is
 * connected. */
static ll_time earliest_due(const ll_server *server)
{
    int64_t k = server->step + 1;
    ll_time ready = LL_NEVER;
    for (int i = 0; i < server->players; i++) {
        const ll_client_slot *client_slot = &server->client_slots[i];
        const ll_input_slot *slot = slot_of(client_slot, k);
        if (!client_slot->connection.connected)
            continue;
        if (slot->tick != k)
            return LL_NEVER;
        if (ready == LL_NEVER || slot->came > ready)
            ready = slot->came;
    }
    return ready == LL_NEVER ? LL_NEVER : ready + ll_tick_time(1, server->clock.freq);
}

/* Not before the delayed steps are made, at LL_LOCKSTEP_CATCH_UP times the rate. */
static ll_time limit_rate(const ll_server *server, ll_time due)
{
    ll_time soonest = server->stepped + ll_tick_time(1, server->clock.freq) / LL_LOCKSTEP_CATCH_UP;
    return due > soonest ? due : soonest;
}

ll_time ll_lockstep_due(const ll_server *server)
{
    return limit_rate(server, earliest_due(server));
}

ll_time ll_lockstep_due_in_rhythm(const ll_server *server)
{
    ll_time due = earliest_due(server);
    if (due > server->stepped && due < server->barriers.recovery_until)
        due = align_to_farthest(server, due);
    return limit_rate(server, due);
}

/* Whether the player's input for step k arrived after an outage: long after the input before it, or together
 * with the inputs of that much time. */
static bool came_late(const ll_server *server, const ll_client_slot *client_slot, int64_t k)
{
    ll_time interval = ll_tick_time(1, server->clock.freq);
    int64_t inputs = (RHYTHM_GAP + interval - 1) / interval;
    const ll_input_slot *slot = slot_of(client_slot, k), *before = slot_of(client_slot, k - 1);
    const ll_input_slot *behind = slot_of(client_slot, k + (inputs < RHYTHM_MANY ? inputs : RHYTHM_MANY));
    if (before->tick != k - 1 && client_slot->peer.came > server->clock.epoch)
        return true; /* the player has joined again */
    if (behind->tick > k && behind->came == slot->came)
        return true;
    return before->tick == k - 1 && slot->came - before->came > interval + RHYTHM_GAP;
}

/* Step k waited for the last of its inputs. */
static void stall(ll_server *server, int64_t k, ll_time waited)
{
    ll_client_slot *last = NULL;
    server->stalled += waited;
    for (int i = 0; i < server->players; i++) {
        ll_client_slot *client_slot = &server->client_slots[i];
        if (client_slot->connection.connected &&
            (!last || slot_of(client_slot, k)->came > slot_of(last, k)->came))
            last = client_slot;
    }
    if (last)
        last->counts.waited += waited;
}

void ll_lockstep_step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                      ll_time now)
{
    ll_action actions[LL_PLAYERS_MAX];
    int64_t k = ++server->step;
    LL_ASSERT(now >= server->stepped); /* the time of steps does not decrease */
    ll_time interval = ll_tick_time(1, server->clock.freq);
    if (now - server->stepped > interval)
        stall(server, k, now - server->stepped - interval);
    for (int i = 0; i < server->players; i++) {
        ll_client_slot *client_slot = &server->client_slots[i];
        const ll_input_slot *slot = slot_of(client_slot, k);
        actions[i] = client_slot->connection.connected ? ll_server_action(server, i, k) : (ll_action){0};
        if (!client_slot->connection.connected)
            continue;
        LL_ASSERT(slot->tick == k && slot->came <= now); /* no step without all inputs */
        client_slot->inputs.acked = slot->seq;
        ll_server_measure(past, i, slot, now);
        ll_client_slot_done(client_slot, slot->seq, !ll_client_slot_replaced(client_slot, k));
    }
    game->step(ll_server_world(server), env, actions, now, past);
    server->stepped = now;
}

void ll_lockstep_step_in_rhythm(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                                ll_time now)
{
    ll_time interval = ll_tick_time(1, server->clock.freq);
    bool waited = now - server->stepped > interval + interval / RHYTHM_BLUR;
    for (int i = 0; i < server->players && waited; i++) {
        const ll_client_slot *client_slot = &server->client_slots[i];
        if (client_slot->connection.connected && came_late(server, client_slot, server->step + 1))
            server->barriers.recovery_until = now + RHYTHM_KEPT;
    }
    ll_lockstep_step(server, game, env, past, now);
}
