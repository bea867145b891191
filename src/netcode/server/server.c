#include "netcode/server/server.h"

#include <string.h>

#include "base/assert.h"
#include "base/keep.h"
#include "netcode/snapshot/common.h"

size_t ll_server_size(int players, ll_extent extent)
{
    return sizeof(ll_server) + (size_t)players * sizeof(ll_client_slot) + ll_extent_size(extent) +
           ll_baseline_history_size(extent);
}

void ll_server_init(ll_server *server, int players, ll_extent extent)
{
    memset(server, 0, ll_server_size(players, extent));
    server->players = players;
    server->rules.validates = 1;
    ll_world *world = ll_server_world(server);
    world->players = players;
    world->entities = extent.entities;
    world->tail = extent.tail;
    ll_baseline_history_init(ll_server_baseline_history(server), extent);
}

void ll_server_replicate(ll_server *server)
{
    ll_baseline_history *history = ll_server_baseline_history(server);
    history->replicated = 1;
    ll_replicas_init(ll_server_replicas(server), server->players, history->entities);
}

static void configure_replicas(ll_server *server, const ll_server_config *config)
{
    ll_replicas *replicas = ll_server_replicas(server);
    LL_ASSERT(replicas || !ll_codecs[config->snapshot]->selects);
    if (!replicas)
        return;
    if (server->codec != config->snapshot || replicas->selection.radius_m != config->selection.radius_m)
        ll_replicas_forget(replicas);
    replicas->selection = config->selection;
    replicas->tick = -1; /* of another radius */
}

void ll_server_configure(ll_server *server, const ll_server_config *config)
{
    configure_replicas(server, config);
    if (server->codec != config->snapshot)
        ll_baseline_history_clear(
            ll_server_baseline_history(server)); /* baselines sent with another codec or grid may be gone */
    server->codec = (uint16_t)config->snapshot;
    server->rules.mesh = (config->peers & LL_PEERS_MESH) != 0;
    server->rules.validates = config->validation && !server->rules.mesh;
    server->rules.refused = config->refused;
    server->rules.starved = config->starved;
    server->rules.starved_ticks = (int32_t)config->starved_ticks;
    server->barriers.rollback = (int32_t)config->max_rollback_ticks;
    server->rules.starved_tau_ms = config->starved_tau_ms;
    server->grid = (ll_quantization){(float)config->quantum_m, (float)config->quantum_mps,
                                     (float)config->quantum_rad, (float)config->quantum_radps};
}

void ll_client_slot_clear(ll_client_slot *client_slot)
{
    for (int i = 0; i < LL_INPUT_RING; i++)
        client_slot->inputs.ring[i].tick = -1;
    client_slot->inputs.newest = -1;
}

void ll_client_slot_open(ll_client_slot *client_slot, ll_freq client_freq, int64_t step, ll_time now)
{
    ll_slot_inputs *inputs = &client_slot->inputs;
    inputs->held = (ll_action){0};
    inputs->held_step = step;
    inputs->used = (ll_axes){{0}};
    inputs->acked = inputs->processed = inputs->decided = 0;
    inputs->wants = 0;
    memset(inputs->results, 0, sizeof inputs->results);
    client_slot->snapshots.received = client_slot->snapshots.full = 0;
    client_slot->snapshots.slack = client_slot->snapshots.last_slack = LL_SLACK_UNKNOWN;
    client_slot->limits.allowance = (ll_rate_limiter){ll_rate_burst(client_freq), now};
    client_slot->limits.account = (ll_time_budget){0, now};
    client_slot->connection.first = step;
    client_slot->peer =
        (ll_peer_status){.at = -1, .came = now, .relayed = step, .hashed = step, .desync = -1};
    for (int i = 0; i < LL_PEERS_MAX; i++)
        client_slot->peer.acks[i].known = (int32_t)step;
}

void ll_server_start(ll_server *server, ll_freq step_freq, ll_freq update_freq, ll_freq client_freq,
                     ll_time now)
{
    LL_ASSERT(server->players >= 1 && server->players <= LL_PLAYERS_MAX);
    LL_ASSERT(step_freq > 0 && update_freq > 0 && client_freq > 0);
    server->epoch = ll_server_next_epoch(server);
    server->clock = (ll_clock){now, server->step, step_freq};
    server->updates = (ll_clock){now, 0, update_freq};
    server->update = 1;
    server->stepped = now;
    server->next_check = now + LL_CONNECTION_CHECK_INTERVAL;
    server->barriers.tick = server->barriers.resume = 0;
    server->barriers.recovery_until = now;
    server->barriers.due = 0;
    server->client_freq = client_freq;
    ll_baseline_history_clear(ll_server_baseline_history(server));
    for (int i = 0; i < server->players; i++) {
        ll_client_slot_clear(&server->client_slots[i]);
        ll_client_slot_open(&server->client_slots[i], client_freq, server->step, now);
        server->client_slots[i].connection.epoch = server->epoch;
    }
}

/* Whether an input is new: `false` if it arrived before. */
static bool is_new(const ll_slot_inputs *inputs, int64_t tick)
{
    if (tick <= inputs->newest - LL_INPUT_RING)
        return false; /* so old that a later input has its slot */
    return inputs->ring[tick & (LL_INPUT_RING - 1)].tick != tick;
}

/* The step up to which the server has decided all inputs; where inputs are applied on arrival, the input. */
static int64_t decided_upto(const ll_server *server, const ll_sync_mode *sync,
                            const ll_client_slot *client_slot)
{
    return sync->applies_on_arrival ? (int64_t)client_slot->inputs.acked : server->step;
}

static int16_t slack_of(int64_t ahead)
{
    return (int16_t)(ahead > INT16_MAX ? INT16_MAX : ahead <= INT16_MIN ? INT16_MIN : ahead - 1);
}

static void measure_slack(ll_client_slot *client_slot, int64_t ahead, uint32_t seq)
{
    ll_slot_snapshots *snapshots = &client_slot->snapshots;
    snapshots->last_slack = (int32_t)(ahead - 1);
    if (snapshots->slack == LL_SLACK_UNKNOWN || snapshots->last_slack < snapshots->slack) {
        snapshots->slack = snapshots->last_slack;
        client_slot->inputs.slack_seq = seq;
    }
}

/* The replacement of a refused input. */
static __attribute__((noinline)) ll_action replacement(const ll_server *server,
                                                       const ll_client_slot *client_slot, int64_t tick)
{
    if (server->rules.refused == LL_REFUSED_NEUTRAL)
        return (ll_action){0};
    const ll_input_slot *before = &client_slot->inputs.ring[(tick - 1) & (LL_INPUT_RING - 1)];
    return ll_held(before->tick == tick - 1 ? &before->action : &client_slot->inputs.held);
}

static void mark_replaced(ll_slot_inputs *inputs, int64_t tick, bool replaced)
{
    uint64_t *word = &inputs->replaced[(tick & (LL_INPUT_RING - 1)) >> 6], bit = UINT64_C(1) << (tick & 63);
    *word = replaced ? *word | bit : *word & ~bit;
}

/* An input as the rules see it: where the duration of a key press counts, axes are scaled by its share of the
 * longest, which is a tick at least. */
static ll_action normalised(const ll_server *server, const ll_sync_mode *sync, const ll_action *input)
{
    ll_action a = *input;
    double ticks = sync->press_s * (double)server->client_freq / 1000;
    if (ticks > 1) {
        a.axis[0] = (float)(a.axis[0] / ticks);
        a.axis[1] = (float)(a.axis[1] / ticks);
    }
    return a;
}

/* The share of the time budget that the input would use: by its step, or, where inputs are applied on
 * arrival, by all inputs that have arrived. */
static double budget_use(const ll_server *server, const ll_sync_mode *sync, const ll_client_slot *client_slot,
                         const ll_action *input, int64_t ahead, ll_time now)
{
    if (sync->applies_on_arrival)
        return ll_time_use(&client_slot->limits.account, input, server->client_freq, now);
    return ((double)ahead + 1) / (double)ll_budget_ticks(server->client_freq);
}

static __attribute__((noinline)) ll_rule judge_normalised(const ll_server *server, const ll_sync_mode *sync,
                                                          ll_client_slot *client_slot,
                                                          const ll_action *action, double use, ll_time now)
{
    const ll_action relative = normalised(server, sync, action);
    return ll_validate(&relative, use, &client_slot->limits.allowance, server->client_freq, now);
}

/* An input that arrived `ahead` steps before its own, and takes `use` of the time budget. */
static inline ll_rule judge(const ll_server *server, const ll_sync_mode *sync, ll_client_slot *client_slot,
                            const ll_action *action, int64_t ahead, double use, ll_time now)
{
    if (!server->rules.validates) /* the ring has no slot further ahead */
        return ahead >= LL_INPUT_RING && !sync->applies_on_arrival ? LL_RULE_BUDGET : LL_RULE_NONE;
    if (sync->press_s != 0)
        return judge_normalised(server, sync, client_slot, action, use, now);
    return ll_validate(action, use, &client_slot->limits.allowance, server->client_freq, now);
}

/* The newest snapshot that the client had; 0: none. */
static int32_t received_of(const ll_input_message *message)
{
    return message->lead > 0 ? message->tick - message->lead : 0;
}

/* The place of input `seq` for its step, or of what replaces it. */
static ll_input_slot *input_place(ll_slot_inputs *inputs, int64_t tick, uint32_t seq, bool replaces)
{
    LL_ASSERT(tick > inputs->newest - LL_INPUT_RING); /* overwrites no later input */
    mark_replaced(inputs, tick, replaces);
    inputs->seq_minus_tick = (int64_t)seq - tick;
    if (tick > inputs->newest)
        inputs->newest = tick;
    return &inputs->ring[tick & (LL_INPUT_RING - 1)];
}

/* Decides input `i` of a message, a new one. */
static inline void take_input(ll_server *server, const ll_sync_mode *sync, ll_client_slot *client_slot,
                              const ll_input_message *message, int i, ll_time now, ll_input_result *result)
{
    const int64_t tick = message->tick + i, ahead = tick - decided_upto(server, sync, client_slot);
    const ll_action *action = &message->inputs[i];
    const double use = budget_use(server, sync, client_slot, action, ahead, now);
    *result = (ll_input_result){.seq = message->head.seq + (uint32_t)i, .slack = slack_of(ahead)};
    const ll_rule rule = judge(server, sync, client_slot, action, ahead, use, now);
    if (rule != LL_RULE_NONE) {
        client_slot->counts.refused[rule]++;
        result->outcome = LL_OUTCOME_REFUSED;
        result->rule = (uint8_t)rule;
        if (rule == LL_RULE_BUDGET && !sync->applies_on_arrival && i >= message->head.count - message->fresh)
            measure_slack(client_slot, ahead, result->seq); /* its client must learn how far ahead it is */
        if (rule == LL_RULE_BUDGET || !sync->reports_refusals)
            return; /* no slot that far ahead, or dropped without an answer */
    } else if (ahead <= 0 && !sync->applies_on_arrival) {
        client_slot->counts.late++;
        result->outcome = LL_OUTCOME_LATE;
    } else {
        client_slot->counts.accepted++;
    }
    if (rule == LL_RULE_NONE) {
        ll_slot_limits *limits = &client_slot->limits;
        limits->budget_used = use > limits->budget_used ? use : limits->budget_used;
        if (sync->applies_on_arrival)
            ll_time_spend(&limits->account, action, server->client_freq, now);
    }
    ll_input_slot *slot = input_place(&client_slot->inputs, tick, result->seq, rule != LL_RULE_NONE);
    *slot = (ll_input_slot){tick, now, *action, result->seq, received_of(message)};
    if (__builtin_expect(rule != LL_RULE_NONE, 0))
        slot->action = replacement(server, client_slot, tick);
    if (i >= message->head.count - message->fresh) /* a repeated one says nothing about the link's delay */
        measure_slack(client_slot, ahead, result->seq);
}

/* A message says which snapshots the client has. */
static __attribute__((noinline)) void take_received(ll_server *server, int player,
                                                    const ll_input_message *message)
{
    ll_replicas *replicas = ll_server_replicas(server);
    uint32_t before;
    if (!replicas || received_of(message) == 0)
        return;
    memcpy(&before, (const char *)message + ll_input_message_size(message->head.count), sizeof before);
    ll_replica *replica = ll_replicas_of(replicas, player);
    if (replica->epoch == message->head.epoch)
        ll_replica_acknowledge(replica, ll_server_baseline_history(server), received_of(message), before);
}

int ll_server_receive(ll_server *server, const ll_sync_mode *sync, int player, const void *packet,
                      ll_time now, ll_input_result results[LL_INPUTS_MAX])
{
    const ll_input_message *message = packet;
    ll_client_slot *client_slot = &server->client_slots[player];
    LL_KEEP(client_slot);
    ll_slot_inputs *inputs = &client_slot->inputs;
    const int all = message->head.count;
    const int64_t first = message->tick, received = received_of(message);
    int count = 0;
    LL_ASSERT(all <= LL_INPUTS_MAX); /* one result each */
    if (message->head.epoch != client_slot->connection.epoch)
        return 0;
    inputs->wants = message->wants;
    if (received > client_slot->snapshots.received)
        client_slot->snapshots.received = received;
    if (message->wants & LL_PART_RECEIVED)
        take_received(server, player, message);
    for (int i = 0; i < all; i++)
        if (first + i >= 1 && is_new(inputs, first + i))
            take_input(server, sync, client_slot, message, i, now, &results[count++]);
    client_slot->counts.duplicate += all - count;
    return count;
}

void ll_server_measure(ll_past *past, int player, const ll_input_slot *slot, ll_time now)
{
    if (past)
        past->measured[player] = now - ll_history_time(past->history, slot->seen);
}

ll_action ll_server_action(ll_server *server, int player, int64_t step)
{
    LL_ASSERT(player >= 0 && player < server->players && step >= 0);
    const ll_client_slot *client_slot = &server->client_slots[player];
    ll_slot_inputs *inputs = &server->client_slots[player].inputs;
    const ll_input_slot *slot = &inputs->ring[step & (LL_INPUT_RING - 1)];
    ll_action action;
    if (slot->tick == step) {
        action = slot->action;
        /* the controls of a disconnected player have no effect */
        inputs->held = client_slot->connection.connected ? action : (ll_action){0};
        inputs->held_step = step;
    } else {
        double steps_per_ms = (double)server->clock.freq / 1e6;
        ll_starve_config config = {server->rules.starved_tau_ms * steps_per_ms, server->rules.starved_ticks};
        action = ll_starves[server->rules.starved]->act(&inputs->held, step - inputs->held_step, &config);
    }
    inputs->used = (ll_axes){{action.axis[0], action.axis[1]}};
    return action;
}

static void set_input_result(ll_slot_inputs *inputs, uint32_t seq, bool applied)
{
    uint32_t *word = &inputs->results[seq / 32 % LL_INPUT_RESULT_WORDS], bit = UINT32_C(1) << (seq & 31);
    *word = applied ? *word | bit : *word & ~bit;
}

void ll_client_slot_done(ll_client_slot *client_slot, uint32_t seq, bool applied)
{
    ll_slot_inputs *inputs = &client_slot->inputs;
    /* an input that was overtaken, or never arrived, is not applied yet */
    while (inputs->decided + 1 < seq)
        set_input_result(inputs, ++inputs->decided, false);
    if (inputs->decided < seq)
        inputs->decided = seq;
    set_input_result(inputs, seq, applied);
    if (applied && seq > inputs->processed)
        inputs->processed = seq;
    LL_ASSERT(inputs->processed <= inputs->decided);
}

int ll_server_message_max(ll_extent extent, int players)
{
    return (int)(sizeof(ll_snapshot_message) + (size_t)(players - 1) * sizeof(ll_axes) +
                 sizeof(ll_input_result_part) + LL_INPUT_RESULT_WORDS_MAX * sizeof(uint32_t) +
                 ll_extent_size(extent));
}

/* Appends the axes of all players but `player` in the last step; returns the end. */
static __attribute__((noinline)) char *put_axes(const ll_server *server, int player, char *at)
{
    for (int i = 0; i < server->players; i++) {
        if (i == player)
            continue;
        memcpy(at, &server->client_slots[i].inputs.used, sizeof(ll_axes));
        at += sizeof(ll_axes);
    }
    return at;
}

static bool was_applied(const ll_slot_inputs *inputs, uint32_t seq)
{
    return inputs->results[seq / 32 % LL_INPUT_RESULT_WORDS] >> (seq & 31) & 1;
}

/* Words for the inputs decided since the snapshot that the client is known to have; where inputs belong to no
 * step, for all that are kept. */
static uint32_t result_words(const ll_server *server, const ll_client_slot *client_slot,
                             const ll_sync_mode *sync)
{
    int64_t since = sync->applies_on_arrival || client_slot->snapshots.received == 0
                        ? LL_INPUT_RESULT_WORDS_MAX * 32
                        : server->step - client_slot->snapshots.received;
    int64_t most = client_slot->inputs.decided < since ? client_slot->inputs.decided : since;
    int64_t words = (most + 31) / 32;
    return (uint32_t)(words < LL_INPUT_RESULT_WORDS_MAX ? words : LL_INPUT_RESULT_WORDS_MAX);
}

/* Appends the results of inputs; returns the end. */
static __attribute__((noinline)) char *put_results(const ll_server *server, const ll_client_slot *client_slot,
                                                   const ll_sync_mode *sync, char *at)
{
    ll_input_result_part part = {client_slot->inputs.decided, result_words(server, client_slot, sync)};
    memcpy(at, &part, sizeof part);
    at += sizeof part;
    for (uint32_t w = 0; w < part.words; w++, at += sizeof(uint32_t)) {
        uint32_t word = 0;
        for (uint32_t i = 0; i < 32 && 32 * w + i < part.newest; i++)
            word |= (uint32_t)was_applied(&client_slot->inputs, part.newest - 32 * w - i) << i;
        memcpy(at, &word, sizeof word);
    }
    return at;
}

/* Returns the number of bits; the encoding is too long if that exceeds the size of the full world. */
static int64_t encode(const ll_codec *codec, const ll_outgoing *out, uint8_t *bytes, ll_snapshot_cost *cost)
{
    ll_bit_writer w = {.bytes = bytes, .capacity = 8 * (int64_t)ll_world_size(out->world)};
    *cost = (ll_snapshot_cost){.whole = !codec->compares};
    codec->encode(&w, out, cost);
    return w.count;
}

/* The receiver's replica, and what all have in common. */
static __attribute__((noinline)) void add_replica(const ll_server *server, int player, ll_outgoing *out)
{
    const ll_slot_connection *connection = &server->client_slots[player].connection;
    out->replicas = ll_server_replicas(server);
    out->replica = ll_replicas_of(out->replicas, player);
    if (out->replica->epoch != connection->epoch)
        ll_replica_restart(out->replica, out->world->entities, connection->epoch);
}

enum { COMMON_LEAST = 8 }; /* a copy of fewer entities takes as long as encoding them */

/* Returns the bytes of the world and records its encoding in `m`. */
static int put_world(ll_server *server, int player, ll_snapshot_common *common, uint8_t *bytes,
                     ll_snapshot_message *m)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    bool counts = server->stepped >= server->from;
    ll_outgoing out = {.world = ll_server_world(server),
                       .self = player,
                       .receivers = server->players,
                       .grid = &server->grid,
                       .counts = counts,
                       .tick = server->step};
    const ll_codec *codec = ll_codecs[server->codec];
    const ll_baseline *from = NULL;
    ll_snapshot_cost cost;
    if (codec->gridded) {
        ll_baseline_history *all = ll_server_baseline_history(server);
        const ll_baseline *now =
            ll_baseline_history_take(all, out.world, server->step, &server->grid, counts);
        if (codec->selects)
            add_replica(server, player, &out);
        if ((codec->compares || codec->selects) &&
            client_slot->snapshots.received > client_slot->snapshots.full)
            from = ll_baseline_history_find(all, client_slot->snapshots.received);
        out.cells = now->cell;
        out.baseline = from ? from->cell : NULL;
        out.same_tail = from && from->tail_version == now->tail_version;
        if (out.world->entities - server->players >= COMMON_LEAST)
            out.common = common;
    }
    if (codec->compares && !from)
        codec = &ll_codec_quantised;
    int64_t bits = encode(codec, &out, bytes, &cost);
    if (bits > 8 * (int64_t)ll_world_size(out.world)) { /* never with a limit of its own */
        codec = &ll_codec_full;
        bits = encode(codec, &out, bytes, &cost);
        client_slot->snapshots.full = server->step;
    }
    m->codec = (uint16_t)ll_codec_index(codec);
    m->baseline = from && codec->gridded ? (uint16_t)(server->step - from->tick) : 0;
    if (counts)
        ll_snapshot_cost_add(&client_slot->counts.sent, &cost);
    return (int)((bits + 7) / 8);
}

/* As put_world, with dead reckoning. A player who has acknowledged no snapshot since it was admitted lacks
 * what was sent before, or may have no state at all: one that is admitted again still names its newest. */
static __attribute__((noinline)) int put_reckoned(ll_server *server, int player, ll_reckoning *reckoning,
                                                  uint8_t *bytes, ll_snapshot_message *m)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    const ll_world *world = ll_server_world(server);
    ll_snapshot_cost cost = {0};
    ll_bit_writer w = {.bytes = bytes,
                       .capacity =
                           8 * (int64_t)ll_world_size(world) + ll_reckoning_extra_bits(world->entities)};
    bool whole = client_slot->snapshots.received <= client_slot->connection.first;
    ll_reckoning_encode(reckoning, player, world, server->stepped, whole, &w, &cost);
    LL_ASSERT(w.count <= w.capacity);
    m->codec = (uint16_t)ll_codec_index(&ll_codec_full);
    if (server->stepped >= server->from)
        ll_snapshot_cost_add(&client_slot->counts.sent, &cost);
    return (int)((w.count + 7) / 8);
}

static int compose(ll_server *server, const ll_sync_mode *sync, int player, ll_snapshot_common *common,
                   ll_reckoning *reckoning, void *packet)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    uint8_t parts = client_slot->inputs.wants & (LL_PART_AXES | LL_PART_APPLIED);
    ll_snapshot_message m = {
        .head = {LL_MESSAGE_SNAPSHOT, parts, client_slot->connection.epoch, client_slot->inputs.acked},
        .tick = server->step,
        .time = server->stepped,
        .update_hz = (float)server->updates.freq / 1000.0f,
        .applied = client_slot->inputs.processed,
        .slack = client_slot->snapshots.slack,
        .slack_seq = client_slot->inputs.slack_seq};
    client_slot->snapshots.slack = LL_SLACK_UNKNOWN;
    char *at = (char *)packet + sizeof m;
    if (parts & LL_PART_AXES)
        at = put_axes(server, player, at);
    if (parts & LL_PART_APPLIED)
        at = put_results(server, client_slot, sync, at);
    int world = reckoning ? put_reckoned(server, player, reckoning, (uint8_t *)at, &m)
                          : put_world(server, player, common, (uint8_t *)at, &m);
    memcpy(packet, &m, sizeof m);
    return (int)(at - (char *)packet) + world;
}

int ll_server_compose(ll_server *server, const ll_sync_mode *sync, int player, ll_snapshot_common *common,
                      void *packet)
{
    return compose(server, sync, player, common, NULL, packet);
}

int ll_server_compose_reckoned(ll_server *server, const ll_sync_mode *sync, int player,
                               ll_reckoning *reckoning, void *packet)
{
    return compose(server, sync, player, NULL, reckoning, packet);
}
