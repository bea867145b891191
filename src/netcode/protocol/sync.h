/* Sync modes, which keep server and clients in step. */
#pragma once

#include <stdbool.h>

#include "base/vtime.h"
#include "game/core/game.h"

struct ll_past;
struct ll_server;
struct ll_client;
struct ll_client_setup;
struct ll_client_begin;
struct ll_input_result;
struct ll_desync;
struct ll_snapshot_common;

typedef struct ll_sync_mode {
    const char *name;
    bool server_steps_at_update_hz; /* otherwise at tick_hz */
    bool client_steps_at_update_hz; /* otherwise at tick_hz */
    bool client_runs_ahead;         /* clients run ahead, so that an input arrives before its step */
    bool applies_on_arrival;        /* the server applies inputs on arrival, not by their step */
    double press_s; /* the duration of a key press counts, at most this; 0: an input lasts one tick */
    bool waits; /* the server waits for every input: clients repeat all open inputs, and the server sends the
                   newest snapshot again to a client that lacks it */
    bool steps_by_inputs;  /* the time of the next step depends on received inputs, not on the clock alone */
    bool answers;          /* a client makes its next input only when a snapshot has arrived */
    bool sends_idle;       /* an input for every tick, also when no control is touched */
    bool reports_refusals; /* a refused input is answered */
    bool drops_stale;      /* a client ignores a snapshot older than the newest it has */
    bool extrapolates;     /* a client extrapolates beyond the newest snapshot if configured */
    bool guesses;          /* clients step with guessed inputs, up to max_rollback_ticks */
    bool buckets;          /* inputs have a fixed playout delay (netcode/protocol/bucket.h) */

    /* Time of the server's next step; LL_NEVER while it waits. */
    ll_time (*due)(const struct ll_server *server);

    /* One step of the server's world with the inputs it has. `past` is for the game; the sync mode fills in
     * the age of the players' views. NULL: no lag compensation. */
    void (*step)(struct ll_server *server, const ll_game *game, const ll_game_env *env, struct ll_past *past,
                 ll_time now);

    /* The server receives a packet of `player`. Writes a result for each input that was not a repetition, at
     * most LL_INPUTS_MAX, and returns their number. */
    int (*take)(struct ll_server *server, const struct ll_sync_mode *sync, int player, const void *packet,
                ll_time now, struct ll_input_result *results);

    /* Makes inputs for players who are not connected; called when one is dropped. NULL: the steps do it. */
    void (*stand_in)(struct ll_server *server, ll_time now);

    /* `player` has been accepted, with the world of a game in progress; NULL: nothing to do. */
    void (*join)(struct ll_server *server, const struct ll_sync_mode *sync, int player, ll_time now);

    /* Writes the server's message of an update to `player` and returns its size. */
    int (*compose)(struct ll_server *server, const struct ll_sync_mode *sync, int player,
                   struct ll_snapshot_common *common, void *packet);

    /* Initialises the client's part of this sync mode, from a world. NULL: nothing to do. */
    void (*start)(struct ll_client *client, const struct ll_client_setup *setup,
                  const struct ll_client_begin *begin);

    /* A packet of the server has reached a client. Returns its ll_outcome. */
    int (*receive)(struct ll_client *client, const struct ll_client_setup *setup, const void *packet,
                   int size, ll_time now);

    /* One tick of a client: reads what has arrived, makes inputs. Writes the client's message and returns its
     * size, 0 if there is nothing to send. */
    int (*tick)(struct ll_client *client, const struct ll_client_setup *setup, ll_time now, void *packet);

    /* One display of a client: reads what has arrived and decides what to draw. */
    void (*display)(struct ll_client *client, const struct ll_client_setup *setup, ll_time now);

    /* Puts the entities of others where the client draws them at `now` with interpolation on; NULL: `display`
     * does not interpolate. */
    void (*interpolate)(struct ll_client *client, const struct ll_client_setup *setup, ll_time now);

    /* After a tick: the observer compares the client's world with the server's; NULL: clients have no world
     * of their own. */
    void (*observe)(struct ll_desync *desync, const struct ll_client *client,
                    const struct ll_client_setup *setup, const struct ll_server *server);
} ll_sync_mode;

/* X(name), in the order of the choice `sync` */
#define LL_SYNC_MODES(X)                                                                                     \
    X(free) X(lockstep) X(gambetta) X(deterministic) X(rollback) X(lockstep_pipelined) X(bucket)

#define LL_SYNC_DECLARE(name) extern const ll_sync_mode ll_sync_##name;
LL_SYNC_MODES(LL_SYNC_DECLARE)
#undef LL_SYNC_DECLARE

extern const ll_sync_mode *const ll_syncs[]; /* NULL-terminated */
extern const char *const ll_sync_mode_names[];
