/* How much of the disk sessions may take: bytes of log of one, and of all. */
#pragma once

#include "daemon/hosting/session_entry.h"

/* LL_IO (507) when the log of this session, those of its maker, or those of all, are as long as they may be.
 * `clock`: of what only moves the clock, for which a little is kept back, so that a session with a full log
 * can still be paused. Locked. */
ll_status ll_quota_line(ll_session_entry *session_entry, bool clock);

/* Where the bytes of the logs of a client's sessions are summed. */
_Atomic int64_t *ll_quota_share(ll_host *host, const char *client);

struct ll_scenario;

/* A budget, a client's leaving and the daemon's end take effect between ticks: what a tick may cost is
 * bounded by the size of the state that it goes over. LL_BAD_INPUT: it is too large. Any thread. */
ll_status ll_quota_state(const ll_host_config *config, const struct ll_scenario *scenario);

/* For a new session whose log begins with `bytes`; a fork begins with its origin's. LL_IO when they do not
 * fit, LL_LIMIT when its client made too many: each begun LL_QUOTA_FORK_BYTES count as one session. */
ll_status ll_quota_make(ll_host *host, const char *client, int64_t bytes);

enum { LL_QUOTA_FORK_BYTES = 64 << 10 };
