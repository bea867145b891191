/* The lease of this daemon in PostgreSQL: a thread that renews it, and receives the requests of other
 * daemons.
 *
 * It has a connection of its own, so that no commit and no claim delays a renewal. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>

#include "daemon/store/postgres.h"

enum { RENEWALS = 5 /* in the time of a lease */, RECONNECT_MS = 200 };

double ll_pg_lease_left_s(ll_store *store)
{
    postgres_store *s = (postgres_store *)store;
    return (double)(atomic_load(&s->freeze_at) - ll_pg_now()) * 1e-9;
}

/* Safe until then: the request was sent at `sent`, so that the database's lease ends later. */
static void extend(postgres_store *s, int64_t sent)
{
    atomic_store(&s->freeze_at, sent + (int64_t)(s->lease_s * LL_LEASE_SAFE * 1e9));
}

static bool listen_for(postgres_store *s, int64_t daemon)
{
    char sql[48];
    snprintf(sql, sizeof sql, "LISTEN laglab_%lld", (long long)daemon);
    return ll_pg_run(&s->lease, sql);
}

static bool enlist(postgres_store *s)
{
    pg_link *link = &s->lease;
    int64_t sent = ll_pg_now();
    if (!ll_pg_run(link, "UNLISTEN *") ||
        !ll_pg_query(link,
                     "INSERT INTO daemon(token,url,engine,state,lease_until)"
                     " VALUES(gen_random_uuid(),$1,$2,'up',now()+$3*interval '1 second') RETURNING inc,token",
                     "ttr", s->address, s->engine, s->lease_s))
        return false;
    int64_t daemon = ll_pg_whole(link, 0, 0);
    char token[PG_TOKEN_MAX];
    snprintf(token, sizeof token, "%s", ll_pg_text(link, 0, 1));
    if (!listen_for(s, daemon))
        return false;
    extend(s, sent);
    pthread_mutex_lock(&s->base.lock);
    memcpy(s->token, token, sizeof s->token);
    s->base.daemon = daemon;
    pthread_mutex_unlock(&s->base.lock);
    return true;
}

/* False: no connection. */
static bool renew(postgres_store *s, const pg_self *self)
{
    int64_t sent = ll_pg_now();
    if (!ll_pg_query(&s->lease,
                     "UPDATE daemon SET lease_until=now()+$3*interval '1 second'"
                     " WHERE inc=$1::bigint AND token=$2::uuid AND state<>'dead'",
                     "itr", self->daemon, self->token, s->lease_s))
        return false;
    if (ll_pg_changed(&s->lease) > 0)
        extend(s, sent);
    else
        ll_store_fence(&s->base, self->daemon);
    return true;
}

/* ---- requests of other daemons ---- */

static void take_requests(postgres_store *s)
{
    PGnotify *request;
    pthread_mutex_lock(&s->base.lock);
    void (*asked)(void *context, const char *id) = s->asked;
    void *context = s->asked_context;
    pthread_mutex_unlock(&s->base.lock);
    PQconsumeInput(s->lease.db);
    while ((request = PQnotifies(s->lease.db)) != NULL) {
        if (asked)
            asked(context, request->extra);
        PQfreemem(request);
    }
}

void ll_pg_on_asked(ll_store *store, void (*asked)(void *context, const char *id), void *context)
{
    postgres_store *s = (postgres_store *)store;
    pthread_mutex_lock(&s->base.lock);
    s->asked = asked;
    s->asked_context = context;
    pthread_mutex_unlock(&s->base.lock);
}

/* ---- the thread ---- */

void ll_pg_fenced(ll_store *store)
{
    eventfd_write(((postgres_store *)store)->wake, 1);
}

static void wait_until(postgres_store *s, int64_t until_ns)
{
    int64_t left_ms = (until_ns - ll_pg_now()) / 1000000 + 1;
    struct pollfd on[2] = {{.fd = s->wake, .events = POLLIN},
                           {.fd = PQsocket(s->lease.db), .events = POLLIN}};
    poll(on, 2, left_ms < 0 ? 0 : left_ms > 10000 ? 10000 : (int)left_ms);
    eventfd_t count;
    eventfd_read(s->wake, &count);
}

/* Renews, or registers as a new incarnation when the last one is dead. */
static bool keep_lease(postgres_store *s)
{
    int before = PQbackendPID(s->lease.db);
    ll_pg_enter(s, &s->lease);
    pg_self self = ll_pg_self(s);
    bool same = PQbackendPID(s->lease.db) == before && before != 0;
    bool good = self.daemon == 0 || same || listen_for(s, self.daemon);
    good = good && (self.daemon == 0 || renew(s, &self));
    if (good && ll_pg_self(s).daemon == 0)
        good = enlist(s);
    ll_pg_leave(&s->lease, ll_ok());
    return good;
}

static void *keep_leases(void *argument)
{
    postgres_store *s = argument;
    pthread_setname_np(pthread_self(), "lease");
    int64_t renewal = (int64_t)(s->lease_s / RENEWALS * 1e9), next = ll_pg_now() + renewal;
    while (!atomic_load(&s->lease_ends)) {
        wait_until(s, next);
        bool lost = ll_pg_self(s).daemon == 0; /* by a commit */
        take_requests(s);
        if (ll_pg_now() < next && !lost && PQstatus(s->lease.db) == CONNECTION_OK)
            continue;
        int64_t from = ll_pg_now();
        next = from + (keep_lease(s) ? renewal : (int64_t)RECONNECT_MS * 1000000);
        take_requests(s); /* that came with the answers */
    }
    return NULL;
}

ll_status ll_pg_start_lease(postgres_store *s)
{
    ll_pg_enter(s, &s->lease);
    ll_status status =
        ll_pg_leave(&s->lease, enlist(s) ? ll_ok() : ll_pg_failure(s, &s->lease, "Registering"));
    if (ll_failed(&status))
        return status;
    s->lease_started = pthread_create(&s->lease_thread, NULL, keep_leases, s) == 0;
    return s->lease_started ? ll_ok() : ll_error(LL_NO_MEMORY, "cannot start the lease thread");
}

void ll_pg_end_lease(postgres_store *s)
{
    atomic_store(&s->lease_ends, true);
    eventfd_write(s->wake, 1);
    if (s->lease_started)
        pthread_join(s->lease_thread, NULL);
    pg_self self = ll_pg_self(s);
    if (self.daemon == 0 || PQstatus(s->lease.db) != CONNECTION_OK)
        return;
    ll_pg_enter(s, &s->lease);
    ll_pg_query(&s->lease, "UPDATE daemon SET state='dead' WHERE inc=$1::bigint AND token=$2::uuid", "it",
                self.daemon, self.token);
    ll_pg_leave(&s->lease, ll_ok());
}
