/* Changes of parameters in the log and the timeline. */
#include <cjson/cJSON.h>
#include <stdlib.h>

#include "session/internal.h"

ll_status ll_apply_values(const ll_sim_kind *kind, void *config, const char *values)
{
    void *before = calloc(1, kind->table->size);
    cJSON *json = cJSON_Parse(values);
    ll_status status = before && json ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: change");
    if (before)
        ll_param_copy(kind->table, before, config);
    if (!ll_failed(&status))
        status =
            ll_param_patch(kind->table, json, config, NULL, NULL); /* all at once: rules may relate them */
    if (!ll_failed(&status))
        kind->settle(config, before);
    cJSON_Delete(json);
    free(before);
    return status;
}
