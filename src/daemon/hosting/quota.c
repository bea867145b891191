#include "daemon/hosting/quota.h"

#include <string.h>

#include "base/hash.h"
#include "daemon/support/rate_limits.h"
#include "session/scenario.h"

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

ll_status ll_quota_check_line(ll_session_entry *session_entry, bool clock)
{
    ll_host *host = session_entry->host;
    int64_t most = bytes_of(host->config.max_log_mib), now = atomic_load(&session_entry->shared.log_bytes);
    if (now >= most + (clock ? CLOCK_BYTES : 0)) {
        atomic_fetch_add(&host->refused.logs, 1);
        return ll_error(LL_IO, "Log of this session has %.1f MiB; the limit is reached (max_log_mib).",
                        (double)now / mebi);
    }
    ll_status status = clock ? ll_ok() : client_full(host, session_entry->shared.client_bytes, 0);
    return clock || ll_failed(&status) ? status : total_full(host, 0);
}

ll_status ll_quota_check_session(ll_host *host, const char *client, int64_t bytes)
{
    ll_status status = total_full(host, bytes);
    LL_THEN(status, client_full(host, ll_quota_client_bytes(host, client), bytes));
    if (ll_failed(&status))
        return status;
    double sessions = 1 + (double)(bytes / LL_QUOTA_FORK_BYTES), most = host->config.max_new_sessions_per_min;
    if (ll_rate_limits_take_many(host->creations, client, sessions, ll_host_now()))
        return status;
    atomic_fetch_add(&host->refused.creations, 1);
    return sessions > 1 ? ll_error(LL_LIMIT,
                                   "sessions: must be at most %g/min for one address; this fork of a log of "
                                   "%.1f MiB counts as %g",
                                   most, (double)bytes / mebi, sessions)
                        : ll_error(LL_LIMIT, "sessions: must be at most %g/min for one address", most);
}
