/* How server and clients keep in step: one row, and one file, per way. */
#pragma once

#include <stdbool.h>

#include "base/vtime.h"
#include "game/core/game.h"

struct ll_past;
struct ll_server;
struct ll_client;
struct ll_client_setup;
struct ll_input_result;
struct ll_desync;

typedef struct ll_sync_mode {
    const char *name;
    const char *help;
    bool server_steps_at_update_hz; /* otherwise at tick_hz */
    bool client_steps_at_update_hz; /* otherwise at tick_hz */
    bool
        client_runs_ahead; /* clients run ahead, so that an input arrives for the step that it is meant for */
    bool applies_on_arrival; /* the server applies inputs as they have come, not by their step */
    double press_s; /* an input counts for the time that a key was down, at most so long; 0: for a tick */
    bool waits; /* the server does not go on without an input: clients repeat all that is open, and are told
                   the newest state again when they lack it */
    bool steps_by_inputs; /* when the next step is due depends on what has come, not on the clock alone */
    bool answers;         /* a client makes its next input when a state has come, and not before */
    bool sends_idle;      /* an input for every tick, also when no control is touched */
    bool tells_refusals;  /* a refused input is answered */
    bool drops_stale;     /* a client ignores a state that is older than the one it has */
    bool extrapolates;    /* a client goes on beyond the newest state when it is set to */
    bool guesses;         /* clients step on by guessed inputs, up to max_rollback_ticks */

    /* When the server's next step is due; LL_NEVER while it waits. */
    ll_time (*due)(const struct ll_server *server);

    /* One step of the server's world by the inputs it has. `past` is for the game; the way of keeping in step
     * fills in how old the players' views must be. NULL where nobody looks back. */
    void (*step)(struct ll_server *server, const ll_game *game, const ll_game_env *env, struct ll_past *past,
                 ll_time now);

    /* The server takes a packet of `player`. Gives a verdict for each input that was not a repetition, at
     * most LL_INPUTS_MAX, and returns how many. */
    int (*take)(struct ll_server *server, const struct ll_sync_mode *sync, int player, const void *packet,
                ll_time now, struct ll_input_result *verdicts);

    /* Stands in for players who are not connected; called when one is dropped. NULL: steps see to it. */
    void (*stand_in)(struct ll_server *server, ll_time now);

    /* `player` has been let in, with the world of a game that is under way; NULL: nothing. */
    void (*join)(struct ll_server *server, const struct ll_sync_mode *sync, int player, ll_time now);

    /* Writes the server's message of an update to `player` and returns its size. */
    int (*compose)(struct ll_server *server, const struct ll_sync_mode *sync, int player, void *packet);

    /* What a client sets up beside the common, at step `step` of `world`; its inputs begin behind step
     * `first`. NULL: nothing. */
    void (*start)(struct ll_client *client, const struct ll_client_setup *setup, int64_t step, int64_t first,
                  const ll_world *world);

    /* A packet of the server has come to a client. Returns its ll_outcome. */
    int (*receive)(struct ll_client *client, const struct ll_client_setup *setup, const void *packet,
                   int size, ll_time now);

    /* One tick of a client: takes what has come, makes inputs. Writes the client's message and returns its
     * size, 0 when there is nothing to send. */
    int (*tick)(struct ll_client *client, const struct ll_client_setup *setup, ll_time now, void *packet);

    /* One display of a client: takes what has come and decides what to draw. */
    void (*display)(struct ll_client *client, const struct ll_client_setup *setup, ll_time now);

    /* Puts the entities of others where the client draws them at `now` with interpolation on; NULL where
     * `display` does not interpolate. */
    void (*interpolate)(struct ll_client *client, const struct ll_client_setup *setup, ll_time now);

    /* After a tick: one who sees both sides compares the client's world with the server's; NULL where
     * clients have no world of their own. */
    void (*observe)(struct ll_desync *desync, const struct ll_client *client,
                    const struct ll_client_setup *setup, const struct ll_server *server);
} ll_sync_mode;

extern const ll_sync_mode ll_sync_free;
extern const ll_sync_mode ll_sync_lockstep;
extern const ll_sync_mode ll_sync_lockstep_pipelined;
extern const ll_sync_mode ll_sync_gambetta;
extern const ll_sync_mode ll_sync_deterministic;
extern const ll_sync_mode ll_sync_rollback;

extern const ll_sync_mode *const ll_syncs[]; /* NULL-terminated; the index is the choice `sync` */
extern const char *const ll_sync_mode_names[];
