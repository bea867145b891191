/* What is known before any run of why metrics will be null. */
#include <cjson/cJSON.h>
#include <inttypes.h>
#include <stdio.h>

#include "experiment/spec/experiment.h"

enum { POINTS_MOST = 32 /* that are looked at, since who watches an experiment asks often */ };

/* The kind's sentences of a point; NULL: there are none. */
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

/* At how many of the points that were looked at, where it is not all. */
static cJSON *told(const char *notice, int64_t found, int64_t looked)
{
    char text[600];
    if (found == looked)
        return cJSON_CreateString(notice);
    snprintf(text, sizeof text, "At %" PRId64 " of %" PRId64 " points that were looked at: %s", found, looked,
             notice);
    return cJSON_CreateString(text);
}

cJSON *ll_experiment_notices(const ll_experiment *e)
{
    cJSON *notices = cJSON_CreateArray(), *first = NULL;
    int64_t found = 0, looked = e->points < POINTS_MOST ? e->points : POINTS_MOST;
    for (int64_t p = 0; e->base.kind->notices && p < looked; p++) {
        cJSON *here = of_point(e, p * (e->points / looked));
        found += here != NULL;
        if (first)
            cJSON_Delete(here);
        else
            first = here;
    }
    const cJSON *item;
    cJSON_ArrayForEach(item, first) cJSON_AddItemToArray(notices, told(item->valuestring, found, looked));
    cJSON_Delete(first);
    return notices;
}
