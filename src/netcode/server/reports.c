#include "netcode/server/reports.h"

#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

#define ROUNDING 1e-9 /* m/s, rad and rad/s: a client and a bound may round differently */
#define STEPS_MAX 512 /* between two reports; more count as this many */
#define MEMBERS 6     /* of a motion */

_Static_assert(sizeof(ll_motion) == MEMBERS * sizeof(double), "a motion is a list of its members");

static const ll_param rows[] = {
    {LL_PARAM_ROW("allowance_m", REAL, ll_report_params, allowance_m), .max = 100, .default_value = 1,
     .unit = "m",
     .help = "Distance that a player with authority position may report beyond what the game permits, in all "
             "while it is connected."},
};

const ll_param_table ll_report_table = {.name = "reports",
                                        .help = "Validation of the positions that clients report.",
                                        LL_PARAM_ROWS(rows, ll_report_params)};

void ll_reports_init(ll_reports *reports, const ll_report_params *params, int players)
{
    reports->allowance_m = params->allowance_m;
    reports->players = players;
}

/* ---- receiving ---- */

void ll_reports_take(ll_reports *reports, const ll_server *server, int player, const void *packet)
{
    ll_report_slot *slot = &reports->slot[player];
    ll_input_message head;
    memcpy(&head, packet, offsetof(ll_input_message, inputs));
    const int64_t tick = head.tick + (int64_t)head.head.count - 1;
    int at = ll_input_message_size(head.head.count);
    if (!slot->reports || !(head.wants & LL_PART_STATE) ||
        head.head.epoch != server->client_slots[player].connection.epoch)
        return;
    if (tick <= server->step || tick > server->step + LL_REPORT_RING) {
        slot->late += tick <= server->step;
        return;
    }
    at += head.wants & LL_PART_RECEIVED ? (int)sizeof(uint32_t) : 0;
    ll_report *report = &slot->ring[tick & (LL_REPORT_RING - 1)];
    report->tick = tick;
    memcpy(&report->state, (const char *)packet + at, sizeof report->state);
}

/* ---- judging ---- */

typedef struct bounds {
    double low[MEMBERS], high[MEMBERS];
} bounds;

static void extend(bounds *b, const ll_entity *e)
{
    const ll_motion state = ll_motion_of(e);
    double member[MEMBERS];
    memcpy(member, &state, sizeof member);
    for (int k = 0; k < MEMBERS; k++) {
        b->low[k] = member[k] < b->low[k] ? member[k] : b->low[k];
        b->high[k] = member[k] > b->high[k] ? member[k] : b->high[k];
    }
}

/* What the entity of `player` can be after `steps` steps from `from`: full axes bound it (ll_game). */
static bounds reach(const ll_game *game, const ll_game_env *env, int player, const ll_entity *from,
                    int64_t steps)
{
    _Alignas(8) char bytes[sizeof(ll_world) + LL_PLAYERS_MAX * sizeof(ll_entity)] = {0};
    ll_world *world = (ll_world *)(void *)bytes;
    bounds b;
    world->players = world->entities = LL_PLAYERS_MAX;
    for (int k = 0; k < MEMBERS; k++) {
        b.low[k] = __builtin_inf();
        b.high[k] = -__builtin_inf();
    }
    for (int corner = 0; corner < 4; corner++) {
        const ll_action full = {.axis = {corner & 1 ? 1 : -1, corner & 2 ? 1 : -1}};
        world->entity[player] = *from;
        for (int64_t k = 0; k < steps && k < STEPS_MAX; k++)
            game->step_own(world, env, player, &full);
        extend(&b, &world->entity[player]);
    }
    return b;
}

/* Distance of a value from its bounds; NaN of a NaN. */
static double outside(const bounds *b, int k, double value)
{
    double below = b->low[k] - value, above = value - b->high[k];
    return below > 0 ? below : above > 0 ? above : value - value;
}

/* The allowance that would be used if `state` were accepted; NaN: it is outside of what may be, however small
 * the distance. Velocities and angles have no allowance: a little too much speed in each report adds up. */
static double use_of(const ll_report_slot *slot, const bounds *b, const ll_motion *state)
{
    double member[MEMBERS];
    memcpy(member, state, sizeof member);
    for (int k = 2; k < MEMBERS; k++)
        if (!(outside(b, k, member[k]) <= ROUNDING))
            return __builtin_nan("");
    const double x = outside(b, 0, member[0]), y = outside(b, 1, member[1]);
    return slot->used_m + ll_sqrt(x * x + y * y);
}

/* Rounding does not add up either: what is kept lies within the bounds. */
static ll_motion within(const bounds *b, const ll_motion *state)
{
    double member[MEMBERS];
    ll_motion kept;
    memcpy(member, state, sizeof member);
    for (int k = 2; k < MEMBERS; k++)
        member[k] = ll_clamp(member[k], b->low[k], b->high[k]);
    memcpy(&kept, member, sizeof kept);
    return kept;
}

static bool is_finite(const ll_motion *m)
{
    const double sum = m->x + m->y + m->vx + m->vy + m->angle + m->angular_velocity;
    return sum - sum == 0;
}

/* True: the reported state is now the entity's. */
static bool accept(const ll_reports *reports, ll_report_slot *slot, const ll_server *server,
                   const ll_game *game, const ll_game_env *env, int player, ll_entity *own)
{
    const ll_motion *state = &slot->ring[server->step & (LL_REPORT_RING - 1)].state;
    if (!server->rules.validates) {
        if (is_finite(state))
            ll_motion_set(own, state);
        return is_finite(state);
    }
    const bounds b = reach(game, env, player, &slot->anchor, server->step - slot->anchor_step);
    const double use = use_of(slot, &b, state);
    if (!(use <= reports->allowance_m))
        return false;
    const ll_motion kept = within(&b, state);
    ll_motion_set(own, &kept);
    slot->used_m = use;
    return true;
}

static void anchor(ll_report_slot *slot, const ll_entity *own, int64_t step)
{
    slot->anchor = *own;
    slot->anchor_step = step;
}

/* A player who has just been accepted starts from the server's state. */
static void begin(ll_report_slot *slot, const ll_client_slot *client_slot, const ll_entity *own, int64_t step)
{
    slot->epoch = client_slot->connection.epoch;
    slot->used_m = 0;
    slot->refused_seq = 0;
    anchor(slot, own, step);
}

/* False: a report was refused. */
static bool settle(ll_reports *reports, ll_server *server, const ll_game *game, const ll_game_env *env,
                   int player)
{
    ll_report_slot *slot = &reports->slot[player];
    const ll_client_slot *client_slot = &server->client_slots[player];
    ll_entity *own = &ll_server_world(server)->entity[player];
    const int64_t step = server->step;
    const ll_input_slot *input = &client_slot->inputs.ring[step & (LL_INPUT_RING - 1)];
    if (slot->epoch != client_slot->connection.epoch) {
        begin(slot, client_slot, own, step);
        return true;
    }
    if (input->tick == step && ll_client_slot_replaced(client_slot, step)) {
        anchor(slot, own, step); /* another rule refused the input, and with it the report */
        slot->refused_seq = input->seq;
        return true;
    }
    if (slot->ring[step & (LL_REPORT_RING - 1)].tick != step || input->tick != step) {
        slot->missing += client_slot->connection.connected && client_slot->inputs.newest >= 0;
        return true;
    }
    const bool accepted = accept(reports, slot, server, game, env, player, own);
    slot->accepted += accepted;
    slot->refused += !accepted;
    slot->refused_seq = accepted ? slot->refused_seq : input->seq;
    anchor(slot, own, step);
    return accepted;
}

uint64_t ll_reports_apply(ll_reports *reports, ll_server *server, const ll_game *game, const ll_game_env *env)
{
    uint64_t refused = 0;
    for (int i = 0; i < server->players; i++)
        if (reports->slot[i].reports && !settle(reports, server, game, env, i))
            refused |= UINT64_C(1) << i;
    return refused;
}

void ll_reports_mark(const ll_reports *reports, int player, void *packet)
{
    memcpy((char *)packet + offsetof(ll_snapshot_message, refused), &reports->slot[player].refused_seq,
           sizeof reports->slot[player].refused_seq);
}
