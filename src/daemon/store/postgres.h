/* Shared by the files of the store in PostgreSQL, lower ones first: postgres_link.c (connections),
 * postgres_commit.c (the writer), postgres_claim.c (sessions), postgres_state.c (their states),
 * postgres_quota.c (codes and quotas), postgres_class.c (classes), postgres_answer.c (repeated requests),
 * postgres_lease.c (the lease thread), postgres.c (tables, opening), postgres_import.c (a folder's sessions).
 * Not for other rooms. */
#pragma once

#include <stdatomic.h>

#include "daemon/store/internal.h"
#include "postgres/link.h"

enum { PG_TOKEN_MAX = 40 };

typedef ll_pg_link pg_link;

typedef struct postgres_store {
    ll_store base;
    char name[160]; /* the URL without its password and its query */
    char *url;
    char address[LL_STORE_URL_MAX + 1];
    char engine[LL_STORE_ENGINE_MAX + 1];
    double lease_s;
    pg_link writer, reader, lease;
    char token[PG_TOKEN_MAX]; /* of the present incarnation; guarded by base.lock */

    pthread_t lease_thread;
    bool lease_started;
    int wake; /* an eventfd: the lease thread has something to do */
    atomic_bool lease_ends;
    _Atomic int64_t freeze_at;                    /* ns, of ll_pg_now */
    void (*asked)(void *context, const char *id); /* guarded by base.lock */
    void *asked_context;
} postgres_store;

/* Who this daemon is at present. */
typedef struct pg_self {
    int64_t daemon; /* 0: none now */
    char token[PG_TOKEN_MAX];
} pg_self;

/* ---- postgres.c ---- */

/* The reader's connection and the tables, without an incarnation and its threads. Ended by ll_store_close. */
ll_status ll_pg_open_tables(const ll_shared_config *config, postgres_store **store);

/* ---- postgres_link.c ---- */

int64_t ll_pg_now(void); /* ns since the machine started, suspended ones too: of leases */
pg_self ll_pg_self(postgres_store *s);
ll_status ll_pg_reach(postgres_store *s, pg_link *link); /* connects */

/* ll_pg_lock and ll_pg_unlock of one of its connections. */
void ll_pg_enter(postgres_store *s, pg_link *link);
ll_status ll_pg_leave(pg_link *link, ll_status status);
ll_status ll_pg_failure(const postgres_store *s, const pg_link *link, const char *doing);

/* ---- postgres_commit.c ---- */

ll_status ll_pg_commit(ll_store *store, const record *batch, int64_t daemon);

/* ---- postgres_claim.c ---- */

ll_status ll_pg_read_log(ll_store *store, int64_t number, char **text, size_t *length);
ll_status ll_pg_new_numbers(ll_store *store, int64_t *first, int64_t *past);
ll_status ll_pg_claim(ll_store *store, const char *id, ll_claim *claim);
/* Who has a session or a class, of a result with the columns engine, owner, its URL, whether its lease is
 * over. False: there is none. */
bool ll_pg_read_owner(const pg_link *link, ll_claim *claim);
ll_status ll_pg_release_id(ll_store *store, const char *id);
ll_status ll_pg_mark_dead(ll_store *store, int64_t daemon, bool gone, bool *marked);
ll_status ll_pg_ask(ll_store *store, int64_t owner, const char *id);
ll_status ll_pg_expire(ll_store *store, double ttl_s, int64_t *deleted);
ll_status ll_pg_replace(ll_store *store);
ll_status ll_pg_drain(ll_store *store);

/* ---- postgres_state.c ---- */

ll_status ll_pg_read_state(ll_store *store, int64_t number, ll_stored_state *state);

/* ---- postgres_quota.c ---- */

ll_status ll_pg_reserve_code(ll_store *store, int64_t number, const char *code, ll_session_quota *quota,
                             bool *taken);
ll_status ll_pg_find_code(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1]);
ll_status ll_pg_count_keys(ll_store *store, ll_log_size *sizes, int64_t count,
                           void (*each)(void *context, const ll_key_use *use), void *context);

/* ---- postgres_class.c ---- */

ll_status ll_pg_open_class(ll_store *store, const ll_new_class *wanted, ll_opened_class *opened);
ll_status ll_pg_claim_class(ll_store *store, const char *id, ll_claim *claim);
ll_status ll_pg_find_class(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1]);

/* ---- postgres_answer.c ---- */

ll_status ll_pg_claim_answer(ll_store *store, ll_answer_key *key, ll_answer_claim *claim);

/* ---- postgres_lease.c ---- */

ll_status ll_pg_start_lease(postgres_store *s); /* registers, then renews */
void ll_pg_end_lease(postgres_store *s);        /* this incarnation is dead */
void ll_pg_fenced(ll_store *store);             /* it has to be registered again */
double ll_pg_lease_left_s(ll_store *store);
void ll_pg_on_asked(ll_store *store, void (*asked)(void *context, const char *id), void *context);
