/* Hosting: all sessions of the daemon, the threads that pace them, and permissions.
 *
 * A session is found by its id and held by a counted reference (ll_host_find ... ll_session_entry_release).
 * Its engine object may be used only between ll_session_entry_enter and ll_session_entry_leave. `enter` locks
 * it, loads it from the store if it was not used since the start, and runs it up to the present. A session is
 * locked for a few milliseconds at a time. Changes go through ll_host_command, which makes them durable: a
 * command is applied only while the store works, and answered only after its line is stored.
 *
 * Each session belongs to one worker thread, which steps it at 60 Hz of wall time while it has viewers,
 * encodes each frame once and publishes it. A session without viewers is parked after `park_after_s` and uses
 * no CPU until the next request. A session that is parked, or whose ticks are too long for a frame, is run by
 * a task of the daemon instead of its worker.
 *
 * Any thread may call, except for new, stop and free. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vtime.h"
#include "daemon/store/store.h"
#include "daemon/stream/ws.h"
#include "session/session.h"

/* Every setting is a row of ll_host_table: `park_after_s` is `--park-after-s` on the command line. */
typedef struct ll_host_config {
    char data[512];                  /* folder of the databases; `memory`: nothing is stored */
    char shard[LL_SHARD_LENGTH + 1]; /* with which ids and codes begin; empty: they are random alone */
    char scenarios[512];             /* folder of the library */
    char api[512];                   /* folder of openapi.yaml and asyncapi.yaml */
    int64_t threads;                 /* that step sessions; 0: one per core */
    int64_t work_threads;            /* tasks that run at once; 0: one per core */
    int64_t max_sessions;
    int64_t max_memory_mib;          /* 0: three quarters of the machine's */
    double max_new_sessions_per_min; /* by one address */
    double max_code_lookups_per_min; /* by one address */
    int64_t max_state_mib;           /* of one session's state */
    double max_commands_per_s;       /* to one session; twice that in a burst */
    int64_t max_experiments, max_client_experiments, max_experiment_runs;
    int64_t max_log_mib, max_logs_mib; /* of one session; of all sessions; 0: no limit */
    int64_t max_client_logs_mib;       /* of all sessions that one address created; 0: no limit */
    int64_t max_results_mib;           /* of all experiments; 0: no limit */
    double experiment_run_ttl_s;       /* age at which an unfinished one is cancelled */
    double job_cpu_s;                  /* processor time of a job (jobs.h) */
    double job_idle_s;                 /* time without a request after which a job is cancelled */
    int64_t max_body_bytes;
    double park_after_s;
    double experiment_ttl_s; /* age */
    double session_ttl_s;    /* time without viewer or request */
    double save_every_s;     /* interval: clock of a playing session */
    struct ll_access
        *access; /* who may create; not in the table; NULL: every client, and there is no operator */
} ll_host_config;

extern const ll_param_table ll_host_table;

typedef struct ll_host ll_host;
typedef struct ll_session_entry ll_session_entry;

typedef struct ll_host_stats {
    int64_t sessions;                                  /* all sessions */
    int64_t playing, paused, ended, failed;            /* of the sessions in memory */
    int64_t parked, unloaded;                          /* unloaded: only on disk since the start */
    uint64_t created, deleted, expired, ticks, frames; /* since the start; frames: published */
    uint64_t commands, inputs;
    uint64_t refused_sessions, refused_creations, refused_lookups, refused_commands, refused_store;
    uint64_t refused_memory, refused_logs;
    int64_t log_bytes;          /* of all sessions */
    int64_t memory, memory_max; /* bytes: reserved by sessions in memory, and the maximum */
} ll_host_stats;

/* Registers the stored sessions. `store` may be NULL (in memory only) and is not owned. */
struct ll_tasks;
ll_status ll_host_create(const ll_host_config *config, ll_store *store, struct ll_tasks *tasks,
                         ll_host **host);

/* Opens the streams of stored sessions, starts the workers and the reaper. */
ll_status ll_host_start(ll_host *host, ll_ws *ws);

void ll_host_stop(ll_host *host); /* joins the workers; nothing is published afterwards */
/* Queues the clocks of all sessions; after stop. With `wait`, waits for sessions that are locked; otherwise
 * these keep the clock that was stored last. */
uint64_t ll_host_save(ll_host *host, bool wait); /* the last ticket; 0: none */
void ll_host_free(ll_host *host);                /* after the web server was closed */

const ll_host_config *ll_host_get_config(const ll_host *host);
ll_host_stats ll_host_get_stats(ll_host *host);

/* ---- sessions ---- */

typedef struct ll_created_session {
    ll_session_entry *session_entry; /* a reference for the caller */
    char owner_key[LL_KEY_LENGTH + 1];
    char player_keys[LL_PLAYERS_MAX][LL_KEY_LENGTH + 1];
    int players;
    ll_session_status status;
    int64_t tick;
    bool full; /* refused: the session limit is reached */
} ll_created_session;

typedef struct ll_create_request {
    const struct cJSON *scenario;       /* either this */
    ll_session_entry *origin;           /* or the session to fork */
    int64_t seed;                       /* < 0: the scenario's */
    const struct ll_workload *workload; /* inputs at the start of its log; NULL: none */
    bool paused;
    double speed;                   /* 0: default (1, or the origin's) */
    const char *group;              /* id whose stem the session gets; NULL: none */
    int64_t group_most;             /* sessions with that stem */
    const char *peer;               /* the client's address, whose quotas count */
    struct ll_class_key *class_key; /* whose quotas count in place of the address's; NULL: none */
    struct ll_task *task;           /* for a fork, whose origin may have to wake */
} ll_create_request;

/* Creates a session, which is stored when this returns. LL_LIMIT (too many), LL_IO (the store fails), or the
 * engine's error. */
ll_status ll_host_create_session(ll_host *host, const ll_create_request *request,
                                 ll_created_session *created);

ll_session_entry *ll_host_find(ll_host *host, const char *id); /* NULL: not found */
ll_session_entry *ll_host_find_code(ll_host *host, const char *code);

void ll_session_entry_release(ll_session_entry *session_entry);

ll_status ll_host_delete(ll_host *host, ll_session_entry *session_entry, struct ll_task *task);
/* Deletes it from memory at once, and its row as soon as the store works. False: it was deleted already. */
bool ll_host_discard(ll_host *host, ll_session_entry *session_entry);
bool ll_host_allows_lookup(ll_host *host, const char *peer);
/* A class whose boards and copies are made: the `nth` of those that its address, or its key, has open. */
typedef struct ll_host_class {
    const char *id;
    int nth;
} ll_host_class;
/* Of sessions, classes, experiments and jobs, by `class_key` or, if that is NULL, by the address; a fork of
 * `origin` (may be NULL) counts by its log. With `for_class` (NULL: none) boards of this class, or with
 * `origin` its copies, by the address that asks for them, each at the `nth` part of the rate: so one address
 * cannot fill the daemon by opening classes. LL_LIMIT. */
ll_status ll_host_check_rate(ll_host *host, const char *peer, struct ll_class_key *class_key,
                             const ll_host_class *for_class, const ll_session_entry *origin);

/* What an operator sees of a session. */
typedef struct ll_host_entry {
    int64_t serial; /* ascending in order of creation or loading */
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    int status; /* an ll_session_status; -1: not loaded since the start */
    bool parked;
    int viewers;
    int64_t created_ms, log_bytes;
    double idle_s;                        /* since the last request */
    const struct ll_class_key *class_key; /* that it was made with; NULL: none */
} ll_host_entry;

/* Sessions with a serial above `after`, ascending, at most `most`. Caller frees `*entries`. */
ll_status ll_host_list(ll_host *host, int64_t after, int most, ll_host_entry **entries, int *count);

const char *ll_session_entry_id(const ll_session_entry *session_entry);
const char *ll_session_entry_code(const ll_session_entry *session_entry);
int ll_session_entry_viewers(const ll_session_entry *session_entry);

/* Role of a key: LL_ROLE_OWNER (the operator's key too), a player's number, or LL_ROLE_NONE. */
enum { LL_ROLE_NONE = -2, LL_ROLE_OWNER = -1 };
int ll_session_entry_role(const ll_session_entry *session_entry, const char *key, size_t length);

/* Keys of others: `role` is asked about a key that is not the session's. The class that shows a session lets
 * its teacher and members use it so. Set once, before any request. */
typedef int ll_host_guest_role(void *context, const char *session, const char *key, size_t length);
void ll_host_set_guests(ll_host *host, ll_host_guest_role *role, void *context);

/* Streams that authenticated by such a key lose that role, and have to authenticate again. */
void ll_session_entry_revoke_guests(ll_session_entry *session_entry, int role);

/* What can be read of a session without waking it or waiting; false: it is busy, or not loaded. */
typedef struct ll_session_glance {
    ll_session_status status;
    int64_t tick;
    uint32_t params_version;
} ll_session_glance;
bool ll_session_entry_glance(ll_session_entry *session_entry, ll_session_glance *glance);

/* Locks the session, wakes it and runs it up to the present. On an error it is not locked. `was_parked` may
 * be NULL. A session that is more than catch_up_ms of computing behind, or seeking, is returned at the tick
 * that it has, so that a request never waits for a session that is slower than real time. Without a task, a
 * session that is large, parked or busy is LL_INTERRUPTED at once, as it takes milliseconds; with a task,
 * LL_INTERRUPTED means that the task was stopped. */
ll_status ll_session_entry_enter(ll_session_entry *session_entry, struct ll_task *task, ll_session **session,
                                 bool *was_parked);
void ll_session_entry_leave(ll_session_entry *session_entry);

/* Reserves memory of a request, in addition to the sessions'; LL_NO_MEMORY: not available. */
ll_status ll_host_reserve_memory(ll_host *host, int64_t bytes);
void ll_host_release_memory(ll_host *host, int64_t bytes);

/* Calls `change` with the session locked. If that begins a seek, the task runs it until it ends, the task is
 * stopped, or another command intervenes (LL_CONFLICT). `report` (may be NULL) is called at the end, with the
 * session locked again.
 *
 * Without a task, a seek that takes more than a few milliseconds is LL_INTERRUPTED, and the number of the
 * command is in `begun`: the same call with a task and this number continues it. */
typedef ll_status ll_host_change(void *context, ll_session *session, ll_time wall);
typedef void ll_host_report(void *context, ll_session *session);
typedef struct ll_command_request {
    ll_host_change *change;
    ll_host_report *report;
    void *context;
    struct ll_task *task;
    uint32_t *begun; /* 0, or NULL with a task: it is a new command */
    bool clock;      /* it only moves the clock */
} ll_command_request;
ll_status ll_host_command(ll_host *host, ll_session_entry *session_entry, const ll_command_request *request);
