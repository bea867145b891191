#include "daemon/hosting/quota.h"

#include <stdio.h>
#include <string.h>

#include "base/hash.h"
#include "daemon/support/rate_limits.h"
#include "session/scenario.h"
#include "threads/clock.h"

enum { CLOCK_BYTES = 64 << 10 }; /* reserved for clock operations, beyond the limit of one session */

static const double mebi = 1 << 20;

/* 0: no limit. */
static int64_t bytes_of(int64_t mib)
{
    return mib > 0 ? mib << 20 : INT64_MAX / 2;
}

static ll_status total_full(ll_host *host, int64_t more)
{
    int64_t most = bytes_of(host->config.max_logs_mib), now = atomic_load(&host->usage.log_bytes);
    if (now < most && more <= most - now)
        return ll_ok();
    atomic_fetch_add(&host->refused.logs, 1);
    return ll_error(LL_IO, "Session logs use %.1f of %.1f MiB (max_logs_mib); delete sessions first.",
                    (double)now / mebi, (double)most / mebi);
}

ll_status ll_quota_check_state(const ll_host_config *config, const ll_scenario *scenario)
{
    double size = (double)scenario->kind->size(scenario->config), most = (double)config->max_state_mib * mebi;
    return size <= most
               ? ll_ok()
               : ll_error(LL_BAD_INPUT,
                          "scenario: state would have %.1f MiB; must have at most %.0f MiB (max_state_mib)",
                          size / mebi, most / mebi);
}

_Atomic int64_t *ll_quota_client_bytes(ll_host *host, const char *client)
{
    return &host->usage.client_bytes[ll_hash(0, client, strlen(client)) % LL_HOST_BUCKETS];
}

/* Limit per client, so that one client cannot fill the disk. */
static ll_status client_full(ll_host *host, _Atomic int64_t *client_bytes, int64_t more)
{
    int64_t most = bytes_of(host->config.max_client_logs_mib),
            now = client_bytes ? atomic_load(client_bytes) : 0;
    if (now < most && more <= most - now)
        return ll_ok();
    atomic_fetch_add(&host->refused.logs, 1);
    return ll_error(LL_IO,
                    "Session logs of this address use %.1f of %.1f MiB (max_client_logs_mib); delete some of "
                    "its sessions first.",
                    (double)now / mebi, (double)most / mebi);
}

static ll_status key_logs_full(ll_host *host, ll_class_key *key, int64_t more)
{
    int64_t most = key->most[LL_KEY_LOGS], now = atomic_load(&key->used[LL_KEY_LOGS]);
    if (most < 0 || (now < most && more <= most - now))
        return ll_ok();
    atomic_fetch_add(&host->refused.logs, 1);
    atomic_fetch_add(&key->refused, 1);
    return ll_error(
        LL_IO,
        "The logs of the class key %s have %.1f of the %.1f MiB that they may have; delete some of "
        "its sessions.",
        key->name, (double)now / mebi, (double)most / mebi);
}

ll_status ll_quota_key_full(ll_class_key *key)
{
    atomic_fetch_add(&key->refused, 1);
    return ll_error(LL_LIMIT, "The class key %s has as many sessions as it may have (%lld); delete some.",
                    key->name, (long long)key->most[LL_KEY_SESSIONS]);
}

ll_status ll_quota_check_line(ll_session_entry *session_entry, bool clock)
{
    ll_host *host = session_entry->host;
    int64_t most = bytes_of(host->config.max_log_mib), now = atomic_load(&session_entry->shared.log_bytes);
    if (now >= most + (clock ? CLOCK_BYTES : 0)) {
        atomic_fetch_add(&host->refused.logs, 1);
        return ll_error(LL_IO, "Log of this session has %.1f MiB; the limit is reached (max_log_mib).",
                        (double)now / mebi);
    }
    ll_class_key *key = atomic_load(&session_entry->shared.class_key);
    ll_status status = clock ? ll_ok()
                       : key ? key_logs_full(host, key, 0)
                             : client_full(host, session_entry->shared.client_bytes, 0);
    return clock || ll_failed(&status) ? status : total_full(host, 0);
}

/* New sessions per minute of a key, or of an address. */
static double rate_of(const ll_host *host, const ll_class_key *key)
{
    return key && key->most[LL_KEY_RATE] > 0 ? (double)key->most[LL_KEY_RATE]
                                             : host->config.max_new_sessions_per_min;
}

/* All buckets have one size: where more sessions fit, each takes less. The boards of a class have a bucket
 * of its own; the copies of one address use up neither it nor those of other addresses. */
static bool take_rate(ll_host *host, const char *peer, const ll_class_key *key,
                      const ll_host_class *for_class, bool copy, double sessions, double most)
{
    char bucket[128];
    if (for_class)
        snprintf(bucket, sizeof bucket, "class %s %s", for_class->id, copy ? peer : "");
    else
        snprintf(bucket, sizeof bucket, "%s%s", key ? "class key " : "", key ? key->name : peer);
    double cost = host->config.max_new_sessions_per_min / most;
    return ll_rate_limits_take_many(host->creations, bucket, sessions * cost, ll_now_ns());
}

ll_status ll_host_check_rate(ll_host *host, const char *peer, ll_class_key *key,
                             const ll_host_class *for_class, const ll_session_entry *origin)
{
    int64_t bytes = origin ? atomic_load(&origin->shared.log_bytes) : 0;
    double sessions = 1 + (double)(bytes / LL_QUOTA_FORK_BYTES),
           most = rate_of(host, key) / (for_class ? for_class->nth : 1);
    if (take_rate(host, peer, key, for_class, origin, sessions, most))
        return ll_ok();
    atomic_fetch_add(&host->refused.creations, 1);
    if (key)
        atomic_fetch_add(&key->refused, 1);
    if (key && !for_class)
        return ll_error(LL_LIMIT,
                        "The class key %s may make at most %g sessions, classes and experiments per minute; "
                        "wait a little.",
                        key->name, most);
    const char *of_class = for_class ? " of a class" : "";
    if (sessions > 1)
        return ll_error(LL_LIMIT,
                        "sessions: must be at most %g/min for one address%s; this fork of a log of %.1f MiB "
                        "counts as %g",
                        most, of_class, (double)bytes / mebi, sessions);
    if (for_class && !origin)
        return ll_error(LL_LIMIT, "boards: must be at most %g/min for one class", most);
    return ll_error(LL_LIMIT, "%s: must be at most %g/min for one address%s",
                    for_class ? "copies" : "sessions, classes and experiments", most, of_class);
}

ll_status ll_quota_check_session(ll_host *host, const char *client, ll_class_key *key, int64_t bytes)
{
    ll_status status = total_full(host, bytes);
    LL_THEN(status, key ? key_logs_full(host, key, bytes)
                        : client_full(host, ll_quota_client_bytes(host, client), bytes));
    return !ll_failed(&status) && key && ll_class_key_is_full(key, LL_KEY_SESSIONS) ? ll_quota_key_full(key)
                                                                                    : status;
}
