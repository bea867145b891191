/* What sessions go with: see ll_host_group. */
#include <string.h>

#include "daemon/hosting/session_entry.h"

void ll_host_set_group(ll_host *host, const ll_host_group *group)
{
    atomic_store(&host->group, group);
}

ll_status ll_host_obtain_group(ll_host *host, const char *id, ll_task *task)
{
    const ll_host_group *group = atomic_load(&host->group);
    return group ? group->obtain(group->context, id, task)
                 : ll_error(LL_UNAVAILABLE, "This daemon takes no sessions now; try again.");
}

ll_status ll_host_check_group(ll_host *host, const char *session)
{
    const ll_host_group *group = atomic_load(&host->group);
    return group && group->gives(group->context, session)
               ? ll_error(LL_UNAVAILABLE, "The session is just leaving this daemon; try again.")
               : ll_ok();
}

bool ll_host_give_group(ll_host *host, const char *id)
{
    const ll_host_group *group = atomic_load(&host->group);
    return group && group->give(group->context, id);
}
