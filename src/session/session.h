/* A session is its log: scenario + seed + commands, each stamped with virtual time.
 *
 * The same engine is driven in several ways: paced to the wall clock, unpaced, replayed, scrubbed, forked,
 * recovered. Whatever a session holds besides its log (the block, snapshots, recent events) can be dropped
 * and made again, which is what parking does.
 *
 * Not thread-safe: the owner serialises calls. No function reads a clock: `wall` is the owner's monotonic
 * time in ns.
 *
 * Virtual time moves in whole ticks of the scenario. `head` is the furthest tick of the present log; seeking
 * back leaves the log as it is and plays it again; a command given before the head drops the commands after
 * it (the log tells that by a `rewind` entry). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "base/status.h"
#include "base/vtime.h"
#include "sim/core/sim.h"

struct cJSON;
struct ll_scenario;
typedef struct ll_session ll_session;

typedef enum ll_session_status {
    LL_SESSION_PAUSED,
    LL_SESSION_PLAYING,
    LL_SESSION_ENDED,  /* at the scenario's duration */
    LL_SESSION_FAILED, /* diverged: see `error` */
} ll_session_status;

extern const char *const ll_session_status_names[];

/* Every entry of the log as one line of JSON without newline, in order; the first is the header (scenario,
 * seed). */
typedef void ll_log_line(void *context, const char *line, size_t length);

/* Makes a session, paused at tick 0. `scenario` is the JSON of a scenario; `seed` < 0 takes the scenario's.
 * `on_line` (may be NULL) is called for each line as it is appended, the header at once: a store that keeps
 * all lines can restore the session. */
ll_status ll_session_create(const struct cJSON *scenario, int64_t seed, ll_log_line *on_line, void *context,
                            ll_session **session);
/* The same of a scenario that has been read; its configuration is taken, also on an error. */
ll_status ll_session_open(struct ll_scenario *scenario, ll_log_line *on_line, void *context,
                          ll_session **session);
void ll_session_destroy(ll_session *session);

/* Restores a session from the lines of a log (as written, separated by newlines); parked, paused at the last
 * stamped tick. */
ll_status ll_session_restore(const char *log, size_t length, ll_log_line *on_line, void *context,
                             ll_session **session);

/* A copy of the log up to the present tick, under a new `on_line` (which gets all lines); paused at that
 * tick. */
ll_status ll_session_fork(ll_session *session, ll_log_line *on_line, void *context, ll_session **copy);

/* ---- driving ---- */

/* Runs what is due at `wall`, at most `max_ticks`. Returns how many ticks are still due (0: up to date). */
int64_t ll_session_advance(ll_session *session, ll_time wall, int64_t max_ticks);

/* The owner's patience with what follows, until it is set to NULL: a tick that takes longer is given up, and
 * so is a change that makes the run anew. The session is then half awake where it was; as the next tick takes
 * long, it is one for ll_session_begin_ahead. With `safely` the same piece is not lost twice: it costs a copy
 * of the state for each ll_session_advance. */
void ll_session_set_patience(ll_session *session, const ll_interrupt *interrupt);
int64_t ll_session_advance_safely(ll_session *session, ll_time wall, int64_t max_ticks, bool *broken_off);

/* One tick that may take long, made of a copy of the state while the session goes on to be used: `begin`
 * (*ahead is NULL where nothing is due), `run` without the session on any thread, `end` with it, which takes
 * the tick over unless the session was changed meanwhile, and frees it. `end` returns what is due then, as
 * ll_session_advance does. */
typedef struct ll_ahead ll_ahead;
ll_status ll_session_begin_ahead(ll_session *session, ll_time wall, ll_ahead **ahead);
void ll_ahead_run(ll_ahead *ahead, const ll_interrupt *interrupt);
int64_t ll_session_end_ahead(ll_session *session, ll_ahead *ahead, ll_time wall);
void ll_ahead_free(ll_ahead *ahead); /* of a session that is gone */

/* How many ticks are due at `wall`: of the errand that it is on, or of a playing session's clock. */
int64_t ll_session_due(const ll_session *session, ll_time wall);

/* Runs unpaced to `tick` (beyond the head it moves the head). */
ll_status ll_session_run_to(ll_session *session, int64_t tick);
/* The same in pieces, from where it is: LL_INTERRUPTED tells how far it came. */
ll_status ll_session_run_within(ll_session *session, int64_t tick, const ll_interrupt *interrupt);

/* {"op":"pause"} {"op":"play"} {"op":"step","ticks":1} (negative steps back) {"op":"seek","tick":N} or
 * {"op":"seek","time_s":X}
 * {"op":"speed","speed":0.25} (0.1 to 10) {"op":"restart","reset":false} (reset: back to the scenario as
 * created). Unknown keys are errors. Step and seek pause. Play at the end starts again from tick 0 with the
 * same log (a replay). */
ll_status ll_session_control(ll_session *session, ll_time wall, const struct cJSON *control);
/* The same, but step and seek only set out: the session is on an errand until ll_session_pursue, or
 * ll_session_advance, has brought it there. A change on the way ends the errand at the tick that was reached,
 * as ll_session_rest does. The session must be awake. */
ll_status ll_session_begin_control(ll_session *session, ll_time wall, const struct cJSON *control);
/* Goes at most `max_ticks` of the errand. Returns how many are left; 0: there is none any more. */
int64_t ll_session_pursue(ll_session *session, int64_t max_ticks);
void ll_session_rest(ll_session *session); /* a seek ends where it is */

/* JSON merge patch of live parameters, applied at the present tick, all or nothing. */
ll_status ll_session_patch(ll_session *session, ll_time wall, const struct cJSON *patch);

/* A person's controls for `player` (whose control must be `person`: LL_CONFLICT otherwise), held until the
 * next call. Appended to the log only when they changed. */
ll_status ll_session_input(ll_session *session, ll_time wall, int player, const ll_action *action);

/* ---- reading ---- */

typedef struct ll_session_info {
    ll_session_status status;
    bool parked;  /* or not awake yet: `tick` and `status` are those that it will have */
    bool seeking; /* on its way; `tick` is where it is now */
    int64_t tick, head_tick, end_tick;
    int64_t at_tick; /* where it is while it wakes; else `tick` */
    ll_time time, head, duration;
    ll_freq tick_freq;
    double speed;
    int64_t seed;
    uint32_t params_version; /* counts changes of parameters, restarts and seeks over them: reread the params
                                when it differs */
    uint32_t generation; /* counts jumps of time (seek, step, restart): a viewer drops what it drew when it
                            differs */
    size_t bytes;        /* memory held now */
    size_t awake_bytes;  /* and when it is awake, with all the states that it keeps */
    size_t log_entries;
    int timeline_skipped; /* steps of the timeline that did not fit what commands had made of the parameters
                           */
    const char *title, *kind;
} ll_session_info;

ll_session_info ll_session_get_info(const ll_session *session);
const ll_status *ll_session_error(const ll_session *session); /* why it failed; code LL_OK when it did not */

uint64_t ll_session_hash(ll_session *session); /* of the state at the present tick; wakes a parked session */
struct cJSON *ll_session_params(ll_session *session); /* the whole scenario with its present values */
struct cJSON *ll_session_state(ll_session *session);  /* {"tick","time_s","hash","state":{...}} */

struct cJSON *ll_session_notices(const ll_session *session); /* of its scenario: see ll_sim_kind */

/* {"tick","time_s","hash","metrics":{...}}; the metrics of every kind have "expect", the scenario's:
 * [{"metric","min","value","met"}]; `value` is null where there is no such number. */
struct cJSON *ll_session_metrics(ll_session *session);

/* Measures the parts of the scenario, as it was made, into `metrics`. */
void ll_session_time_parts(const ll_session *session, struct cJSON *metrics, int64_t (*now_ns)(void));

/* {"ns_per_sim_s","bytes","block_bytes","checkpoint_bytes","event_bytes","log_bytes","parked_bytes"};
 * parked_bytes is what is left while it is parked. Where steps were metered and the kind has parts also
 * "metered_s" and "parts": [{"all":{"ns_per_sim_s"}, ...phases}], one for each of those side by side. */
struct cJSON *ll_session_cost(const ll_session *session);

/* A copy with the commands up to `tick` (at most the head), at tick 0: for what is told of other ticks while
 * the session itself does not move. Caller destroys. */
ll_status ll_session_copy(const ll_session *session, int64_t tick, ll_session **copy);

/* CSV (RFC 4180) of ticks from..to (at most the head), header first, from such a copy. `write` gets pieces.
 */
ll_status ll_session_trace(ll_session *session, int64_t from, int64_t to,
                           void (*write)(void *context, const char *text, size_t length), void *context);
/* The same of a copy that is at hand. */
ll_status ll_session_write_trace(ll_session *copy, int64_t from, int64_t to, const ll_interrupt *interrupt,
                                 void (*write)(void *context, const char *text, size_t length),
                                 void *context);

/* All lines of the log; with `on_line` also hashes at some ticks, the present one among them. */
void ll_session_log(const ll_session *session, ll_log_line *line, void *context);
/* The last tick before the failure in which the present log ends; -1: it does not. And what the state that
 * failed hashes to; 0: the log does not tell. */
int64_t ll_session_failed_at(const ll_session *session);
uint64_t ll_session_failed_hash(const ll_session *session);

/* ---- hosting ---- */

/* Drops everything that the log can give again. Any other call wakes the session. While nobody looks, virtual
 * time goes on by `wall` and is caught up by ll_session_advance. */
void ll_session_park(ll_session *session);

/* Begins to wake a parked one, which is an errand; LL_NO_MEMORY. */
ll_status ll_session_begin_to_wake(ll_session *session);

/* Puts a session that was restored, and is parked, where it was when its clock was stored. */
typedef struct ll_session_place_at {
    int64_t tick, head;
    double speed; /* 0: as it is */
    bool playing;
} ll_session_place_at;
void ll_session_place(ll_session *session, ll_time wall, const ll_session_place_at *at);

/* From now on parts of steps are metered by the owner's clock, for `cost`; NULL: no longer. */
void ll_session_step_profiler(ll_session *session, int64_t (*now_ns)(void));

void ll_session_account(ll_session *session, int64_t cpu_ns,
                        int64_t ticks); /* measured cost of advancing; for `cost` only */
