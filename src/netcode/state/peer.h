/* A client of the peer-to-peer syncs: it has all players' inputs by tick, and steps the whole world itself.
 *
 * Deterministic lockstep makes a tick when all its inputs have arrived, and waits otherwise. Rollback repeats
 * a player's last input as a guess and steps up to `max_rollback_ticks` beyond the confirmed tick. When an
 * input differs from the guess it goes back and resimulates (GGPO, GGRS). Deterministic lockstep is rollback
 * with a prediction window of 0. The worlds of confirmed ticks are hashed, and the relay server compares the
 * hashes.
 *
 * Cost per frame: one step of the whole world, a copy of it, and the resimulated steps. */
#pragma once

#include "netcode/state/client.h"
#include "netcode/state/peer_choices.h"

#define LL_PEER_RING 64    /* ticks of inputs, worlds and hashes that a client keeps */
#define LL_LEAD_SAMPLES 16 /* a mean lead has the weight 1 / this for its last value; at first 1 / count */

_Static_assert(LL_PEER_RING == LL_WAY_RING, "what is kept by tick reaches as far");

/* Farthest that a client may be beyond the server's step: only the client itself knows its own inputs that
 * are still on their way to the server. */
_Static_assert(2 * LL_ROLLBACK_MAX + LL_INPUT_DELAY_MAX + LL_SYNC_TEST_MAX < LL_PEER_RING,
               "the ring holds them");

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

/* What a client knows of a player. */
typedef struct ll_peer_player {
    int64_t known;   /* inputs up to this tick have arrived (own inputs: are made); later ones are guesses */
    int32_t at;      /* its tick in the last relay; -1: unknown */
    int32_t samples; /* number of such relays, at most as many as the mean uses */
    double ahead;    /* ticks that this client is ahead of it, from what is received of it; mean */
    double behind;   /* ticks that it is ahead of this client, from what it receives of it; mean */
    ll_controls inputs[LL_PEER_RING];
} ll_peer_player;

typedef struct ll_peer {
    ll_clock ticks;    /* time of a tick if no player ever waited: the time passed to steps and scripts */
    int64_t start;     /* tick of the world that it started from */
    int64_t first;     /* its own inputs are for the ticks after this one; those before are neutral */
    int64_t tick;      /* of the newest world */
    int64_t confirmed; /* all players' inputs up to here are known */
    int64_t wrong;     /* the first tick made with a wrong guess; LL_NEVER: none */
    int64_t hashed;    /* the relay server has the hashes up to this tick */
    ll_time stalled_since;
    ll_time relayed; /* when the last relay arrived; 0: none has */
    int64_t barrier; /* makes no inputs for ticks beyond this one (netcode/server/barrier.h); 0: no barrier */
    int64_t
        resume; /* the barrier ends when this many ticks have passed since the game began; 0: not known yet */
    int64_t time_sync_from; /* the frame before the one from which time sync checks are counted */
    int64_t began;          /* the tick that it started from, or of the last barrier */
    ll_time since;          /* when it continued from there; LL_NEVER: not yet */
    ll_time spread;         /* interval of ticks up to `spread_until`; 0: not known yet */
    int64_t spread_until;
    ll_time stepped;        /* when the last tick was made */
    uint32_t waiting;       /* bit p: cannot continue without the input of player p */
    int32_t frames_to_wait; /* frames to leave out so that the others catch up */
    uint32_t gap;           /* relays had stopped for a time, and the server does not know it yet */
    uint32_t reserved;
    uint32_t hashes[LL_PEER_RING];
    ll_peer_player player[]; /* one per player; then LL_PEER_RING worlds */
} ll_peer;

#pragma GCC diagnostic pop

static inline size_t ll_peer_size(int players, size_t world_size)
{
    return sizeof(ll_peer) + (size_t)players * sizeof(ll_peer_player) + LL_PEER_RING * world_size;
}

void ll_peer_start(ll_client *client, const ll_client_setup *setup, const ll_client_begin *begin);
int ll_peer_receive(ll_client *client, const ll_client_setup *setup, const void *packet, int bytes,
                    ll_time now);
int ll_peer_tick(ll_client *client, const ll_client_setup *setup, ll_time now, void *packet);
void ll_peer_display(ll_client *client, const ll_client_setup *setup, ll_time now);

/* The peer is stored where a client of an authoritative server has its snapshots. */
static inline ll_peer *ll_client_peer(const ll_client *c)
{
    return (ll_peer *)((char *)c + c->layout.states);
}

static inline ll_world *ll_peer_world(const ll_client *c, int64_t tick)
{
    const ll_peer *peer = ll_client_peer(c);
    return (ll_world *)((char *)&peer->player[ll_client_rendered_const(c)->players] +
                        (tick & (LL_PEER_RING - 1)) * c->layout.world_size);
}

static inline ll_controls *ll_peer_input(ll_peer *peer, int player, int64_t tick)
{
    return &peer->player[player].inputs[tick & (LL_PEER_RING - 1)];
}

/* The first other player, to whom the message of `ll_peer_tick` goes over a mesh; -1: there is none, and it
 * goes to the server. */
static inline int ll_peer_first_other(const ll_client *c)
{
    return c->self > 0 ? 0 : ll_client_rendered_const(c)->players > 1 ? 1 : -1;
}

/* Writes the copy of a tick's message for `other`, and returns its size. */
int ll_peer_compose(const ll_client *client, const ll_client_setup *setup, int other, void *packet);

static inline bool ll_peer_meshed(const ll_client_setup *setup)
{
    return (setup->rules->peers & LL_PEERS_MESH) != 0;
}

/* ---- shared by the peer's files ---- */

/* take.c: an input of `player`, and its tick with the lead that it reports, have arrived */
void ll_peer_take_input(ll_peer *peer, int player, int64_t tick, const ll_controls *input);
void ll_peer_take_lead(ll_client *client, const ll_client_setup *setup, const ll_relay_part *part,
                       ll_time now);

/* mesh.c */
void ll_mesh_start(ll_client *client, const ll_client_setup *setup);
int ll_mesh_receive(ll_client *client, const ll_client_setup *setup, const ll_peer_message *message,
                    ll_time now);
/* The server sent inputs that it made for `player`. */
void ll_mesh_note_away(const ll_client_setup *setup, int player);
/* The tick of the first input that a copy for `other` contains. */
int64_t ll_mesh_first(const ll_client *client, const ll_client_setup *setup, int other);

static inline bool ll_peer_paced(const ll_client_setup *setup)
{
    return (setup->rules->peers & LL_PEERS_PACE) != 0;
}

/* The input delay now, and the longest that it may have. */
static inline int64_t ll_peer_delay(const ll_client_setup *s)
{
    return s->rules->peers & LL_PEERS_ADAPT ? s->choices->delay : s->config->input_delay_ticks;
}

static inline int64_t ll_peer_delay_max(const ll_client_setup *s)
{
    return s->rules->peers & LL_PEERS_ADAPT ? LL_ADAPTIVE_DELAY_MAX : s->config->input_delay_ticks;
}

/* pacing.c */
void ll_pacing_start(const ll_client_setup *setup);
void ll_pacing_forget_lead(const ll_client_setup *setup, int player); /* after a barrier */
/* Inputs of `player` for ticks from `first` on have come that were not known. */
void ll_pacing_inputs_came(const ll_client *client, const ll_client_setup *setup, int player, int64_t first,
                           ll_time now);
/* What packets report to `player` in place of a whole lead, and what is taken from such a report. */
int32_t ll_pacing_report(const ll_client_setup *setup, int player);
void ll_pacing_take(ll_client *client, const ll_client_setup *setup, const ll_relay_part *part, ll_time now);
/* Lead over the player that is farthest behind, ticks; at least 0. */
double ll_pacing_lead(const ll_client *client, const ll_peer_choices *choices);
void ll_pacing_stretch(ll_client *client, const ll_client_setup *setup);
void ll_pacing_adapt_delay(ll_client *client, const ll_client_setup *setup, ll_time now);

/* step.c */
void ll_peer_step(ll_client *client, const ll_client_setup *setup); /* to the next tick */
void ll_peer_roll_back(ll_client *client, const ll_client_setup *setup,
                       ll_time now); /* if a guess was wrong */
void ll_peer_confirm(ll_client *client);
void ll_peer_sync_test(ll_client *client, const ll_client_setup *setup, ll_time now);
