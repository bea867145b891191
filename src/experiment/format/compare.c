#include "experiment/format/compare.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* `path=value` up to a comma. */
typedef struct wanted {
    char path[LL_EXPERIMENT_PATH_MAX + 8], value[128];
} wanted;

static bool is_value(const cJSON *value, const char *text)
{
    char *end;
    if (cJSON_IsString(value))
        return strcmp(value->valuestring, text) == 0;
    if (cJSON_IsBool(value))
        return strcmp(cJSON_IsTrue(value) ? "true" : "false", text) == 0;
    double number = strtod(text, &end);
    return end != text && *end == '\0' && value && value->valuedouble == number;
}

static ll_status read_wanted(const ll_experiment *e, const char *field, const char *text,
                             wanted list[LL_EXPERIMENT_AXES_MAX], int *count)
{
    *count = 0;
    while (*text) {
        size_t size = strcspn(text, ","), path = strcspn(text, "=");
        wanted *w = &list[*count];
        if (*count == LL_EXPERIMENT_AXES_MAX || path >= size || path >= sizeof w->path ||
            size - path > sizeof w->value)
            break;
        snprintf(w->path, sizeof w->path, "%.*s", (int)path, text);
        snprintf(w->value, sizeof w->value, "%.*s", (int)(size - path - 1), text + path + 1);
        bool known = false;
        for (int a = 0; a < e->axis_count; a++)
            known |= strcmp(e->axes[a].path, w->path) == 0;
        if (!known)
            return ll_field_error(LL_BAD_INPUT, field, "%s: %s is not on an axis of the experiment", field,
                                  w->path);
        (*count)++;
        text += size + (text[size] == ',');
    }
    if (*text || *count == 0)
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: must be first, the number of a point, or values of axes such as "
                              "players.0.lag_ms=100; got %.60s",
                              field, text);
    return ll_ok();
}

static bool has_all(const ll_experiment *e, int64_t point, const wanted *list, int count)
{
    bool all = true;
    cJSON *values = ll_experiment_point(e, point);
    for (int i = 0; i < count && all; i++)
        all = is_value(cJSON_GetObjectItemCaseSensitive(values, list[i].path), list[i].value);
    cJSON_Delete(values);
    return all;
}

ll_status ll_compare_point(const ll_experiment *e, const char *field, const char *text, int64_t *point)
{
    char *end;
    wanted list[LL_EXPERIMENT_AXES_MAX];
    int count;
    *point = 0;
    if (strcmp(text, "first") == 0)
        return ll_ok();
    errno = 0;
    *point = strtoll(text, &end, 10);
    if (end != text && *end == '\0') {
        if (!errno && *point >= 0 && *point < e->points)
            return ll_ok();
        return ll_field_error(LL_BAD_INPUT, field, "%s: must be a point from 0 to %lld; got %.40s", field,
                              (long long)(e->points - 1), text);
    }
    LL_TRY(read_wanted(e, field, text, list, &count));
    for (*point = 0; *point < e->points; (*point)++)
        if (has_all(e, *point, list, count))
            return ll_ok();
    return ll_field_error(LL_BAD_INPUT, field, "%s: no point has %.100s", field, text);
}

ll_status ll_compare_rows(const ll_experiment *e, int64_t point, ll_row_source *source, void *context,
                          ll_row **rows, int64_t *count)
{
    ll_row row;
    ll_status status = ll_ok();
    *count = 0;
    *rows = malloc((size_t)e->head.repeats * sizeof **rows);
    if (!*rows)
        return ll_error(LL_NO_MEMORY, "out of memory: baseline");
    while (*count < e->head.repeats && source(context, &row, &status) && row.run / e->head.repeats == point)
        (*rows)[(*count)++] = row;
    if (ll_failed(&status)) {
        free(*rows);
        *rows = NULL;
    }
    return status;
}
