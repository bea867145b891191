#include <cjson/cJSON.h>

#include "param/internal.h"

/* Texts and choices may be written bare; anything else that is no JSON becomes a string, which the row then
 * refuses by name. */
static cJSON *read_value(const ll_param *row, const char *value)
{
    bool bare =
        row != NULL && (row->type == LL_PARAM_TEXT || row->type == LL_PARAM_CHOICE) && value[0] != '"';
    cJSON *json = bare ? NULL : cJSON_ParseWithOpts(value, NULL, 1);
    return json != NULL ? json : cJSON_CreateString(value);
}

ll_status ll_param_set(const ll_param_table *table, void *object, const char *path, const char *value,
                       bool live_only)
{
    cJSON *patch = cJSON_CreateObject();
    cJSON *json = read_value(ll_param_find(table, object, path, NULL), value);
    if (json == NULL || !cJSON_AddItemToObject(patch, path, json)) {
        cJSON_Delete(json);
        cJSON_Delete(patch);
        return ll_error(LL_NO_MEMORY, "out of memory");
    }
    ll_status status = ll_patch_apply(table, patch, object, &(ll_patch_options){.live_only = live_only});
    cJSON_Delete(patch);
    return status;
}
