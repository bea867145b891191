/* Shared by store.c (the queue, the writer thread) and the kinds of stores: sqlite.c, postgres.c. Not for
 * other rooms. */
#pragma once

#include <pthread.h>

#include "daemon/store/import.h"
#include "daemon/store/shared.h"
#include "daemon/store/store.h"

typedef enum record_type {
    RECORD_ROW,
    RECORD_LINE,
    RECORD_DELETE,
    RECORD_RELEASE,
    RECORD_STATE,
    RECORD_ANSWER,
    RECORD_FREE_ANSWER,
    RECORD_CLASS,
    RECORD_DELETE_CLASS,
    RECORD_RELEASE_CLASS
} record_type;

typedef struct ll_store_record {
    struct ll_store_record *next;
    record_type type;
    ll_store_place place;
    int64_t index;
    size_t size;
    char bytes[]; /* an ll_stored, a line, a state, or a class or an answer: its id or name, NUL, its text */
} record;

/* What only a store that several daemons share does: shared.h. */
typedef struct ll_shared_kind {
    void (*fenced)(ll_store *store); /* called by ll_store_fence */
    double (*lease_left_s)(ll_store *store);
    ll_status (*claim)(ll_store *store, const char *id, ll_claim *claim);
    ll_status (*release_id)(ll_store *store, const char *id);
    ll_status (*mark_dead)(ll_store *store, int64_t daemon, bool gone, bool *marked);
    ll_status (*ask)(ll_store *store, int64_t owner, const char *id);
    void (*on_asked)(ll_store *store, void (*asked)(void *context, const char *id), void *context);
    ll_status (*reserve_code)(ll_store *store, int64_t number, const char *code, ll_session_quota *quota,
                              bool *taken);
    ll_status (*count_keys)(ll_store *store, ll_log_size *sizes, int64_t count,
                            void (*each)(void *context, const ll_key_use *use), void *context);
    ll_status (*find_code)(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1]);
    ll_status (*read_state)(ll_store *store, int64_t number, ll_stored_state *state);
    ll_status (*open_class)(ll_store *store, const ll_new_class *wanted, ll_opened_class *opened);
    ll_status (*claim_class)(ll_store *store, const char *id, ll_claim *claim);
    ll_status (*find_class)(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1]);
    ll_status (*claim_answer)(ll_store *store, ll_answer_key *key, ll_answer_claim *claim);
    ll_status (*expire)(ll_store *store, double ttl_s, int64_t *deleted);
    ll_status (*replace)(ll_store *store);
    ll_status (*drain)(ll_store *store);
} ll_shared_kind;

/* What a kind of store does. */
typedef struct ll_store_kind {
    const ll_shared_kind *shared; /* NULL: it belongs to one daemon */
    int64_t retry_ms;             /* after a failed commit */
    void (*close)(ll_store *store);
    /* Called by the writer thread. All or nothing; the same batch may be written again. LL_CONFLICT: the
     * incarnation `daemon` is dead, and nothing was written. */
    ll_status (*commit)(ll_store *store, const record *batch, int64_t daemon);
    ll_status (*list)(ll_store *store, void (*each)(void *context, const ll_stored *stored), void *context);
    ll_status (*read_log)(ll_store *store, int64_t number, char **text, size_t *length);
    ll_status (*list_classes)(ll_store *store,
                              void (*each)(void *context, const char *id, int64_t seen_ms, const char *text),
                              void *context);
    /* Reserves numbers for new sessions: *first to *past - 1. */
    ll_status (*new_numbers)(ll_store *store, int64_t *first, int64_t *past);
} ll_store_kind;

typedef struct lost_range {
    uint64_t from, to;
} lost_range;

enum { LOST_RANGES = 16 };

/* First member of each kind's own struct. */
struct ll_store {
    const ll_store_kind *kind;
    pthread_t thread;
    bool started;

    pthread_mutex_t lock; /* guards all members below */
    pthread_cond_t queued, done;
    record *first, *last;
    uint64_t ticket, durable;
    lost_range lost[LOST_RANGES]; /* the last ones; their waiters are woken at once */
    int losses;
    int64_t daemon; /* incarnation; 0: none now, or not shared */
    int64_t next_number, past_number;
    ll_store_stats stats;
    bool closing, failing;
    ll_status why;
    void (*notify)(void *context);
    void *notify_context;
};

/* ---- sqlite.c ---- */

/* A folder to be read only, with its lock. Its database stays as it is. LL_NOT_FOUND: it has none. */
ll_status ll_sqlite_open_source(const char *directory, ll_store **store);

/* ---- postgres.c, postgres_import.c: only if built with libpq ---- */

ll_status ll_pg_open(const ll_shared_config *config, ll_store **store);
ll_status ll_pg_import(const char *directory, const char *url, ll_imported *imported);

/* ---- store.c ---- */

void ll_store_init(ll_store *store, const ll_store_kind *kind);
ll_status ll_store_start(ll_store *store); /* the writer thread, when the kind is ready */
void ll_store_end(ll_store *store);        /* frees the members above; by `close` */

/* The incarnation is dead: what is queued is lost, and nothing more is accepted for it. Once: no effect for
 * another than the present one. Not locked. */
void ll_store_fence(ll_store *store, int64_t daemon);

/* Appends a line and a newline to a text that grows. */
typedef struct log_text {
    char *text;
    size_t length, capacity;
} log_text;

bool ll_store_add_line(log_text *log, const void *line, size_t size);
/* The text as the result of read_log; an empty log is an error that names `where`. */
ll_status ll_store_end_log(log_text *log, ll_status status, const char *where, char **text, size_t *length);
