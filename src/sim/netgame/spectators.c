/* Spectators of the peer-to-peer syncs: their links, whose turn it is, and what is measured and streamed of
 * them.
 *
 * They read what packets bring them, and nothing of theirs reaches a player. Their links are their own, with
 * draws of their own, so that a game is the same with and without them. */
#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

#include "sim/netgame/parts.h"

#define LINK_SECONDS 1.3 /* of packets that a link holds; none takes longer */
#define WORLDS 8         /* at most on their way, by LL_SPECTATOR_ASKS */
#define STREAM 1024      /* of random numbers: links of players have lower ones */

/* ---- layout ---- */

static int slots(const ll_netgame_config *c)
{
    double rate = c->tick_hz > c->server.update_hz ? c->tick_hz : c->server.update_hz;
    return (int)(rate * LINK_SECONDS) + 32;
}

static int down_arena(const ll_netgame_config *c, size_t world_size)
{
    return slots(c) * ll_feed_message_max(c->player_count) +
           WORLDS * (int)(sizeof(ll_feed_message) + world_size);
}

static int up_arena(const ll_netgame_config *c)
{
    return slots(c) * (int)sizeof(ll_watch_message);
}

int64_t ll_netgame_lay_out_spectators(ll_netgame *g, const ll_netgame_config *c, int64_t at, ll_extent world)
{
    ll_netgame_spectators all = {.count = c->spectator_count};
    const size_t world_size = ll_extent_size(world);
    if (c->spectator_count == 0)
        return at;
    for (int i = 0; i < c->spectator_count; i++) {
        ll_netgame_spectator s = {.feed = (int64_t)sizeof s};
        s.watcher = s.feed + (int64_t)ll_feed_size(c->player_count);
        s.up = s.watcher + (int64_t)ll_spectator_size(c->player_count, world_size);
        s.down = s.up + (int64_t)ll_link_size(slots(c), up_arena(c));
        all.at[i] = at;
        if (g) {
            s.params = c->spectators[i];
            memcpy((char *)g + at, &s, sizeof s);
        }
        at += s.down + (int64_t)ll_link_size(slots(c), down_arena(c, world_size));
    }
    if (g)
        memcpy((char *)g + at, &all, sizeof all);
    return at + (int64_t)sizeof all;
}

void ll_netgame_init_spectators(ll_netgame *g, const ll_netgame_config *c)
{
    const size_t world_size = ll_world_size(ll_server_world_const(ll_netgame_server(g)));
    for (int i = 0; i < c->spectator_count; i++) {
        ll_netgame_spectator *s = ll_netgame_spectator_of(g, i);
        const uint64_t stream = STREAM + 2 * (uint64_t)i, seed = (uint64_t)c->head.seed;
        ll_link_init(ll_netgame_spectator_up(s), slots(c), up_arena(c), seed, stream);
        ll_link_init(ll_netgame_spectator_down(s), slots(c), down_arena(c, world_size), seed, stream + 1);
        ll_histogram_init(&s->age_ms, 0.1);
        s->from = (ll_time)(c->warmup_s * 1e9);
        s->due = LL_NEVER;
        ll_spectator *w = ll_netgame_watcher(s);
        w->players = c->player_count;
    }
}

void ll_netgame_begin_spectators(ll_netgame *g, ll_time now)
{
    const ll_server *server = ll_netgame_server(g);
    for (int i = 0; i < ll_netgame_spectator_count(g); i++) {
        ll_netgame_spectator *s = ll_netgame_spectator_of(g, i);
        const uint16_t epoch = (uint16_t)(ll_netgame_watcher(s)->epoch + 1);
        ll_feed_start(ll_netgame_feed_of(s), server->players, epoch, server->step);
        ll_spectator_start(ll_netgame_watcher(s), ll_server_world_const(server), epoch, server->step,
                           server->clock);
        s->ticks = (ll_clock){now, 0, server->client_freq};
        s->due = ll_clock_time(&s->ticks, 1);
        s->made_upto = server->step;
        s->made[server->step & (LL_NETGAME_MADE - 1)] = s->shown = now;
    }
}

void ll_netgame_change_spectators(ll_netgame *g, const ll_netgame_config *c)
{
    for (int i = 0; i < ll_netgame_spectator_count(g) && i < c->spectator_count; i++)
        ll_netgame_spectator_of(g, i)->params = c->spectators[i];
}

/* ---- who sends ---- */

static void count(ll_traffic *t, int type, int bytes, int fragments)
{
    int headers = fragments * (LL_UDP_OVERHEAD + (fragments > 1 ? LL_FRAGMENT_HEADER : 0));
    t->bytes[type] += bytes;
    t->messages[type]++;
    t->packets[type] += fragments;
    t->wire_bytes[type] += bytes + headers;
}

/* Of a player who sends, too: a copy is one of its input messages, an acknowledgement comes to it like a
 * relay. */
static void count_both(const ll_netgame_run *run, ll_netgame_spectator *s, bool copy, int bytes,
                       int fragments)
{
    const ll_time now = run->game->now;
    if (now >= s->from)
        count(copy ? &s->sent : &s->acks, LL_MESSAGE_RELAY, bytes, fragments);
    if (s->params.player < 0)
        return;
    ll_client_metrics *in = run->seat[s->params.player].metrics;
    if (now >= in->from)
        count(&in->traffic, copy ? LL_MESSAGE_INPUT : LL_MESSAGE_RELAY, bytes, fragments);
}

/* The sender has made the ticks up to this one: a client now, the server when its history says. */
static void note_made(ll_netgame_spectator *s, int64_t tick, const ll_history *history, ll_time now)
{
    if (tick - s->made_upto > LL_NETGAME_MADE)
        s->made_upto = tick - LL_NETGAME_MADE;
    while (s->made_upto < tick) {
        int64_t made = ++s->made_upto;
        s->made[made & (LL_NETGAME_MADE - 1)] = history ? ll_history_time(history, made) : now;
    }
}

static int compose(ll_netgame_run *run, ll_netgame_spectator *s, int sender)
{
    ll_feed *feed = ll_netgame_feed_of(s);
    const ll_world *world;
    if (sender < 0) {
        ll_feed_follow_server(feed, run->server);
        note_made(s, run->server->step, run->history, run->game->now);
        world = run->world;
    } else {
        const ll_client *client = run->seat[sender].client;
        ll_feed_follow_client(feed, client);
        note_made(s, ll_client_peer(client)->tick, NULL, run->game->now);
        world = ll_feed_client_world(feed, client);
    }
    return ll_feed_compose(feed, world, run->composed);
}

static void feed_spectator(ll_netgame_run *run, ll_netgame_spectator *s, int sender)
{
    const ll_time now = run->game->now;
    const void *packet;
    int bytes;
    while ((packet = ll_link_next(ll_netgame_spectator_up(s), now, &bytes)) != NULL)
        ll_feed_receive(ll_netgame_feed_of(s), packet);
    bytes = compose(run, s, sender);
    if (bytes == 0)
        return;
    const ll_sending sent = ll_link_send(ll_netgame_spectator_down(s), &s->params.link.down, s->params.lag_ms,
                                         now, run->composed, bytes);
    count_both(run, s, true, bytes, sent.fragments);
}

__attribute__((noinline)) void ll_netgame_feed_spectators(ll_netgame_run *run, int sender)
{
    if (!run->sync->observe || run->game->now < 0 ||
        (sender >= 0 && !ll_connection_plays(&run->seat[sender].client->connection)))
        return;
    for (int i = 0; i < run->spectators->count; i++) {
        ll_netgame_spectator *s = ll_netgame_spectator_of(run->game, i);
        if (s->params.player == sender)
            feed_spectator(run, s, sender);
    }
}

/* ---- who watches ---- */

__attribute__((noinline)) ll_time ll_netgame_spectators_due(const ll_netgame_run *run, int *spectator)
{
    ll_time first = LL_NEVER;
    *spectator = 0;
    for (int i = 0; i < run->spectators->count; i++) {
        ll_time due = ll_netgame_spectator_of(run->game, i)->due;
        *spectator = due < first ? i : *spectator;
        first = due < first ? due : first;
    }
    return first;
}

static void answer(ll_netgame_run *run, ll_netgame_spectator *s)
{
    const ll_time now = run->game->now;
    ll_watch_message m;
    if (!ll_spectator_compose(ll_netgame_watcher(s), &m))
        return;
    const ll_sending sent = ll_link_send(ll_netgame_spectator_up(s), &s->params.link.up, s->params.lag_ms,
                                         now, &m, (int)sizeof m);
    count_both(run, s, false, (int)sizeof m, sent.fragments);
}

/* What has changed since `before`, from the warm-up on. */
static void measure(ll_netgame_spectator *s, const ll_spectator *before, ll_time now)
{
    const ll_spectator *w = ll_netgame_watcher(s);
    if (w->tick != before->tick)
        s->shown = s->made[w->tick & (LL_NETGAME_MADE - 1)];
    if (now < s->from)
        return;
    s->catch_up += w->catch_up - before->catch_up;
    s->ticks_made += w->made - before->made;
    s->waits += w->waits - before->waits;
    s->out_ticks += w->out_ticks - before->out_ticks;
    s->falls += w->falls - before->falls;
    ll_histogram_add(&s->age_ms, ll_to_ms(now - s->shown));
    ll_running_stats_add(&s->behind, (double)(w->known - w->tick));
}

/* Packets that have arrived since its last tick wait for this one, which is the first that can show them. */
__attribute__((noinline)) void ll_netgame_spectate(ll_netgame_run *run, int i)
{
    const ll_netgame *g = run->game;
    ll_netgame_spectator *s = ll_netgame_spectator_of(g, i);
    ll_spectator *w = ll_netgame_watcher(s);
    const ll_spectator before = *w;
    const void *packet;
    int bytes;
    while ((packet = ll_link_next(ll_netgame_spectator_down(s), g->now, &bytes)) != NULL)
        ll_spectator_receive(w, &s->params, packet);
    ll_spectator_tick(w, &s->params, run->rules, &g->env);
    measure(s, &before, g->now);
    answer(run, s);
    s->due = ll_clock_time(&s->ticks, w->number + 1);
}

/* ---- metrics ---- */

#define SPECTATOR(X)                                                                                         \
    X(count, tick, NULL, w->tick, "tick that the spectator shows; counted from the game's begin", NULL)      \
    X(flag, out, NULL, w->out != 0, "the spectator has fallen out and has no new world yet", NULL)           \
    X(distribution, age_ms, "ms", ll_netgame_distribution(ll_histogram_summary(&s->age_ms)),                 \
      "age of what the spectator shows: virtual time now less the time at which its sender made that tick; " \
      "a value per tick of the spectator's machine",                                                         \
      "The run has not reached warmup_s.")                                                                   \
    X(gauge, behind_ticks, "ticks", ll_netgame_gauge(&s->behind, 1),                                         \
      "ticks whose inputs the spectator has and that it has not shown", "The run has not reached warmup_s.") \
    X(count, ticks, NULL, s->ticks_made, "ticks that the spectator made", NULL)                              \
    X(count, catch_up_ticks, NULL, s->catch_up, "of these, made as a second one at once to catch up", NULL)  \
    X(number, waited_s, "s", (double)s->waits * g->env.dt,                                                   \
      "time that the spectator had no inputs for a next tick; a tick of its machine counts 1 / tick_hz",     \
      NULL)                                                                                                  \
    X(events, fell_out, NULL, s->falls,                                                                      \
      "times that the spectator fell out: inputs for more than buffer_ticks came at once, or the sender no " \
      "longer had the next ones",                                                                            \
      NULL)                                                                                                  \
    X(number, out_s, "s", (double)s->out_ticks * g->env.dt,                                                  \
      "time that the spectator was out; a tick of its machine counts 1 / tick_hz", NULL)                     \
    X(number, messages_per_s, "1/s", ll_netgame_ratio((double)s->sent.messages[LL_MESSAGE_RELAY], seconds),  \
      "messages to the spectator per second", "The run has not reached warmup_s.")                           \
    X(number, wire_bytes_per_s, "B/s",                                                                       \
      ll_netgame_ratio((double)s->sent.wire_bytes[LL_MESSAGE_RELAY], seconds),                               \
      "bytes per second to the spectator on the wire, headers included; of a player who sends them they "    \
      "are "                                                                                                 \
      "part of its input messages",                                                                          \
      "The run has not reached warmup_s.")                                                                   \
    X(number, ack_bytes_per_s, "B/s",                                                                        \
      ll_netgame_ratio((double)s->acks.wire_bytes[LL_MESSAGE_RELAY], seconds),                               \
      "bytes per second from the spectator on the wire, headers included",                                   \
      "The run has not reached warmup_s.")

const ll_metric_table ll_netgame_spectator_table = {
    LL_OF_RUN("spectators.*"), .when = "Only with spectators.",
    .help = "A spectator of deterministic lockstep or rollback, from warmup_s on.",
    LL_METRICS_FROM(SPECTATOR)};

void ll_netgame_spectator_metrics(const ll_netgame *g, cJSON *metrics)
{
    const int n = ll_netgame_spectator_count(g);
    cJSON *all = n > 0 ? cJSON_AddArrayToObject(metrics, "spectators") : NULL;
    for (int i = 0; i < n; i++) {
        const ll_netgame_spectator *s = ll_netgame_spectator_of(g, i);
        const ll_spectator *w = ll_netgame_watcher(s);
        const double seconds = g->now > s->from ? ll_to_s(g->now - s->from) : 0;
        cJSON *o = cJSON_CreateObject();
        LL_METRICS_PUT(o, &ll_netgame_spectator_table, SPECTATOR);
        cJSON_AddItemToArray(all, o);
    }
}

/* ---- streamed ---- */

typedef struct spectator_row {
    uint8_t spectator, state;
    int64_t tick;
    uint32_t buffered, waits, catch_up, falls;
    float age_ms;
} spectator_row;

enum { FOLLOWING, CATCHING_UP, OUT };
static const char *const states[] = {"following", "catching_up", "out", NULL};

static const ll_record_field spectator_fields[] = {
    LL_INT(spectator_row, spectator, NULL, "index of the spectator"),
    LL_ENUM(spectator_row, state, states,
            "catching_up: makes two ticks at once; out: has fallen out, and waits for a whole world"),
    LL_INT(spectator_row, tick, NULL, "tick that it shows"),
    LL_INT(spectator_row, buffered, "ticks", "ticks whose inputs it has and that it has not shown"),
    LL_STEP(spectator_row, age_ms, LL_BITS_MS, "ms",
            "age of what it shows: virtual time now less the time at which its sender made that tick; null: "
            "the game has not begun"),
    LL_INT(spectator_row, waits, NULL, "ticks of its machine without inputs for a next tick"),
    LL_INT(spectator_row, catch_up, NULL, "ticks that it made as second ones at once"),
    LL_INT(spectator_row, falls, NULL, "times that it has fallen out"),
};

const ll_record ll_netgame_spectator_record = {.id = 15,
                                               .name = "spectators",
                                               .channel = LL_CHANNEL_SPECTATORS,
                                               .help = "Spectators, counted from the game's begin.",
                                               .form = LL_FORM_BY_INDEX,
                                               LL_ROWS_OF(spectator_row, spectator_fields)};

static uint8_t state_of(const ll_netgame_spectator *s, const ll_spectator *w)
{
    const int64_t ahead = w->known - w->tick;
    if (w->out)
        return OUT;
    return ahead > s->params.behind_ticks && ahead > 1 ? CATCHING_UP : FOLLOWING;
}

static spectator_row row_of(const ll_netgame *g, int i)
{
    const ll_netgame_spectator *s = ll_netgame_spectator_of(g, i);
    const ll_spectator *w = ll_netgame_watcher(s);
    return (spectator_row){.spectator = (uint8_t)i,
                           .state = state_of(s, w),
                           .tick = w->tick,
                           .buffered = (uint32_t)(w->known - w->tick),
                           .age_ms = s->due == LL_NEVER ? NAN : (float)ll_to_ms(g->now - s->shown),
                           .waits = (uint32_t)w->waits,
                           .catch_up = (uint32_t)w->catch_up,
                           .falls = (uint32_t)w->falls};
}

void ll_netgame_fill_spectators(const ll_netgame *g, ll_row_set *rows)
{
    for (int i = 0; i < ll_netgame_spectator_count(g); i++) {
        const spectator_row row = row_of(g, i);
        ll_row_set_put(rows, &ll_netgame_spectator_record, &row, 1);
    }
}
