#include "daemon/hosting/quota.h"

#include <string.h>

#include "base/hash.h"
#include "daemon/support/rate_limits.h"
#include "session/scenario.h"

enum { CLOCK_BYTES = 64 << 10 }; /* for moves of the clock, beyond the limit of one session */

static const double mebi = 1 << 20;

/* 0 is no limit. */
static int64_t bytes_of(int64_t mib)
{
    return mib > 0 ? mib << 20 : INT64_MAX / 2;
}

static ll_status all_full(ll_host *host, int64_t more)
{
    int64_t most = bytes_of(host->config.max_logs_mib), now = atomic_load(&host->log_bytes);
    if (now < most && more <= most - now)
        return ll_ok();
    atomic_fetch_add(&host->refused_logs, 1);
    return ll_error(LL_IO,
                    "The logs of all sessions take %.1f of %.1f MiB (max_logs_mib): sessions have to "
                    "be deleted first.",
                    (double)now / mebi, (double)most / mebi);
}

ll_status ll_quota_state(const ll_host_config *config, const ll_scenario *scenario)
{
    double size = (double)scenario->kind->size(scenario->config), most = (double)config->max_state_mib * mebi;
    return size <= most ? ll_ok()
                        : ll_error(LL_BAD_INPUT,
                                   "The state of this scenario would have %.1f MiB; here it may have %.0f "
                                   "(max_state_mib).",
                                   size / mebi, most / mebi);
}

_Atomic int64_t *ll_quota_share(ll_host *host, const char *client)
{
    return &host->shares[ll_hash(0, client, strlen(client)) % LL_HOST_BUCKETS];
}

/* One visitor must not take the disk from all others. */
static ll_status share_full(ll_host *host, _Atomic int64_t *share, int64_t more)
{
    int64_t most = bytes_of(host->config.max_client_logs_mib), now = share ? atomic_load(share) : 0;
    if (now < most && more <= most - now)
        return ll_ok();
    atomic_fetch_add(&host->refused_logs, 1);
    return ll_error(LL_IO,
                    "The logs of the sessions that one address has made take %.1f of %.1f MiB "
                    "(max_client_logs_mib): some of them have to be deleted first.",
                    (double)now / mebi, (double)most / mebi);
}

ll_status ll_quota_line(ll_session_entry *session_entry, bool clock)
{
    ll_host *host = session_entry->host;
    int64_t most = bytes_of(host->config.max_log_mib), now = atomic_load(&session_entry->log_bytes);
    if (now >= most + (clock ? CLOCK_BYTES : 0)) {
        atomic_fetch_add(&host->refused_logs, 1);
        return ll_error(LL_IO, "The log of this session has %.1f MiB, which is the limit (max_log_mib).",
                        (double)now / mebi);
    }
    ll_status status = clock ? ll_ok() : share_full(host, session_entry->share, 0);
    return clock || ll_failed(&status) ? status : all_full(host, 0);
}

ll_status ll_quota_make(ll_host *host, const char *client, int64_t bytes)
{
    ll_status status = all_full(host, bytes);
    if (!ll_failed(&status))
        status = share_full(host, ll_quota_share(host, client), bytes);
    if (ll_failed(&status))
        return status;
    double sessions = 1 + (double)(bytes / LL_QUOTA_FORK_BYTES), most = host->config.max_new_sessions_per_min;
    if (ll_rate_limits_take_many(host->creations, client, sessions, ll_host_now()))
        return status;
    atomic_fetch_add(&host->refused_creations, 1);
    return sessions > 1 ? ll_error(LL_LIMIT,
                                   "One address can make at most %g sessions a minute; this fork of a log of "
                                   "%.1f MiB counts as %g.",
                                   most, (double)bytes / mebi, sessions)
                        : ll_error(LL_LIMIT, "One address can make at most %g sessions a minute.", most);
}
