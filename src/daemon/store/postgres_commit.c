/* The writer of the store in PostgreSQL: a batch in one transaction, with the daemon's own row as the fence.
 *
 * Lines and rows of all sessions are one statement, which commits by itself: one round trip. Only a batch
 * that releases or deletes sessions, or has states, answers or classes, needs more. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/store/postgres.h"

/* ---- arrays as text ---- */

typedef struct pg_array {
    char *text;
    size_t size, capacity;
    bool failed; /* no memory */
} pg_array;

static void append(pg_array *a, const char *bytes, size_t size)
{
    if (a->size + size + 1 > a->capacity) {
        size_t wanted = (a->size + size + 1) * 2;
        char *bigger = realloc(a->text, wanted);
        if (!bigger) {
            a->failed = true;
            return;
        }
        a->text = bigger;
        a->capacity = wanted;
    }
    memcpy(a->text + a->size, bytes, size);
    a->size += size;
    a->text[a->size] = '\0';
}

static void separate(pg_array *a)
{
    append(a, a->size == 0 ? "{" : ",", 1);
}

static void add_whole(pg_array *a, int64_t value)
{
    char number[24];
    int size = snprintf(number, sizeof number, "%" PRId64, value);
    separate(a);
    append(a, number, (size_t)size);
}

static void add_real(pg_array *a, double value)
{
    char number[32];
    int size = snprintf(number, sizeof number, "%.17g", value);
    separate(a);
    append(a, number, (size_t)size);
}

static void add_text(pg_array *a, const char *bytes, size_t size)
{
    separate(a);
    append(a, "\"", 1);
    for (size_t from = 0; from < size;) {
        size_t plain = 0;
        while (from + plain < size && bytes[from + plain] != '"' && bytes[from + plain] != '\\')
            plain++;
        append(a, bytes + from, plain);
        from += plain;
        if (from < size) {
            append(a, "\\", 1);
            append(a, bytes + from++, 1);
        }
    }
    append(a, "\"", 1);
}

static void add_hex(pg_array *a, const void *bytes, size_t size)
{
    static const char digits[] = "0123456789abcdef";
    const unsigned char *from = bytes;
    separate(a);
    append(a, "\"", 1);
    for (size_t i = 0; i < size; i++) {
        const char two[2] = {digits[from[i] >> 4], digits[from[i] & 15]};
        append(a, two, 2);
    }
    append(a, "\"", 1);
}

/* ---- a batch as arrays ---- */

enum {
    OF_LINE,
    AT_LINE,
    BODY,
    NUMBER,
    ID,
    CODE,
    CREATED,
    KEYS,
    PLAYING,
    SPEED,
    TICK,
    HEAD,
    HASH_TICK,
    HASH_LINES,
    HASH,
    RELEASED,
    DELETED,
    STATE_OF,
    STATE,
    ANSWERED,
    ANSWER,
    NOT_ANSWERED,
    CLASS,
    CLASS_TEXT,
    CLASS_RELEASED,
    CLASS_DELETED,
    ARRAYS
};

typedef struct pg_batch {
    pg_array of[ARRAYS];
} pg_batch;

static void add_row(pg_batch *b, const ll_stored *row)
{
    pg_array *of = b->of;
    add_whole(&of[NUMBER], row->place.number);
    add_text(&of[ID], row->id, strlen(row->id));
    add_text(&of[CODE], row->code, strlen(row->code));
    add_whole(&of[CREATED], row->created_ms);
    add_hex(&of[KEYS], row->keys, (size_t)row->key_count * sizeof row->keys[0]);
    separate(&of[PLAYING]);
    append(&of[PLAYING], row->playing ? "t" : "f", 1);
    add_real(&of[SPEED], row->speed);
    add_whole(&of[TICK], row->tick);
    add_whole(&of[HEAD], row->head_tick);
    add_whole(&of[HASH_TICK], row->hash_tick);
    add_whole(&of[HASH_LINES], row->hash_lines);
    add_whole(&of[HASH], (int64_t)row->hash);
}

static void add_record(pg_batch *b, const record *r)
{
    ll_stored row;
    switch (r->type) {
    case RECORD_ROW:
        memcpy(&row, r->bytes, sizeof row);
        add_row(b, &row);
        break;
    case RECORD_LINE:
        add_whole(&b->of[OF_LINE], r->place.number);
        add_whole(&b->of[AT_LINE], r->index);
        add_text(&b->of[BODY], r->bytes, r->size);
        break;
    case RECORD_RELEASE:
        add_whole(&b->of[RELEASED], r->place.number);
        break;
    case RECORD_DELETE:
        add_whole(&b->of[DELETED], r->place.number);
        break;
    case RECORD_STATE:
        add_whole(&b->of[STATE_OF], r->place.number);
        add_hex(&b->of[STATE], r->bytes, r->size);
        break;
    case RECORD_ANSWER:
        add_text(&b->of[ANSWERED], r->bytes, LL_ANSWER_HEX - 1);
        add_text(&b->of[ANSWER], r->bytes + LL_ANSWER_HEX, r->size - LL_ANSWER_HEX);
        break;
    case RECORD_FREE_ANSWER:
        add_text(&b->of[NOT_ANSWERED], r->bytes, LL_ANSWER_HEX - 1);
        break;
    case RECORD_CLASS:
        add_text(&b->of[CLASS], r->bytes, LL_ID_LENGTH);
        add_text(&b->of[CLASS_TEXT], r->bytes + LL_ID_LENGTH + 1, r->size - LL_ID_LENGTH - 1);
        break;
    case RECORD_RELEASE_CLASS:
        add_text(&b->of[CLASS_RELEASED], r->bytes, LL_ID_LENGTH);
        break;
    case RECORD_DELETE_CLASS:
        add_text(&b->of[CLASS_DELETED], r->bytes, LL_ID_LENGTH);
        break;
    }
}

/* False: no memory. */
static bool end_arrays(pg_batch *b)
{
    bool good = true;
    for (int i = 0; i < ARRAYS; i++) {
        append(&b->of[i], b->of[i].size == 0 ? "{}" : "}", b->of[i].size == 0 ? 2 : 1);
        good = good && !b->of[i].failed;
    }
    return good;
}

static void free_arrays(pg_batch *b)
{
    for (int i = 0; i < ARRAYS; i++)
        free(b->of[i].text);
}

/* ---- the statements ---- */

/* A daemon that marks this one as dead waits for the lock of `me`, or is waited for: then `me` is empty. Rows
 * that were written before by a batch whose outcome was unknown stay as they are. */
static const char write_sql[] =
    "WITH me AS MATERIALIZED (SELECT 1 FROM daemon WHERE inc=$1::bigint AND token=$2::uuid AND state<>'dead'"
    " FOR SHARE),"
    " l AS (INSERT INTO line(session,i,body) SELECT u.s,u.i,u.b"
    " FROM me, unnest($3::bigint[],$4::integer[],$5::text[]) AS u(s,i,b) ON CONFLICT DO NOTHING),"
    " r AS (INSERT INTO session(no,id,code,engine,created_ms,keys,owner,playing,speed,tick,head_tick,"
    "hash_tick,hash_lines,hash,seen)"
    " SELECT DISTINCT ON (u.no) u.no,u.id,u.code,$6::text,u.created_ms,decode(u.keys,'hex'),$1::bigint,"
    "u.playing,u.speed,u.tick,u.head_tick,u.hash_tick,u.hash_lines,u.hash,now()"
    " FROM me, unnest($7::bigint[],$8::text[],$9::text[],$10::bigint[],$11::text[],$12::boolean[],"
    "$13::double precision[],$14::bigint[],$15::bigint[],$16::bigint[],$17::bigint[],$18::bigint[])"
    " WITH ORDINALITY AS u(no,id,code,created_ms,keys,playing,speed,tick,head_tick,hash_tick,hash_lines,"
    "hash,n) ORDER BY u.no, u.n DESC"
    " ON CONFLICT (no) DO UPDATE SET playing=EXCLUDED.playing, speed=EXCLUDED.speed, tick=EXCLUDED.tick,"
    " head_tick=EXCLUDED.head_tick, hash_tick=EXCLUDED.hash_tick, hash_lines=EXCLUDED.hash_lines,"
    " hash=EXCLUDED.hash, seen=EXCLUDED.seen WHERE session.owner=EXCLUDED.owner)"
    " SELECT count(*) FROM me";

enum { WRITE_ARGUMENTS = 18 };

/* *fenced: this incarnation is dead. */
static bool write_lines(postgres_store *s, const pg_batch *b, const pg_self *self, bool *fenced)
{
    char daemon[24];
    const char *values[WRITE_ARGUMENTS] = {
        daemon, self->token, b->of[OF_LINE].text, b->of[AT_LINE].text, b->of[BODY].text, s->engine};
    snprintf(daemon, sizeof daemon, "%" PRId64, self->daemon);
    for (int i = NUMBER; i <= HASH; i++)
        values[6 + i - NUMBER] = b->of[i].text;
    if (!ll_pg_send(&s->writer, write_sql, WRITE_ARGUMENTS, values))
        return false;
    *fenced = ll_pg_whole(&s->writer, 0, 0) == 0;
    return true;
}

static bool write_states(postgres_store *s, const pg_batch *b, const pg_self *self)
{
    return ll_pg_query(&s->writer,
                       "INSERT INTO state(session,body) SELECT DISTINCT ON (u.s) u.s, decode(u.b,'hex')"
                       " FROM unnest($2::bigint[],$3::text[]) WITH ORDINALITY AS u(s,b,i)"
                       " JOIN session ON no=u.s AND owner=$1::bigint ORDER BY u.s, u.i DESC"
                       " ON CONFLICT (session) DO UPDATE SET body=EXCLUDED.body",
                       "itt", self->daemon, b->of[STATE_OF].text, b->of[STATE].text);
}

static bool end_sessions(postgres_store *s, const pg_batch *b, const pg_self *self)
{
    pg_link *link = &s->writer;
    const char *gone = b->of[DELETED].text;
    return ll_pg_query(link,
                       "UPDATE session SET owner=NULL WHERE owner=$1::bigint AND no = ANY($2::bigint[])",
                       "it", self->daemon, b->of[RELEASED].text) &&
           ll_pg_query(link, "DELETE FROM session WHERE no = ANY($1::bigint[])", "t", gone) &&
           ll_pg_query(link, "DELETE FROM line WHERE session = ANY($1::bigint[])", "t", gone) &&
           ll_pg_query(link, "DELETE FROM state WHERE session = ANY($1::bigint[])", "t", gone) &&
           ll_pg_query(link, "DELETE FROM code WHERE session = ANY($1::bigint[])", "t", gone);
}

/* A batch may be written again, when its outcome was unknown: an answer is stored once. */
static bool end_answers(postgres_store *s, const pg_batch *b, const pg_self *self)
{
    pg_link *link = &s->writer;
    return ll_pg_query(link,
                       "UPDATE answer SET answer=u.a FROM unnest($2::text[],$3::text[]) AS u(n,a)"
                       " WHERE name=u.n AND owner=$1::bigint AND answer IS NULL",
                       "itt", self->daemon, b->of[ANSWERED].text, b->of[ANSWER].text) &&
           ll_pg_query(link,
                       "DELETE FROM answer WHERE name = ANY($2::text[]) AND owner=$1::bigint AND"
                       " answer IS NULL",
                       "it", self->daemon, b->of[NOT_ANSWERED].text);
}

/* A class that is released or deleted is not written any more by this daemon. */
static bool write_classes(postgres_store *s, const pg_batch *b, const pg_self *self)
{
    pg_link *link = &s->writer;
    return ll_pg_query(link,
                       "UPDATE class SET body=u.b, seen=now() FROM (SELECT DISTINCT ON (i) i, b FROM"
                       " unnest($2::text[],$3::text[]) WITH ORDINALITY AS w(i,b,n) ORDER BY i, n DESC) AS u"
                       " WHERE class.id=u.i AND owner=$1::bigint",
                       "itt", self->daemon, b->of[CLASS].text, b->of[CLASS_TEXT].text) &&
           ll_pg_query(link, "UPDATE class SET owner=NULL WHERE owner=$1::bigint AND id = ANY($2::text[])",
                       "it", self->daemon, b->of[CLASS_RELEASED].text) &&
           ll_pg_query(link, "DELETE FROM class WHERE owner=$1::bigint AND id = ANY($2::text[])", "it",
                       self->daemon, b->of[CLASS_DELETED].text);
}

static bool any(const pg_batch *b, int array)
{
    return b->of[array].size > 2; /* {} */
}

static bool write_all(postgres_store *s, const pg_batch *b, const pg_self *self, bool whole, bool *fenced)
{
    pg_link *link = &s->writer;
    if (!whole)
        return write_lines(s, b, self, fenced);
    bool good = ll_pg_run(link, "BEGIN") && write_lines(s, b, self, fenced);
    if (good && *fenced)
        return ll_pg_run(link, "ROLLBACK");
    good = good && (!any(b, STATE) || write_states(s, b, self));
    good = good && (!(any(b, ANSWERED) || any(b, NOT_ANSWERED)) || end_answers(s, b, self));
    good = good &&
           (!(any(b, CLASS) || any(b, CLASS_RELEASED) || any(b, CLASS_DELETED)) || write_classes(s, b, self));
    good = good && (!(any(b, RELEASED) || any(b, DELETED)) || end_sessions(s, b, self));
    return good && ll_pg_run(link, "COMMIT");
}

ll_status ll_pg_commit(ll_store *store, const record *batch, int64_t daemon)
{
    postgres_store *s = (postgres_store *)store;
    pg_batch b = {0};
    bool whole = false, fenced = false;
    pg_self self = ll_pg_self(s);
    if (self.daemon != daemon)
        return ll_error(LL_CONFLICT, "This daemon has lost its lease.");
    for (const record *r = batch; r; r = r->next) {
        add_record(&b, r);
        whole = whole || (r->type != RECORD_ROW && r->type != RECORD_LINE);
    }
    if (!end_arrays(&b)) {
        free_arrays(&b);
        return ll_error(LL_UNAVAILABLE, "Out of memory: records for the store.");
    }
    ll_pg_enter(s, &s->writer);
    ll_status status =
        write_all(s, &b, &self, whole, &fenced) ? ll_ok() : ll_pg_failure(s, &s->writer, "Writing");
    if (ll_failed(&status) && PQtransactionStatus(s->writer.db) != PQTRANS_IDLE)
        ll_pg_run(&s->writer, "ROLLBACK");
    status = ll_pg_leave(&s->writer, status);
    free_arrays(&b);
    if (!ll_failed(&status) && fenced)
        return ll_error(LL_CONFLICT, "This daemon has lost its lease.");
    return status;
}
