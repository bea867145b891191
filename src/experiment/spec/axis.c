#include "experiment/spec/axis.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"

/* ---- the table ---- */

static const char *const scales[] = {"linear", "log", NULL};

typedef struct settings {
    char path[LL_AXIS_PATH_MAX + 8];
    double from, to;
    int64_t count;
    int32_t scale, reserved;
} settings;

static const ll_param rows[] = {
    {LL_PARAM_ROW("path", TEXT, settings, path), .min = 1, .max = LL_AXIS_PATH_MAX, .required = true,
     .help = "Path of the parameter, such as players.0.lag_ms."},
    {LL_PARAM_ROW("from", REAL, settings, from), .min = -1e15, .max = 1e15,
     .help = "First value of a range."},
    {LL_PARAM_ROW("to", REAL, settings, to), .min = -1e15, .max = 1e15, .help = "Last value of a range."},
    {LL_PARAM_ROW("count", INT, settings, count), .min = 1, .max = LL_AXIS_VALUES_MAX, .default_value = 1,
     .help = "Number of values of a range, both ends included."},
    {LL_PARAM_ROW("scale", CHOICE, settings, scale), .choices = scales,
     .help = "Spacing of a range: equal differences or equal ratios."},
};

static const ll_param_table table = {.name = "axis",
                                     .help = "Values of one parameter: a list in `values`, or a range.",
                                     LL_PARAM_ROWS(rows, settings)};

cJSON *ll_axis_schema(void)
{
    return ll_param_schema(&table);
}

/* ---- columns ---- */

ll_cell_type ll_axis_type(const ll_param *row)
{
    switch (row->type) {
    case LL_PARAM_REAL:
        return LL_CELL_REAL;
    case LL_PARAM_INT:
        return LL_CELL_INT;
    case LL_PARAM_BOOL:
        return LL_CELL_BOOL;
    default:
        return LL_CELL_TEXT;
    }
}

static bool ends_in_unit(const char *path)
{
    static const char *const ends[] = {"ms",  "s",     "hz", "pct",  "m",     "mps",  "mps2",
                                       "rad", "radps", "kg", "kbps", "bytes", "ticks"};
    const char *last = strrchr(path, '_');
    for (size_t i = 0; last && i < sizeof ends / sizeof ends[0]; i++)
        if (strcmp(last + 1, ends[i]) == 0)
            return true;
    return false;
}

void ll_axis_column(const char *path, const char *unit, char *name, int size)
{
    int used = snprintf(name, (size_t)size, "%s%s", path, unit && !ends_in_unit(path) ? "_" : "");
    if (!unit || ends_in_unit(path))
        return;
    if (unit[0] == '1' && unit[1] == '/')
        unit++;
    for (const char *p = unit; *p && used < size - 5; p++)
        if (*p == '/')
            used += snprintf(name + used, (size_t)(size - used), "%sper_", p == unit ? "" : "_");
        else
            used += snprintf(name + used, (size_t)(size - used), "%c", *p == ' ' ? '_' : *p);
}

/* ---- values ---- */

static double between(const ll_axis *a, double from, double to, double position)
{
    return a->scale ? from * ll_exp(ll_detmath_log(to / from) * position) : from + (to - from) * position;
}

/* All whole numbers are equally likely in a linear range; in a logarithmic one each has the part of the range
 * that is rounded to it, the ends included. */
static double whole_sample(const ll_axis *a, double position)
{
    double from = floor(a->from + 0.5), to = floor(a->to + 0.5), side = to < from ? -0.5 : 0.5;
    double value = floor(between(a, from - side, to + side, position) + 0.5);
    return fmin(fmax(value, fmin(from, to)), fmax(from, to));
}

cJSON *ll_axis_sample(const ll_axis *a, double position)
{
    if (!a->sampled) {
        int64_t k = (int64_t)(position * (double)a->count);
        return ll_axis_at(a, k < a->count ? k : a->count - 1);
    }
    return ll_param_number(a->type == LL_CELL_INT ? whole_sample(a, position)
                                                  : between(a, a->from, a->to, position));
}

cJSON *ll_axis_at(const ll_axis *a, int64_t k)
{
    if (a->values) {
        cJSON *copy = cJSON_Duplicate(cJSON_GetArrayItem(a->values, (int)k), true);
        if (copy) {
            free(copy->string);
            copy->string = NULL;
        }
        return copy;
    }
    if (k == a->count - 1 && k > 0) /* exactly */
        return ll_param_number(a->type == LL_CELL_INT ? floor(a->to + 0.5) : a->to);
    double value = between(a, a->from, a->to, a->count > 1 ? (double)k / (double)(a->count - 1) : 0);
    return ll_param_number(a->type == LL_CELL_INT ? floor(value + 0.5) : value);
}

/* ---- reading ---- */

static ll_status below(const char *field, const ll_status *status)
{
    char path[200];
    snprintf(path, sizeof path, "%s%s%s", field, status->field[0] ? "." : "", status->field);
    return ll_field_error(LL_BAD_INPUT, path, "%s: %s", field, status->text);
}

static ll_status check_shape(const cJSON *json, const char *field, bool sampled)
{
    bool list = cJSON_HasObjectItem(json, "values");
    bool from = cJSON_HasObjectItem(json, "from"), to = cJSON_HasObjectItem(json, "to");
    const cJSON *values = cJSON_GetObjectItemCaseSensitive(json, "values");
    if (!cJSON_IsObject(json))
        return ll_field_error(LL_BAD_INPUT, field,
                              "%s: must be an object with path and values, or path, from, to and count",
                              field);
    if (list && (from || to || cJSON_HasObjectItem(json, "count")))
        return ll_field_error(LL_BAD_INPUT, field, "%s: must have either values or a range", field);
    if (!list && !(from && to && (sampled || cJSON_HasObjectItem(json, "count"))))
        return ll_field_error(LL_BAD_INPUT, field, "%s: must have values, or from, to%s", field,
                              sampled ? "" : " and count");
    if (list && !cJSON_IsArray(values))
        return ll_field_error(LL_BAD_INPUT, field, "%s.values: must be an array", field);
    int count = cJSON_GetArraySize(values);
    if (list && (count == 0 || count > LL_AXIS_VALUES_MAX))
        return ll_field_error(LL_BAD_INPUT, field, "%s.values: must have 1 to %d values; got %d", field,
                              LL_AXIS_VALUES_MAX, count);
    return ll_ok();
}

/* A rule that relates the value to other parameters may refuse it here and accept it with another axis'
 * value, so only errors of the field itself count. */
static ll_status check_value(const ll_axis *a, cJSON *value, const ll_param_table *scenario, void *copy)
{
    cJSON *patch = cJSON_CreateObject();
    cJSON_AddItemToObject(patch, a->path, value);
    ll_status status = ll_param_merge(scenario, patch, copy);
    cJSON_Delete(patch);
    if (status.code == LL_BAD_INPUT)
        status = strcmp(status.field, a->path) == 0 ? below(a->field, &status) : ll_ok();
    return status;
}

/* Every value alone, on a copy of the configuration. */
ll_status ll_axis_check_values(const ll_axis *a, const ll_param_table *scenario, const void *config,
                               const ll_interrupt *interrupt)
{
    cJSON *patch = cJSON_CreateObject(), *item = a->values ? a->values->child : NULL;
    cJSON_AddNullToObject(patch, a->path);
    void *copy = ll_param_clone(scenario, config, patch);
    cJSON_Delete(patch);
    ll_status status = copy ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: scenario");
    ll_pace pace = ll_pace_by(interrupt, 1);
    for (int64_t k = 0; k < a->count && !ll_failed(&status); k++) {
        cJSON *value = item         ? cJSON_Duplicate(item, true)
                       : a->sampled ? ll_axis_sample(a, (double)k)
                                    : ll_axis_at(a, k);
        status = check_value(a, value, scenario, copy);
        ll_param_copy(scenario, copy, config);
        item = item ? item->next : NULL;
        if (!ll_failed(&status) && !ll_goes_on(&pace))
            status =
                ll_error(LL_INTERRUPTED, "interrupted after %lld values of %s", (long long)k + 1, a->field);
    }
    free(copy);
    return status;
}

static ll_status check_path(const ll_axis *a, const char *field, const ll_param_table *scenario, void *config,
                            const ll_param **row)
{
    *row = ll_param_find(scenario, config, a->path, NULL);
    if (!*row) { /* the patch of an unknown path returns the message */
        cJSON *patch = cJSON_CreateObject();
        cJSON_AddNullToObject(patch, a->path);
        ll_status status = ll_param_merge(scenario, patch, config);
        cJSON_Delete(patch);
        ll_status count_notice = below(field, &status);
        char path[80];
        snprintf(path, sizeof path, "%s.path", field);
        return ll_field_error(LL_BAD_INPUT, path, "%s", count_notice.text);
    }
    if ((*row)->type >= LL_PARAM_OBJECT || (*row)->type == LL_PARAM_JSON)
        return ll_field_error(LL_BAD_INPUT, field, "%s.path: must be one value; %s is an object or an array",
                              field, a->path);
    if (strcmp(a->path, "seed") == 0)
        return ll_field_error(LL_BAD_INPUT, field, "%s.path: must not be seed: repeats use ascending seeds",
                              field);
    if (strcmp(a->path, "kind") == 0)
        return ll_field_error(LL_BAD_INPUT, field, "%s.path: must not be kind", field);
    return ll_ok();
}

static ll_status check_range(const ll_axis *a, const char *field)
{
    if (a->type != LL_CELL_REAL && a->type != LL_CELL_INT)
        return ll_field_error(LL_BAD_INPUT, field, "%s: %s is not a number: must have values, not a range",
                              field, a->path);
    if (a->scale == 1 && !(a->from > 0 && a->to > 0))
        return ll_field_error(LL_BAD_INPUT, field, "%s: log range must be above 0 at both ends; got %g to %g",
                              field, a->from, a->to);
    return ll_ok();
}

ll_status ll_axis_parse(const cJSON *json, const char *field, bool sampled, const ll_param_table *scenario,
                        const void *config, ll_axis *a)
{
    settings s;
    const ll_param *row = NULL;
    *a = (ll_axis){0};
    LL_TRY(check_shape(json, field, sampled));
    cJSON *rest = cJSON_Duplicate(json, true);
    a->values = cJSON_DetachItemFromObjectCaseSensitive(rest, "values");
    ll_param_defaults(&table, &s);
    ll_status status = ll_param_parse(&table, rest, &s);
    cJSON_Delete(rest);
    if (ll_failed(&status)) {
        ll_axis_free(a);
        return below(field, &status);
    }
    memcpy(a->path, s.path, sizeof a->path);
    snprintf(a->field, sizeof a->field, "%s", field);
    a->from = s.from;
    a->to = s.to;
    a->scale = s.scale;
    a->sampled = sampled && !a->values && !cJSON_HasObjectItem(json, "count");
    a->count = a->values ? cJSON_GetArraySize(a->values) : a->sampled ? 2 : s.count;
    void *copy = malloc(scenario->size);
    if (!copy)
        status = ll_error(LL_NO_MEMORY, "out of memory: scenario");
    else
        memcpy(copy, config, scenario->size);
    LL_THEN(status, check_path(a, field, scenario, copy, &row));
    free(copy);
    if (!ll_failed(&status)) {
        a->type = ll_axis_type(row);
        if (!a->values)
            status = check_range(a, field);
    }
    if (ll_failed(&status))
        ll_axis_free(a);
    return status;
}

void ll_axis_free(ll_axis *a)
{
    cJSON_Delete(a->values);
    a->values = NULL;
}
