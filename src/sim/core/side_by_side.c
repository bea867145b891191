#include "sim/core/side_by_side.h"

#include <cjson/cJSON.h>
#include <stdio.h>

cJSON *ll_beside_told(const void *block, int count, cJSON *(*tell)(const void *block, int place))
{
    cJSON *o = tell(block, 0);
    cJSON *beside = count > 1 ? cJSON_AddArrayToObject(o, "beside") : NULL;
    for (int i = 1; i < count; i++)
        cJSON_AddItemToArray(beside, tell(block, i));
    return o;
}

void ll_beside_column(char out[48], int place, const char *name)
{
    if (place == 0)
        snprintf(out, 48, "%s", name);
    else
        snprintf(out, 48, "beside%d_%s", place - 1, name);
}
