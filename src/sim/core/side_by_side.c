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

void ll_side_by_side_trace(ll_trace_line *trace, int place)
{
    trace->prefix[0] = '\0';
    if (place > 0)
        snprintf(trace->prefix, sizeof trace->prefix, "side_by_side%d_", place - 1);
}
