/* Notices for readers of a table of results. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "experiment/format/table_internal.h"

void ll_table_note(ll_result_table *t, const ll_row *row)
{
    if (!ll_row_good(row))
        return;
    t->made++;
    for (int i = 0; i < t->experiment->metric_count; i++)
        t->has[i] += isfinite(row->metrics[i]) ? 1 : 0;
}

cJSON *ll_result_table_notices(const ll_result_table *t)
{
    const ll_experiment *e = t->experiment;
    cJSON *notices = cJSON_CreateArray();
    char text[400];
    for (int i = 0; i < e->metric_count && t->made > 0; i++) {
        if (t->has[i] > 0)
            continue;
        snprintf(text, sizeof text, "No run has %s: it is null in all %" PRId64 ".", e->metrics[i], t->made);
        cJSON_AddItemToArray(notices, cJSON_CreateString(text));
    }
    if (t->unreached > 0) {
        snprintf(
            text, sizeof text,
            "At %" PRId64 " of %" PRId64 " points all %" PRId64
            " repeats were made, but the interval of %s is still wider than `until` requires, or missing.",
            t->unreached, e->points, e->head.repeats, e->metrics[e->until_metric]);
        cJSON_AddItemToArray(notices, cJSON_CreateString(text));
    }
    return notices;
}
