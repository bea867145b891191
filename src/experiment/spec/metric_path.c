#include "experiment/spec/metric_path.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/run_status.h"
#include "experiment/spec/window.h"

/* The value of the path's first name, which is copied to `name`; `*path` is moved to the remaining path, or
 * its end. */
static const cJSON *metric_step(const cJSON *metrics, const char **path, char name[64])
{
    size_t length = strcspn(*path, ".");
    snprintf(name, 64, "%.*s", (int)length, *path);
    char *end;
    long index = strtol(name, &end, 10);
    *path += length + ((*path)[length] == '.');
    return cJSON_IsArray(metrics) && end != name && *end == '\0' && index >= 0
               ? cJSON_GetArrayItem(metrics, (int)index)
               : cJSON_GetObjectItemCaseSensitive(metrics, name);
}

static const cJSON *metric_at(const cJSON *metrics, const char *path, char *reached, int size,
                              const char **missing)
{
    reached[0] = '\0';
    for (;;) {
        char name[64];
        *missing = path;
        const cJSON *next = metric_step(metrics, &path, name);
        if (!next)
            return NULL;
        size_t used = strlen(reached);
        snprintf(reached + used, (size_t)size - used, "%s%s", used ? "." : "", name);
        metrics = next;
        if (*path == '\0')
            return metrics;
    }
}

/* The error for a wrong path: lists names that exist there, as many as fit. */
static ll_status no_metric(const cJSON *metrics, const char *field, const char *path)
{
    char reached[160], names[120] = "", found[160];
    const char *missing;
    const cJSON *at = metric_at(metrics, path, reached, sizeof reached, &missing), *item;
    if (!at)
        at = reached[0] ? metric_at(metrics, reached, found, sizeof found, &missing) : metrics;
    if (cJSON_IsArray(at))
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: the scenario has no metric %s; %s has %d elements, from 0", field, path,
                              reached, cJSON_GetArraySize(at));
    cJSON_ArrayForEach(item, at)
    {
        size_t used = strlen(names);
        if (used + strlen(item->string) + sizeof ", " + sizeof ", ..." > sizeof names) {
            strcat(names, ", ...");
            break;
        }
        snprintf(names + used, sizeof names - used, "%s%s", used ? ", " : "", item->string);
    }
    if (names[0] == '\0')
        return ll_field_error(LL_BAD_INPUT, field, "%s: %s is not a number", field, path);
    return ll_field_error(LL_BAD_INPUT, field, "%s: the scenario has no metric %s; %s has %s", field, path,
                          reached[0] ? reached : "it", names);
}

static bool is_number(const cJSON *item)
{
    return cJSON_IsNumber(item) || cJSON_IsRaw(item) || cJSON_IsBool(item);
}

ll_status ll_metric_check(const cJSON *metrics, const char *field, const char *path)
{
    char reached[160];
    const char *missing;
    const cJSON *found = metric_at(metrics, path, reached, sizeof reached, &missing);
    return found && (is_number(found) || cJSON_IsNull(found)) ? ll_ok() : no_metric(metrics, field, path);
}

const cJSON *ll_metric_at(const cJSON *metrics, const char *path)
{
    char reached[160];
    const char *missing;
    return metric_at(metrics, path, reached, sizeof reached, &missing);
}

double ll_metric_value(const cJSON *metrics, const char *path)
{
    const cJSON *item = ll_metric_at(metrics, path);
    return cJSON_IsBool(item) ? cJSON_IsTrue(item) : is_number(item) ? item->valuedouble : NAN;
}

const cJSON *ll_metric_failed_part(const cJSON *metrics, const char *path, char *where, int size)
{
    where[0] = '\0';
    for (const cJSON *part = metrics; part != NULL;) {
        char name[64];
        const cJSON *status = cJSON_GetObjectItemCaseSensitive(part, "status");
        if (cJSON_IsString(status) && strcmp(status->valuestring, ll_run_status_names[LL_RUN_OK]) != 0)
            return part;
        if (*path == '\0')
            break;
        part = metric_step(part, &path, name);
        size_t used = strlen(where);
        snprintf(where + used, (size_t)size - used, "%s%s", used ? "." : "", name);
    }
    where[0] = '\0';
    return NULL;
}

/* The column of a trace that `path` begins with, such as player_0_own_lead_m.mean; NULL: none. */
static const ll_metric_field *column_at(const ll_metric_table *t, const char *path)
{
    size_t before = strcspn(t->path, "*"), digits;
    if (strncmp(path, t->path, before) != 0)
        return NULL;
    path += before;
    if (t->path[before] == '*') {
        const char *after = t->path + before + 1;
        digits = strspn(path, "0123456789");
        if (digits == 0 || strncmp(path + digits, after, strlen(after)) != 0)
            return NULL;
        path += digits + strlen(after);
    }
    size_t length = strcspn(path, ".");
    for (int i = 0; i < t->count; i++)
        if (strlen(t->fields[i].name) == length && memcmp(t->fields[i].name, path, length) == 0)
            return &t->fields[i];
    return NULL;
}

/* The field of a metric, also of one in a window. `bare` is set to the path without the window. */
static const ll_metric_field *field_of(const ll_sim_kind *kind, const char *path,
                                       char bare[LL_WINDOW_PATH_MAX + 8])
{
    snprintf(bare, LL_WINDOW_PATH_MAX + 8, "%.*s", (int)strcspn(path, "@"), path);
    const ll_metric_field *field = ll_metric_find(kind->metric_tables, bare);
    const ll_metric_table *const *t = strchr(path, '@') ? kind->trace_tables : NULL;
    for (; t && *t && !field; t++)
        field = column_at(*t, bare);
    return field;
}

bool ll_metric_is_signed(const ll_sim_kind *kind, const char *path)
{
    char bare[LL_WINDOW_PATH_MAX + 8];
    const ll_metric_field *field = field_of(kind, path, bare);
    return field != NULL && field->is_signed;
}

static bool ends_in(const char *path, const char *end)
{
    size_t size = strlen(path), n = strlen(end);
    return size >= n && strcmp(path + size - n, end) == 0;
}

bool ll_metric_is_cost(const char *path)
{
    return strcmp(path, "cost.ns_per_sim_s") == 0;
}

bool ll_metric_is_rate(const char *path)
{
    return ends_in(path, "_per_s");
}

ll_metric_scale ll_metric_scale_of(const ll_sim_kind *kind, const cJSON *metrics, const char *path)
{
    char bare[LL_WINDOW_PATH_MAX + 8];
    const ll_metric_field *field = field_of(kind, path, bare);
    bool is_windowed = strchr(path, '@') != NULL;
    char reached[160];
    const char *missing;
    path = bare;
    if (cJSON_IsBool(metric_at(metrics, path, reached, sizeof reached, &missing)))
        return LL_SCALE_FLAG;
    /* How long a window was differs from run to run: a rate in it is no count over a known time. */
    if (kind->no_rare_events || ll_metric_is_cost(path) || (is_windowed && ll_metric_is_rate(path)))
        return LL_SCALE_AMOUNT;
    if (field != NULL && field->rare)
        return LL_SCALE_COUNT;
    if (ends_in(path, ".max") || ends_in(path, "_max") || ends_in(path, ".p99"))
        return LL_SCALE_EXTREME;
    if (field == NULL || field->tail == LL_TAIL_LIGHT || ends_in(path, ".count"))
        return LL_SCALE_AMOUNT;
    bool of_mean = ends_in(path, ".mean") || ends_in(path, ".p50");
    return field->tail == LL_TAIL_LONG && of_mean ? LL_SCALE_TAILED : LL_SCALE_EXTREME;
}
