/* The authoritative server: receives inputs, validates and applies them, and its state is the true one.
 *
 * It knows of the clients only what their packets contain. Part of a simulation's block: no pointers. */
#pragma once

#include "game/core/compensate.h"
#include "netcode/protocol/config.h"
#include "netcode/protocol/event.h"
#include "netcode/protocol/sync.h"
#include "netcode/protocol/wire.h"
#include "netcode/reckoning/reckoning.h"
#include "netcode/server/starve.h"
#include "netcode/server/validate.h"
#include "netcode/snapshot/baseline_history.h"
#include "netcode/snapshot/replica.h"
#include "netcode/snapshot/snapshot.h"

#define LL_INPUT_RING 512 /* inputs kept per player, by step; more than ll_budget_ticks on either side */

#define LL_CONNECTION_CHECK_INTERVAL (LL_SECOND / 10) /* interval between checks of the connections */

#define LL_INPUT_RESULT_WORDS (LL_INPUT_RING / 32)

#define LL_HASH_RING 64 /* hashes of the server's world kept, by step */

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_input_slot {
    int64_t tick; /* -1: empty */
    ll_time came; /* when it arrived; -1 once applied on arrival */
    ll_action action;
    uint32_t seq;
    int32_t seen; /* step of the newest snapshot that the client had when it sent this */
} ll_input_slot;

/* What the relay server knows of one player's client. */
typedef struct ll_peer_status {
    int32_t at; /* its tick; -1: unknown */
    int32_t reserved;
    ll_time
        way; /* one-way delay to its client, as the client measured it; 0: none of its packets has arrived */
    ll_time came; /* when the last of them arrived; before the first, when its epoch began */
    ll_peer_ack acks[LL_PEERS_MAX];
    int64_t relayed; /* its newest input in the last relays: no client knows a later one */
    int64_t hashed;  /* its hashes up to this tick have been compared */
    int64_t desync;  /* the first that differed; -1: none */
} ll_peer_status;

/* The inputs of one player, and what became of them. */
typedef struct ll_slot_inputs {
    ll_input_slot ring[LL_INPUT_RING]; /* indexed by tick modulo the ring */
    ll_action held;     /* the last input applied on arrival, or the replacement of a refused one */
    ll_axes used;       /* in the last step, including replacements */
    int64_t held_step;  /* step of `held` */
    uint32_t acked;     /* the last input whose step is over, with any result */
    uint32_t processed; /* the newest applied input; 0: none */
    uint32_t decided;   /* the newest input with a result */
    uint32_t slack_seq;
    uint32_t wants;   /* ll_part */
    uint32_t repeats; /* packets without a new input since the last snapshot was sent */
    uint32_t results[LL_INPUT_RESULT_WORDS]; /* a bit for each input, by number: applied on arrival */
    uint64_t
        replaced[LL_INPUT_RING / 64]; /* a bit for each slot: it holds the replacement of a refused input */
    int64_t seq_minus_tick;
    int64_t newest; /* tick; -1: no input yet */
} ll_slot_inputs;

/* What snapshots to one player start from and report. */
typedef struct ll_slot_snapshots {
    int64_t received; /* tick of the newest snapshot that the client has; 0: none */
    int64_t
        full; /* tick of the last snapshot that was too long for a grid: no snapshot up to it is a baseline */
    int32_t slack; /* smallest since the last update */
    int32_t last_slack;
} ll_slot_snapshots;

/* How many inputs one player may still send: against cheats. */
typedef struct ll_slot_limits {
    ll_rate_limiter allowance;
    ll_time_budget account;
    double budget_used; /* largest used share of the time budget; above 1 it was exceeded */
} ll_slot_limits;

/* The connection to one player's client. */
typedef struct ll_slot_connection {
    ll_time seen;      /* the newest of the server's answers that the player is known to have */
    ll_time last_ack;  /* when that became known */
    ll_time last_sent; /* when anything was last sent to the player */
    int64_t first;     /* its inputs count for the steps after this one */
    uint32_t attempt;  /* of the client, with which it was accepted */
    uint16_t epoch;
    uint8_t connected;
    uint8_t offset; /* lockstep_pipelined: delay of its inputs in whole intervals, as measured by its pings */
    int64_t joins, drops;
} ll_slot_connection;

/* Counts for metrics. */
typedef struct ll_slot_counts {
    ll_time
        waited; /* both lockstep modes: time that all waited for this player's inputs, the last to arrive */
    int64_t accepted, duplicate, late, starved;
    int64_t refused[LL_RULES];
    ll_snapshot_cost sent;
} ll_slot_counts;

/* What the server knows of one player. */
typedef struct ll_client_slot {
    ll_slot_inputs inputs;
    ll_slot_snapshots snapshots;
    ll_slot_limits limits;
    ll_slot_connection connection;
    ll_slot_counts counts;
    ll_peer_status peer;
} ll_client_slot;

/* What it does with inputs that break a rule, and instead of inputs that are missing. */
typedef struct ll_server_rules {
    uint16_t validates;
    uint16_t mesh;         /* peers send their inputs to each other: it only keeps the session */
    int32_t refused;       /* ll_refused */
    int32_t starved;       /* index into ll_starves */
    int32_t starved_ticks; /* number of ticks that repeat_n repeats for */
    double starved_tau_ms; /* duration of decay */
} ll_server_rules;

/* Barriers of the peer-to-peer syncs (netcode/server/barrier.h). */
typedef struct ll_server_barriers {
    int32_t rollback;       /* rollback: prediction window of the clients, ticks */
    uint32_t due;           /* deterministic and rollback: a barrier is to follow */
    int64_t tick, resume;   /* as sent in relays */
    ll_time recovery_until; /* lockstep_pipelined: until then steps follow the inputs of one player;
                               deterministic and rollback: no barrier before then */
} ll_server_barriers;

typedef struct ll_server {
    ll_clock clock; /* of steps */
    ll_clock updates;
    int64_t step;       /* steps made; the state is that after this step */
    int64_t update;     /* number of the next update */
    ll_time stepped;    /* when the last step was made */
    ll_time stalled;    /* lockstep: time spent waiting for inputs */
    ll_time next_check; /* when the connections are checked next */
    ll_freq client_freq;
    int32_t players;
    uint16_t epoch; /* the last that was assigned */
    uint16_t codec; /* index into ll_codecs */
    ll_server_rules rules;
    ll_quantization grid; /* that the codec rounds to */
    ll_time from;         /* snapshot costs count from then on */
    ll_server_barriers barriers;
    uint32_t hashes[LL_HASH_RING]; /* deterministic and rollback: of the world after a step */
    ll_client_slot client_slots[]; /* one per player; then the world; the baselines; the replicas, if any */
} ll_server;

#pragma GCC diagnostic pop

size_t ll_server_size(int players, ll_extent extent); /* a multiple of 8 */

/* Zeroes the server and sets the size of its world; the caller fills in the world. */
void ll_server_init(ll_server *server, int players, ll_extent extent);
/* Its snapshots may contain some of the entities: there must be room for ll_replicas_size after it. */
void ll_server_replicate(ll_server *server);
void ll_server_configure(ll_server *server, const ll_server_config *config); /* how it sends its world */

/* Whether the hash of its world after `step` is kept. */
static inline bool ll_server_has_hash(const ll_server *server, int64_t step)
{
    return step <= server->step && step > server->step - LL_HASH_RING;
}

static inline ll_world *ll_server_world(ll_server *server)
{
    return (ll_world *)&server->client_slots[server->players];
}

static inline const ll_world *ll_server_world_const(const ll_server *server)
{
    return (const ll_world *)&server->client_slots[server->players];
}

static inline ll_baseline_history *ll_server_baseline_history(const ll_server *server)
{
    const ll_world *world = ll_server_world_const(server);
    return (ll_baseline_history *)((char *)world + ll_world_size(world));
}

/* NULL: it keeps none. */
static inline ll_replicas *ll_server_replicas(const ll_server *server)
{
    ll_baseline_history *b = ll_server_baseline_history(server);
    size_t size = ll_baseline_history_size((ll_extent){b->entities, b->tail});
    return b->replicated ? (ll_replicas *)((char *)b + size) : NULL;
}

/* 0 is no epoch: the epoch of a player who is not connected. */
static inline uint16_t ll_server_next_epoch(const ll_server *server)
{
    return server->epoch == UINT16_MAX ? 1 : (uint16_t)(server->epoch + 1);
}

/* Starts, or restarts in a new epoch at `now` with clocks of these rates; the world does not change. */
void ll_server_start(ll_server *server, ll_freq step_freq, ll_freq update_freq, ll_freq client_freq,
                     ll_time now);

/* Forgets all received inputs. */
void ll_client_slot_clear(ll_client_slot *client_slot);

/* For a player who starts again after `step`; received inputs, counters and the connection stay. */
void ll_client_slot_open(ll_client_slot *client_slot, ll_freq client_freq, int64_t step, ll_time now);

/* Action of `player` in step `step`: its input, or the replacement if none has arrived. */
ll_action ll_server_action(ll_server *server, int player, int64_t step);

/* Records that the server has decided an input, and whether it was applied. */
void ll_client_slot_done(ll_client_slot *client_slot, uint32_t seq, bool applied);

static inline bool ll_client_slot_replaced(const ll_client_slot *client_slot, int64_t tick)
{
    return client_slot->inputs.replaced[(tick & (LL_INPUT_RING - 1)) >> 6] >> (tick & 63) & 1;
}

/* Result of one input. */
typedef struct ll_input_result {
    uint32_t seq;
    uint8_t outcome; /* ll_event outcome: 0 applied 1 refused 3 late */
    uint8_t rule;
    int16_t slack; /* input slack, steps; negative: late */
} ll_input_result;

/* Processes the inputs of an ll_input_message. Writes a result for each that was not a repetition and returns
 * their number. A refused input is replaced according to `refused`, so that no player waits for it. */
int ll_server_receive(ll_server *server, const ll_sync_mode *sync, int player, const void *packet,
                      ll_time now, ll_input_result results[LL_INPUTS_MAX]);

/* Sets in `past` the age, at `now`, of the newest snapshot that `player` had when it made the input of
 * `slot`. */
void ll_server_measure(ll_past *past, int player, const ll_input_slot *slot, ll_time now);

/* Writes the message of an update to `player` and returns its size, at most ll_server_message_max. Where the
 * client has no baseline, delta becomes quantised; an encoding longer than full becomes full. `common`: what
 * the messages of this update share (netcode/snapshot/common.h); NULL: each is encoded whole. */
int ll_server_compose(ll_server *server, const ll_sync_mode *sync, int player,
                      struct ll_snapshot_common *common, void *packet);
/* The same with dead reckoning: the world has the entities that are due. */
int ll_server_compose_reckoned(ll_server *server, const ll_sync_mode *sync, int player,
                               ll_reckoning *reckoning, void *packet);
int ll_server_message_max(ll_extent extent, int players);
