/* Classes in the store in PostgreSQL: opening, and who has them. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/store/postgres.h"

/* ---- opening ---- */

static const char open_sql[] =
    "WITH me AS MATERIALIZED (SELECT 1 FROM daemon WHERE inc=$1::bigint AND token=$2::uuid AND state='up'"
    " FOR SHARE)"
    " INSERT INTO class(id,stem,code,client,engine,owner,body,seen,class_key)"
    " SELECT $3,left($3,10),$4,$5,$6,$1::bigint,$7,now(),nullif($8,'') FROM me ON CONFLICT DO NOTHING";

/* Within a transaction and a lock, so that the quotas hold for all daemons together. */
static bool open_class(postgres_store *s, const pg_self *self, const ll_new_class *wanted,
                       ll_opened_class *opened)
{
    pg_link *link = &s->reader;
    bool good = ll_pg_run(link, "BEGIN") && ll_pg_run(link, "SELECT pg_advisory_xact_lock(7817203)") &&
                ll_pg_query(link,
                            "SELECT count(*), count(*) FILTER (WHERE client=$1 AND class_key IS NULL),"
                            " count(*) FILTER (WHERE class_key=$2) FROM class",
                            "tt", wanted->client, wanted->class_key);
    if (!good)
        return false;
    opened->full = ll_pg_whole(link, 0, 0) >= wanted->most;
    bool keyed = wanted->class_key[0] != '\0';
    opened->client_full = !keyed && ll_pg_whole(link, 0, 1) >= wanted->most_client;
    opened->key_full = keyed && wanted->most_of_key >= 0 && ll_pg_whole(link, 0, 2) >= wanted->most_of_key;
    if (!opened->full && !opened->client_full && !opened->key_full) {
        good = ll_pg_query(link, open_sql, "ittttttt", self->daemon, self->token, wanted->id, wanted->code,
                           wanted->client, s->engine, wanted->text, wanted->class_key);
        opened->taken = good && ll_pg_changed(link) == 0;
    }
    return good && ll_pg_run(link, "COMMIT");
}

ll_status ll_pg_open_class(ll_store *store, const ll_new_class *wanted, ll_opened_class *opened)
{
    postgres_store *s = (postgres_store *)store;
    pg_self self = ll_pg_self(s);
    *opened = (ll_opened_class){.daemon = self.daemon};
    ll_pg_enter(s, &s->reader);
    ll_status status =
        open_class(s, &self, wanted, opened) ? ll_ok() : ll_pg_failure(s, &s->reader, "Opening a class");
    if (ll_failed(&status) && PQtransactionStatus(s->reader.db) != PQTRANS_IDLE)
        ll_pg_run(&s->reader, "ROLLBACK");
    return ll_pg_leave(&s->reader, status);
}

/* ---- claiming ---- */

/* As of a session: see postgres_claim.c. */
static const char claim_sql[] =
    "WITH me AS MATERIALIZED (SELECT 1 FROM daemon WHERE inc=$1::bigint AND token=$2::uuid AND state='up'"
    " FOR SHARE), old AS (SELECT owner FROM class WHERE id=$3)"
    " UPDATE class SET owner=$1::bigint FROM me WHERE id=$3 AND engine=$4 AND (owner IS NULL OR"
    " owner=$1::bigint OR owner IN (SELECT inc FROM daemon WHERE state='dead'))"
    " RETURNING body, (extract(epoch FROM now()-seen)*1000)::bigint, (SELECT owner FROM old)";

static void read_claim(const pg_link *link, int64_t daemon, ll_claim *claim)
{
    claim->text = strdup(ll_pg_text(link, 0, 0));
    claim->idle_ms = ll_pg_whole(link, 0, 1);
    claim->daemon = daemon;
    claim->result = LL_CLAIM_DONE;
    claim->why = ll_pg_null(link, 0, 2)              ? LL_CLAIM_FREE
                 : ll_pg_whole(link, 0, 2) == daemon ? LL_CLAIM_OWN
                                                     : LL_CLAIM_DEAD;
}

/* Why the claim got nothing. */
static bool explain(postgres_store *s, const char *id, const pg_self *self, ll_claim *claim)
{
    pg_link *link = &s->reader;
    if (!ll_pg_query(link,
                     "SELECT c.engine, c.owner, d.url, d.lease_until<now(),"
                     " (SELECT state='up' FROM daemon WHERE inc=$2::bigint AND token=$3::uuid)"
                     " FROM class c LEFT JOIN daemon d ON d.inc=c.owner WHERE c.id=$1",
                     "tit", id, self->daemon, self->token))
        return false;
    if (!ll_pg_read_owner(link, claim))
        return true;
    claim->result = strcmp(claim->engine, s->engine) != 0 ? LL_CLAIM_ENGINE
                    : !ll_pg_true(link, 0, 4)             ? LL_CLAIM_REFUSED
                                                          : LL_CLAIM_HELD;
    return true;
}

ll_status ll_pg_claim_class(ll_store *store, const char *id, ll_claim *claim)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    pg_self self = ll_pg_self(s);
    *claim = (ll_claim){.result = LL_CLAIM_REFUSED};
    if (self.daemon == 0)
        return ll_ok();
    ll_pg_enter(s, link);
    bool good = ll_pg_query(link, claim_sql, "ittt", self.daemon, self.token, id, s->engine);
    if (good && PQntuples(link->result) > 0)
        read_claim(link, self.daemon, claim);
    else if (good)
        good = explain(s, id, &self, claim);
    ll_status status = ll_pg_leave(link, good ? ll_ok() : ll_pg_failure(s, link, "Claiming a class"));
    if (claim->result == LL_CLAIM_DONE && !claim->text)
        return ll_error(LL_NO_MEMORY, "out of memory: class");
    return status;
}

ll_status ll_pg_find_class(ll_store *store, const char *code, char id[LL_ID_LENGTH + 1])
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    ll_pg_enter(s, link);
    bool good = ll_pg_query(link, "SELECT id FROM class WHERE code=$1", "t", code);
    bool found = good && PQntuples(link->result) > 0;
    if (found)
        snprintf(id, LL_ID_LENGTH + 1, "%s", ll_pg_text(link, 0, 0));
    ll_status status =
        ll_pg_leave(link, good ? ll_ok() : ll_pg_failure(s, link, "Looking up the code of a class"));
    return ll_failed(&status) || found ? status : ll_error(LL_NOT_FOUND, "Class not found.");
}
