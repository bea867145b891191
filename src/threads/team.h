/* Makes a team of threads (base/team.h).
 *
 * A job is short, some microseconds, and the next one follows soon: threads wait by polling for about 50 us
 * before they sleep. A team belongs to one thread at a time, the one that gives it jobs. */
#pragma once

#include "base/status.h"
#include "base/team.h"

/* `parts`: threads, the caller's included, 1 to LL_TEAM_PARTS_MAX. The caller owns the team. */
ll_status ll_team_make(int parts, ll_team **out);
void ll_team_free(ll_team *team); /* NULL is fine */
