/* Inside of a session; for the files of this room. */
#pragma once

#include "base/version.h"
#include "netcode/protocol/event.h"
#include "session/scenario.h"
#include "session/session.h"

#define LL_EVENT_RING 2048 /* events kept for views: 4 s of two players */
#define LL_MARKS 64        /* hashes kept of the present log: the last ones */
#define LL_SNAPSHOTS 2     /* kept of a run: at a third and two thirds of its duration */

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

/* What the state of a tick hashes to, after all commands of that tick. */
typedef struct ll_mark {
    int64_t tick;
    uint64_t hash;
} ll_mark;

/* Where a session is on its way to: it is run there piece by piece. */
typedef enum ll_errand { LL_ERRAND_NONE, LL_ERRAND_WAKE, LL_ERRAND_SEEK } ll_errand;

typedef struct ll_checkpoint {
    void *block;
    void *config;
    int64_t tick; /* -1: none */
    size_t next;  /* entry that comes next */
    int32_t step; /* of the timeline, that comes next */
    int32_t skipped;
} ll_checkpoint;

struct ll_session {
    ll_scenario scenario; /* as created: what a reset goes back to */
    void *base;           /* configuration at tick 0 of the present log */
    void *config;         /* at the present tick */
    ll_log log;
    size_t next;     /* the first entry that is not applied yet */
    int32_t step;    /* the first of the timeline that is not applied yet */
    int32_t skipped; /* steps of the timeline that did not fit what commands had made of the parameters */
    int64_t tick, head, end;
    ll_freq freq;

    void *block;                  /* NULL: parked */
    bool stale;                   /* a change started again: the block is before the present tick */
    const ll_interrupt *patience; /* of the owner, now; NULL: there is no end to it */
    uint64_t epoch;               /* counts what changes the block: see ahead.c */
    bool broken;                  /* the last advance was broken off within a tick */
    bool safe;                    /* whoever advances it puts it back then */
    size_t block_size;
    ll_checkpoint snapshots[LL_SNAPSHOTS];
    ll_event *events; /* ring; NULL: parked */
    uint32_t event_count;
    uint32_t event_base; /* the first since time jumped last: those before it are of another past */

    ll_errand errand;
    int64_t goal;                    /* of the errand */
    int64_t quiet;                   /* before that tick no events are kept on the way */
    ll_session_status status_asleep; /* while it wakes: what it will be again */

    ll_session_status status;
    ll_status error;
    int64_t failed_at;       /* the tick behind which the present log ends in a failure; -1: it does not */
    uint64_t failed_hash;    /* of the state as it failed; 0: not known */
    ll_mark marks[LL_MARKS]; /* in the order of ticks */
    int mark_count;
    char version[LL_VERSION_MAX + 1]; /* of the laglab that made it */
    double speed;
    ll_time anchor_wall; /* the wall time at which ... */
    ll_time anchor_time; /* ... this virtual time was shown */
    uint32_t params_version, generation;
    int64_t cpu_ns, cpu_ticks;
    ll_step_profiler step_profiler; /* without a clock: off */

    ll_log_line *on_line;
    void *line_context;
};

static inline ll_scenario_head *ll_session_head(const ll_session *s)
{
    return (ll_scenario_head *)s->config;
}

/* ---- log.c ---- */

#define LL_LOG_FORMAT 1

ll_status ll_log_append(ll_log *log, const ll_log_entry *entry); /* copies `values` */
void ll_log_truncate(ll_log *log, size_t count);
void ll_log_free(ll_log *log);

struct cJSON *ll_session_create_line(const ll_session *s); /* caller deletes */
void ll_session_emit_create(const ll_session *s, ll_log_line *line, void *context);
void ll_session_emit_entry(const ll_log_entry *entry, ll_log_line *line, void *context);
void ll_session_emit_op(const ll_session *s, const char *op, ll_log_line *line,
                        void *context); /* rewind, head, play, pause */
void ll_session_emit_mark(const ll_mark *mark, ll_log_line *line, void *context);
void ll_session_emit_failure(const ll_session *s, ll_log_line *line, void *context);

void ll_session_emit_restart(const ll_session *s);

/* {"tick","player","axes","buttons"}; `buttons` may be left out of what is read. The sentence of an error
 * names the member, its range and the value. */
ll_status ll_input_read(const struct cJSON *json, ll_log_entry *entry);
struct cJSON *ll_input_write(const ll_log_entry *entry); /* caller deletes */

/* ---- timeline.c ---- */

/* When a step acts; INT64_MAX behind the last. */
int64_t ll_timeline_tick(const ll_scenario_head *head, int32_t step, ll_freq freq);
ll_status ll_timeline_check(const ll_sim_kind *kind, const void *config);

/* ---- marks.c ---- */

void ll_session_forget_marks(ll_session *s, int64_t from); /* of `from` and later ticks */
void ll_session_keep_mark(ll_session *s, const ll_mark *mark);
void ll_session_mark(ll_session *s); /* the present tick's, also told to the listener */

/* ---- values.c ---- */

ll_status ll_apply_values(const ll_sim_kind *kind, void *config,
                          const char *values); /* of an entry; all or nothing */

/* ---- engine.c ---- */

void ll_session_run(ll_session *s, int64_t to, bool record);
void ll_session_start_from(ll_session *s, const ll_checkpoint *shot,
                           bool record);  /* NULL: from the beginning */
void ll_session_apply_due(ll_session *s); /* what the log and the timeline say up to the present tick */
void ll_session_drop_snapshots(ll_session *s, int64_t from); /* of `from` and later ticks */
void ll_session_line(const ll_session *s, const char *op);   /* to the session's own listener */
void ll_session_anchor(ll_session *s, ll_time wall);         /* from now on, `wall` is the present tick */

void ll_session_keep_event(void *context, const void *row); /* an ll_recorder's; of a session */
void ll_session_fail(ll_session *s, const ll_status *why);
void ll_session_shoot(ll_session *s); /* a snapshot, where one is due */
/* Where the block stands before the present tick it is brought there; false when patience ended before. */
bool ll_session_refresh(ll_session *s);
/* Begins to make the state of `tick` from the nearest that is kept. */
void ll_session_begin_state(ll_session *s, int64_t tick);
/* On the way to `tick`, events before this tick are too old for whoever looks there. */
int64_t ll_session_quiet(const ll_session *s, int64_t tick);
void ll_session_spoil(ll_session *s); /* the block was broken off within a tick: it is made again */

/* ---- errand.c ---- */

/* Sets out for `tick`; ll_session_pursue goes. When it is there a seek tells the log that it paused. */
void ll_session_set_out(ll_session *s, int64_t tick);
void ll_session_make_state(ll_session *s, int64_t tick); /* at once */
ll_status ll_session_wake(ll_session *s);

/* ---- session.c ---- */

void ll_session_end_if_over(ll_session *s);

void ll_session_move_to(ll_session *s, int64_t tick);

ll_status ll_session_new(const ll_scenario *scenario, const void *base, ll_log_line *on_line, void *context,
                         ll_session **session);
void ll_session_rebase(ll_session *s, const void *base); /* a new log that starts from `base` */
