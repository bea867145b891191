/* Shared by the files of a netgame: its packets, its observer, and the loop over its events. */
#pragma once

#include "netcode/protocol/packet.h"
#include "sim/netgame/netgame.h"

#define LL_NETGAME_PACKET_MAX (LL_GAME_WORLD_MAX + 2048)

static inline void ll_netgame_record(const ll_recorder *r, ll_event event)
{
    if (r)
        r->record(r->context, &event);
}

static inline ll_freq ll_netgame_rate(const ll_netgame *g, bool at_update_hz)
{
    return ll_freq_from_hz(at_update_hz ? g->config.server.update_hz : g->config.tick_hz);
}

/* What a run needs of one player: places in the block, and what follows from the configuration. */
typedef struct ll_netgame_seat {
    ll_client *client;
    ll_client_slot *slot;
    ll_client_metrics *metrics;
    ll_link *up, *down;
    ll_dejitter *dejitter;   /* NULL: off, and empty */
    ll_transport *transport; /* NULL: messages are packets */
    bool plain;              /* it has neither of these two */
    ll_nearness *nearness;   /* NULL: snapshots contain every entity */
    ll_link_plan up_plan, down_plan;
    ll_client_setup setup;
    ll_script_memo memo;
} ll_netgame_seat;

/* A run without changes from outside, found once at its start: nothing here changes during it but the packets
 * in hand. */
typedef struct ll_netgame_run {
    ll_netgame *game;
    const ll_game *rules;
    const ll_sync_mode *sync;
    ll_server *server;
    ll_world *world; /* the server's */
    ll_history *history;
    ll_shots *shots;         /* NULL in a game without weapons */
    ll_reckoning *reckoning; /* NULL: no dead reckoning */
    ll_reports *reports;     /* NULL: players send controls alone */
    ll_detection *detection; /* one per player; NULL: the server detects nothing */
    const ll_recorder *recorder;
    int players;
    bool meshed;       /* players' inputs travel directly to each other */
    uint32_t observes; /* bits of ll_observation */
    uint64_t waiting; /* a bit per player: it may have changes of controls that a display has not shown yet */
    ll_netgame_seat seat[LL_PLAYERS_MAX];
    ll_input_result results[LL_INPUTS_MAX]; /* of the inputs of a packet */
    _Alignas(8) char received[LL_NETGAME_PACKET_MAX];
    _Alignas(8) char composed[LL_NETGAME_PACKET_MAX];
} ll_netgame_run;

/* run.c: the set-up of the client of player `i` */
ll_client_setup ll_netgame_client_setup(const ll_netgame *g, int i, const ll_recorder *recorder);

/* Every event up to and including `until`; LL_DIVERGED where the server's world, or a client's view,
 * is not finite */
ll_status ll_netgame_run_until(ll_netgame *g, ll_time until, const ll_recorder *r, ll_pace *pace);

/* transport.c: where messages are not packets. Sides are those of link/transport/transport.h. */
ll_transport_setup ll_netgame_transport_setup(const ll_netgame_config *c, int up_max, int down_max);
/* `event` is that of the message; false: refused. */
bool ll_netgame_transport_send(ll_netgame_run *run, int player, int side, const void *message, int bytes,
                               const ll_event *event);
void ll_netgame_transport_arrive(ll_netgame_run *run, int player, int side);
int ll_netgame_transport_take(ll_netgame_run *run, int player, int side, void *message);
void ll_netgame_transport_settle(ll_netgame_run *run, int player, int side);
void ll_netgame_transport_timers(ll_netgame_run *run, int player);

extern const char *const ll_netgame_message_names[LL_MESSAGES + 1]; /* traffic.c; NULL-terminated */

/* observe.c: a plan of a link on which every packet is recorded; `tap` holds it, and must not move */
typedef struct ll_packet_tap {
    ll_link_plan plan;
    ll_link_tap link_tap;
    const ll_recorder *recorder;
    const ll_time *now;
    int32_t mtu;
    bool plain; /* packets are messages */
    ll_packet packet;
} ll_packet_tap;

static inline bool ll_netgame_records_packets(const ll_netgame_run *run)
{
    return run->recorder && run->recorder->packet;
}

void ll_netgame_tap(const ll_netgame_run *run, int player, bool up, ll_packet_tap *tap);

/* packets.c: sends and receives packets, and applies their effects on both sides */
void ll_netgame_send(ll_netgame_run *run, int player, bool up, const void *packet, int bytes);
void ll_netgame_update(ll_netgame_run *run);            /* to all connected players */
void ll_netgame_check_connections(ll_netgame_run *run); /* the server checks its connections */
void ll_netgame_deliver_up(ll_netgame_run *run, int player);
void ll_netgame_deliver_down(ll_netgame_run *run, int player);
void ll_netgame_deliver_held(ll_netgame_run *run, int player); /* by the de-jitter buffer */

/* observe.c: the event of a message that is sent now, but for its fate */
ll_event ll_netgame_message_event(const ll_netgame_run *run, int player, const void *packet);

/* observe.c: the server's statistics of a packet with inputs, and of a step in which shots were judged */
void ll_netgame_detect_packet(const ll_netgame_run *run, int player, const void *packet);
void ll_netgame_detect_shots(const ll_netgame_run *run, const ll_past *past);

/* observe.c: measurements that need a view of all actors */
void ll_netgame_record_shot(void *game, const ll_hit_result *hit_result); /* a shot was judged */
void ll_netgame_watch_players(ll_netgame_run *run, ll_time since);        /* after a step: gain of cheats */
/* Before a change to `next`: the gain of players that start to cheat counts from here on. */
void ll_netgame_watch_cheats_begin(ll_netgame *g, const ll_netgame_config *next);
void ll_netgame_observe_step(ll_netgame_run *run);
void ll_netgame_watch_tick(ll_netgame_run *run, int player);
void ll_netgame_observe_display(ll_netgame_run *run, int player);
void ll_netgame_compare_views(ll_netgame_run *run, ll_time elapsed);
