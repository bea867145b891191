/* Sync modes: rules of server and clients. */
#include "netcode/observe/desync.h"
#include "netcode/protocol/bucket.h"
#include "netcode/server/barrier.h"
#include "netcode/server/by_clock.h"
#include "netcode/server/lockstep.h"
#include "netcode/server/relay_server.h"
#include "netcode/state/client.h"
#include "netcode/state/peer.h"

/* Of modes in which the server sends its state. */
#define BY_SNAPSHOTS                                                                                         \
    .take = ll_server_receive, .compose = ll_server_compose, .receive = ll_client_receive,                   \
    .display = ll_client_display

/* Of modes in which clients step the world by the inputs of all. */
#define BY_INPUTS                                                                                            \
    .sends_idle = true, .reports_refusals = true, .steps_by_inputs = true, .due = ll_relay_server_due,       \
    .step = ll_relay_server_step, .take = ll_relay_server_take, .stand_in = ll_relay_server_fill,            \
    .join = ll_barrier_join, .compose = ll_relay_server_compose, .start = ll_peer_start,                     \
    .receive = ll_peer_receive, .tick = ll_peer_tick, .display = ll_peer_display,                            \
    .observe = ll_desync_observe

/* Free: the server steps on its own clock and applies at step k the inputs meant for k. The parameter
 * `starved` selects the replacement of a missing input. An input that arrives after its step is late and is
 * not applied. Clients run ahead by their lag, so that this is rare. */
const ll_sync_mode ll_sync_free = {
    .name = "free",
    .client_runs_ahead = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .due = ll_by_clock_due,
    .step = ll_by_clock_step,
    BY_SNAPSHOTS,
    .tick = ll_client_tick,
    .interpolate = ll_interpolate_server_time,
};

/* Lockstep as in the paper (Figure 10): a client sends its input, waits for the snapshot that includes it,
 * and only then makes the next. A step takes the slowest player's round trip and an interval of the server:
 * one slow player slows all. Nothing is guessed, so nothing is corrected. An input without an answer is sent
 * again. */
const ll_sync_mode ll_sync_lockstep = {
    .name = "lockstep",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .waits = true,
    .answers = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .steps_by_inputs = true,
    .due = ll_lockstep_due,
    .step = ll_lockstep_step,
    BY_SNAPSHOTS,
    .tick = ll_client_tick,
    .interpolate = ll_interpolate_server_time,
};

/* Lockstep with inputs in flight: clients make one every interval, before the previous snapshot has arrived.
 * So the game keeps its rate at any lag, and an input is felt a round trip and an interval later. When a
 * player's inputs are missing, all wait. Then the server makes the delayed steps whose inputs have arrived at
 * a higher rate, and clients made no inputs meanwhile: latency returns to what it was. */
const ll_sync_mode ll_sync_lockstep_pipelined = {
    .name = "lockstep_pipelined",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .waits = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .steps_by_inputs = true,
    .due = ll_lockstep_due_in_rhythm,
    .step = ll_lockstep_step_in_rhythm,
    BY_SNAPSHOTS,
    .tick = ll_client_tick,
    .interpolate = ll_interpolate_server_time,
};

/* Bucket synchronisation (MiMaze: Gautier, Diot, Kurose, 1999; paper: "ignore lost packets and move on"). The
 * server steps on its own clock and does not wait. An input is applied at a fixed delay after it was made,
 * the same for all players, so that players of different lag act at the same time. What arrives later is
 * ignored: the step has the replacement that `starved` selects.
 *
 * The clocks of all machines are set before the game, as MiMaze's were by NTP: a client does not measure the
 * server's clock, and only `drift_ppm` sets them apart. A client makes one input in a bucket; none in a
 * bucket without a tick of its timer. */

/* The next input is for the step of the present bucket; none if that has one already. */
static void align_to_bucket(ll_client *c, const ll_client_setup *s, ll_time now)
{
    ll_time since = ll_client_local(s, now) - c->snapshots.game_start;
    int64_t step =
        c->snapshots.game_start_step + ll_bucket_step(since, s->bucket_delay_ms, c->ticks.clock.freq);
    c->ticks.skipped = 0;
    c->inputs.extra = step > c->inputs.tick ? 0 : -1;
    if (step <= c->inputs.tick + 1)
        return;
    ll_client_snap(c, step - 1);
    if (c->inputs.seq == 0)
        c->predicting = 0; /* of a client that has joined again: its prediction begins at this step */
}

static int tick_in_buckets(ll_client *c, const ll_client_setup *s, ll_time now, void *packet)
{
    if (ll_connection_plays(&c->connection))
        align_to_bucket(c, s, now);
    return ll_client_tick(c, s, now, packet);
}

const ll_sync_mode ll_sync_bucket = {
    .name = "bucket",
    .server_steps_at_update_hz = true,
    .client_steps_at_update_hz = true,
    .sends_idle = true,
    .reports_refusals = true,
    .drops_stale = true,
    .extrapolates = true,
    .buckets = true,
    .due = ll_by_clock_due,
    .step = ll_by_clock_step,
    BY_SNAPSHOTS,
    .tick = tick_in_buckets,
    .interpolate = ll_interpolate_server_time,
};

/* Gambetta: the rules of the live demo "Fast-Paced Multiplayer", defects included, for comparison.
 *
 * The server has one clock: at each update it applies all inputs that have arrived and sends its state. A
 * client sends inputs only while a key is down; each counts for the time since the frame before. An input of
 * more than 1/40 s is dropped without an answer and never acknowledged. Clients do not use the snapshots'
 * times: a client applies the snapshot that arrives last, even if it is older, and interpolates between the
 * times of the frames that applied them, exactly one update interval back. */

/* The demo applies inputs in the order of arrival. That order affects only which input is acknowledged last,
 * since moves are additive. */
static void drain(ll_server *server, int player, const ll_game *game, const ll_game_env *env)
{
    ll_client_slot *client_slot = &server->client_slots[player];
    int64_t first = client_slot->inputs.newest - LL_INPUT_RING + 1;
    for (int64_t tick = first < 1 ? 1 : first; tick <= client_slot->inputs.newest; tick++) {
        ll_input_slot *slot = &client_slot->inputs.ring[tick & (LL_INPUT_RING - 1)];
        if (slot->tick != tick || slot->came < 0)
            continue;
        game->step_own(ll_server_world(server), env, player, &slot->action);
        slot->came = -1;
        client_slot->inputs.acked = slot->seq;
        ll_client_slot_done(client_slot, slot->seq, true);
    }
}

static void step_at_update(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past,
                           ll_time now)
{
    (void)past;
    server->step++;
    for (int i = 0; i < server->players; i++)
        drain(server, i, game, env);
    server->stepped = now;
}

static void interpolate_by_arrival(ll_client *c, const ll_client_setup *s, ll_time now)
{
    for (; c->drawing.received < c->snapshots.received; c->drawing.received++)
        ll_client_state(c, c->drawing.received)->arrived = now;
    ll_time render = now - (ll_time)(1e9 / c->latest.update_hz);
    int64_t oldest = ll_client_oldest(c);
    int64_t i = c->snapshots.received - 1;
    while (i > oldest && ll_client_state(c, i)->arrived > render)
        i--;
    const ll_snapshot_entry *a = ll_client_state(c, i),
                            *b = i + 1 < c->snapshots.received ? ll_client_state(c, i + 1) : NULL;
    bool held =
        b == NULL ||
        a->arrived > render; /* no two snapshots bracket the time: the demo leaves the entity where it is */
    ll_draw_info *marks = ll_client_draw_infos(c);
    int entities = ll_client_latest(c)->entities;
    if (!held) {
        ll_time span = b->arrived - a->arrived;
        double alpha = span > 0 ? (double)(render - a->arrived) / (double)span : 1;
        ll_blend(c, a, b, alpha);
        c->view.render = a->time + (ll_time)(alpha * (double)(b->time - a->time));
        for (int p = 0; p < entities; p++)
            if (p != c->self)
                marks[p].time = c->view.render;
    } else {
        for (int p = 0; p < entities; p++)
            if (p != c->self)
                marks[p].flags = LL_RENDERED_HELD;
    }
    c->view.state = held ? LL_VIEW_STARVED : LL_VIEW_NORMAL;
    c->drawing.time_scale = held ? 0 : 1;
    c->view.delay = now - render;
    c->drawing.depth = c->snapshots.received - 1 - i;
    if (held && !c->view.held && now >= s->client_metrics->from)
        s->client_metrics->buffer.underruns++;
    c->view.held = held;
    c->drawing.buffer_ms = ll_to_ms(ll_client_state(c, c->snapshots.received - 1)->arrived - render);
}

const ll_sync_mode ll_sync_gambetta = {
    .name = "gambetta",
    .server_steps_at_update_hz = true,
    .applies_on_arrival = true,
    .press_s = 1.0 / 40,
    .due = ll_by_clock_due,
    .step = step_at_update,
    BY_SNAPSHOTS,
    .tick = ll_client_tick,
    .interpolate = interpolate_by_arrival,
};

/* Deterministic lockstep (paper, "Deterministic Lockstep"; Fiedler): only inputs are sent, and every client
 * makes tick k when it has all inputs for k. Nothing is guessed and nothing corrected. The price: two lags
 * between an input and its effect, and equal arithmetic on every machine. */
const ll_sync_mode ll_sync_deterministic = {
    .name = "deterministic",
    BY_INPUTS,
};

/* Rollback (GGPO, GGRS): deterministic lockstep that does not wait. A client guesses the inputs that have not
 * arrived, and resimulates the ticks with a wrong guess. */
const ll_sync_mode ll_sync_rollback = {
    .name = "rollback",
    .guesses = true,
    BY_INPUTS,
};

#define ROW(name) &ll_sync_##name,
#define NAME(name) #name,

const ll_sync_mode *const ll_syncs[] = {LL_SYNC_MODES(ROW) NULL};
const char *const ll_sync_mode_names[] = {LL_SYNC_MODES(NAME) NULL};
