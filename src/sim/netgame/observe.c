/* The observer of a netgame: it sees the server and every client, and compares them. */
#include <ctype.h>
#include <string.h>

#include "netcode/client/cheat.h"
#include "netcode/observe/player_observer.h"
#include "sim/netgame/parts.h"

static void judge_neglect(ll_netgame *g, const ll_hit_result *j)
{
    ll_point present[LL_BODIES_MAX];
    const ll_arena *arena = &ll_netgame_shots(g)->arena;
    const ll_past past = {.history = ll_netgame_history(g), .rules = &g->config.server.compensation};
    ll_bodies_now(arena, ll_server_world(ll_netgame_server(g)), present);
    ll_drag_neglect_judge(ll_netgame_drag_neglect(g), &(ll_field){arena, present, &past, NULL}, j);
}

/* A shot was judged in the present step of the server. */
void ll_netgame_record_shot(void *context, const ll_hit_result *j)
{
    ll_netgame *g = context;
    ll_server *server = ll_netgame_server(g);
    int64_t *refused = server->client_slots[j->shooter].counts.refused;
    bool on_player = j->body != LL_NOBODY && j->body < server->players;
    bool rules = !ll_netgame_sync(g)->observe; /* a relay server refuses nothing */
    refused[LL_RULE_FIRE_RATE] += rules && j->kind == LL_HIT_RESULT_VOID;
    refused[LL_RULE_REWIND] += rules && j->shot && j->shot->view_time_rejected;
    ll_sight victim = {.self = j->body};
    if (on_player)
        victim.shown = ll_client_rendered_const(ll_netgame_client(g, j->body));
    ll_shots_judge(ll_netgame_shots(g), j, server->step, ll_netgame_history(g), ll_server_world(server),
                   on_player ? &victim : NULL);
    ll_behind_cover_judge(ll_netgame_behind_cover(g), j, server->step);
    if (ll_netgame_drag_neglect(g))
        judge_neglect(g, j);
}

/* Measures what player `i` gains by its cheat. A step stands for its length; an update that applies inputs on
 * arrival, for the time since the one before. */
static __attribute__((noinline)) void watch_cheat(ll_netgame_run *run, int i, ll_time since)
{
    const bool drains = run->sync->applies_on_arrival;
    const ll_game_env *env = &run->game->env;
    ll_client_metrics *in = run->seat[i].metrics;
    const ll_honest_stepped stepped = {run->world, run->server->step, run->game->now, drains};
    ll_cheat_gain_step(&in->gain, run->rules, env, &run->world->entity[i], drains ? ll_to_s(since) : env->dt);
    ll_honest_step(&in->honest, run->rules, env, i, &stepped);
}

void ll_netgame_watch_players(ll_netgame_run *run, ll_time since)
{
    if (!(run->observes & LL_OBSERVE_GAIN))
        return;
    for (int i = 0; i < run->players; i++)
        if (run->seat[i].setup.config->cheat != LL_CHEAT_NONE)
            watch_cheat(run, i, since);
}

void ll_netgame_watch_cheats_begin(ll_netgame *g, const ll_netgame_config *next)
{
    const ll_server *server = ll_netgame_server(g);
    for (int i = 0; i < g->config.player_count; i++) {
        ll_client_metrics *in = ll_netgame_client_metrics(g, i);
        if (g->config.players[i].cheat != LL_CHEAT_NONE || next->players[i].cheat == LL_CHEAT_NONE)
            continue;
        ll_cheat_gain_watch(&in->gain, &ll_server_world_const(server)->entity[i]);
        ll_honest_watch(&in->honest, &ll_server_world_const(server)->entity[i], server->stepped);
    }
}

/* A packet holds the inputs made since the last one and `redundancy` earlier ones; a lag switch keeps its
 * inputs back. */
static uint32_t unsent_from(const ll_netgame_seat *seat)
{
    const ll_client *c = seat->client;
    uint32_t again = (uint32_t)seat->setup.config->redundancy;
    uint32_t from = c->inputs.seq > again ? c->inputs.seq - again + 1 : 1;
    return c->inputs.unsent != 0 && c->inputs.unsent < from ? c->inputs.unsent : from;
}

/* The observer sees the results of every player's inputs in the step. */
void ll_netgame_observe_step(ll_netgame_run *run)
{
    if (!(run->observes & (LL_OBSERVE_INPUTS | LL_OBSERVE_VIEWS)))
        return;
    for (int i = 0; i < run->players; i++) {
        const ll_netgame_seat *seat = &run->seat[i];
        ll_stepped stepped = {.world = run->world,
                              .history = run->history,
                              .step = run->server->step,
                              .acked = seat->slot->inputs.acked,
                              .unsent_from = run->sync->applies_on_arrival ? unsent_from(seat) : 0,
                              .applies_on_arrival = run->sync->applies_on_arrival};
        ll_client_metrics_stepped(seat->metrics, i, &stepped, run->game->now);
    }
}

/* All clients have drawn: compares their views. */
void ll_netgame_compare_views(ll_netgame_run *run, ll_time elapsed)
{
    ll_client_metrics *client_metrics[LL_PLAYERS_MAX];
    const ll_client *clients[LL_PLAYERS_MAX];
    const uint64_t *known[LL_PLAYERS_MAX];
    if (!(run->observes & LL_OBSERVE_CLIENTS))
        return;
    for (int i = 0; i < run->players; i++) {
        client_metrics[i] = run->seat[i].metrics;
        clients[i] = run->seat[i].client;
        known[i] = run->seat[i].setup.recent ? run->seat[i].setup.recent->known : NULL;
    }
    if (known[0])
        ll_client_metrics_between_some(client_metrics, clients, known, run->players, run->game->now, elapsed);
    else
        ll_client_metrics_between(client_metrics, clients, run->players, run->game->now, elapsed);
}

/* A client's tick: it may have changed its controls; and the input that an honest client would have sent. */
void ll_netgame_watch_tick(ll_netgame_run *run, int player)
{
    const ll_netgame_seat *seat = &run->seat[player];
    if (!(run->observes & (LL_OBSERVE_GAIN | LL_OBSERVE_INPUTS)))
        return;
    ll_time due = run->game->now + seat->up_plan.delay;
    run->waiting |= (uint64_t)ll_changes_waiting(&seat->metrics->changes) << player;
    if (!(run->observes & LL_OBSERVE_GAIN))
        return;
    if (ll_cheat_minds(&seat->setup))
        ll_honest_frame(&seat->metrics->honest, seat->client->inputs.tick, due);
    else
        ll_honest_frame_once(&seat->metrics->honest, seat->client->inputs.tick, due);
}

/* What a display of `player` shows of the others' changes of controls. */
static void observe_seen(ll_netgame_run *run, int player, const ll_truth *truth)
{
    const ll_netgame_seat *seat = &run->seat[player];
    ll_drawn_tick last = {LL_NEVER, seat->metrics->drawn_tick};
    for (uint64_t left = run->waiting & ~(UINT64_C(1) << player); left != 0; left &= left - 1) {
        const int i = __builtin_ctzll(left);
        ll_client_metrics *in = run->seat[i].metrics;
        if (ll_changes_waiting(&in->changes))
            ll_client_metrics_seen(in, i, seat->client, truth, &last, run->game->now);
        else
            run->waiting &= ~(UINT64_C(1) << i);
    }
}

/* A display of `player`: compares its view with the truth, and records which changes of the others' controls
 * it shows. */
void ll_netgame_observe_display(ll_netgame_run *run, int player)
{
    const ll_netgame_seat *seat = &run->seat[player];
    const ll_time now = run->game->now;
    if (!(run->observes & (LL_OBSERVE_INPUTS | LL_OBSERVE_VIEWS))) {
        ll_client_metrics_drawn(seat->metrics, seat->client->displays.elapsed, now);
        return;
    }
    const double device_ms = seat->setup.config->display_device_ms;
    const ll_truth truth = {.world = run->world,
                            .history = run->history,
                            .device = device_ms != 0 ? ll_ms(device_ms) : 0,
                            .acked = seat->slot->inputs.acked,
                            .nearness = seat->nearness,
                            .known = seat->setup.recent ? seat->setup.recent->known : NULL,
                            .applies_on_arrival = run->sync->applies_on_arrival,
                            .peers = run->sync->observe != NULL};
    ll_client_metrics_frame(seat->metrics, seat->client, &truth, now);
    if ((run->observes & LL_OBSERVE_INPUTS) && player < LL_CHANGE_VIEWERS)
        observe_seen(run, player, &truth);
}

/* ---- detection of cheats by the server ---- */

/* The observer knows who cheats: other alarms are mistaken. */
static void raise(const ll_netgame_run *run, int player, ll_alarms *alarms)
{
    alarms->count++;
    alarms->mistaken += run->seat[player].setup.config->cheat == LL_CHEAT_NONE;
    if (alarms->first == LL_NEVER)
        alarms->first = run->game->now;
}

__attribute__((noinline)) void ll_netgame_detect_packet(const ll_netgame_run *run, int player,
                                                        const void *packet)
{
    ll_rate_watch *watch = &run->detection[player].rate;
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    if (head.epoch == run->seat[player].slot->connection.epoch &&
        ll_rate_take(watch, head.epoch, head.seq, head.count, run->server->client_freq, run->game->now))
        raise(run, player, &watch->alarms);
}

/* The history has the world before the step, in which the player's shot began, and those before it, of which
 * its client drew one. */
static void look(const ll_netgame_run *run, const ll_past *past, int player, const ll_action *action)
{
    const ll_arena *arena = &run->shots->arena;
    const ll_weapons *weapons = run->rules->weapons;
    ll_reaction_watch *watch = &run->detection[player].reaction;
    ll_point bodies[LL_BODIES_MAX];
    bool rejected;
    ll_time age = ll_view_age(past, player, action->view_age_ns, &rejected);
    ll_bodies_at(arena, past->history, run->game->now - age, bodies);
    ll_moment before = ll_history_find(past->history, ll_history_newest(past->history));
    ll_history_at(past->history, before, player, &bodies[player].x, &bodies[player].y);
    ll_aim aim = weapons->aim(run->world, &run->game->env, player, action);
    aim.from = bodies[player];
    int64_t fired = weapons->arms(run->world, player)->shots[LL_HITSCAN];
    bool shoots = fired > watch->fired;
    ll_time reaction = ll_reaction_see(watch, arena, player, bodies, shoots ? &aim : NULL, run->game->now);
    watch->fired = fired;
    if (reaction >= 0 && ll_reaction_try(watch, reaction < LL_REACTION_FAST))
        raise(run, player, &watch->alarms);
    ll_aim_watch *aims = &ll_netgame_aim_watch(run->game)[player];
    double rate = ll_aim_see(aims, arena, player, bodies, &aim, shoots, run->game->now);
    if (rate >= 0 && ll_aim_try(aims, rate > LL_AIM_FAST))
        raise(run, player, &aims->alarms);
}

__attribute__((noinline)) void ll_netgame_detect_shots(const ll_netgame_run *run, const ll_past *past)
{
    const int64_t step = run->server->step;
    for (int i = 0; i < run->players; i++) {
        const ll_client_slot *slot = run->seat[i].slot;
        const ll_input_slot *input = &slot->inputs.ring[step & (LL_INPUT_RING - 1)];
        if (slot->connection.connected && input->tick == step && !ll_client_slot_replaced(slot, step))
            look(run, past, i, &input->action);
    }
}

/* ---- what must be observed for a metric ---- */

typedef struct need {
    const char *begins; /* the path, or the part of it after `players.N.` */
    uint32_t observes;
} need;

/* The first row counts; for a path without a row everything is observed. */
static const need of_run[] = {
    {"server.fairness", LL_OBSERVE_ALL}, {"server.", 0}, {"cost.", 0}, {NULL, LL_OBSERVE_ALL}};

static const need of_player[] = {
    {"own_", LL_OBSERVE_VIEWS},
    {"remote_error_m", LL_OBSERVE_VIEWS},
    {"timeline_error_m", LL_OBSERVE_VIEWS},
    {"view_age_ms", LL_OBSERVE_VIEWS},
    {"age_of_information_ms", LL_OBSERVE_VIEWS},
    {"inconsistency.server", LL_OBSERVE_VIEWS},
    {"smoothness", LL_OBSERVE_VIEWS},
    {"buffer", LL_OBSERVE_VIEWS},
    {"inconsistency.clients", LL_OBSERVE_CLIENTS},
    {"input_latency_ms", LL_OBSERVE_INPUTS},
    {"confirmed_latency_ms", LL_OBSERVE_INPUTS},
    {"seen_latency_ms", LL_OBSERVE_INPUTS},
    {"ack_rtt_ms", LL_OBSERVE_INPUTS},
    {"inputs", LL_OBSERVE_INPUTS},
    {"acks", LL_OBSERVE_INPUTS},
    {"corrections_by_cause", LL_OBSERVE_INPUTS},
    {"correction", 0},
    {"visible_correction", LL_OBSERVE_FRAMES},
    {"pop_m", LL_OBSERVE_FRAMES},
    {"unacked", LL_OBSERVE_FRAMES},
    {"replay", 0},
    {"bandwidth", 0},
    {"snapshot", 0},
    {"selection.near", LL_OBSERVE_VIEWS},
    {"selection.far", LL_OBSERVE_VIEWS},
    {"selection", 0},
    {"reckoning", 0},
    {"reports", 0},
    {"link_up", 0},
    {"transport", 0},
    {"link_down", 0},
    {"dejitter", 0},
    {"connection", 0},
    {"validation", LL_OBSERVE_GAIN},
    {"detection", 0},
    {"stalls", 0},
    {"rollback", 0},
    {"pacing", 0},
    {"sync_test", 0},
    {"desync", 0},
    {"shots", 0},
    {"game", 0},
    {NULL, LL_OBSERVE_ALL},
};

static uint32_t look_up(const need *rows, const char *path)
{
    while (rows->begins && strncmp(path, rows->begins, strlen(rows->begins)) != 0)
        rows++;
    return rows->observes;
}

uint32_t ll_netgame_observed_for(const char *path)
{
    static const char players[] = "players.";
    if (strncmp(path, players, strlen(players)) != 0)
        return look_up(of_run, path);
    path += strlen(players);
    while (isdigit((unsigned char)*path))
        path++;
    return look_up(of_player, *path == '.' ? path + 1 : path);
}

/* ---- packets ---- */

/* An ll_link_tap function; the context is an ll_packet_tap. */
static void record_packet(void *context, const ll_link_packet *on_link)
{
    ll_packet_tap *tap = context;
    int32_t begin = on_link->index * tap->mtu, left = on_link->size - begin;
    ll_message_head head;
    memcpy(&head, on_link->message, sizeof head); /* packets of a transport are longer, too */
    tap->packet.sent = *tap->now;
    tap->packet.name = tap->plain ? ll_netgame_message_names[head.type] : "packet";
    tap->packet.on_link = on_link;
    tap->packet.bytes = (const char *)on_link->message + begin;
    tap->packet.size = on_link->count > 1 && left > tap->mtu ? tap->mtu : left;
    tap->recorder->packet(tap->recorder->context, &tap->packet);
}

void ll_netgame_tap(const ll_netgame_run *run, int player, bool up, ll_packet_tap *tap)
{
    const ll_netgame_seat *seat = &run->seat[player];
    tap->plan = up ? seat->up_plan : seat->down_plan;
    tap->recorder = run->recorder;
    tap->now = &run->game->now;
    tap->mtu = (int32_t)tap->plan.params->mtu_bytes;
    tap->plain = ll_transport_plain((int)run->game->config.server.transport);
    tap->packet = (ll_packet){.player = player, .up = up};
    tap->link_tap = (ll_link_tap){record_packet, tap};
    tap->plan.tap = &tap->link_tap;
}

/* ---- messages ---- */

/* What only an input packet has: the step of its newest input, and how long that took to be sent. */
static void describe_input(const ll_netgame_run *run, int player, const void *packet, ll_event *e)
{
    const ll_sync_mode *sync = run->sync;
    const ll_netgame_seat *seat = &run->seat[player];
    if (sync->take != ll_server_receive)
        return; /* peers have packets of their own */
    ll_input_message m;
    memcpy(&m, packet, offsetof(ll_input_message, inputs));
    const ll_pending_input *input = ll_client_pending(seat->client, e->number);
    if (!sync->applies_on_arrival)
        e->tick = (uint32_t)(m.tick + m.head.count - 1);
    if (input->seq != e->number)
        return;
    e->held_ms = (float)ll_to_ms(run->game->now - input->made);
    if (e->number == seat->client->inputs.seq)
        e->device_ms =
            (float)ll_to_ms(input->made - ll_client_control_time(seat->client, &seat->setup, input->made));
}

/* The event of a message that is sent now, but for its fate. */
ll_event ll_netgame_message_event(const ll_netgame_run *run, int player, const void *packet)
{
    ll_message_head head;
    memcpy(&head, packet, sizeof head);
    ll_event e = {.type = head.type, .player = (uint8_t)player, .begin = run->game->now, .number = head.seq};
    if (head.type == LL_MESSAGE_SNAPSHOT || head.type == LL_MESSAGE_RELAY)
        e.number = (uint32_t)run->server->step;
    if (head.type == LL_MESSAGE_INPUT) {
        e.number += head.count - 1u; /* its newest */
        describe_input(run, player, packet, &e);
    }
    return e;
}
