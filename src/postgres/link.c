/* Connections by libpq. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "postgres/link.h"
#include "postgres/url.h"

/* ---- connections ---- */

/* The message without its quotation of the URL, which has the password. */
ll_status ll_pg_check_url(const char *url, const char *name)
{
    char *message = NULL;
    PQconninfoOption *options = PQconninfoParse(url, &message);
    ll_status status = ll_ok();
    if (message) {
        message[strcspn(message, "\":\n")] = '\0';
        status =
            ll_field_error(LL_BAD_INPUT, "store", "invalid URL of the store %.100s: %.100s", name, message);
    }
    PQconninfoFree(options);
    PQfreemem(message);
    return status;
}

void ll_pg_init(ll_pg_link *link, const char *session)
{
    link->db = NULL;
    link->result = NULL;
    link->session = session;
    link->begun = false;
    pthread_mutex_init(&link->lock, NULL);
}

void ll_pg_close(ll_pg_link *link)
{
    PQclear(link->result);
    PQfinish(link->db);
    pthread_mutex_destroy(&link->lock);
}

/* Messages of the program are sentences of its own; what matters of these is in the next error. */
static void ignore(void *context, const char *message)
{
    (void)context, (void)message;
}

static bool run(ll_pg_link *link, const char *sql)
{
    return ll_pg_keep(link, PQexec(link->db, sql));
}

/* Not on a failed connection, where it would replace the reason. */
static bool begin_session(ll_pg_link *link)
{
    link->begun = PQstatus(link->db) == CONNECTION_OK && run(link, link->session);
    return link->begun;
}

bool ll_pg_connect(ll_pg_link *link, const char *url, const ll_pg_patience *patience)
{
    const char *const parameters[][2] = {{"connect_timeout", patience->connect_timeout},
                                         {"keepalives_idle", patience->keepalives_idle},
                                         {"keepalives_interval", patience->keepalives_interval},
                                         {"keepalives_count", patience->keepalives_count},
                                         {"tcp_user_timeout", patience->tcp_user_timeout},
                                         {"fallback_application_name", "laglab"},
                                         {"dbname", url}, /* what comes later overrides */
                                         {NULL, NULL}};
    enum { COUNT = sizeof parameters / sizeof parameters[0] };
    const char *names[COUNT], *values[COUNT];
    for (int i = 0; i < COUNT; i++) {
        names[i] = parameters[i][0];
        values[i] = parameters[i][1];
    }
    link->db = PQconnectdbParams(names, values, true);
    PQsetNoticeProcessor(link->db, ignore, NULL);
    return begin_session(link);
}

void ll_pg_lock(ll_pg_link *link)
{
    pthread_mutex_lock(&link->lock);
    PQconsumeInput(link->db); /* reads the server's last message */
    PQconsumeInput(link->db); /* reads the end of the connection */
    if (PQstatus(link->db) != CONNECTION_OK) {
        PQreset(link->db);
        link->begun = false;
    }
    if (!link->begun)
        begin_session(link);
}

ll_status ll_pg_unlock(ll_pg_link *link, ll_status status)
{
    PQclear(link->result);
    link->result = NULL;
    pthread_mutex_unlock(&link->lock);
    return status;
}

/* ---- statements ---- */

bool ll_pg_keep(ll_pg_link *link, PGresult *result)
{
    PQclear(link->result);
    link->result = result;
    ExecStatusType status = PQresultStatus(result);
    return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK || status == PGRES_COPY_IN;
}

/* Without its settings a statement would be for another schema. The result that is kept is then that of the
 * settings, so that ll_pg_fault_of says why they failed. */
bool ll_pg_run(ll_pg_link *link, const char *sql)
{
    return link->begun && run(link, sql);
}

static bool send_as(ll_pg_link *link, int binary, const char *sql, int count, const char *const *values)
{
    return link->begun &&
           ll_pg_keep(link, PQexecParams(link->db, sql, count, NULL, values, NULL, NULL, binary));
}

bool ll_pg_send(ll_pg_link *link, const char *sql, int count, const char *const *values)
{
    return send_as(link, 0, sql, count, values);
}

static bool query_as(ll_pg_link *link, int binary, const char *sql, const char *types, va_list arguments)
{
    char numbers[LL_PG_ARGUMENTS_MAX][32];
    const char *values[LL_PG_ARGUMENTS_MAX];
    int count = 0;
    for (; types[count]; count++) {
        values[count] = numbers[count];
        if (types[count] == 't')
            values[count] = va_arg(arguments, const char *);
        else if (types[count] == 'r')
            snprintf(numbers[count], sizeof numbers[count], "%.17g", va_arg(arguments, double));
        else
            snprintf(numbers[count], sizeof numbers[count], "%" PRId64, va_arg(arguments, int64_t));
    }
    return send_as(link, binary, sql, count, values);
}

bool ll_pg_query(ll_pg_link *link, const char *sql, const char *types, ...)
{
    va_list arguments;
    va_start(arguments, types);
    bool good = query_as(link, 0, sql, types, arguments);
    va_end(arguments);
    return good;
}

bool ll_pg_query_binary(ll_pg_link *link, const char *sql, const char *types, ...)
{
    va_list arguments;
    va_start(arguments, types);
    bool good = query_as(link, 1, sql, types, arguments);
    va_end(arguments);
    return good;
}

/* ---- results ---- */

int64_t ll_pg_changed(const ll_pg_link *link)
{
    return strtoll(PQcmdTuples(link->result), NULL, 10);
}

int ll_pg_rows(const ll_pg_link *link)
{
    return PQntuples(link->result);
}

const char *ll_pg_text(const ll_pg_link *link, int row, int column)
{
    return PQgetvalue(link->result, row, column);
}

int64_t ll_pg_whole(const ll_pg_link *link, int row, int column)
{
    return strtoll(ll_pg_text(link, row, column), NULL, 10);
}

bool ll_pg_true(const ll_pg_link *link, int row, int column)
{
    return ll_pg_text(link, row, column)[0] == 't';
}

bool ll_pg_null(const ll_pg_link *link, int row, int column)
{
    return PQgetisnull(link->result, row, column) != 0;
}

/* libpq reports every address that it tried, one per line: "connection to ... failed: reason". The store's
 * name says which one it is. */
ll_pg_fault ll_pg_fault_of(const ll_pg_link *link, char reason[LL_PG_REASON_MAX])
{
    static const char before[] = " failed: ";
    const char *message = PQerrorMessage(link->db);
    if (PQstatus(link->db) != CONNECTION_OK) {
        const char *at = strstr(message, before);
        at = at ? at + strlen(before) : message;
        snprintf(reason, LL_PG_REASON_MAX, "%.*s", (int)strcspn(at, "\n"), at);
        return LL_PG_LOST;
    }
    const char *code = PQresultErrorField(link->result, PG_DIAG_SQLSTATE);
    const char *primary = PQresultErrorField(link->result, PG_DIAG_MESSAGE_PRIMARY);
    snprintf(reason, LL_PG_REASON_MAX, "%s", primary ? primary : message);
    if (code && strcmp(code, "53100") == 0)
        return LL_PG_DISK_FULL;
    return code && strcmp(code, "25006") == 0 ? LL_PG_READ_ONLY : LL_PG_REFUSED;
}
