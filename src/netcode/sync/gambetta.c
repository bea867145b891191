/* Gambetta: the rules of the live demo "Fast-Paced Multiplayer", defects included, for comparison.
 *
 * The server has one clock: at each update it applies all inputs that have arrived and sends its state. A
 * client sends inputs only while a key is down; each counts for the time since the frame before. An input of
 * more than 1/40 s is dropped without an answer and never acknowledged. Clients do not use the snapshots'
 * times: a client applies the snapshot that arrives last, even if it is older, and interpolates between the
 * times of the frames that applied them, exactly one update interval back. */
#include "netcode/server/server.h"
#include "netcode/state/client.h"

static ll_time due(const ll_server *server)
{
    return ll_clock_time(&server->clock, server->step + 1);
}

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

static void step(ll_server *server, const ll_game *game, const ll_game_env *env, ll_past *past, ll_time now)
{
    (void)past;
    server->step++;
    for (int i = 0; i < server->players; i++)
        drain(server, i, game, env);
    server->stepped = now;
}

static void interpolate(ll_client *c, const ll_client_setup *s, ll_time now)
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
    .help = "The live demo's rules: the server applies its whole queue at each update, receive times, "
            "refusals without an answer.",
    .server_steps_at_update_hz = true,
    .applies_on_arrival = true,
    .press_s = 1.0 / 40,
    .due = due,
    .step = step,
    .take = ll_server_receive,
    .compose = ll_server_compose,
    .receive = ll_client_receive,
    .tick = ll_client_tick,
    .display = ll_client_display,
    .interpolate = interpolate,
};
