/* A session is its log: scenario, seed and commands, each with its tick.
 *
 * The same engine runs it paced to the wall clock, unpaced, replayed, forked or recovered. Everything that a
 * session holds besides its log (the block, checkpoints, recent events) can be dropped and rebuilt; parking
 * drops it.
 *
 * Not thread-safe: the owner serialises calls. No function reads a clock: `wall` is the owner's monotonic
 * time in ns.
 *
 * Virtual time advances in whole ticks of the scenario. `head` is the furthest tick of the present log.
 * Seeking back keeps the log and replays it. A command before the head drops all later commands, which the
 * log records as a `rewind` line. */
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
    LL_SESSION_ENDED,  /* the scenario's duration is over */
    LL_SESSION_FAILED, /* the simulation diverged: see `error` */
} ll_session_status;

extern const char *const ll_session_status_names[];

/* Receives every entry of the log as one line of JSON without newline, in order. The first is the header
 * (scenario, seed). */
typedef void ll_log_line(void *context, const char *line, size_t length);

/* Creates a session, paused at tick 0. `scenario` is the JSON of a scenario; `seed` < 0: the scenario's.
 * `on_line` (may be NULL) is called for each line when it is appended, and at once for the header: a store
 * that keeps all lines can restore the session. */
ll_status ll_session_create(const struct cJSON *scenario, int64_t seed, ll_log_line *on_line, void *context,
                            ll_session **session);
/* The same for a parsed scenario. Takes its configuration, also on an error. */
ll_status ll_session_open(struct ll_scenario *scenario, ll_log_line *on_line, void *context,
                          ll_session **session);

/* Memory that a thread keeps from one short run to the next, since the pages of a new block cost more than
 * the run. {0}: none yet. */
typedef struct ll_kept_block {
    void *block; /* NULL: none, or a session has it */
    size_t size;
} ll_kept_block;

/* When no session has the block. */
void ll_kept_block_free(ll_kept_block *kept);

/* Opens a session that runs forward (ll_session_run_forward). Its state is in `kept`, unless that is NULL,
 * until it is destroyed; one session at a time has it. */
ll_status ll_session_open_forward(struct ll_scenario *scenario, ll_kept_block *kept, ll_session **session);

/* Opens a session that keeps no events, since it has no viewers. */
ll_status ll_session_open_unwatched(struct ll_scenario *scenario, ll_session **session);

void ll_session_destroy(ll_session *session);

/* Restores a session from the lines of a log (as emitted, separated by newlines). It is parked, and paused at
 * the last tick of the log. */
ll_status ll_session_restore(const char *log, size_t length, ll_log_line *on_line, void *context,
                             ll_session **session);

/* A copy of the log up to the present tick, with its own `on_line`, which receives all lines; paused at that
 * tick. */
ll_status ll_session_fork(ll_session *session, ll_log_line *on_line, void *context, ll_session **copy);

/* The session must be asleep. It will not be sought back and has no viewers: it takes no checkpoints, so that
 * seeking back replays from the start, and keeps no events. */
void ll_session_run_forward(ll_session *session);
/* The session must be asleep, and keeps events again. */
void ll_session_keep_events(ll_session *session);

/* Before the first tick: only the metrics at these paths will be read, so that the run observes no more
 * than these need. Its hash stays the same. Not for a session with viewers; copies and forks observe
 * everything. */
void ll_session_observe_only(ll_session *session, const char *const *paths, int count);

/* ---- running ---- */

/* Runs the ticks that are due at `wall`, at most `max_ticks`. Returns how many are still due (0: up to
 * date). */
int64_t ll_session_advance(ll_session *session, ll_time wall, int64_t max_ticks);

/* Sets the threads that ticks of the calls that follow may use, with the same results; NULL: the caller's
 * alone. */
void ll_session_set_team(ll_session *session, ll_team *team);

/* Sets the interrupt for the calls that follow; NULL: none. It stops a tick that takes too long, and a change
 * that recomputes the run. The session then has to wake again at its tick; as its ticks are long, the caller
 * should use ll_session_begin_background_tick. ll_session_advance_or_restore copies the state at each call (a
 * cost) and restores the copy on an interrupt, so that an interrupt loses only the ticks of that call. */
void ll_session_set_interrupt(ll_session *session, const ll_interrupt *interrupt);
int64_t ll_session_advance_or_restore(ll_session *session, ll_time wall, int64_t max_ticks,
                                      bool *interrupted);

/* Runs one tick that may take long on a copy of the state, while the session stays usable. `begin` sets *tick
 * to NULL when nothing is due. `run` does not use the session and may run on any thread. `end` installs the
 * result unless the session was changed meanwhile, and frees it; it returns the ticks that are due, as
 * ll_session_advance does. */
typedef struct ll_background_tick ll_background_tick;
ll_status ll_session_begin_background_tick(ll_session *session, ll_time wall, ll_background_tick **tick);
void ll_background_tick_run(ll_background_tick *tick, const ll_interrupt *interrupt);
int64_t ll_session_end_background_tick(ll_session *session, ll_background_tick *tick, ll_time wall);
void ll_background_tick_free(ll_background_tick *tick); /* without `end`, when the session is deleted */

/* Ticks that are due at `wall`: to the end of its transition, or by the clock of a playing session. */
int64_t ll_session_due(const ll_session *session, ll_time wall);

/* Runs unpaced to `tick`; moves the head when `tick` is beyond it. */
ll_status ll_session_run_to(ll_session *session, int64_t tick);
/* The same from the present tick, interruptible. LL_INTERRUPTED: the message names the tick that was
 * reached. */
ll_status ll_session_run_within(ll_session *session, int64_t tick, const ll_interrupt *interrupt);

/* {"op":"pause"} {"op":"play"} or {"op":"play","until_tick":N} (pauses there) {"op":"step","ticks":1}
 * (negative steps back) {"op":"seek","tick":N} or
 * {"op":"seek","time_s":X} {"op":"speed","speed":0.25} (0.1 to 10) {"op":"restart","reset":false} (reset:
 * back to the scenario as created). Unknown keys are errors. Step and seek pause. Play at the end starts
 * again from tick 0 with the same log (a replay). */
ll_status ll_session_control(ll_session *session, ll_time wall, const struct cJSON *control);
/* The same, but step and seek only begin a transition, which ll_session_continue or ll_session_advance runs.
 * A change meanwhile ends it at the tick that was reached, as ll_session_stop_seek does. The session must be
 * awake. */
ll_status ll_session_begin_control(ll_session *session, ll_time wall, const struct cJSON *control);
/* Runs at most `max_ticks` of the transition. Returns the ticks that are left; 0: no transition is in
 * progress. */
int64_t ll_session_continue(ll_session *session, int64_t max_ticks);
void ll_session_stop_seek(ll_session *session); /* ends a seek at the tick that was reached */

/* Applies a JSON merge patch of live parameters at the present tick, all or nothing. */
ll_status ll_session_patch(ll_session *session, ll_time wall, const struct cJSON *patch);

/* Controls of a person for `player` (whose control must be `person`, else LL_CONFLICT), held until the next
 * call. Logged only when they changed. */
ll_status ll_session_input(ll_session *session, ll_time wall, int player, const ll_action *action);

/* ---- reading ---- */

typedef struct ll_session_info {
    ll_session_status status;
    bool parked;  /* or not awake yet: then `tick` and `status` are those that it will have */
    bool seeking; /* a seek is in progress; `tick` is the tick reached so far */
    int64_t tick, head_tick, end_tick;
    int64_t at_tick; /* tick reached so far while it wakes; else `tick` */
    ll_time time, head, duration;
    ll_freq tick_freq;
    double speed;
    int64_t seed;
    uint32_t params_version; /* counts changes of parameters, restarts and seeks over them: reread the
                                parameters when it differs */
    uint32_t generation; /* counts jumps of time (seek, step, restart): viewers discard what they drew when it
                            differs */
    size_t log_entries;
    int timeline_skipped; /* steps of the timeline that were invalid for the parameters that commands had set
                           */
    const char *title, *kind;
} ll_session_info;

ll_session_info ll_session_get_info(const ll_session *session);

/* Of that what changes from frame to frame; reads the session itself only. */
typedef struct ll_session_pulse {
    ll_session_status status;
    bool parked;
    int64_t tick, at_tick;
    uint32_t params_version, generation;
} ll_session_pulse;

ll_session_pulse ll_session_get_pulse(const ll_session *session);

/* Memory held, in bytes: at present, and when it is awake with all checkpoints that it takes and all events
 * that it may keep. */
size_t ll_session_bytes(const ll_session *session);
size_t ll_session_awake_bytes(const ll_session *session);

/* Whether a change computes all ticks up to the present again. */
bool ll_session_begins_anew(const ll_session *session);

const ll_status *ll_session_error(const ll_session *session); /* reason of the failure; NULL: not failed */

uint64_t ll_session_hash(ll_session *session);        /* of the present tick; wakes a parked session */
struct cJSON *ll_session_params(ll_session *session); /* the whole scenario with its present values */
struct cJSON *ll_session_state(ll_session *session);  /* {"tick","time_s","hash","state":{...}} */

struct cJSON *ll_session_notices(const ll_session *session); /* of its scenario: see ll_sim_kind */

/* {"tick","time_s","hash","metrics":{...}}; for every kind the metrics include "expect", from the scenario:
 * [{"metric","min","value","met"}]. `value` is null when the metric has no number. */
struct cJSON *ll_session_metrics(ll_session *session);
/* `metrics` alone, without the time of a hash: NULL if there is no memory. */
struct cJSON *ll_session_metric_values(ll_session *session);

/* Measures the parts of the scenario, with its initial parameters, into `metrics`. */
void ll_session_time_parts(const ll_session *session, struct cJSON *metrics, int64_t (*now_ns)(void));

/* {"ns_per_sim_s","bytes","block_bytes","metric_bytes","history_bytes","checkpoint_bytes","event_bytes",
 * "trace_bytes","log_bytes","parked_bytes"}; metric_bytes and history_bytes are parts of the block
 * (ll_block_use), trace_bytes is what ll_session_account_copy noted, parked_bytes what remains while it is
 * parked. When the step profiler ran and the kind has parts, also "metered_s" and "parts":
 * [{"all":{"ns_per_sim_s"}, ...phases}], one for each side-by-side part. */
struct cJSON *ll_session_cost(const ll_session *session);

/* A copy with the commands up to `tick` (at most the head), at tick 0 and asleep: for reading other ticks
 * without moving the session. It runs forward (ll_session_run_forward). Caller destroys. */
ll_status ll_session_copy(const ll_session *session, int64_t tick, ll_session **copy);

/* The columns of a trace at the present tick, as `line` asks for them. Wakes a parked session. */
void ll_session_trace_line(ll_session *session, ll_trace_line *line);

/* The present value of a parameter that is one number, a flag (0 or 1) or a choice (its index). False: there
 * is no such parameter. */
bool ll_session_parameter(ll_session *session, const char *path, double *value);

/* CSV (RFC 4180) of ticks from..to (at most the head), header first, computed on a copy. `write` gets
 * pieces. */
ll_status ll_session_trace(ll_session *session, int64_t from, int64_t to,
                           void (*write)(void *context, const char *text, size_t length), void *context);
/* The same on the caller's copy. */
ll_status ll_session_write_trace(ll_session *copy, int64_t from, int64_t to, const ll_interrupt *interrupt,
                                 void (*write)(void *context, const char *text, size_t length),
                                 void *context);

/* Number of players whose packets a capture has; 0: the kind sends none. */
int ll_session_players(const ll_session *session);

/* What a capture contains: the packets of ticks from..to, as they pass one interface or all of them. */
typedef struct ll_capture_range {
    int64_t from, to;
    int interface; /* of a player, from 0; the server's is the next; LL_ALL_INTERFACES */
} ll_capture_range;

#define LL_ALL_INTERFACES (-1)

/* The interface of that name: `server`, or that of a player; NULL or empty: all. */
ll_status ll_session_interface(const ll_session *session, const char *name, int *interface);

/* The packets as a capture file for Wireshark (docs/links.md), computed on a copy: as sent, and as received.
 * The players have connected before time 0. LL_CONFLICT: the kind sends no packets. `write` gets pieces. */
ll_status ll_session_capture(ll_session *session, const ll_capture_range *range,
                             void (*write)(void *context, const char *bytes, size_t length), void *context);
/* The same on the caller's copy. */
ll_status ll_session_write_capture(ll_session *copy, const ll_capture_range *range,
                                   const ll_interrupt *interrupt,
                                   void (*write)(void *context, const char *bytes, size_t length),
                                   void *context);

/* All lines of the log; for a session with `on_line` also state hashes, the present tick's among them. */
void ll_session_log(const ll_session *session, ll_log_line *line, void *context);
/* Last tick before the failure that ends the present log; -1: none. And the hash of the failed state; 0: the
 * log does not have it. */
int64_t ll_session_failed_at(const ll_session *session);
uint64_t ll_session_failed_hash(const ll_session *session);

/* ---- hosting ---- */

/* Drops everything that the log can rebuild. Any other call wakes the session. Without viewers, virtual time
 * continues by `wall`, and ll_session_advance catches up. */
void ll_session_park(ll_session *session);

/* Begins the transition that wakes a parked session; LL_NO_MEMORY. */
ll_status ll_session_begin_wake(ll_session *session);

/* Position and clock of a restored session, as last stored. The session must be parked. `tick` is that of
 * the state, and of a failed session one more: its state comes after the tick. Negative: the log's end. */
typedef struct ll_session_position {
    int64_t tick, head;
    double speed; /* 0: unchanged */
    bool playing;
} ll_session_position;
void ll_session_set_position(ll_session *session, ll_time wall, const ll_session_position *at);

/* Profiles parts of steps with the owner's clock, for `cost`; NULL: off. */
void ll_session_step_profiler(ll_session *session, int64_t (*now_ns)(void));

/* For `cost` only: the measured cost of advancing; and the memory of a copy on which a trace was computed. */
void ll_session_account(ll_session *session, int64_t cpu_ns, int64_t ticks);
void ll_session_account_copy(ll_session *session, const ll_session *copy);
