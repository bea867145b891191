#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

/* The later of two of the same path counts. */
static ll_status add(cJSON *patch, const char *path, const char *value)
{
    cJSON *text = cJSON_CreateString(value);
    cJSON_DeleteItemFromObjectCaseSensitive(patch, path);
    if (text != NULL && cJSON_AddItemToObject(patch, path, text))
        return ll_ok();
    cJSON_Delete(text);
    return ll_error(LL_NO_MEMORY, "out of memory");
}

static ll_status add_pair(cJSON *patch, const char *set)
{
    char path[256];
    size_t length = strcspn(set, "=");
    if (length == 0 || set[length] == '\0' || length >= sizeof path)
        return ll_error(LL_BAD_INPUT, "--set takes path=value; got %.100s", set);
    memcpy(path, set, length);
    path[length] = '\0';
    return add(patch, path, set + length + 1);
}

ll_status ll_param_set(const ll_param_table *table, void *object, const char *path, const char *value,
                       bool live_only)
{
    cJSON *patch = cJSON_CreateObject();
    ll_status status = add(patch, path, value);
    LL_THEN(status,
            ll_patch_apply(table, patch, object, &(ll_patch_options){.live_only = live_only, .texts = true}));
    cJSON_Delete(patch);
    return status;
}

ll_status ll_param_put(const ll_param_table *table, void *object, const char *const *sets, int count)
{
    cJSON *patch = cJSON_CreateObject();
    ll_status status = ll_ok();
    for (int i = 0; i < count && !ll_failed(&status); i++)
        status = add_pair(patch, sets[i]);
    LL_THEN(status,
            ll_patch_apply(table, patch, object, &(ll_patch_options){.unchecked = true, .texts = true}));
    cJSON_Delete(patch);
    return status;
}

ll_status ll_param_check(const ll_param_table *table, const void *object)
{
    return ll_run_checks(table, object);
}
