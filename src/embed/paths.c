#include "embed/paths.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { PATH_SIZE = 256 };

static bool append(ll_paths *paths, const char *path)
{
    if (paths->count == paths->capacity) {
        size_t capacity = paths->capacity ? 2 * paths->capacity : 256;
        char **items = realloc(paths->items, capacity * sizeof *items);
        if (!items)
            return false;
        paths->items = items;
        paths->capacity = capacity;
    }
    char *copy = strdup(path);
    if (copy)
        paths->items[paths->count++] = copy;
    return copy != NULL;
}

/* Metrics are at most LL_JSON_DEPTH deep, so this ends. `path` is of PATH_SIZE bytes. */
static bool walk(const cJSON *at, ll_paths *paths, char *path, size_t used)
{
    if (cJSON_IsNumber(at) || cJSON_IsRaw(at) || cJSON_IsBool(at) || cJSON_IsNull(at))
        return append(paths, path);
    const cJSON *part;
    int index = 0;
    cJSON_ArrayForEach(part, at)
    {
        char number[16];
        snprintf(number, sizeof number, "%d", index++);
        int size = snprintf(path + used, PATH_SIZE - used, "%s%s", used ? "." : "",
                            cJSON_IsArray(at) ? number : part->string);
        if (size < PATH_SIZE - (int)used && !walk(part, paths, path, used + (size_t)size))
            return false;
        path[used] = '\0';
    }
    return true;
}

bool ll_paths_list(const cJSON *metrics, ll_paths *paths)
{
    char path[PATH_SIZE] = "";
    if (metrics && walk(metrics, paths, path, 0))
        return true;
    ll_paths_free(paths);
    return false;
}

void ll_paths_free(ll_paths *paths)
{
    for (size_t i = 0; i < paths->count; i++)
        free(paths->items[i]);
    free(paths->items);
    *paths = (ll_paths){0};
}
