#include "netcode/server.h"

#include <string.h>

size_t ll_server_size(int players, size_t world_size)
{
    return sizeof(ll_server) + (size_t)players * sizeof(ll_seat) + world_size;
}

void ll_server_init(ll_server *server, int players)
{
    memset(server, 0, ll_server_size(players, 0));
    server->players = players;
}

static void empty_seat(ll_seat *seat, ll_freq client_freq, ll_time now)
{
    for (int i = 0; i < LL_INPUT_RING; i++)
        seat->slots[i].tick = -1;
    seat->held = (ll_action){0};
    seat->acked = 0;
    seat->wants = 0;
    seat->newest = -1;
    seat->slack = seat->last_slack = LL_SLACK_UNKNOWN;
    seat->allowance = (ll_allowance){ll_rate_burst(client_freq), now};
}

void ll_server_start(ll_server *server, uint16_t epoch, ll_freq step_freq, ll_freq update_freq,
                     ll_freq client_freq, ll_time now)
{
    server->epoch = epoch;
    server->clock = (ll_clock){now, server->step, step_freq};
    server->updates = (ll_clock){now, 0, update_freq};
    server->update = 1;
    server->stepped = now;
    server->client_freq = client_freq;
    for (int i = 0; i < server->players; i++)
        empty_seat(&server->seats[i], client_freq, now);
}

/* Where an input belongs: `false` when it has been seen before. */
static bool is_new(const ll_seat *seat, int64_t tick)
{
    if (tick <= seat->newest - LL_INPUT_RING)
        return false; /* so old that its slot is another's */
    return seat->slots[tick & (LL_INPUT_RING - 1)].tick != tick;
}

/* The step, or for a draining server the input, that everything up to is done with. */
static int64_t done(const ll_server *server, const ll_sync *sync, const ll_seat *seat)
{
    return sync->drains ? (int64_t)seat->acked : server->step;
}

static void measure_slack(ll_seat *seat, int64_t ahead, uint32_t seq)
{
    seat->last_slack = (int32_t)(ahead - 1);
    if (seat->slack == LL_SLACK_UNKNOWN || seat->last_slack < seat->slack) {
        seat->slack = seat->last_slack;
        seat->slack_seq = seq;
    }
}

/* What takes the place of a refused input: the one before it. */
static ll_action instead(const ll_seat *seat, int64_t tick)
{
    const ll_input_slot *before = &seat->slots[(tick - 1) & (LL_INPUT_RING - 1)];
    return ll_held(before->tick == tick - 1 ? &before->action : &seat->held);
}

/* An input as the rules see it: where it counts for the time that a key was down, as a share of the longest,
 * which is a tick at least. */
static ll_action judged(const ll_server *server, const ll_sync *sync, const ll_action *input)
{
    ll_action a = *input;
    double ticks = sync->press_s * (double)server->client_freq / 1000, longest = ticks > 1 ? ticks : 1;
    a.axis[0] = (float)(a.axis[0] / longest);
    a.axis[1] = (float)(a.axis[1] / longest);
    return a;
}

int ll_server_receive(ll_server *server, const ll_sync *sync, int player, const void *packet, ll_time now,
                      ll_verdict verdicts[LL_INPUTS_MAX])
{
    const ll_input_message *message = packet;
    ll_seat *seat = &server->seats[player];
    int count = 0;
    if (message->head.epoch != server->epoch)
        return 0;
    seat->wants = message->wants;
    for (int i = 0; i < message->head.count; i++) {
        int64_t tick = message->tick + i;
        if (tick < 1 || !is_new(seat, tick)) {
            seat->duplicate++;
            continue;
        }
        int64_t ahead = tick - done(server, sync, seat);
        ll_verdict *verdict = &verdicts[count++];
        *verdict = (ll_verdict){.seq = message->head.seq + (uint32_t)i};
        ll_action input = judged(server, sync, &message->inputs[i]);
        ll_rule rule = ll_validate(&input, ahead, &seat->allowance, server->client_freq, now);
        if (rule != LL_RULE_NONE) {
            seat->refused[rule]++;
            verdict->outcome = LL_OUTCOME_REFUSED;
            verdict->rule = (uint8_t)rule;
            if (rule == LL_RULE_BUDGET || !sync->tells_refusals)
                continue; /* there is no slot so far ahead, or it is dropped in silence */
        } else if (ahead <= 0 && !sync->drains) {
            seat->late++;
            verdict->outcome = LL_OUTCOME_LATE;
        } else {
            seat->accepted++;
        }
        ll_action action = rule == LL_RULE_NONE ? message->inputs[i] : instead(seat, tick);
        seat->slots[tick & (LL_INPUT_RING - 1)] =
            (ll_input_slot){tick, now, action, verdict->seq, message->tick - message->lead};
        seat->seq_minus_tick = (int64_t)verdict->seq - tick;
        if (tick > seat->newest)
            seat->newest = tick;
        measure_slack(seat, ahead,
                      verdict->seq); /* also of one that comes behind a later: it may be the late one */
    }
    return count;
}

void ll_server_measure(ll_past *past, int player, const ll_input_slot *slot, ll_time now)
{
    if (past)
        past->measured[player] = now - ll_history_time(past->history, slot->seen);
}

int ll_server_message_max(ll_extent extent, int players)
{
    return (int)(sizeof(ll_state_message) + (size_t)(players - 1) * sizeof(ll_controls) +
                 ll_extent_size(extent));
}

/* Appends everybody's controls but those of `player`; returns the end. */
static char *put_controls(const ll_server *server, int player, char *at)
{
    for (int i = 0; i < server->players; i++) {
        const ll_action *held = &server->seats[i].held;
        ll_controls controls = {{held->axis[0], held->axis[1]}, held->buttons};
        if (i == player)
            continue;
        memcpy(at, &controls, sizeof controls);
        at += sizeof controls;
    }
    return at;
}

int ll_server_compose(ll_server *server, int player, void *packet)
{
    ll_seat *seat = &server->seats[player];
    size_t world = ll_world_size(ll_server_world(server));
    uint8_t parts = seat->wants & LL_PART_CONTROLS;
    ll_state_message m = {.head = {LL_MESSAGE_STATE, parts, server->epoch, seat->acked},
                          .tick = server->step,
                          .time = server->stepped,
                          .update_hz = (float)server->updates.freq / 1000.0f,
                          .slack = seat->slack,
                          .slack_seq = seat->slack_seq};
    seat->slack = LL_SLACK_UNKNOWN;
    char *at = packet;
    memcpy(at, &m, sizeof m);
    at += sizeof m;
    if (parts & LL_PART_CONTROLS)
        at = put_controls(server, player, at);
    memcpy(at, ll_server_world(server), world);
    return (int)(at + world - (char *)packet);
}
