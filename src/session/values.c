/* Changes of parameters in the log and the timeline. */
#include <cjson/cJSON.h>
#include <stdlib.h>

#include "session/internal.h"

ll_status ll_change_values(const ll_sim_kind *kind, void *config, const cJSON *patch, ll_param_change *change,
                           void *context)
{
    void *before = ll_param_clone(kind->table, config, NULL);
    if (!before)
        return ll_error(LL_NO_MEMORY, "out of memory: change");
    ll_status status =
        ll_param_patch(kind->table, patch, config, change, context); /* all at once: rules may relate them */
    if (!ll_failed(&status) && kind->may_change) {
        status = kind->may_change(config, before);
        if (ll_failed(&status))
            ll_param_copy(kind->table, config, before);
    }
    if (!ll_failed(&status))
        kind->settle(config, before);
    free(before);
    return status;
}

ll_status ll_apply_values(const ll_sim_kind *kind, void *config, const char *values)
{
    cJSON *json = cJSON_Parse(values);
    if (!json)
        return ll_error(LL_NO_MEMORY, "out of memory: change");
    ll_status status = ll_change_values(kind, config, json, NULL, NULL);
    cJSON_Delete(json);
    return status;
}
