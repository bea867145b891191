/* A connection to PostgreSQL, and statements on it. */
#pragma once

#include <libpq-fe.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

/* Used by one thread at a time. */
typedef struct ll_pg_link {
    PGconn *db;
    PGresult *result;     /* of the last statement */
    const char *session;  /* statements that begin every connection; outlives the link */
    bool begun;           /* they were done on this one */
    pthread_mutex_t lock; /* guards the others from ll_pg_lock to ll_pg_unlock */
} ll_pg_link;

/* When a connection counts as lost, in libpq's names. */
typedef struct ll_pg_patience {
    const char *connect_timeout;                                          /* s, for each address */
    const char *keepalives_idle, *keepalives_interval, *keepalives_count; /* s, s, probes */
    const char *tcp_user_timeout;                                         /* ms without an acknowledgement */
} ll_pg_patience;

/* Why a statement or a connection failed. */
typedef enum ll_pg_fault {
    LL_PG_LOST,      /* no connection: whether the statement was done is unknown */
    LL_PG_DISK_FULL, /* of the server */
    LL_PG_READ_ONLY, /* a server or a database that is not written to */
    LL_PG_REFUSED,   /* anything else */
} ll_pg_fault;

enum { LL_PG_ARGUMENTS_MAX = 12, LL_PG_REASON_MAX = 256 };

/* ---- connections ---- */

void ll_pg_init(ll_pg_link *link, const char *session);
void ll_pg_close(ll_pg_link *link); /* also one that was never opened */

/* Connects. The URL's own parameters override `patience`. False: ll_pg_fault_of says why. */
bool ll_pg_connect(ll_pg_link *link, const char *url, const ll_pg_patience *patience);

/* Locks the connection, and opens it again if the server has closed it, as after a restart. Where that fails,
 * or the statements that begin the connection, all others fail until the next lock, for the same reason. */
void ll_pg_lock(ll_pg_link *link);
ll_status ll_pg_unlock(ll_pg_link *link,
                       ll_status status); /* releases the result, unlocks, and gives `status` */

/* ---- statements: true if it was done ---- */

bool ll_pg_run(ll_pg_link *link, const char *sql);
bool ll_pg_send(ll_pg_link *link, const char *sql, int count, const char *const *values);

/* A letter of `types` for each argument: t text, i int64_t, r double; at most LL_PG_ARGUMENTS_MAX. The
 * results are text, of the second function in PostgreSQL's binary format. */
bool ll_pg_query(ll_pg_link *link, const char *sql, const char *types, ...);
bool ll_pg_query_binary(ll_pg_link *link, const char *sql, const char *types, ...);

bool ll_pg_keep(ll_pg_link *link, PGresult *result); /* takes ownership: the result of the last statement */

/* ---- the last statement's result ---- */

int64_t ll_pg_changed(const ll_pg_link *link);                       /* rows that it changed */
int ll_pg_rows(const ll_pg_link *link);                              /* rows that it returned */
const char *ll_pg_text(const ll_pg_link *link, int row, int column); /* valid until the next statement */
int64_t ll_pg_whole(const ll_pg_link *link, int row, int column);
bool ll_pg_true(const ll_pg_link *link, int row, int column);
bool ll_pg_null(const ll_pg_link *link, int row, int column);

/* After a failure: its class, and the server's or libpq's sentence. */
ll_pg_fault ll_pg_fault_of(const ll_pg_link *link, char reason[LL_PG_REASON_MAX]);
