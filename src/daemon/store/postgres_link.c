/* Connections of the store in PostgreSQL. */
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "daemon/store/postgres.h"

/* The lease in the database goes on while this machine is suspended. CLOCK_MONOTONIC stands still meanwhile,
 * so that a machine that wakes would take a lease that is over for a valid one. */
int64_t ll_pg_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_BOOTTIME, &now);
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

ll_status ll_pg_failure(const postgres_store *s, const pg_link *link, const char *doing)
{
    char reason[LL_PG_REASON_MAX];
    switch (ll_pg_fault_of(link, reason)) {
    case LL_PG_LOST:
        return ll_error(LL_UNAVAILABLE, "Server of the store %.100s not usable: %s", s->name, reason);
    case LL_PG_DISK_FULL:
        return ll_error(LL_IO, "Disk of the store %.120s is full.", s->name);
    case LL_PG_READ_ONLY:
        return ll_error(LL_IO, "Cannot write to the store %.120s: %.80s.", s->name, reason);
    default:
        return ll_error(LL_UNAVAILABLE, "%s in the store %.100s failed: %.100s", doing, s->name, reason);
    }
}

/* A network that swallows packets is an error after about half the lease, so that the connection is tried
 * again as soon as the daemon freezes. */
ll_status ll_pg_reach(postgres_store *s, pg_link *link)
{
    char patience_ms[16];
    double ms = s->lease_s * 500;
    snprintf(patience_ms, sizeof patience_ms, "%d", ms < 500 ? 500 : ms > 30000 ? 30000 : (int)ms);
    const ll_pg_patience patience = {.connect_timeout = "2",
                                     .keepalives_idle = "5",
                                     .keepalives_interval = "5",
                                     .keepalives_count = "3",
                                     .tcp_user_timeout = patience_ms};
    return ll_pg_connect(link, s->url, &patience) ? ll_ok() : ll_pg_failure(s, link, "Opening");
}

void ll_pg_enter(postgres_store *s, pg_link *link)
{
    (void)s;
    ll_pg_lock(link);
}

ll_status ll_pg_leave(pg_link *link, ll_status status)
{
    return ll_pg_unlock(link, status);
}
