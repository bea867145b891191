/* Hosting: all sessions of the daemon, the threads that pace them, and who may change them.
 *
 * A session is found by its id and held by a counted reference (ll_host_find ... ll_session_entry_release).
 * Its engine object is used between ll_session_entry_enter and ll_session_entry_leave only, which lock it,
 * load it from the store when it was not used since the start, and bring it to the present. A session is
 * locked for a few milliseconds at a time. Changes go through ll_host_command, which also keeps the rules of
 * durability: a command is applied only when the store works, and answered only when its line is stored.
 *
 * Each session belongs to one worker thread, which steps it at 60 Hz of wall time while somebody looks,
 * encodes each frame once and publishes it. A session that nobody looks at is parked after `park_after_s` and
 * costs no CPU until it is asked for. One that sleeps, or whose ticks are too long for a frame, is run by a
 * task of the daemon's own instead of its worker.
 *
 * Any thread, but for create, stop and free. */
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
    char data[512];       /* folder of the database; `memory` keeps nothing */
    char store[512];      /* URL of the experiments' store; empty: in `data` */
    char scenarios[512];  /* folder of the library */
    char api[512];        /* folder of openapi.yaml and asyncapi.yaml */
    int64_t threads;      /* that step sessions; 0: one per core */
    int64_t work_threads; /* tasks that run at once; 0: one per core */
    int64_t max_sessions;
    int64_t max_memory_mib;          /* 0: three quarters of the machine's */
    double max_new_sessions_per_min; /* by one address */
    double max_code_lookups_per_min; /* by one address */
    int64_t max_state_mib;           /* of one session's state */
    double max_commands_per_s;       /* to one session; twice that in a burst */
    int64_t max_experiments, max_client_experiments, max_experiment_runs;
    int64_t max_log_mib, max_logs_mib; /* of one session, of all; 0: no limit */
    int64_t max_client_logs_mib;       /* of those that one address has made; 0: no limit */
    int64_t max_results_mib;           /* of all experiments; 0: no limit */
    double experiment_run_ttl_s;       /* since it was made, for one that is not over */
    double job_cpu_s;                  /* processor time of a job (jobs.h) */
    double job_idle_s;                 /* after which one that nobody asks for is cancelled */
    int64_t max_body_bytes;
    double park_after_s;
    double experiment_ttl_s;  /* since it was made */
    double session_ttl_s;     /* without viewer or request */
    double save_every_s;      /* the clock of a playing session */
    struct ll_access *access; /* who may; no row of the table; NULL: everybody, and nobody is the operator */
} ll_host_config;

extern const ll_param_table ll_host_table;

typedef struct ll_host ll_host;
typedef struct ll_session_entry ll_session_entry;

typedef struct ll_host_stats {
    int64_t sessions;                                  /* all */
    int64_t playing, paused, ended, failed;            /* of those in memory */
    int64_t parked, unloaded;                          /* unloaded: on disk only since the start */
    uint64_t created, deleted, expired, ticks, frames; /* since the start; frames published */
    uint64_t commands, inputs;
    uint64_t refused_sessions, refused_creations, refused_lookups, refused_commands, refused_store;
    uint64_t refused_memory, refused_logs;
    int64_t log_bytes;          /* of all sessions */
    int64_t memory, memory_max; /* bytes: of those in memory, and of all that may be */
} ll_host_stats;

/* Registers the stored sessions. `store` may be NULL (in memory only) and is not owned. */
struct ll_tasks;
ll_status ll_host_create(const ll_host_config *config, ll_store *store, struct ll_tasks *tasks,
                         ll_host **host);

/* The hooks of the streams, and what they need; before any session is made or found. */
ll_ws_hooks ll_host_hooks(ll_host *host);
ll_status
ll_host_start(ll_host *host,
              ll_ws *ws); /* opens the streams of stored sessions, starts the workers and the caretaker */

void ll_host_stop(ll_host *host); /* joins the workers: nothing is published after it */
/* Queues the clocks of all sessions; after stop. Those that somebody works on are waited for, or left as they
 * were stored last. */
uint64_t ll_host_save(ll_host *host, bool wait); /* the last ticket; 0: there is none */
void ll_host_free(ll_host *host);                /* after the door was closed */

ll_time ll_host_now(void); /* monotonic */
const ll_host_config *ll_host_get_config(const ll_host *host);
ll_host_stats ll_host_get_stats(ll_host *host);

/* ---- sessions ---- */

typedef struct ll_host_made {
    ll_session_entry *session_entry; /* a reference of the caller's */
    char owner_key[LL_KEY_LENGTH + 1];
    char player_keys[LL_PLAYERS_MAX][LL_KEY_LENGTH + 1];
    int players;
    ll_session_status status;
    int64_t tick;
    bool full; /* refused because there are as many sessions as there may be */
} ll_host_made;

typedef struct ll_create_request {
    const struct cJSON *scenario;       /* or */
    ll_session_entry *origin;           /* whose log is forked */
    int64_t seed;                       /* < 0: the scenario's */
    const struct ll_workload *workload; /* that its log begins with; NULL: none */
    bool paused;
    double speed;         /* 0: as it is (1, or the origin's) */
    const char *peer;     /* who asks, for the rate */
    struct ll_task *task; /* for a large session, and for a fork, which may have to wake its origin */
} ll_create_request;

/* Makes a session, stored when this returns. LL_LIMIT (too many), LL_IO (the store fails), or what the engine
 * says. */
ll_status ll_host_make(ll_host *host, const ll_create_request *order, ll_host_made *made);

ll_session_entry *ll_host_find(ll_host *host, const char *id); /* NULL when there is none */
ll_session_entry *ll_host_find_code(ll_host *host, const char *code);
void ll_session_entry_release(ll_session_entry *session_entry);

ll_status ll_host_delete(ll_host *host, ll_session_entry *session_entry, struct ll_task *task);
bool ll_host_allows_lookup(ll_host *host, const char *peer);
bool ll_host_allows_creation(ll_host *host,
                             const char *peer); /* of an experiment; ll_host_make asks itself */

/* What an operator sees of a session. */
typedef struct ll_host_entry {
    int64_t serial; /* in the order of their making or loading */
    char id[LL_ID_LENGTH + 1], code[LL_CODE_LENGTH + 1];
    int status; /* an ll_session_status; -1: not loaded since the start */
    bool parked;
    int viewers;
    int64_t created_ms, log_bytes;
    double idle_s; /* since the last request */
} ll_host_entry;

/* Those with a serial above `after`, in their order, at most `most`. Caller frees `*entries`. */
ll_status ll_host_list(ll_host *host, int64_t after, int most, ll_host_entry **entries, int *count);

const char *ll_session_entry_id(const ll_session_entry *session_entry);
const char *ll_session_entry_code(const ll_session_entry *session_entry);
int ll_session_entry_viewers(const ll_session_entry *session_entry);

/* Whose key it is: LL_ROLE_OWNER (the operator's too), a player's number, or LL_ROLE_NONE. */
enum { LL_ROLE_NONE = -2, LL_ROLE_OWNER = -1 };
int ll_session_entry_role(const ll_session_entry *session_entry, const char *key, size_t length);

/* Locks the session, wakes it, brings it to the present and gives it. On an error nothing is locked.
 * `was_parked` may be NULL. One that is behind by more than a quarter of a second of computing, or on its
 * way, is given as it is: nobody waits for one that cannot keep its speed. Without a task whatever would take
 * more than a few milliseconds is LL_INTERRUPTED at once, with a task when that was ended. */
ll_status ll_session_entry_enter(ll_session_entry *session_entry, struct ll_task *task, ll_session **session,
                                 bool *was_parked);
void ll_session_entry_leave(ll_session_entry *session_entry);

/* Counts what a request holds beside the sessions; LL_NO_MEMORY when there is no room for it. */
ll_status ll_host_reserve(ll_host *host, int64_t bytes);
void ll_host_give_back(ll_host *host, int64_t bytes);

/* `change` is called with the session locked; when that sends it on its way, the task goes along until it is
 * there, is ended, or another command comes between (LL_CONFLICT). `tell` (may be NULL) is called at the end
 * of that, with the session locked again. */
typedef ll_status ll_host_change(void *context, ll_session *session, ll_time wall);
typedef void ll_host_tell(void *context, ll_session *session);
typedef struct ll_create_requests {
    ll_host_change *change;
    ll_host_tell *tell;
    void *context;
    struct ll_task *task;
    bool clock; /* it only moves the clock */
} ll_create_requests;
ll_status ll_host_command(ll_host *host, ll_session_entry *session_entry, const ll_create_requests *orders);
