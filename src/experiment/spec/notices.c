/* Reasons why metrics will be null, as far as they are known before the runs. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>

#include "experiment/spec/experiment.h"

enum { POINTS_MOST = 32 /* points that are checked: clients poll experiments often */ };

/* The kind's notices of a point; NULL: none. */
static cJSON *of_point(const ll_experiment *e, int64_t point)
{
    ll_scenario scenario = {0};
    cJSON *notices = NULL;
    ll_status status = ll_experiment_open(e, point * e->head.repeats, &scenario);
    if (!ll_failed(&status))
        notices = scenario.kind->notices(scenario.config);
    ll_scenario_free(&scenario);
    if (cJSON_GetArraySize(notices) == 0) {
        cJSON_Delete(notices);
        notices = NULL;
    }
    return notices;
}

/* Adds the number of affected points, unless all are. */
static cJSON *count_notice(const char *notice, int64_t found, int64_t checked)
{
    char text[600];
    if (found == checked)
        return cJSON_CreateString(notice);
    snprintf(text, sizeof text, "At %" PRId64 " of %" PRId64 " checked points: %s", found, checked, notice);
    return cJSON_CreateString(text);
}

cJSON *ll_experiment_notices(const ll_experiment *e)
{
    cJSON *notices = cJSON_CreateArray(), *first = NULL;
    int64_t found = 0, checked = e->points < POINTS_MOST ? e->points : POINTS_MOST;
    for (int64_t p = 0; e->base.kind->notices && p < checked; p++) {
        cJSON *here = of_point(e, p * (e->points / checked));
        found += here != NULL;
        if (first)
            cJSON_Delete(here);
        else
            first = here;
    }
    const cJSON *item;
    cJSON_ArrayForEach(item, first)
        cJSON_AddItemToArray(notices, count_notice(item->valuestring, found, checked));
    cJSON_Delete(first);
    return notices;
}
