/* The paths of all numbers of a run's metrics. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

struct cJSON;

typedef struct ll_paths {
    char **items;
    size_t count, capacity;
} ll_paths;

/* Lists what ll_metric_check accepts: numbers, flags, and what was not counted. False: no memory; the list is
 * then empty. */
bool ll_paths_list(const struct cJSON *metrics, ll_paths *paths);
void ll_paths_free(ll_paths *paths); /* empties it */
