#include "sim/core/side_by_side.h"

#include <cjson/cJSON.h>
#include <stdio.h>

cJSON *ll_side_by_side_report(const void *block, int count, cJSON *(*tell)(const void *block, int place))
{
    cJSON *o = tell(block, 0);
    cJSON *others = count > 1 ? cJSON_AddArrayToObject(o, "side_by_side") : NULL;
    for (int i = 1; i < count; i++)
        cJSON_AddItemToArray(others, tell(block, i));
    return o;
}

void ll_side_by_side_column(char out[48], int place, const char *name)
{
    if (place == 0)
        snprintf(out, 48, "%s", name);
    else
        snprintf(out, 48, "side_by_side%d_%s", place - 1, name);
}
