/* Codes of sessions in the store in PostgreSQL, with the quotas of the sessions that have one. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/store/postgres.h"

/* ---- reserving a code ---- */

/* Who makes another session with this stem or this class key waits for the end of the transaction, and counts
 * then. All lock in this order. */
static bool count_others(pg_link *link, ll_session_quota *quota)
{
    if (quota->stem[0]) {
        if (!ll_pg_query(link, "SELECT pg_advisory_xact_lock(7817204, hashtext($1))", "t", quota->stem) ||
            !ll_pg_query(link, "SELECT count(*) FROM code WHERE stem=$1", "t", quota->stem))
            return false;
        quota->full = ll_pg_whole(link, 0, 0) >= quota->most;
    }
    if (quota->class_key[0] && quota->most_of_key >= 0) {
        if (!ll_pg_query(link, "SELECT pg_advisory_xact_lock(7817205, hashtext($1))", "t",
                         quota->class_key) ||
            !ll_pg_query(link, "SELECT count(*) FROM code WHERE class_key=$1", "t", quota->class_key))
            return false;
        quota->key_full = ll_pg_whole(link, 0, 0) >= quota->most_of_key;
    }
    return true;
}

static bool reserve_within(pg_link *link, int64_t number, const char *code, ll_session_quota *quota,
                           bool *taken)
{
    bool good = ll_pg_run(link, "BEGIN") && count_others(link, quota);
    if (!good)
        return false;
    *taken = false;
    if (!quota->full && !quota->key_full) {
        good = ll_pg_query(link,
                           "INSERT INTO code(code,session,stem,class_key) VALUES($1,$2::bigint,"
                           "nullif($3,''),nullif($4,'')) ON CONFLICT DO NOTHING",
                           "titt", code, number, quota->stem, quota->class_key);
        *taken = good && ll_pg_changed(link) == 0;
    }
    return good && ll_pg_run(link, "COMMIT");
}

static ll_status reserve_with_quota(postgres_store *s, int64_t number, const char *code,
                                    ll_session_quota *quota, bool *taken)
{
    pg_link *link = &s->reader;
    ll_pg_enter(s, link);
    ll_status status = reserve_within(link, number, code, quota, taken)
                           ? ll_ok()
                           : ll_pg_failure(s, link, "Reserving a code");
    if (ll_failed(&status) && PQtransactionStatus(link->db) != PQTRANS_IDLE)
        ll_pg_run(link, "ROLLBACK");
    return ll_pg_leave(link, status);
}

ll_status ll_pg_reserve_code(ll_store *store, int64_t number, const char *code, ll_session_quota *quota,
                             bool *taken)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    if (quota)
        return reserve_with_quota(s, number, code, quota, taken);
    ll_pg_enter(s, link);
    bool good =
        ll_pg_query(link, "INSERT INTO code(code,session) VALUES($1,$2::bigint) ON CONFLICT DO NOTHING", "ti",
                    code, number);
    *taken = good && ll_pg_changed(link) == 0;
    return ll_pg_leave(link, good ? ll_ok() : ll_pg_failure(s, link, "Reserving a code"));
}

ll_status ll_pg_find_code(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1])
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    ll_pg_enter(s, link);
    bool good = ll_pg_query(link, "SELECT s.id FROM code c JOIN session s ON s.no=c.session WHERE c.code=$1",
                            "t", code);
    bool found = good && PQntuples(link->result) > 0;
    if (found)
        snprintf(id, LL_ID_LENGTH + 1, "%s", ll_pg_text(link, 0, 0));
    ll_status status = ll_pg_leave(link, good ? ll_ok() : ll_pg_failure(s, link, "Looking up a code"));
    return ll_failed(&status) || found ? status : ll_error(LL_NOT_FOUND, "Code not found.");
}

/* ---- class keys ---- */

/* Not of sessions that another daemon has taken over: that one knows their size. A new one has a code before
 * its row is committed. Rows that others have locked are left out, so that none waits for another in a
 * circle. Returns which were noted. */
static const char note_sql[] =
    "WITH mine AS MATERIALIZED (SELECT c.code, u.b, u.i FROM code c"
    " JOIN unnest($2::bigint[],$3::bigint[]) WITH ORDINALITY u(n,b,i) ON c.session=u.n"
    " WHERE NOT EXISTS (SELECT 1 FROM session WHERE no=u.n AND owner IS DISTINCT FROM $1::bigint)"
    " ORDER BY c.session FOR NO KEY UPDATE OF c SKIP LOCKED)"
    " UPDATE code SET log_bytes=mine.b FROM mine WHERE code.code=mine.code RETURNING mine.i";

static const char count_sql[] =
    "SELECT name, sum(sessions)::bigint, sum(bytes)::bigint, sum(classes)::bigint FROM"
    " (SELECT class_key AS name, count(*) AS sessions, sum(log_bytes) AS bytes, 0 AS classes FROM code"
    " WHERE class_key IS NOT NULL GROUP BY class_key UNION ALL"
    " SELECT class_key, 0, 0, count(*) FROM class WHERE class_key IS NOT NULL GROUP BY class_key) AS uses"
    " GROUP BY name";

enum { NUMBER_TEXT = 21 }; /* characters of a number and a comma */

/* An array of numbers, or with `sizes` of the sizes; the caller frees it. */
static char *write_array(const ll_log_size *sizes, int64_t count, bool of_sizes)
{
    size_t room = (size_t)count * NUMBER_TEXT + 3, length = 0;
    char *text = malloc(room);
    for (int64_t i = 0; text && i < count; i++)
        length += (size_t)snprintf(text + length, room - length, "%c%" PRId64, i == 0 ? '{' : ',',
                                   of_sizes ? sizes[i].bytes : sizes[i].number);
    if (text)
        snprintf(text + length, room - length, "}");
    return text;
}

static bool note_sizes(pg_link *link, int64_t daemon, ll_log_size *sizes, int64_t count)
{
    char *numbers = write_array(sizes, count, false), *bytes = write_array(sizes, count, true);
    bool good = numbers && bytes && ll_pg_query(link, note_sql, "itt", daemon, numbers, bytes);
    for (int i = 0; good && i < ll_pg_rows(link); i++)
        sizes[ll_pg_whole(link, i, 0) - 1].noted = true;
    free(numbers);
    free(bytes);
    return good;
}

ll_status ll_pg_count_keys(ll_store *store, ll_log_size *sizes, int64_t count,
                           void (*each)(void *context, const ll_key_use *use), void *context)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    pg_self self = ll_pg_self(s);
    ll_pg_enter(s, link);
    bool good =
        (count == 0 || note_sizes(link, self.daemon, sizes, count)) && ll_pg_query(link, count_sql, "");
    for (int i = 0; good && i < ll_pg_rows(link); i++) {
        ll_key_use use = {.sessions = ll_pg_whole(link, i, 1),
                          .log_bytes = ll_pg_whole(link, i, 2),
                          .classes = ll_pg_whole(link, i, 3)};
        snprintf(use.name, sizeof use.name, "%s", ll_pg_text(link, i, 0));
        each(context, &use);
    }
    return ll_pg_leave(link, good ? ll_ok() : ll_pg_failure(s, link, "Counting what class keys have"));
}
