/* Answers to requests that may be repeated, in the store in PostgreSQL. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "daemon/store/postgres.h"

/* A name of a dead incarnation without an answer is taken over: one that was seen as dead has committed what
 * it could, so that its answer would be seen too. */
static const char claim_sql[] =
    "WITH me AS MATERIALIZED (SELECT 1 FROM daemon WHERE inc=$1::bigint AND token=$2::uuid AND state<>'dead'"
    " FOR SHARE)"
    " INSERT INTO answer(name,body,owner) SELECT $3,$4,$1::bigint FROM me"
    " ON CONFLICT (name) DO UPDATE SET body=EXCLUDED.body, owner=EXCLUDED.owner, made=now()"
    " WHERE answer.answer IS NULL AND answer.owner IN (SELECT inc FROM daemon WHERE state='dead')";

/* Why the claim got nothing. */
static bool explain(postgres_store *s, const ll_answer_key *key, ll_answer_claim *claim, ll_status *status)
{
    pg_link *link = &s->reader;
    if (!ll_pg_query(link,
                     "SELECT a.body=$2, a.answer, a.owner, d.url, d.lease_until<now()"
                     " FROM answer a LEFT JOIN daemon d ON d.inc=a.owner WHERE a.name=$1",
                     "tt", key->name, key->body))
        return false;
    if (PQntuples(link->result) == 0) { /* this daemon is dead, or the name was given back just now */
        *status = ll_error(LL_UNAVAILABLE, "This daemon takes no sessions now; try again.");
        return true;
    }
    claim->state = !ll_pg_true(link, 0, 0)  ? LL_ANSWER_OTHER
                   : ll_pg_null(link, 0, 1) ? LL_ANSWER_BUSY
                                            : LL_ANSWER_SAME;
    claim->owner = ll_pg_whole(link, 0, 2);
    claim->over = ll_pg_true(link, 0, 4);
    snprintf(claim->url, sizeof claim->url, "%s", ll_pg_text(link, 0, 3));
    if (claim->state != LL_ANSWER_SAME)
        return true;
    claim->text = strdup(ll_pg_text(link, 0, 1));
    if (!claim->text)
        *status = ll_error(LL_NO_MEMORY, "out of memory: answer");
    return true;
}

ll_status ll_pg_claim_answer(ll_store *store, ll_answer_key *key, ll_answer_claim *claim)
{
    postgres_store *s = (postgres_store *)store;
    pg_link *link = &s->reader;
    pg_self self = ll_pg_self(s);
    ll_status status = ll_ok();
    *claim = (ll_answer_claim){.state = LL_ANSWER_FIRST};
    key->daemon = self.daemon;
    ll_pg_enter(s, link);
    bool good = ll_pg_query(link, claim_sql, "ittt", self.daemon, self.token, key->name, key->body);
    if (good && ll_pg_changed(link) == 0)
        good = explain(s, key, claim, &status);
    return ll_pg_leave(link, good ? status : ll_pg_failure(s, link, "Claiming an answer"));
}
