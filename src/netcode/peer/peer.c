#include "netcode/state/peer.h"

#include <string.h>

#include "base/assert.h"

#include "netcode/protocol/limits.h"
#include "netcode/state/weapon_prediction.h"

/* No client waits for a hash: one packet in HASHES_EVERY carries the hashes that the relay server lacks. */
#define HASHES_EVERY 4

/* Time sync (GGPO): a client that is ahead of the slowest by a tick or more waits. */
#define TIME_SYNC_EVERY 10 /* frames between two checks */
#define TIME_SYNC_MAX 9    /* maximum number of frames to wait at once (GGPO) */

#define ROUND_MAX LL_SECOND /* a longer first round includes an outage */

/* A client that joins again before the server has dropped it has sent inputs for ticks that the server has
 * not made yet: it still has them. */
static void keep_own_inputs(ll_peer *peer, int self, const ll_controls *earlier, const ll_client_begin *begin)
{
    for (int64_t tick = begin->step + 1; tick <= begin->own; tick++)
        *ll_peer_input(peer, self, tick) = earlier[tick & (LL_PEER_RING - 1)];
}

void ll_peer_start(ll_client *c, const ll_client_setup *s, const ll_client_begin *begin)
{
    ll_peer *peer = ll_client_peer(c);
    const ll_world *world = begin->world;
    const int64_t step = begin->step, first = begin->first;
    ll_controls earlier[LL_PEER_RING];
    LL_ASSERT(first >= step && first - step < LL_PEER_RING - LL_SYNC_TEST_MAX && begin->own <= first);
    memcpy(earlier, peer->player[c->self].inputs, sizeof earlier);
    memset(peer, 0, ll_peer_size(world->players, 0));
    keep_own_inputs(peer, c->self, earlier, begin);
    peer->ticks = (ll_clock){c->snapshots.game_start, c->snapshots.game_start_step,
                             c->ticks.clock.freq}; /* that of all peers, even after a late join */
    peer->start = peer->tick = peer->confirmed = peer->hashed = step;
    peer->first = first;
    peer->began = step;
    peer->since = LL_NEVER;
    peer->wrong = LL_NEVER;
    for (int p = 0; p < world->players; p++) {
        peer->player[p].known = p == c->self ? first : step;
        peer->player[p].at = -1;
    }
    memcpy(ll_peer_world(c, step), world, (size_t)c->layout.world_size);
    c->inputs.tick = first;
    c->view_step = step;
    if (s->choices) {
        ll_mesh_start(c, s);
        ll_pacing_start(s);
    }
}

/* ---- received packets ---- */

/* The server has made the steps up to `tick`: own inputs for them were applied. */
static void take_steps(ll_client *c, const ll_client_setup *s, int64_t tick, ll_time now)
{
    for (int64_t k = c->latest.tick + 1; k <= tick; k++) {
        const ll_pending_input *p = ll_client_input_at(c, k);
        if (p)
            ll_client_metrics_acknowledged(s->client_metrics, p->seq, k, p->made, now, now);
    }
}

/* Reads a part and returns where the next one begins. */
static const char *take_part(ll_client *c, const ll_client_setup *s, const char *at, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    const ll_relay_part *part = (const ll_relay_part *)(const void *)at;
    const ll_input_run *runs = (const ll_input_run *)(part + 1);
    int64_t tick = part->tick, known = peer->player[part->player].known;
    ll_peer_take_lead(c, s, part, now);
    if (ll_peer_meshed(s))
        ll_mesh_note_away(s, part->player);
    for (int r = 0; r < part->runs; r++)
        for (uint32_t i = 0; i < runs[r].count; i++)
            if (tick++ == peer->player[part->player].known + 1) /* most repeat earlier ones */
                ll_peer_take_input(peer, part->player, tick - 1, &runs[r].input);
    if (ll_peer_paced(s) && peer->player[part->player].known > known)
        ll_pacing_inputs_came(c, s, part->player, known + 1, now);
    return (const char *)(runs + part->runs);
}

/* Whether the barrier is over. */
static bool is_over(const ll_client *c, const ll_client_setup *s, ll_time now)
{
    const ll_peer *peer = ll_client_peer(c);
    ll_time until = c->snapshots.game_start + ll_tick_time(peer->resume, c->ticks.clock.freq);
    return peer->resume != 0 &&
           ll_client_local(s, now) + c->connection.clock.offset >= until - LL_BARRIER_BLUR;
}

/* The first relay arrives when the game has begun, one update later plus the delay down. */
static void take_barrier(ll_client *c, const ll_client_setup *s, const ll_relay_message *m, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    ll_time update = (ll_time)(1e9 / s->rules->update_hz);
    ll_time since =
        peer->relayed != 0 ? peer->relayed : c->snapshots.game_start + ll_barrier_way(&c->connection.clock);
    ll_time slack = update > LL_BARRIER_GAP ? update : LL_BARRIER_GAP; /* a single lost relay is no outage */
    peer->gap |= now - since > update + c->ticks.period + slack;
    peer->relayed = now;
    if (m->barrier == 0)
        return;
    bool news = m->barrier > peer->barrier || (m->barrier == peer->barrier && m->resume > peer->resume);
    if (m->barrier >= c->inputs.tick && news) {
        peer->barrier = m->barrier;
        peer->resume = m->resume;
        peer->gap = is_over(c, s, now);
    }
}

int ll_peer_receive(ll_client *c, const ll_client_setup *s, const void *packet, int bytes, ll_time now)
{
    (void)bytes;
    ll_peer *peer = ll_client_peer(c);
    const ll_relay_message *m = packet;
    if (m->head.epoch != c->epoch)
        return LL_OUTCOME_STALE;
    if (m->head.type == LL_MESSAGE_INPUT)
        return ll_mesh_receive(c, s, packet, now);
    if (m->head.type != LL_MESSAGE_RELAY) {
        c->inputs.refused++; /* the others apply another input: from here on this world differs from theirs */
        return LL_OUTCOME_REFUSED;
    }
    c->inputs.acked = m->head.seq > c->inputs.acked ? m->head.seq : c->inputs.acked;
    peer->hashed = m->hashed > peer->hashed ? m->hashed : peer->hashed;
    if (m->tick > c->latest.tick) {
        take_steps(c, s, m->tick, now);
        c->latest.tick = c->snapshots.confirmed = m->tick;
        c->latest.time = m->time;
    }
    take_barrier(c, s, m, now);
    const char *at = (const char *)(m + 1);
    for (int i = 0; i < m->head.count; i++)
        at = take_part(c, s, at, now);
    return LL_OUTCOME_APPLIED;
}

/* ---- a frame ---- */

static int64_t guesses_max(const ll_client_setup *s)
{
    return s->sync->guesses ? s->rules->max_rollback_ticks : 0;
}

/* A script must act the same at a tick whenever that tick is stepped. So it sees the newest world that is
 * confirmed by then on any link. */
static ll_action control(ll_client *c, const ll_client_setup *s, int64_t tick)
{
    const ll_peer *peer = ll_client_peer(c);
    int64_t seen = tick - 1 - ll_peer_delay_max(s) - guesses_max(s);
    return ll_client_control(c, s, ll_peer_world(c, seen > peer->start ? seen : peer->start),
                             ll_clock_time(&peer->ticks, tick));
}

/* Makes the inputs up to that for tick `newest`; no player can have made inputs for the first
 * `input_delay_ticks`. */
static void make_inputs(ll_client *c, const ll_client_setup *s, int64_t newest, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    newest = peer->barrier != 0 && newest > peer->barrier ? peer->barrier : newest;
    while (c->inputs.tick < newest) {
        bool early = c->inputs.tick < peer->start + ll_peer_delay_max(s);
        ll_action a = early ? (ll_action){0} : control(c, s, c->inputs.tick + 1);
        ll_pending_input *p = ll_client_pending(c, ++c->inputs.seq);
        *p = (ll_pending_input){.seq = c->inputs.seq, .made = now, .action = a};
        ll_client_metrics_input(s->client_metrics, c->inputs.seq, c->inputs.tick + 1, &a,
                                ll_client_control_time(c, s, now), now);
        peer->player[c->self].known = ++c->inputs.tick;
        if (s->weapon_prediction)
            ll_weapon_prediction_input(c, s, p, c->drawing.view_time, now);
        p->action.buttons &=
            LL_BUTTONS; /* the relay server rejects claims, and a claim would depend on what is drawn */
        *ll_peer_input(peer, c->self, c->inputs.tick) =
            (ll_controls){{a.axis[0], a.axis[1]}, p->action.buttons};
    }
}

/* The players whose inputs are missing for the next tick. */
static uint32_t missing(const ll_peer *peer, int players, int64_t guesses)
{
    uint32_t mask = 0;
    for (int p = 0; p < players; p++)
        mask |= (uint32_t)(peer->player[p].known + guesses <= peer->tick) << p;
    return mask;
}

static void stall(ll_client *c, const ll_client_setup *s, uint32_t waiting, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    ll_stepping *n = &s->client_metrics->stepping;
    uint32_t before = peer->waiting;
    bool counts = now >= s->client_metrics->from;
    if (waiting != 0 && before == 0)
        peer->stalled_since = now;
    if (waiting == 0 && before != 0 && s->recorder)
        s->recorder->record(s->recorder->context,
                            &(ll_event){.type = LL_EVENT_STALL,
                                        .player = (uint8_t)c->self,
                                        .begin = now,
                                        .end = now,
                                        .number = before,
                                        .value = (float)ll_to_ms(now - peer->stalled_since)});
    peer->waiting = waiting;
    if (waiting == 0 || !counts)
        return;
    n->stalls += before == 0;
    n->stalled_frames++;
    for (int p = 0; p < ll_client_rendered(c)->players; p++)
        n->waited_frames[p] += (int32_t)(waiting >> p & 1);
}

/* Half the difference between the leads that two peers see: the delay of the packets cancels. */
static void update_time_sync(ll_client *c, const ll_client_setup *s)
{
    ll_peer *peer = ll_client_peer(c);
    double most = 0;
    if ((c->ticks.number - peer->time_sync_from) % TIME_SYNC_EVERY != 0 ||
        (s->rules->peers & LL_PEERS_STRETCH))
        return;
    for (int p = 0; p < ll_client_rendered(c)->players; p++) {
        double lead = (peer->player[p].ahead - peer->player[p].behind) / 2;
        if (p != c->self && peer->player[p].at >= 0 && lead > most)
            most = lead;
    }
    peer->frames_to_wait = most < TIME_SYNC_MAX ? (int32_t)most : TIME_SYNC_MAX;
}

/* Begins the first round, whose ticks are made as early as possible. */
static void begin_round(ll_peer *peer)
{
    peer->began = peer->tick;
    peer->since = LL_NEVER;
    peer->spread = 0;
}

/* A barrier ends as the game begins: no packet in flight, and no time sync data. */
static void end_barrier(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    if (!is_over(c, s, now))
        return;
    peer->barrier = peer->resume = 0;
    peer->time_sync_from = c->ticks.number - 1;
    peer->frames_to_wait = 0;
    begin_round(peer);
    for (int p = 0; p < ll_client_rendered(c)->players; p++) {
        peer->player[p].at = -1;
        peer->player[p].ahead = peer->player[p].behind = 0;
        if (s->choices)
            ll_pacing_forget_lead(s, p);
    }
}

/* Ticks that may be guessed in a row are also confirmed in a row: all clients would step and wait
 * alternately, for about ten seconds, until relays have spread them. So the ticks of the second round are
 * spaced as they will be later: the duration of the first round divided by its number of ticks. */
static void time_round(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    int64_t guesses = guesses_max(s), round_ticks = guesses + ll_peer_delay(s) + 1, known = LL_NEVER;
    if (peer->since == LL_NEVER)
        peer->since = now;
    if (peer->spread != 0 || round_ticks == 1)
        return; /* or no ticks are guessed in a row */
    for (int p = 0; p < ll_client_rendered(c)->players; p++)
        if (p != c->self && peer->player[p].known < known)
            known = peer->player[p].known;
    if (known == LL_NEVER || known <= peer->began)
        return; /* it plays alone; or the round is not over */
    ll_time round = now - peer->since + (guesses > 0 ? c->ticks.period : 0);
    peer->spread = (round < ROUND_MAX ? round : ROUND_MAX) / round_ticks;
    peer->spread_until = peer->began + 2 * round_ticks;
}

/* Whether the next tick is to be delayed. Ticks missing at a barrier are made at once. */
static bool spreads(const ll_client *c, ll_time now)
{
    const ll_peer *peer = ll_client_peer(c);
    return peer->barrier == 0 && peer->tick <= peer->spread_until &&
           now < peer->stepped + peer->spread - c->ticks.period / 2;
}

static bool may_step(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    if (peer->barrier != 0 && peer->tick >= peer->barrier) {
        stall(c, s, 0, now);
        s->client_metrics->stepping.time_sync_frames += now >= s->client_metrics->from;
        return false;
    }
    stall(c, s, missing(peer, ll_client_rendered(c)->players, guesses_max(s)), now);
    if (peer->waiting != 0)
        return false;
    if (spreads(c, now)) {
        s->client_metrics->stepping.time_sync_frames += now >= s->client_metrics->from;
        return false;
    }
    if (peer->barrier == 0)
        update_time_sync(c, s);
    if (peer->frames_to_wait == 0 || peer->barrier != 0) {
        peer->stepped = now;
        return true;
    }
    LL_ASSERT(peer->frames_to_wait > 0 && peer->frames_to_wait <= TIME_SYNC_MAX);
    peer->frames_to_wait--;
    for (int p = 0; p < ll_client_rendered(c)->players; p++)
        peer->player[p].ahead -= 1; /* at once, not when the means have followed */
    s->client_metrics->stepping.time_sync_frames += now >= s->client_metrics->from;
    return false;
}

/* All peers wait for one that has not reached the barrier yet: it makes the ticks up to the barrier as early
 * as possible, so that their inputs are sent together. */
static void step_to_barrier(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_peer *peer = ll_client_peer(c);
    int players = ll_client_rendered(c)->players;
    while (peer->tick < peer->barrier && missing(peer, players, guesses_max(s)) == 0) {
        ll_peer_step(c, s);
        ll_peer_confirm(c); /* worlds that are not hashed are not kept for long */
        make_inputs(c, s, peer->tick + 1 + ll_peer_delay(s), now);
    }
}

static void draw(ll_client *c, ll_time now)
{
    const ll_peer *peer = ll_client_peer(c);
    ll_draw_info *marks = ll_client_draw_infos(c);
    bool certain = peer->tick == peer->confirmed;
    ll_time time = c->latest.time + (peer->tick - c->latest.tick) * c->ticks.period;
    ll_draw_info mark = {certain && time < now ? time : now, certain ? 0 : LL_RENDERED_PREDICTED, 0};
    memcpy(ll_client_rendered(c), ll_peer_world(c, peer->tick), (size_t)c->layout.world_size);
    for (int i = 0; i < ll_client_rendered(c)->entities; i++)
        marks[i] = mark;
    c->view_step = peer->tick;
    c->drawing.view_time = mark.time;
    c->drawing.alpha = 1;
    c->drawing.buffer_ms = 0;
}

int ll_peer_compose(const ll_client *c, const ll_client_setup *s, int other, void *packet)
{
    const ll_peer *peer = ll_client_peer(c);
    int players = ll_client_rendered_const(c)->players, runs = 0;
    int64_t first = other < 0 ? peer->first + c->inputs.acked + 1 : ll_mesh_first(c, s, other), tick = first;
    ll_peer_message *m = packet;
    ll_peer_ack *acks = (ll_peer_ack *)(m + 1);
    ll_input_run *run = (ll_input_run *)(acks + players);
    for (int p = 0; p < players; p++) {
        const ll_peer_player *from = &peer->player[p];
        acks[p] = (ll_peer_ack){(int32_t)from->known, from->at < 0 ? 0 : (int32_t)(peer->tick - from->at)};
        if (ll_peer_paced(s))
            acks[p].ahead = ll_pacing_report(s, p);
    }
    for (; tick <= c->inputs.tick; tick++) { /* the pending inputs reach further back than the ring */
        const ll_action *a = &c->pending[(tick - peer->first) & (LL_PENDING_RING - 1)].action;
        if (!ll_run_add(run, &runs, &(ll_controls){{a->axis[0], a->axis[1]}, a->buttons}))
            break;
    }
    uint32_t *hash = (uint32_t *)(run + runs), hashes = 0;
    int64_t hashed = peer->confirmed - peer->hashed < LL_HASHES_MAX ? peer->hashed + 1
                                                                    : peer->confirmed - LL_HASHES_MAX + 1;
    for (int64_t k = hashed; k <= peer->confirmed && c->ticks.number % HASHES_EVERY == 0; k++)
        hash[hashes++] = peer->hashes[k & (LL_PEER_RING - 1)];
    *m = (ll_peer_message){
        .head = {LL_MESSAGE_INPUT, (uint8_t)(tick - first), c->epoch, (uint32_t)(first - peer->first)},
        .tick = (int32_t)first,
        .way = (uint32_t)(ll_barrier_way(&c->connection.clock) / 1000 + 1) | (peer->gap ? LL_WAY_GAP : 0),
        .at = (int32_t)peer->tick,
        .hashed = (int32_t)hashed,
        .runs = (uint16_t)runs,
        .other = (uint16_t)(other + 1),
        .hashes = hashes};
    return (int)((char *)(hash + hashes) - (char *)packet);
}

int ll_peer_tick(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
{
    const ll_peer *peer = ll_client_peer(c);
    int64_t delay = ll_peer_delay(s);
    ll_client_begin_tick(c, now);
    if (!ll_connection_plays(&c->connection)) {
        ll_client_miss(c, s, now);
        return 0;
    }
    ll_peer_roll_back(c, s, now);
    end_barrier(c, s, now);
    make_inputs(c, s, peer->tick + 1 + delay, now);
    time_round(c, s, now);
    if (may_step(c, s, now)) {
        ll_peer_step(c, s);
        if (guesses_max(s) == 0) /* no step without the others' inputs, which may wait for this one */
            make_inputs(c, s, peer->tick + 1 + delay, now);
        if (peer->barrier != 0) {
            make_inputs(c, s, peer->tick + 1 + delay, now);
            step_to_barrier(c, s, now);
        }
    }
    ll_peer_confirm(c);
    if (s->rules->peers & LL_PEERS_STRETCH)
        ll_pacing_stretch(c, s);
    if (s->rules->peers & LL_PEERS_ADAPT)
        ll_pacing_adapt_delay(c, s, now);
    ll_peer_sync_test(c, s, now);
    ll_measure(s->client_metrics, LL_METRIC_UNACKED, now, (double)(c->inputs.seq - c->inputs.acked));
    return ll_peer_compose(c, s, ll_peer_meshed(s) ? ll_peer_first_other(c) : -1, packet);
}

void ll_peer_display(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_client_begin_display(c, now);
    draw(c, now);
    ll_smooth_draw(c, s, now);
    if (s->weapon_prediction)
        ll_weapon_prediction_frame(c, s);
}
