/* Connections of the store in PostgreSQL, and statements on them. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/store/postgres.h"

enum { ARGUMENTS_MAX = 8 };

/* Of each connection. A daemon that freezes between two statements of a commit must not keep its row locked,
 * since others wait for that row to mark it as dead. */
static const char session[] =
    "SET search_path TO laglab_sessions; SET client_min_messages TO warning; SET client_encoding TO 'UTF8';"
    "SET idle_in_transaction_session_timeout TO '2s'; SET lock_timeout TO '5s'";

int64_t ll_pg_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

pg_self ll_pg_self(postgres_store *s)
{
    pg_self self;
    pthread_mutex_lock(&s->base.lock);
    self.daemon = s->base.daemon;
    memcpy(self.token, s->token, sizeof self.token);
    pthread_mutex_unlock(&s->base.lock);
    return self;
}

/* ---- errors ---- */

/* libpq reports every address that it tried, one per line; the name has the first one already. */
ll_status ll_pg_failure(const postgres_store *s, const pg_link *link, const char *doing)
{
    static const char before[] = " failed: ";
    const char *message = PQerrorMessage(link->db);
    if (PQstatus(link->db) != CONNECTION_OK) {
        const char *reason = strstr(message, before);
        reason = reason ? reason + strlen(before) : message;
        return ll_error(LL_UNAVAILABLE, "Server of the store %.100s not usable: %.*s", s->name,
                        (int)strcspn(reason, "\n"), reason);
    }
    const char *code = PQresultErrorField(link->result, PG_DIAG_SQLSTATE);
    const char *primary = PQresultErrorField(link->result, PG_DIAG_MESSAGE_PRIMARY);
    if (code && strcmp(code, "53100") == 0)
        return ll_error(LL_IO, "Disk of the store %.120s is full.", s->name);
    if (code && strcmp(code, "25006") == 0)
        return ll_error(LL_IO, "Cannot write to the store %.120s: %.80s.", s->name, primary);
    return ll_error(LL_UNAVAILABLE, "%s in the store %.100s failed: %.100s", doing, s->name,
                    primary ? primary : message);
}

/* ---- statements ---- */

static bool keep(pg_link *link, PGresult *result)
{
    PQclear(link->result);
    link->result = result;
    ExecStatusType status = PQresultStatus(result);
    return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
}

bool ll_pg_run(pg_link *link, const char *sql)
{
    return keep(link, PQexec(link->db, sql));
}

bool ll_pg_send(pg_link *link, const char *sql, int count, const char *const *values)
{
    return keep(link, PQexecParams(link->db, sql, count, NULL, values, NULL, NULL, 0));
}

bool ll_pg_query(pg_link *link, const char *sql, const char *types, ...)
{
    char numbers[ARGUMENTS_MAX][32];
    const char *values[ARGUMENTS_MAX];
    int count = 0;
    va_list arguments;
    va_start(arguments, types);
    for (; types[count]; count++) {
        values[count] = numbers[count];
        if (types[count] == 't')
            values[count] = va_arg(arguments, const char *);
        else if (types[count] == 'r')
            snprintf(numbers[count], sizeof numbers[count], "%.17g", va_arg(arguments, double));
        else
            snprintf(numbers[count], sizeof numbers[count], "%" PRId64, va_arg(arguments, int64_t));
    }
    va_end(arguments);
    return ll_pg_send(link, sql, count, values);
}

int64_t ll_pg_changed(const pg_link *link)
{
    return strtoll(PQcmdTuples(link->result), NULL, 10);
}

const char *ll_pg_text(const pg_link *link, int row, int column)
{
    return PQgetvalue(link->result, row, column);
}

int64_t ll_pg_whole(const pg_link *link, int row, int column)
{
    return strtoll(ll_pg_text(link, row, column), NULL, 10);
}

bool ll_pg_true(const pg_link *link, int row, int column)
{
    return ll_pg_text(link, row, column)[0] == 't';
}

bool ll_pg_null(const pg_link *link, int row, int column)
{
    return PQgetisnull(link->result, row, column) != 0;
}

/* ---- connections ---- */

static bool begin_session(pg_link *link)
{
    return PQstatus(link->db) == CONNECTION_OK && ll_pg_run(link, session);
}

/* The daemon's messages are lines of JSON; what matters of these is in the next error. */
static void ignore(void *context, const char *message)
{
    (void)context, (void)message;
}

/* A network that swallows packets is an error after about half the lease, so that the connection is tried
 * again as soon as the daemon freezes. */
ll_status ll_pg_reach(postgres_store *s, pg_link *link)
{
    static const char *const names[] = {"connect_timeout",
                                        "keepalives_idle",
                                        "keepalives_interval",
                                        "keepalives_count",
                                        "tcp_user_timeout",
                                        "fallback_application_name",
                                        "dbname",
                                        NULL};
    char patience_ms[16];
    double ms = s->lease_s * 500;
    snprintf(patience_ms, sizeof patience_ms, "%d", ms < 500 ? 500 : ms > 30000 ? 30000 : (int)ms);
    const char *const values[] = {"2", "5", "5", "3", patience_ms, "laglab", s->url, NULL};
    link->db = PQconnectdbParams(names, values, true);
    PQsetNoticeProcessor(link->db, ignore, NULL);
    return begin_session(link) ? ll_ok() : ll_pg_failure(s, link, "Opening");
}

void ll_pg_enter(postgres_store *s, pg_link *link)
{
    (void)s;
    pthread_mutex_lock(&link->lock);
    PQconsumeInput(link->db); /* reads the server's last message */
    PQconsumeInput(link->db); /* reads the end of the connection */
    if (PQstatus(link->db) != CONNECTION_OK) {
        PQreset(link->db);
        begin_session(link);
    }
}

ll_status ll_pg_leave(pg_link *link, ll_status status)
{
    PQclear(link->result);
    link->result = NULL;
    pthread_mutex_unlock(&link->lock);
    return status;
}
