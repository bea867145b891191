/* Whose turn is next: packets, the server and the clients, in the order of virtual time. */
#include <stdio.h>

#include "base/keep.h"
#include "base/pair.h"
#include "netcode/state/peer.h"
#include "sim/netgame/parts.h"

ll_client_setup ll_netgame_client_setup(const ll_netgame *g, int i, const ll_recorder *recorder)
{
    const ll_sync_mode *sync = ll_netgame_sync(g);
    const ll_player_config *player = &g->config.players[i];
    ll_freq ticks = ll_netgame_rate(g, sync->client_steps_at_update_hz), displays = ll_netgame_rate(g, false);
    if (player->display_hz > 0)
        displays = ll_freq_from_hz(player->display_hz);
    bool together = player->display_hz == 0 && ticks == displays && !sync->answers;
    return (ll_client_setup){.game = ll_netgame_game(g),
                             .env = &g->env,
                             .sync = sync,
                             .config = player,
                             .display_freq = together ? 0 : displays,
                             .client_metrics = ll_netgame_client_metrics(g, i),
                             .recorder = recorder,
                             .rules = &g->config.server,
                             .selects = ll_codecs[g->config.server.snapshot]->selects,
                             .weapon_prediction = ll_netgame_weapon_prediction(g, i),
                             .shots = ll_netgame_shots(g),
                             .reckoning = ll_netgame_reckoning(g),
                             .choices = ll_netgame_choices(g, i),
                             .reporter = ll_netgame_reporter(g, i),
                             .recent = ll_netgame_recent(g, i),
                             .bucket_delay_ms = g->config.bucket_delay_ms,
                             .seed = (uint64_t)g->config.head.seed};
}

/* Where a position or speed is not finite. */
typedef struct divergence {
    int entity;
    int viewer; /* the player in whose view; -1: in the server's world */
} divergence;

static double sum_of(const ll_entity *e)
{
    return e->x + e->y + e->vx + e->vy + e->angle + e->angular_velocity;
}

static bool is_finite(double x)
{
    return x - x == 0; /* false for infinity and NaN */
}

/* The numbers of an entity in pairs: positions, velocities, angles. */
static inline bool finite_sum(const ll_world *world)
{
    ll_pair all = {0, 0};
    for (int i = 0; i < world->entities; i++) {
        const ll_pair *e = (const ll_pair *)(const void *)&world->entity[i];
        all += e[0] + e[1] + e[2];
    }
    return is_finite(all[0] + all[1]);
}

static __attribute__((noinline)) bool finite_each(const ll_world *world, int *entity)
{
    for (int i = 0; i < world->entities; i++)
        if (!is_finite(sum_of(&world->entity[i]))) {
            *entity = i;
            return false;
        }
    return true; /* each is, their sum is not */
}

/* False: `entity` is not. */
static inline bool finite_world(const ll_world *world, int *entity)
{
    return finite_sum(world) || finite_each(world, entity);
}

/* The same of what was drawn again. */
static bool finite_shown(const ll_world *world, const ll_recent *recent, int *entity)
{
    double all = 0;
    for (int word = 0; word < LL_ENTITY_WORDS; word++)
        for (uint64_t left = recent->shown[word]; left != 0; left &= left - 1)
            all += sum_of(&world->entity[word * 64 + __builtin_ctzll(left)]);
    return is_finite(all) || finite_each(world, entity);
}

static __attribute__((noinline)) ll_status not_finite(const ll_netgame *g, divergence where)
{
    char name[LL_NAME_MAX + 16], view[LL_NAME_MAX + 32] = "";
    if (where.entity < g->config.player_count)
        snprintf(name, sizeof name, "player %s", g->config.players[where.entity].name);
    else
        snprintf(name, sizeof name, "entity %d", where.entity);
    if (where.viewer >= 0)
        snprintf(view, sizeof view, " in the view of player %s", g->config.players[where.viewer].name);
    return ll_error(LL_DIVERGED, "the position or speed of %s%s is not finite at step %lld (%.6f s)", name,
                    view, (long long)ll_netgame_server(g)->step, ll_to_s(g->now));
}

/* A step in which shots are judged. */
static __attribute__((noinline)) void step_armed(ll_netgame_run *run)
{
    ll_netgame *g = run->game;
    ll_past past = {.history = run->history,
                    .rules = &g->config.server.compensation,
                    .params = ll_netgame_policies(g),
                    .buffer = 2 * ll_tick_time(1, run->server->updates.freq),
                    .witness = ll_netgame_record_shot,
                    .context = g};
    run->sync->step(run->server, run->rules, &g->env, &past, g->now);
    if (run->detection && !run->sync->observe)
        ll_netgame_detect_shots(run, &past);
}

static __attribute__((noinline)) void note_starved_before(ll_netgame_run *run)
{
    for (int i = 0; i < run->players; i++)
        run->seat[i].metrics->input_history.starved_before = run->seat[i].slot->counts.starved;
}

/* The states that players report for this step. */
static __attribute__((noinline)) void apply_reports(ll_netgame_run *run)
{
    uint64_t refused = ll_reports_apply(run->reports, run->server, run->rules, &run->game->env);
    for (int i = 0; i < run->players; i++)
        if (refused >> i & 1 && run->seat[i].setup.config->cheat == LL_CHEAT_NONE)
            run->seat[i].metrics->false_refusals++;
}

/* False when the world has diverged, at `where`. */
static bool server_steps(ll_netgame_run *run, divergence *where)
{
    ll_netgame *g = run->game;
    ll_server *server = run->server;
    ll_time before = server->stepped;
    if (run->shots)
        step_armed(run);
    else
        run->sync->step(server, run->rules, &g->env, NULL, g->now);
    if (run->reports)
        apply_reports(run);
    where->viewer = -1;
    if (!finite_world(run->world, &where->entity))
        return false;
    ll_netgame_watch_players(run, g->now - before);
    if (g->now < run->seat[0].metrics->from)
        note_starved_before(run);
    ll_history_add(run->history, g->now, run->world);
    ll_netgame_observe_step(run);
    if (run->shots)
        ll_shots_step(run->shots, server->step, run->history);
    if (run->recorder)
        ll_netgame_record(run->recorder, (ll_event){.type = LL_EVENT_STEP,
                                                    .begin = g->now,
                                                    .end = g->now,
                                                    .number = (uint32_t)server->step});
    if (run->sync->server_steps_at_update_hz)
        ll_netgame_update(run);
    return true;
}

/* Over a mesh: the copies of a tick's message for the others, after that for the first. */
static __attribute__((noinline)) void send_copies(ll_netgame_run *run, int player)
{
    const ll_netgame_seat *seat = &run->seat[player];
    for (int other = ll_peer_first_other(seat->client) + 1; other < run->players; other++)
        if (other != player) {
            int bytes = ll_peer_compose(seat->client, &seat->setup, other, run->composed);
            ll_netgame_send(run, player, true, run->composed, bytes);
        }
}

static __attribute__((noinline)) void client_ticks(ll_netgame_run *run, int player)
{
    ll_netgame_seat *seat = &run->seat[player];
    ll_client *client = seat->client;
    const ll_client_setup *s = &seat->setup;
    const ll_time now = run->game->now;
    int bytes = run->sync->tick(client, s, now, run->composed);
    const bool copies = run->meshed && bytes > 0;
    ll_netgame_watch_tick(run, player);
    ll_client_set_timer(client, s, now);
    for (; bytes > 0; bytes = ll_client_held(client, s, now, run->composed))
        ll_netgame_send(run, player, true, run->composed, bytes);
    if (copies)
        send_copies(run, player);
    if (run->sync->observe)
        run->sync->observe(ll_netgame_desync(run->game, player), client, s, run->server);
}

/* The same of a usual client, which is no peer. */
static inline void client_ticks_usually(ll_netgame_run *run, ll_netgame_seat *seat, int player)
{
    ll_client *client = seat->client;
    const ll_client_setup *s = &seat->setup;
    const ll_time now = run->game->now;
    int bytes = ll_client_usual_tick(client, s, now, run->composed);
    ll_netgame_watch_tick(run, player);
    ll_client_set_usual_timer(client);
    while (bytes > 0) {
        ll_netgame_send(run, player, true, run->composed, bytes);
        bytes = client->inputs.unsent == 0 ? 0 : ll_client_held(client, s, now, run->composed);
    }
}

/* Whether the display that was just made shows a snapshot for the first time, or, where displays are apart
 * from ticks, a predicted input. */
static bool shows_news(const ll_client *client, const ll_client_setup *s, ll_time now)
{
    ll_time before = now - client->displays.elapsed;
    if (s->sync->observe || client->snapshots.received == 0)
        return false; /* a peer draws its own world */
    const ll_pending_input *input = &client->pending[client->inputs.seq & (LL_PENDING_RING - 1)];
    bool predicted = s->config->prediction && s->display_freq != 0 && input->made > before;
    return predicted ||
           ll_client_state((ll_client *)client, client->snapshots.received - 1)->arrived > before;
}

static __attribute__((noinline)) void record_display(const ll_netgame_run *run, int player)
{
    const ll_netgame_seat *seat = &run->seat[player];
    const ll_time now = run->game->now;
    if (shows_news(seat->client, &seat->setup, now))
        ll_netgame_record(run->recorder, (ll_event){.type = LL_EVENT_DISPLAY,
                                                    .player = (uint8_t)player,
                                                    .begin = now,
                                                    .end = now,
                                                    .number = (uint32_t)seat->client->latest.tick});
}

/* What the player now sees of the others, and of hits on itself. */
static __attribute__((noinline)) void watch_shots(ll_netgame_run *run, int player)
{
    const ll_client *client = run->seat[player].client;
    const ll_time now = run->game->now;
    int64_t known = client->view_step >= 0 ? client->view_step : client->latest.tick;
    ll_shots_frame(run->shots, &(ll_sight){ll_client_rendered_const(client), player}, now);
    ll_behind_cover_frame(ll_netgame_behind_cover(run->game), run->shots, player, known, now);
}

/* A client's prediction may diverge before the server does: false then. */
static inline bool client_displays(ll_netgame_run *run, ll_netgame_seat *seat, int player, divergence *where)
{
    ll_client *client = seat->client;
    const ll_time now = run->game->now;
    if (seat->setup.usual)
        ll_client_usual_display(client, &seat->setup, now);
    else
        run->sync->display(client, &seat->setup, now);
    ll_client_set_display(client, &seat->setup);
    if (run->recorder)
        record_display(run, player);
    where->viewer = player;
    const ll_recent *recent = seat->setup.recent;
    const ll_world *shown = ll_client_rendered_const(client);
    if (!(recent && recent->shows ? finite_shown(shown, recent, &where->entity)
                                  : finite_world(shown, &where->entity)))
        return false;
    if (run->observes & (LL_OBSERVE_INPUTS | LL_OBSERVE_VIEWS))
        ll_netgame_observe_display(run, player);
    else
        ll_client_metrics_drawn(seat->metrics, client->displays.elapsed, now);
    if (run->shots)
        watch_shots(run, player);
    if (player == run->players - 1)
        ll_netgame_compare_views(run, client->displays.elapsed);
    return true;
}

static inline bool client_acts(ll_netgame_run *run, ll_netgame_seat *seat, int player, divergence *where)
{
    ll_client *client = seat->client;
    const ll_client_setup *s = &seat->setup;
    const ll_time now = run->game->now;
    bool ticks = client->ticks.due <= now,
         displays = s->display_freq == 0 ? ticks : client->displays.due <= now;
    if (ticks && s->usual)
        client_ticks_usually(run, seat, player);
    else if (ticks)
        client_ticks(run, player);
    bool finite = !displays || client_displays(run, seat, player, where);
    ll_client_set_due(client, s);
    if (client->due > now)
        return finite; /* nothing is due for its connection */
    int bytes = ll_connection_poll(client, s, now, run->composed);
    if (bytes > 0)
        ll_netgame_send(run, player, true, run->composed, bytes);
    ll_client_set_due(client, s);
    return finite;
}

/* ---- whose turn is next ---- */

/* The next actor. At one instant packets come first, then the server's step, its update, and the clients: so
 * a packet that arrives at a tick counts for that tick. */
typedef enum actor {
    ACTOR_UP,
    ACTOR_DOWN,
    ACTOR_PLAYOUT,
    ACTOR_TRANSPORT,
    ACTOR_STEP,
    ACTOR_UPDATE,
    ACTOR_TEND,
    ACTOR_CLIENT
} actor;

/* Time, actor and player in one number: of two turns the smaller comes first. */
typedef int64_t turn;

enum { PLAYER_BITS = 6, ACTOR_BITS = 3, TURN_BITS = PLAYER_BITS + ACTOR_BITS };
_Static_assert(LL_PLAYERS_MAX <= 1 << PLAYER_BITS, "a turn has room for every player");

#define LATEST ((INT64_MAX >> TURN_BITS) - 1) /* stands for LL_NEVER */

static turn turn_of(ll_time time, actor who, int player)
{
    return ((time < LATEST ? time : LATEST) * (1 << TURN_BITS)) |
           (turn)((unsigned)who << PLAYER_BITS | (unsigned)player);
}

static actor actor_of(turn t)
{
    return (actor)(t >> PLAYER_BITS & ((1 << ACTOR_BITS) - 1));
}

static int player_of(turn t)
{
    return (int)(t & ((1 << PLAYER_BITS) - 1));
}

/* Rounds down, before time 0 too. */
static ll_time time_of(turn t)
{
    return t >> TURN_BITS;
}

static turn earlier(turn a, turn b)
{
    return a < b ? a : b;
}

static turn arrival_of(const ll_link *link, actor who, int player)
{
    ll_time due = ll_link_next_due(link);
    if (due == LL_NEVER)
        return INT64_MAX;
    return due * (1 << TURN_BITS) | (turn)((unsigned)who << PLAYER_BITS | (unsigned)player);
}

/* The next turns: of the server and of the players. Each is computed again only if the last event may have
 * changed it. Those of the players are the leaves of a tree in which every node has the first of its two
 * children, which are at twice its index and after that: the root, at 1, has the first of all. */
typedef struct player_turns {
    turn acts, up, down; /* of a player: its client's, and of packets on its links */
} player_turns;

typedef struct schedule {
    turn step, update, tend; /* the server's */
    turn server;             /* the first of them */
    player_turns of[LL_PLAYERS_MAX];
    unsigned leaves; /* a power of two; player i is at leaves + i, and the rest have no turn */
    turn tree[2 * LL_PLAYERS_MAX];
} schedule;

_Static_assert((LL_PLAYERS_MAX & (LL_PLAYERS_MAX - 1)) == 0, "the tree has room for every player");

static void begin_schedule(schedule *next, int players)
{
    next->step = next->update = INT64_MAX;
    next->leaves = 1;
    while (next->leaves < (unsigned)players)
        next->leaves *= 2;
    for (unsigned i = 1; i < 2 * next->leaves; i++)
        next->tree[i] = INT64_MAX;
}

static void set_player(schedule *next, int player, turn first)
{
    unsigned at = next->leaves + (unsigned)player;
    for (next->tree[at] = first; at > 1; at /= 2)
        next->tree[at / 2] = earlier(next->tree[at], next->tree[at ^ 1]);
}

static void renew_step(const ll_netgame_run *run, schedule *next)
{
    next->step = turn_of(run->sync->due(run->server), ACTOR_STEP, 0);
    next->server = earlier(earlier(next->step, next->update), next->tend);
}

static void renew_update(const ll_netgame_run *run, schedule *next)
{
    const ll_server *server = run->server;
    next->update = run->sync->server_steps_at_update_hz
                       ? INT64_MAX
                       : turn_of(ll_clock_time(&server->updates, server->update), ACTOR_UPDATE, 0);
    next->server = earlier(earlier(next->step, next->update), next->tend);
}

static inline void renew_acts(const ll_netgame_seat *seat, player_turns *of, int player, ll_time now)
{
    const ll_time due = seat->client->due;
    /* a received packet may have made something due */
    of->acts = turn_of(due > now ? due : now, ACTOR_CLIENT, player);
}

static inline void renew_up(const ll_netgame_seat *seat, player_turns *of, int player)
{
    of->up = arrival_of(seat->up, ACTOR_UP, player);
}

static inline void renew_down(const ll_netgame_seat *seat, player_turns *of, int player)
{
    of->down = arrival_of(seat->down, ACTOR_DOWN, player);
}

static inline turn first_of(const player_turns *of)
{
    return earlier(earlier(of->acts, of->up), of->down);
}

static __attribute__((noinline)) void renew_player(const ll_netgame_run *run, schedule *next, int player)
{
    const ll_netgame_seat *seat = &run->seat[player];
    player_turns *of = &next->of[player];
    renew_acts(seat, of, player, run->game->now);
    renew_up(seat, of, player);
    renew_down(seat, of, player);
    turn first = first_of(of);
    if (seat->dejitter)
        first = earlier(first, turn_of(ll_dejitter_next_due(seat->dejitter), ACTOR_PLAYOUT, player));
    if (seat->transport)
        first = earlier(first, turn_of(ll_transport_due(seat->transport), ACTOR_TRANSPORT, player));
    set_player(next, player, first);
}

/* The server checks its connections. */
static __attribute__((noinline)) void renew_tend(const ll_netgame_run *run, schedule *next)
{
    next->tend = turn_of(run->server->next_check, ACTOR_TEND, 0);
    next->server = earlier(earlier(next->step, next->update), next->tend);
}

static __attribute__((noinline)) void renew_all(const ll_netgame_run *run, schedule *next)
{
    renew_tend(run, next);
    renew_update(run, next);
    renew_step(run, next);
    for (int i = 0; i < run->players; i++)
        renew_player(run, next, i);
}

/* The server has sent to all players. */
static void renew_arrivals(const ll_netgame_run *run, schedule *next)
{
    for (int i = 0; i < run->players; i++) {
        renew_down(&run->seat[i], &next->of[i], i);
        if (next->of[i].down < next->tree[next->leaves + (unsigned)i])
            set_player(next, i, next->of[i].down);
        if (run->seat[i].transport)
            renew_player(run, next, i);
    }
}

/* False when a world has diverged, at `where`. */
static inline __attribute__((always_inline)) bool take_server_turn(ll_netgame_run *run, schedule *next,
                                                                   turn now, divergence *where)
{
    bool finite = true;
    switch (actor_of(now)) {
    case ACTOR_STEP:
        finite = server_steps(run, where);
        renew_step(run, next);
        if (run->sync->server_steps_at_update_hz)
            renew_arrivals(run, next);
        break;
    case ACTOR_UPDATE:
        ll_netgame_update(run);
        run->server->update++;
        renew_update(run, next);
        if (run->sync->steps_by_inputs)
            renew_step(run, next); /* what it has sent may be what a relay waits for */
        renew_arrivals(run, next);
        break;
    case ACTOR_TEND:
        ll_netgame_check_connections(run);
        renew_all(run, next);
        break;
    default:
        LL_ASSERT(false);
    }
    return finite;
}

static bool take_turn(ll_netgame_run *run, schedule *next, turn now, divergence *where)
{
    const int player = player_of(now);
    ll_netgame_seat *seat = &run->seat[player];
    player_turns *of = &next->of[player];
    bool finite = true;
    LL_KEEP(seat);
    LL_KEEP(of);
    switch (actor_of(now)) {
    case ACTOR_UP:
        ll_netgame_deliver_up(run, player);
        if (run->sync->steps_by_inputs)
            renew_step(run, next);
        if (run->meshed)
            renew_arrivals(run, next);
        renew_up(seat, of, player);
        renew_down(seat, of, player); /* it may have answered */
        break;
    case ACTOR_DOWN:
        ll_netgame_deliver_down(run, player);
        renew_down(seat, of, player);
        renew_acts(seat, of, player, run->game->now);
        break;
    case ACTOR_PLAYOUT:
        ll_netgame_deliver_held(run, player);
        break;
    case ACTOR_TRANSPORT:
        ll_netgame_transport_timers(run, player);
        break;
    case ACTOR_CLIENT:
        finite = client_acts(run, seat, player, where);
        renew_acts(seat, of, player, run->game->now);
        renew_up(seat, of, player);
        break;
    case ACTOR_STEP:
    case ACTOR_UPDATE:
    case ACTOR_TEND:
        return take_server_turn(run, next, now, where);
    }
    if (seat->plain)
        set_player(next, player, first_of(of));
    else
        renew_player(run, next, player);
    return finite;
}

static void take_seat(ll_netgame_run *run, int i)
{
    ll_netgame *g = run->game;
    const ll_player_config *config = &g->config.players[i];
    const ll_netgame_parts *parts = ll_netgame_parts_of(g, i);
    char *block = (char *)g;
    ll_profile_shelf *shelf = ll_netgame_profiles(g);
    ll_dejitter *dejitter = (ll_dejitter *)(block + parts->dejitter);
    bool plays_out = config->dejitter != LL_DEJITTER_NONE || ll_dejitter_depth(dejitter) > 0;
    run->seat[i] = (ll_netgame_seat){
        .client = (ll_client *)(block + parts->client),
        .slot = &run->server->client_slots[i],
        .metrics = (ll_client_metrics *)(block + parts->client_metrics),
        .up = (ll_link *)(block + parts->up),
        .down = (ll_link *)(block + parts->down),
        .dejitter = plays_out ? dejitter : NULL,
        .transport = ll_netgame_transport(g, i),
        .up_plan = ll_profile_shelf_plan(shelf, 2 * i, &config->link.up, config->lag_ms),
        .down_plan = ll_profile_shelf_plan(shelf, 2 * i + 1, &config->link.down, config->lag_ms),
        .setup = ll_netgame_client_setup(g, i, run->recorder),
        .memo.until = INT64_MIN};
    run->seat[i].setup.memo = &run->seat[i].memo;
    run->seat[i].setup.usual = ll_client_is_usual(&run->seat[i].setup);
    run->seat[i].plain = !run->seat[i].transport && !run->seat[i].dejitter;
    if (run->seat[i].setup.selects) {
        run->seat[i].nearness = ll_netgame_nearness(g, i);
        run->seat[i].nearness->near_m = g->config.server.selection.radius_m / 4;
    }
}

static __attribute__((noinline)) void begin(ll_netgame_run *run, ll_netgame *g, const ll_recorder *r)
{
    run->game = g;
    run->rules = ll_netgame_game(g);
    run->sync = ll_netgame_sync(g);
    run->server = ll_netgame_server(g);
    run->world = ll_server_world(run->server);
    run->history = ll_netgame_history(g);
    run->shots = ll_netgame_shots(g);
    run->reckoning = ll_netgame_reckoning(g);
    run->reports = ll_netgame_reports(g);
    run->detection = ll_netgame_detection(g);
    run->recorder = r;
    run->players = g->config.player_count;
    run->meshed = ll_netgame_meshed(g);
    run->observes = ll_netgame_client_metrics(g, 0)->observes;
    run->waiting = ~UINT64_C(0) >> (64 - run->players);
    for (int i = 0; i < run->players; i++)
        take_seat(run, i);
}

ll_status ll_netgame_run_until(ll_netgame *g, ll_time until, const ll_recorder *r, ll_pace *pace)
{
    ll_netgame_run run;
    schedule next;
    divergence where = {0, -1};
    const bool paced = pace && pace->interrupt;
    const turn end = turn_of(until + 1, (actor)0, 0);
    begin(&run, g, r);
    begin_schedule(&next, run.players);
    renew_all(&run, &next);
    for (;;) {
        turn now = earlier(next.server, next.tree[1]);
        if (now >= end)
            break;
        if (paced && !ll_goes_on(pace))
            return ll_error(LL_INTERRUPTED, "a tick was interrupted");
        if (time_of(now) > g->now) /* otherwise a live change has brought it forward */
            g->now = time_of(now);
        if (!take_turn(&run, &next, now, &where))
            return not_finite(g, where);
    }
    g->now = until;
    return ll_ok();
}
