/* Disk quotas of session logs: of one session, of one client, of all. */
#pragma once

#include "daemon/hosting/session_entry.h"

/* LL_IO (507) when the logs of this session, of its creator or of all sessions have reached their limits.
 * `clock`: the line only moves the clock. A reserve is kept for such lines, so that a session with a full log
 * can still be paused. Locked. */
ll_status ll_quota_check_line(ll_session_entry *session_entry, bool clock);

/* Counter of the log bytes of a client's sessions. */
_Atomic int64_t *ll_quota_client_bytes(ll_host *host, const char *client);

struct ll_scenario;

/* LL_BAD_INPUT: the scenario's state is too large. The limit bounds the time of a tick: time limits, a
 * client's disconnect and the daemon's end take effect only between ticks. Any thread. */
ll_status ll_quota_check_state(const ll_host_config *config, const struct ll_scenario *scenario);

/* For a new session whose log begins with `bytes`, for a fork those of its origin, of a class key or, if that
 * is NULL, of the client. LL_IO when they do not fit, LL_LIMIT when the class key has too many. */
ll_status ll_quota_check_session(ll_host *host, const char *client, ll_class_key *key, int64_t bytes);

ll_status ll_quota_key_full(ll_class_key *key); /* of sessions: LL_LIMIT */

enum { LL_QUOTA_FORK_BYTES = 64 << 10 }; /* of its log: a fork counts as one session more for each */
