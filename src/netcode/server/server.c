#include "netcode/server/server.h"

#include <string.h>

size_t ll_server_size(int players, ll_extent extent)
{
    return sizeof(ll_server) + (size_t)players * sizeof(ll_seat) + ll_extent_size(extent) +
           ll_baselines_size(extent);
}

void ll_server_init(ll_server *server, int players, ll_extent extent)
{
    memset(server, 0, ll_server_size(players, extent));
    server->players = players;
    server->validates = 1;
    ll_world *world = ll_server_world(server);
    world->players = players;
    world->entities = extent.entities;
    world->tail = extent.tail;
    ll_baselines_init(ll_server_baselines(server), extent);
}

void ll_server_configure(ll_server *server, const ll_server_config *config)
{
    if (server->codec != config->snapshot)
        ll_baselines_clear(ll_server_baselines(server)); /* clients may no longer hold what was sent so */
    server->codec = (uint16_t)config->snapshot;
    server->validates = config->validation;
    server->refused = config->refused;
    server->starved = config->starved;
    server->starved_ticks = (int32_t)config->starved_ticks;
    server->rollback = (int32_t)config->max_rollback_ticks;
    server->starved_tau_ms = config->starved_tau_ms;
    server->grid = (ll_grid){(float)config->quantum_m, (float)config->quantum_mps, (float)config->quantum_rad,
                             (float)config->quantum_radps};
}

void ll_seat_clear(ll_seat *seat)
{
    for (int i = 0; i < LL_INPUT_RING; i++)
        seat->slots[i].tick = -1;
    seat->newest = -1;
}

void ll_seat_open(ll_seat *seat, ll_freq client_freq, int64_t step, ll_time now)
{
    seat->held = (ll_action){0};
    seat->held_step = step;
    seat->used = (ll_axes){{0}};
    seat->acked = seat->processed = seat->decided = 0;
    seat->wants = 0;
    memset(seat->verdicts, 0, sizeof seat->verdicts);
    seat->received = seat->full = 0;
    seat->slack = seat->last_slack = LL_SLACK_UNKNOWN;
    seat->allowance = (ll_allowance){ll_rate_burst(client_freq), now};
    seat->account = (ll_time_account){0, now};
    seat->first = step;
    seat->peer = (ll_refereed){.at = -1, .came = now, .relayed = step, .hashed = step, .desync = -1};
    for (int i = 0; i < LL_PLAYERS_MAX; i++)
        seat->peer.heard[i].known = (int32_t)step;
}

void ll_server_start(ll_server *server, ll_freq step_freq, ll_freq update_freq, ll_freq client_freq,
                     ll_time now)
{
    server->epoch = ll_server_next_epoch(server);
    server->clock = (ll_clock){now, server->step, step_freq};
    server->updates = (ll_clock){now, 0, update_freq};
    server->update = 1;
    server->stepped = now;
    server->tend = now + LL_TEND_EVERY;
    server->hold = server->resume = 0;
    server->even = now;
    server->uneven = 0;
    server->client_freq = client_freq;
    ll_baselines_clear(ll_server_baselines(server));
    for (int i = 0; i < server->players; i++) {
        ll_seat_clear(&server->seats[i]);
        ll_seat_open(&server->seats[i], client_freq, server->step, now);
        server->seats[i].epoch = server->epoch;
    }
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

static int16_t slack_of(int64_t ahead)
{
    return (int16_t)(ahead > INT16_MAX ? INT16_MAX : ahead <= INT16_MIN ? INT16_MIN : ahead - 1);
}

static void measure_slack(ll_seat *seat, int64_t ahead, uint32_t seq)
{
    seat->last_slack = (int32_t)(ahead - 1);
    if (seat->slack == LL_SLACK_UNKNOWN || seat->last_slack < seat->slack) {
        seat->slack = seat->last_slack;
        seat->slack_seq = seq;
    }
}

/* What takes the place of a refused input. */
static ll_action instead(const ll_server *server, const ll_seat *seat, int64_t tick)
{
    if (server->refused == LL_REFUSED_NEUTRAL)
        return (ll_action){0};
    const ll_input_slot *before = &seat->slots[(tick - 1) & (LL_INPUT_RING - 1)];
    return ll_held(before->tick == tick - 1 ? &before->action : &seat->held);
}

static void mark_replaced(ll_seat *seat, int64_t tick, bool replaced)
{
    uint64_t *word = &seat->replaced[(tick & (LL_INPUT_RING - 1)) >> 6], bit = UINT64_C(1) << (tick & 63);
    *word = replaced ? *word | bit : *word & ~bit;
}

/* An input as the rules see it: where it counts for the time that a key was down, as a share of the longest,
 * which is a tick at least. */
static ll_action judged(const ll_server *server, const ll_sync *sync, const ll_action *input)
{
    ll_action a = *input;
    double ticks = sync->press_s * (double)server->client_freq / 1000;
    if (ticks > 1) {
        a.axis[0] = (float)(a.axis[0] / ticks);
        a.axis[1] = (float)(a.axis[1] / ticks);
    }
    return a;
}

/* How much of the time budget the input would put in use: by the step that it is for, or, where inputs count
 * as they come, by all that have come. */
static double budget_use(const ll_server *server, const ll_sync *sync, const ll_seat *seat,
                         const ll_action *input, int64_t ahead, ll_time now)
{
    if (sync->drains)
        return ll_time_use(&seat->account, input, server->client_freq, now);
    return ((double)ahead + 1) / (double)ll_budget_ticks(server->client_freq);
}

static ll_rule judge(const ll_server *server, const ll_sync *sync, ll_seat *seat, const ll_action *input,
                     int64_t ahead, double use, ll_time now)
{
    ll_action relative = judged(server, sync, input);
    if (!server->validates) /* there is no slot further ahead */
        return ahead >= LL_INPUT_RING && !sync->drains ? LL_RULE_BUDGET : LL_RULE_NONE;
    return ll_validate(&relative, use, &seat->allowance, server->client_freq, now);
}

/* Notes the newest state that the client has. */
static void take_received(ll_seat *seat, const ll_input_message *message)
{
    int64_t tick = message->lead > 0 ? message->tick - message->lead : 0;
    if (tick > seat->received)
        seat->received = tick;
}

int ll_server_receive(ll_server *server, const ll_sync *sync, int player, const void *packet, ll_time now,
                      ll_verdict verdicts[LL_INPUTS_MAX])
{
    const ll_input_message *message = packet;
    ll_seat *seat = &server->seats[player];
    int count = 0;
    if (message->head.epoch != seat->epoch)
        return 0;
    seat->wants = message->wants;
    take_received(seat, message);
    for (int i = 0; i < message->head.count; i++) {
        int64_t tick = message->tick + i;
        if (tick < 1 || !is_new(seat, tick)) {
            seat->duplicate++;
            continue;
        }
        int64_t ahead = tick - done(server, sync, seat);
        ll_verdict *verdict = &verdicts[count++];
        *verdict = (ll_verdict){.seq = message->head.seq + (uint32_t)i, .slack = slack_of(ahead)};
        double use = budget_use(server, sync, seat, &message->inputs[i], ahead, now);
        ll_rule rule = judge(server, sync, seat, &message->inputs[i], ahead, use, now);
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
        if (rule == LL_RULE_NONE) {
            seat->budget_used = use > seat->budget_used ? use : seat->budget_used;
            if (sync->drains)
                ll_time_spend(&seat->account, &message->inputs[i], server->client_freq, now);
        }
        ll_action action = rule == LL_RULE_NONE ? message->inputs[i] : instead(server, seat, tick);
        seat->slots[tick & (LL_INPUT_RING - 1)] = (ll_input_slot){
            tick, now, action, verdict->seq, message->lead > 0 ? message->tick - message->lead : 0};
        mark_replaced(seat, tick, rule != LL_RULE_NONE);
        seat->seq_minus_tick = (int64_t)verdict->seq - tick;
        if (tick > seat->newest)
            seat->newest = tick;
        if (i >= message->head.count -
                     message->fresh) /* what was lost and is repeated tells nothing of the link */
            measure_slack(seat, ahead, verdict->seq);
    }
    return count;
}

void ll_server_measure(ll_past *past, int player, const ll_input_slot *slot, ll_time now)
{
    if (past)
        past->measured[player] = now - ll_history_time(past->history, slot->seen);
}

ll_action ll_server_action(ll_server *server, int player, int64_t step)
{
    ll_seat *seat = &server->seats[player];
    const ll_input_slot *slot = &seat->slots[step & (LL_INPUT_RING - 1)];
    ll_action action;
    if (slot->tick == step) {
        action = slot->action;
        seat->held = seat->connected ? action : (ll_action){0}; /* nothing of who is gone goes on */
        seat->held_step = step;
    } else {
        double steps_per_ms = (double)server->clock.freq / 1e6;
        ll_starve_config config = {server->starved_tau_ms * steps_per_ms, server->starved_ticks};
        action = ll_starves[server->starved]->act(&seat->held, step - seat->held_step, &config);
    }
    seat->used = (ll_axes){{action.axis[0], action.axis[1]}};
    return action;
}

static void set_verdict(ll_seat *seat, uint32_t seq, bool applied)
{
    uint32_t *word = &seat->verdicts[seq / 32 % LL_VERDICT_WORDS], bit = UINT32_C(1) << (seq & 31);
    *word = applied ? *word | bit : *word & ~bit;
}

void ll_seat_done(ll_seat *seat, uint32_t seq, bool applied)
{
    for (; seat->decided < seq; seat->decided++) /* what was overtaken, or never came, is not applied yet */
        set_verdict(seat, seat->decided + 1, false);
    set_verdict(seat, seq, applied);
    if (applied && seq > seat->processed)
        seat->processed = seq;
}

int ll_server_message_max(ll_extent extent, int players)
{
    return (int)(sizeof(ll_state_message) + (size_t)(players - 1) * sizeof(ll_axes) +
                 sizeof(ll_verdict_part) + LL_VERDICT_WORDS_MAX * sizeof(uint32_t) + ll_extent_size(extent));
}

/* Appends what everybody's axes were in the last step, but those of `player`; returns the end. */
static char *put_axes(const ll_server *server, int player, char *at)
{
    for (int i = 0; i < server->players; i++) {
        if (i == player)
            continue;
        memcpy(at, &server->seats[i].used, sizeof(ll_axes));
        at += sizeof(ll_axes);
    }
    return at;
}

static bool was_applied(const ll_seat *seat, uint32_t seq)
{
    return seat->verdicts[seq / 32 % LL_VERDICT_WORDS] >> (seq & 31) & 1;
}

/* Inputs that the server is done with since the state that the client is known to have; where inputs belong
 * to no step, all that are kept. */
static uint32_t verdict_words(const ll_server *server, const ll_seat *seat, const ll_sync *sync)
{
    int64_t since =
        sync->drains || seat->received == 0 ? LL_VERDICT_WORDS_MAX * 32 : server->step - seat->received;
    int64_t most = seat->decided < since ? seat->decided : since;
    int64_t words = (most + 31) / 32;
    return (uint32_t)(words < LL_VERDICT_WORDS_MAX ? words : LL_VERDICT_WORDS_MAX);
}

/* Appends the verdicts; returns the end. */
static char *put_verdicts(const ll_server *server, const ll_seat *seat, const ll_sync *sync, char *at)
{
    ll_verdict_part part = {seat->decided, verdict_words(server, seat, sync)};
    memcpy(at, &part, sizeof part);
    at += sizeof part;
    for (uint32_t w = 0; w < part.words; w++, at += sizeof(uint32_t)) {
        uint32_t word = 0;
        for (uint32_t i = 0; i < 32 && 32 * w + i < part.newest; i++)
            word |= (uint32_t)was_applied(seat, part.newest - 32 * w - i) << i;
        memcpy(at, &word, sizeof word);
    }
    return at;
}

static void add_cost(ll_snapshot_cost *sum, const ll_snapshot_cost *cost)
{
    sum->entity_bits += cost->entity_bits;
    sum->tail_bits += cost->tail_bits;
    sum->entities += cost->entities;
    sum->unchanged += cost->unchanged;
    sum->resting += cost->resting;
    sum->whole += cost->whole;
}

/* Returns the bits, which are too many when they exceed the full world's. */
static int64_t encode(const ll_codec *codec, const ll_outgoing *out, uint8_t *bytes, ll_snapshot_cost *cost)
{
    ll_bit_writer w = {.bytes = bytes, .capacity = 8 * (int64_t)ll_world_size(out->world)};
    *cost = (ll_snapshot_cost){.whole = !codec->compares};
    codec->encode(&w, out, cost);
    return w.count;
}

/* Returns the bytes of the world and notes in `m` how it is told. */
static int put_world(ll_server *server, int player, uint8_t *bytes, ll_state_message *m)
{
    ll_seat *seat = &server->seats[player];
    bool counts = server->stepped >= server->from;
    ll_outgoing out = {.world = ll_server_world(server), .self = player, .grid = &server->grid};
    const ll_codec *codec = ll_codecs[server->codec];
    const ll_baseline *from = NULL;
    ll_snapshot_cost cost;
    if (codec->gridded) {
        ll_baselines *all = ll_server_baselines(server);
        const ll_baseline *now = ll_baselines_take(all, out.world, server->step, &server->grid, counts);
        if (codec->compares && seat->received > seat->full)
            from = ll_baselines_find(all, seat->received);
        out.cells = now->cell;
        out.baseline = from ? from->cell : NULL;
        out.same_tail = from && from->tail_version == now->tail_version;
    }
    if (codec->compares && !from)
        codec = &ll_codec_quantised;
    int64_t bits = encode(codec, &out, bytes, &cost);
    if (bits > 8 * (int64_t)ll_world_size(out.world)) {
        codec = &ll_codec_full;
        bits = encode(codec, &out, bytes, &cost);
        seat->full = server->step;
    }
    m->codec = (uint16_t)ll_codec_index(codec);
    m->baseline = codec->compares ? (uint16_t)(server->step - from->tick) : 0;
    if (counts)
        add_cost(&seat->sent, &cost);
    return (int)((bits + 7) / 8);
}

int ll_server_compose(ll_server *server, const ll_sync *sync, int player, void *packet)
{
    ll_seat *seat = &server->seats[player];
    uint8_t parts = seat->wants & (LL_PART_AXES | LL_PART_APPLIED);
    ll_state_message m = {.head = {LL_MESSAGE_STATE, parts, seat->epoch, seat->acked},
                          .tick = server->step,
                          .time = server->stepped,
                          .update_hz = (float)server->updates.freq / 1000.0f,
                          .applied = seat->processed,
                          .slack = seat->slack,
                          .slack_seq = seat->slack_seq};
    seat->slack = LL_SLACK_UNKNOWN;
    char *at = (char *)packet + sizeof m;
    if (parts & LL_PART_AXES)
        at = put_axes(server, player, at);
    if (parts & LL_PART_APPLIED)
        at = put_verdicts(server, seat, sync, at);
    int world = put_world(server, player, (uint8_t *)at, &m);
    memcpy(packet, &m, sizeof m);
    return (int)(at - (char *)packet) + world;
}
