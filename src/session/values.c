/* Changes of parameters in the log and the timeline. */
#include <cjson/cJSON.h>
#include <stdlib.h>

#include "session/internal.h"

ll_status ll_apply_values(const ll_sim_kind *kind, void *config, const char *values)
{
    void *before = ll_param_clone(kind->table, config, NULL);
    cJSON *json = cJSON_Parse(values);
    ll_status status = before && json ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: change");
    if (!ll_failed(&status))
        status =
            ll_param_patch(kind->table, json, config, NULL, NULL); /* all at once: rules may relate them */
    if (!ll_failed(&status) && kind->may_change)
        status = kind->may_change(config, before);
    if (!ll_failed(&status))
        kind->settle(config, before);
    cJSON_Delete(json);
    free(before);
    return status;
}
