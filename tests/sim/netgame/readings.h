/* Readings of the metrics of a netgame, for tests: by their path, and of a distribution. cmocka.h and what it
 * needs come before. */
#pragma once

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "support/scene.h"

static inline const cJSON *at(const cJSON *metrics, const char *path)
{
    const cJSON *item = metrics;
    char name[64];
    while (item && *path) {
        size_t length = strcspn(path, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, path);
        item = cJSON_IsArray(item) ? cJSON_GetArrayItem(item, atoi(name))
                                   : cJSON_GetObjectItemCaseSensitive(item, name);
        path += length + (path[length] == '.');
    }
    return item;
}

static inline double value(const cJSON *metrics, const char *path)
{
    const cJSON *item = at(metrics, path);
    if (!cJSON_IsNumber(item))
        fail_msg("%s is no number", path);
    return item->valuedouble;
}

static inline bool is_null(const cJSON *metrics, const char *path)
{
    return cJSON_IsNull(at(metrics, path));
}

static inline ll_summary summary(const scene *s, int player, ll_metric metric)
{
    return ll_histogram_summary(&ll_netgame_client_metrics(s->game, player)->histogram[metric]);
}
