/* Sessions of the store in PostgreSQL: who has them, their logs, their codes. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "daemon/store/postgres.h"

enum { NUMBERS = 1000 /* as the sequence's increment */ };

static int64_t unix_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* One statement of the reader. */
#define READ(s, good, doing)                                                                                 \
    ll_pg_leave(&(s)->reader, (good) ? ll_ok() : ll_pg_failure(s, &(s)->reader, doing))

/* ---- claiming ---- */

static int digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : 0;
}

static void read_keys(ll_stored *row, const char *hex)
{
    size_t each = 2 * sizeof row->keys[0], count = strlen(hex) / each;
    row->key_count = count < LL_STORE_KEYS ? (int)count : LL_STORE_KEYS;
    unsigned char *to = (unsigned char *)row->keys;
    for (size_t i = 0; i < (size_t)row->key_count * sizeof row->keys[0]; i++)
        to[i] = (unsigned char)(digit(hex[2 * i]) << 4 | digit(hex[2 * i + 1]));
}

/* An owner that this statement does not see as dead is not: one that has registered since then is none of
 * these either. So it must not be asked whether the owner is missing among the living. */
static const char claim_sql[] =
    "WITH me AS MATERIALIZED (SELECT 1 FROM daemon WHERE inc=$1::bigint AND token=$2::uuid AND state='up'"
    " FOR SHARE), old AS (SELECT owner FROM session WHERE id=$3)"
    " UPDATE session SET owner=$1::bigint FROM me WHERE id=$3 AND engine=$4 AND (owner IS NULL OR"
    " owner=$1::bigint OR owner IN (SELECT inc FROM daemon WHERE state='dead'))"
    " AND NOT EXISTS (SELECT 1 FROM class WHERE stem=left($3,10) AND owner IS DISTINCT FROM $1::bigint)"
    " RETURNING no, code, created_ms, (extract(epoch FROM now()-seen)*1000)::bigint, encode(keys,'hex'),"
    " playing, speed, tick, head_tick, hash_tick, hash_lines, hash, (SELECT owner FROM old),"
    " (SELECT c.class_key FROM code c WHERE c.session=session.no LIMIT 1)";

static void read_claim(const pg_link *link, const char *id, int64_t daemon, ll_claim *claim)
{
    ll_stored *row = &claim->row;
    *row = (ll_stored){.place = {ll_pg_whole(link, 0, 0), daemon},
                       .created_ms = ll_pg_whole(link, 0, 2),
                       .seen_ms = unix_ms() - ll_pg_whole(link, 0, 3),
                       .playing = ll_pg_true(link, 0, 5),
                       .speed = strtod(ll_pg_text(link, 0, 6), NULL),
                       .tick = ll_pg_whole(link, 0, 7),
                       .head_tick = ll_pg_whole(link, 0, 8),
                       .hash_tick = ll_pg_whole(link, 0, 9),
                       .hash_lines = ll_pg_whole(link, 0, 10),
                       .hash = (uint64_t)ll_pg_whole(link, 0, 11)};
    snprintf(row->id, sizeof row->id, "%s", id);
    snprintf(row->code, sizeof row->code, "%s", ll_pg_text(link, 0, 1));
    snprintf(row->class_key, sizeof row->class_key, "%s", ll_pg_text(link, 0, 13));
    read_keys(row, ll_pg_text(link, 0, 4));
    claim->result = LL_CLAIM_DONE;
    claim->why = ll_pg_null(link, 0, 12)              ? LL_CLAIM_FREE
                 : ll_pg_whole(link, 0, 12) == daemon ? LL_CLAIM_OWN
                                                      : LL_CLAIM_DEAD;
}

/* After the claim: the dead owner's last lines are seen by a later statement only. */
static bool count_lines(pg_link *link, ll_stored *row)
{
    if (!ll_pg_query(link,
                     "SELECT coalesce(max(i)+1,0), coalesce(sum(octet_length(body)+1),0) FROM line"
                     " WHERE session=$1::bigint",
                     "i", row->place.number))
        return false;
    row->lines = ll_pg_whole(link, 0, 0);
    row->log_bytes = ll_pg_whole(link, 0, 1);
    return true;
}

bool ll_pg_read_owner(const pg_link *link, ll_claim *claim)
{
    if (PQntuples(link->result) == 0) {
        claim->result = LL_CLAIM_UNKNOWN;
        return false;
    }
    snprintf(claim->engine, sizeof claim->engine, "%s", ll_pg_text(link, 0, 0));
    snprintf(claim->url, sizeof claim->url, "%s", ll_pg_text(link, 0, 2));
    claim->owner = ll_pg_null(link, 0, 1) ? 0 : ll_pg_whole(link, 0, 1);
    claim->over = ll_pg_true(link, 0, 3);
    return true;
}

/* Who has it. *may: a claim would get it. This only reads: a claim locks the daemon's row, and so is a commit
 * with a write to the disk, also when it gets nothing. */
static bool look(postgres_store *s, const char *id, const pg_self *self, ll_claim *claim, bool *may)
{
    *may = false;
    pg_link *link = &s->reader;
    if (!ll_pg_query(link,
                     "SELECT s.engine, s.owner, d.url, d.lease_until<now(), d.state='dead',"
                     " (SELECT state='up' FROM daemon WHERE inc=$2::bigint AND token=$3::uuid),"
                     " (SELECT c.id FROM class c WHERE c.stem=left($1,10)"
                     " AND c.owner IS DISTINCT FROM $2::bigint)"
                     " FROM session s LEFT JOIN daemon d ON d.inc=s.owner WHERE s.id=$1",
                     "tit", id, self->daemon, self->token))
        return false;
    if (!ll_pg_read_owner(link, claim))
        return true;
    snprintf(claim->class_id, sizeof claim->class_id, "%s", ll_pg_text(link, 0, 6));
    claim->result = strcmp(claim->engine, s->engine) != 0 ? LL_CLAIM_ENGINE
                    : !ll_pg_true(link, 0, 5)             ? LL_CLAIM_REFUSED
                    : !ll_pg_null(link, 0, 6)             ? LL_CLAIM_CLASS
                                                          : LL_CLAIM_HELD;
    *may = claim->result == LL_CLAIM_HELD &&
           (claim->owner == 0 || claim->owner == self->daemon || ll_pg_true(link, 0, 4));
    return true;
}

ll_status ll_pg_claim(ll_store *store, const char *id, ll_claim *claim)
{
    postgres_store *s = (postgres_store *)store;
    pg_self self = ll_pg_self(s);
    *claim = (ll_claim){.result = LL_CLAIM_REFUSED};
    if (self.daemon == 0)
        return ll_ok();
    ll_pg_enter(s, &s->reader);
    bool may, good = look(s, id, &self, claim, &may);
    bool claims = good && may;
    good = good &&
           (!claims || ll_pg_query(&s->reader, claim_sql, "ittt", self.daemon, self.token, id, s->engine));
    if (good && claims && PQntuples(s->reader.result) > 0) {
        read_claim(&s->reader, id, self.daemon, claim);
        good = count_lines(&s->reader, &claim->row);
    } else if (good && claims) { /* another daemon was faster */
        good = look(s, id, &self, claim, &may);
    }
    return READ(s, good, "Claiming a session");
}

ll_status ll_pg_release_id(ll_store *store, const char *id)
{
    postgres_store *s = (postgres_store *)store;
    pg_self self = ll_pg_self(s);
    ll_pg_enter(s, &s->reader);
    bool good = ll_pg_query(&s->reader, "UPDATE session SET owner=NULL WHERE id=$1 AND owner=$2::bigint",
                            "ti", id, self.daemon);
    return READ(s, good, "Releasing a session");
}

ll_status ll_pg_mark_dead(ll_store *store, int64_t daemon, bool gone, bool *marked)
{
    postgres_store *s = (postgres_store *)store;
    ll_pg_enter(s, &s->reader);
    bool good = ll_pg_query(&s->reader,
                            "UPDATE daemon SET state='dead' WHERE inc=$1::bigint AND state<>'dead'"
                            " AND ($2='yes' OR lease_until<now())",
                            "it", daemon, gone ? "yes" : "no");
    *marked = good && ll_pg_changed(&s->reader) > 0;
    return READ(s, good, "Marking a daemon");
}

ll_status ll_pg_ask(ll_store *store, int64_t owner, const char *id)
{
    postgres_store *s = (postgres_store *)store;
    ll_pg_enter(s, &s->reader);
    bool good = ll_pg_query(&s->reader, "SELECT pg_notify('laglab_' || $1::bigint, $2)", "it", owner, id);
    return READ(s, good, "Asking a daemon");
}

/* ---- logs and numbers ---- */

ll_status ll_pg_read_log(ll_store *store, int64_t number, char **text, size_t *length)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    log_text log = {0};
    ll_pg_enter(s, link);
    ll_status status = ll_ok();
    if (!ll_pg_query(link, "SELECT body FROM line WHERE session=$1::bigint ORDER BY i", "i", number))
        status = ll_pg_failure(s, link, "Reading a log");
    int rows = ll_failed(&status) ? 0 : PQntuples(link->result);
    for (int i = 0; i < rows && !ll_failed(&status); i++) {
        if (!ll_store_add_line(&log, ll_pg_text(link, i, 0), (size_t)PQgetlength(link->result, i, 0)))
            status = ll_error(LL_NO_MEMORY, "out of memory: log of a stored session");
    }
    status = ll_pg_leave(link, status);
    return ll_store_end_log(&log, status, s->name, text, length);
}

ll_status ll_pg_new_numbers(ll_store *store, int64_t *first, int64_t *past)
{
    postgres_store *s = (postgres_store *)store;
    ll_pg_enter(s, &s->reader);
    bool good = ll_pg_run(&s->reader, "SELECT nextval('session_number')");
    if (good) {
        *first = ll_pg_whole(&s->reader, 0, 0);
        *past = *first + NUMBERS;
    }
    return READ(s, good, "Numbering a session");
}

/* ---- old rows ---- */

/* Rows of daemons stay while they own a session: the claim asks for owners that are dead, not for those that
 * are missing. */
ll_status ll_pg_expire(ll_store *store, double ttl_s, int64_t *deleted)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    *deleted = 0;
    ll_pg_enter(s, link);
    bool good = ll_pg_query(link,
                            "WITH gone AS (DELETE FROM session WHERE seen<now()-$1*interval '1 second' AND"
                            " (owner IS NULL OR owner IN (SELECT inc FROM daemon WHERE state='dead'))"
                            " RETURNING no),"
                            " c AS (DELETE FROM code USING gone WHERE code.session=gone.no),"
                            " l AS (DELETE FROM line USING gone WHERE line.session=gone.no)"
                            " SELECT count(*) FROM gone",
                            "r", ttl_s);
    if (good)
        *deleted = ll_pg_whole(link, 0, 0);
    good = good &&
           ll_pg_run(
               link,
               "UPDATE daemon SET state='dead' WHERE state<>'dead' AND lease_until<now()-interval '60 s'") &&
           ll_pg_run(link, "DELETE FROM daemon WHERE state='dead' AND lease_until<now()-interval '1 day'"
                           " AND NOT EXISTS (SELECT 1 FROM session WHERE owner=inc)"
                           " AND NOT EXISTS (SELECT 1 FROM class WHERE owner=inc)") &&
           ll_pg_query(link,
                       "DELETE FROM class WHERE seen<now()-$1*interval '1 second' AND"
                       " (owner IS NULL OR owner IN (SELECT inc FROM daemon WHERE state='dead'))",
                       "r", ttl_s) &&
           ll_pg_run(link, "DELETE FROM answer WHERE made<now()-interval '1 day'") &&
           ll_pg_run(link, "DELETE FROM state WHERE NOT EXISTS (SELECT 1 FROM session WHERE"
                           " no=state.session)") &&
           ll_pg_run(link, "DELETE FROM code WHERE made<now()-interval '1 hour'"
                           " AND NOT EXISTS (SELECT 1 FROM session WHERE no=code.session)");
    return READ(s, good, "Deleting old sessions");
}

/* ---- start and end ---- */

ll_status ll_pg_replace(ll_store *store)
{
    postgres_store *s = (postgres_store *)store;
    pg_self self = ll_pg_self(s);
    if (!s->address[0])
        return ll_ok();
    ll_pg_enter(s, &s->reader);
    bool good = ll_pg_query(
        &s->reader, "UPDATE daemon SET state='dead' WHERE url=$1 AND inc<$2::bigint AND state<>'dead'", "ti",
        s->address, self.daemon);
    return READ(s, good, "Replacing a daemon");
}

ll_status ll_pg_drain(ll_store *store)
{
    postgres_store *s = (postgres_store *)store;
    pg_self self = ll_pg_self(s);
    ll_pg_enter(s, &s->reader);
    bool good = ll_pg_query(
        &s->reader,
        "UPDATE daemon SET state='draining' WHERE inc=$1::bigint AND token=$2::uuid AND state='up'", "it",
        self.daemon, self.token);
    return READ(s, good, "Draining");
}
