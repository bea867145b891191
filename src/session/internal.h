/* Internals of a session; for the files of this room only. */
#pragma once

#include "base/version.h"
#include "memory/state_memory.h"
#include "netcode/protocol/event.h"
#include "session/records.h"
#include "session/scenario.h"
#include "session/session.h"

#define LL_TICK_HASHES 64 /* hashes kept of the present log: the newest */
#define LL_CHECKPOINTS 2  /* checkpoints of a run: at a third and two thirds of its duration */
/* A larger block is not copied: seeking back replays it from its start. */
#define LL_CHECKPOINT_BYTES_MAX (128 << 20)

typedef enum ll_op { LL_OP_SET, LL_OP_INPUT } ll_op;

/* A command of the log: takes effect when the state of `tick` is reached. */
typedef struct ll_log_entry {
    int64_t tick;
    ll_op op;
    int32_t player;
    ll_action action;
    char *values; /* LL_OP_SET: {"players.1.lag_ms":250}, owned */
} ll_log_entry;

typedef struct ll_log {
    ll_log_entry *entries;
    size_t count, capacity, text_bytes;
} ll_log;

/* State hash of a tick, after all commands of that tick. */
typedef struct ll_tick_hash {
    int64_t tick;
    uint64_t hash;
} ll_tick_hash;

/* A transition that is in progress; ll_session_continue runs it in pieces. */
typedef enum ll_transition { LL_TRANSITION_NONE, LL_TRANSITION_WAKE, LL_TRANSITION_SEEK } ll_transition;

/* How far the log and the timeline are applied. */
typedef struct ll_log_position {
    size_t next;     /* index of the first log entry that is not applied yet */
    int32_t step;    /* index of the first step of the timeline that is not applied yet */
    int32_t skipped; /* steps of the timeline that were invalid for the parameters that commands had set */
} ll_log_position;

typedef struct ll_checkpoint {
    void *block;
    void *config;
    int64_t tick; /* -1: none */
    ll_log_position position;
} ll_checkpoint;

/* How the advance of a block ends before its time. */
typedef struct ll_session_interruption {
    const ll_interrupt *by; /* of the owner, during a call; NULL: no limit */
    uint64_t epoch;         /* counts changes of the block: see background_tick.c */
    bool happened;          /* the last advance was interrupted within a tick */
    bool restorable;        /* then the caller restores the state */
} ll_session_interruption;

/* Events for viewers. */
typedef struct ll_session_events {
    ll_event *ring; /* LL_EVENT_RING of them; NULL: parked, unwatched, or of a kind that makes none */
    uint32_t count;
    uint32_t base; /* first event since time last jumped: earlier ones belong to another run */
} ll_session_events;

typedef struct ll_session_transition {
    ll_transition kind;
    int64_t target_tick;
    int64_t record_from;             /* events are kept from this tick on */
    ll_session_status status_parked; /* while it wakes: its status when it was parked */
} ll_session_transition;

typedef struct ll_session_failure {
    ll_status status;
    int64_t tick;  /* the tick after which the present log ends in a failure; -1: none */
    uint64_t hash; /* hash of the state of the failure; 0: unknown */
} ll_session_failure;

typedef struct ll_session_hashes {
    ll_tick_hash *marks; /* ascending ticks; at most LL_TICK_HASHES */
    int count, capacity;
} ll_session_hashes;

typedef struct ll_packed ll_packed;

/* Virtual time against wall time. */
typedef struct ll_session_clock {
    double speed;
    ll_time wall; /* wall time at which ... */
    ll_time time; /* ... this virtual time was due */
} ll_session_clock;

/* What it took to run. */
typedef struct ll_session_meter {
    int64_t cpu_ns, cpu_ticks;
    size_t trace_bytes;             /* most that a copy had on which a trace or a capture was computed */
    ll_step_profiler step_profiler; /* without a clock: off */
} ll_session_meter;

/* Gets each new line of the log. */
typedef struct ll_session_listener {
    ll_log_line *on_line;
    void *context;
} ll_session_listener;

struct ll_session {
    void *memory;         /* of the next three; NULL while they are packed */
    ll_scenario scenario; /* as created; a reset restores it */
    void *base;           /* configuration at tick 0 of the present log */
    void *config;         /* configuration at the present tick */
    ll_packed *packed;    /* parked: what these configurations differ in; else NULL */
    ll_log log;
    ll_log_position position;
    int64_t tick, head, end;
    int64_t stop_tick; /* it pauses there; 0: none */
    ll_freq freq;

    size_t config_size; /* that each of the three has: with their last array, which does not grow */
    void *block;        /* NULL: parked */
    size_t block_size;
    void *spare; /* of that size, for copies, while its ticks run on copies and more are due or may be; else
                    NULL */
    bool observes_all;
    bool runs_forward;   /* takes no checkpoints */
    bool unwatched;      /* keeps no events: no one will read them */
    ll_kept_block *kept; /* of the caller: has the block before and after; NULL: none */
    uint32_t observes;   /* otherwise, as bits of the kind's own */
    bool stale;          /* a change restarted the block: it is at an earlier time than the present tick */
    ll_session_interruption interruption;
    ll_team *team; /* of the caller: threads for a tick; NULL: its own alone */
    ll_checkpoint checkpoints[LL_CHECKPOINTS];
    ll_session_events events;
    void (*on_packet)(void *context, const void *row); /* of an ll_recorder, while a capture is written */
    struct ll_capture *capture;                        /* not owned */
    ll_session_hashes hashes;

    ll_session_status status;
    ll_session_transition transition;
    ll_session_failure failure;
    ll_session_clock clock;
    ll_session_meter meter;
    ll_session_listener listener;
    char version[LL_VERSION_MAX + 1]; /* version of laglab that made it */
    uint32_t params_version, generation;
};

static inline ll_scenario_head *ll_session_head(const ll_session *s)
{
    return (ll_scenario_head *)s->config;
}

static inline void ll_session_drop_spare(ll_session *s)
{
    ll_state_memory_free(s->spare);
    s->spare = NULL;
}

/* ---- packed.c ---- */

bool ll_session_allocate(ll_session *s); /* the configurations' memory, all zero; false without memory */
/* Keeps of the configurations only what they differ in; no effect without memory. Until they are unpacked
 * only the functions below may be called. */
void ll_session_pack(ll_session *s);
ll_status ll_session_unpack(ll_session *s); /* LL_NO_MEMORY */
int64_t ll_session_seed(const ll_session *s);
const char *ll_session_title(const ll_session *s);
size_t ll_session_config_used(const ll_session *s);  /* bytes of the present configuration */
size_t ll_session_packed_bytes(const ll_session *s); /* that the configurations take, or would, packed */

/* ---- log.c ---- */

#define LL_LOG_FORMAT 1

ll_status ll_log_append(ll_log *log, const ll_log_entry *entry); /* copies `values` */
void ll_log_truncate(ll_log *log, size_t count);
void ll_log_free(ll_log *log);

struct cJSON *ll_session_create_line(const ll_session *s); /* caller deletes */
void ll_session_emit_create(const ll_session *s, ll_log_line *line, void *context);
void ll_session_emit_entry(const ll_log_entry *entry, ll_log_line *line, void *context);
void ll_session_emit_op(const ll_session *s, const char *op, ll_log_line *line,
                        void *context); /* op: rewind, head, play, pause */
void ll_session_emit_hash(const ll_tick_hash *mark, ll_log_line *line, void *context);
void ll_session_emit_failure(const ll_session *s, ll_log_line *line, void *context);

void ll_session_emit_restart(const ll_session *s);

/* {"tick","player","axes","buttons"}; reading accepts a missing `buttons`. An error's message names the
 * member, its range and the value. */
ll_status ll_input_read(const struct cJSON *json, ll_log_entry *entry);
struct cJSON *ll_input_write(const ll_log_entry *entry); /* caller deletes */

/* ---- tick_hashes.c ---- */

void ll_session_drop_hashes(ll_session *s, int64_t from); /* those of `from` and later ticks */
void ll_session_add_hash(ll_session *s, const ll_tick_hash *mark);
void ll_session_record_hash(ll_session *s); /* of the present tick; also emits it to the listener */

/* ---- values.c ---- */

/* Changes a configuration as a running session may be changed, all or nothing: by a merge patch, which
 * reports its values to `change`, and by the values of a log entry. */
ll_status ll_change_values(const ll_sim_kind *kind, void *config, const struct cJSON *patch,
                           ll_param_change *change, void *context);
ll_status ll_apply_values(const ll_sim_kind *kind, void *config, const char *values);

/* Tick at which a step acts; INT64_MAX after the last step. */
int64_t ll_timeline_tick(const ll_scenario_head *head, int32_t step, ll_freq freq);

/* ---- engine.c ---- */

void ll_session_run(ll_session *s, int64_t to, bool record);
void ll_session_apply_due(ll_session *s); /* applies log and timeline up to the present tick */
void ll_session_drop_checkpoints(ll_session *s, int64_t from); /* those of `from` and later ticks */
void ll_session_emit_own(const ll_session *s, const char *op); /* emits an op to the session's own listener */
void ll_session_set_clock(ll_session *s, ll_time wall);        /* the present tick is due at `wall` */

/* An ll_recorder function; the context is the session, which must have a ring. */
void ll_session_keep_event(void *context, const void *row);
void ll_session_fail(ll_session *s, const ll_status *why);
void ll_session_take_checkpoint(ll_session *s); /* takes a checkpoint if one is due */
/* Begins to rebuild the state of `tick` from the nearest checkpoint. */
void ll_session_begin_rebuild(ll_session *s, int64_t tick);
/* First tick whose events are kept on the way to `tick`: viewers show only the last seconds before it. */
int64_t ll_session_first_recorded(const ll_session *s, int64_t tick);

/* ---- transition.c ---- */

/* Begins a seek to `tick`; ll_session_continue runs it. At its end a "pause" is logged. */
void ll_session_begin_seek(ll_session *s, int64_t tick);
void ll_session_rebuild(ll_session *s,
                        int64_t tick); /* does not return before `tick` is reached or it is interrupted */
ll_status ll_session_wake(ll_session *s);
/* Makes room for the block and the events, not initialised; false without memory. */
bool ll_session_make_state(ll_session *s);
void ll_session_drop_state(ll_session *s); /* the block, the checkpoints and the events */

/* ---- session.c ---- */

void ll_session_end_if_over(ll_session *s); /* ends a session that plays at its last tick, or pauses it at
                                               its stop tick */
void ll_session_pause(ll_session *s);

void ll_session_move_to(ll_session *s, int64_t tick);

ll_status ll_session_new(const ll_scenario *scenario, const void *base, ll_log_line *on_line, void *context,
                         ll_session **session);
/* Begins a new log that starts from `base`. LL_NO_MEMORY: nothing has changed. */
ll_status ll_session_rebase(ll_session *s, const void *base);
