#include "record/metric.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "param/param.h"

static const char *const types[LL_METRIC_TYPES] = {
    [LL_METRIC_NUMBER] = "number",   [LL_METRIC_COUNT] = "count",
    [LL_METRIC_FLAG] = "flag",       [LL_METRIC_TEXT] = "text",
    [LL_METRIC_NUMBERS] = "numbers", [LL_METRIC_DISTRIBUTION] = "distribution",
    [LL_METRIC_LATENCY] = "latency", [LL_METRIC_GAUGE] = "gauge",
    [LL_METRIC_BY_NAME] = "by_name", [LL_METRIC_CURVE] = "curve",
    [LL_METRIC_NOTICES] = "notices"};

/* ---- values ---- */

/* What was not counted is not finite: null. */
static cJSON *number_of(const ll_metric_table *t, double value)
{
    return t->short_numbers && value - value == 0 ? cJSON_CreateNumber(value) : ll_param_number(value);
}

static cJSON *list_of(const ll_metric_table *t, const ll_metric_reading *v)
{
    cJSON *list = cJSON_CreateArray();
    for (int i = 0; i < (int)v->number; i++)
        cJSON_AddItemToArray(list, number_of(t, v->numbers != NULL ? v->numbers[i] : NAN));
    return list;
}

static const char *const distribution[] = {"mean", "rms", "p50", "p95", "p99", "max", "count", NULL};
static const char *const latency[] = {"mean", "rms", "p50", "p95", "p99", "max", "count", "lost_ratio", NULL};
static const char *const gauge[] = {"mean", "min", "max", "count", NULL};

static cJSON *parts_of(const ll_metric_table *t, const char *const *names, const double *parts)
{
    cJSON *o = cJSON_CreateObject();
    for (int i = 0; names[i] != NULL; i++)
        cJSON_AddItemToObject(o, names[i], number_of(t, parts[i]));
    return o;
}

static cJSON *named_of(const ll_metric_table *t, const ll_metric_reading *v)
{
    cJSON *o = cJSON_CreateObject();
    for (int i = 0; i < (int)v->number; i++)
        cJSON_AddItemToObject(o, v->names[i], number_of(t, v->numbers[i]));
    return o;
}

static cJSON *value_json(const ll_metric_table *t, ll_metric_type type, const ll_metric_reading *v)
{
    switch (type) {
    case LL_METRIC_FLAG:
        return isnan(v->number) ? cJSON_CreateNull() : cJSON_CreateBool(v->number != 0);
    case LL_METRIC_TEXT:
        return v->text != NULL ? cJSON_CreateString(v->text) : NULL;
    case LL_METRIC_NUMBERS:
        return list_of(t, v);
    case LL_METRIC_DISTRIBUTION:
        return parts_of(t, distribution, v->parts);
    case LL_METRIC_LATENCY:
        return parts_of(t, latency, v->parts);
    case LL_METRIC_BY_NAME:
        return named_of(t, v);
    case LL_METRIC_GAUGE:
        return parts_of(t, gauge, v->parts);
    default:
        LL_ASSERT(type == LL_METRIC_NUMBER || type == LL_METRIC_COUNT);
        return number_of(t, v->number);
    }
}

void ll_metrics_put(cJSON *object, const ll_metric_table *table, const ll_metric_reading *values)
{
    for (int i = 0; i < table->count; i++) {
        cJSON *item = value_json(table, table->fields[i].type, &values[i]);
        if (item != NULL)
            cJSON_AddItemToObject(object, table->fields[i].name, item);
    }
}

/* ---- paths ---- */

/* The rest of `path` behind what `pattern` says of its beginning; NULL: it begins otherwise. */
static const char *behind(const char *path, const char *pattern)
{
    while (*pattern != '\0') {
        size_t wanted = strcspn(pattern, "."), there = strcspn(path, ".");
        bool any = wanted == 1 && pattern[0] == '*';
        if (there == 0 || (!any && (wanted != there || memcmp(path, pattern, wanted) != 0)))
            return NULL;
        path += there + (path[there] == '.');
        pattern += wanted + (pattern[wanted] == '.');
    }
    return path;
}

static bool has_parts(ll_metric_type type)
{
    return type >= LL_METRIC_NUMBERS;
}

static const ll_metric_field *field_at(const ll_metric_table *t, const char *path)
{
    path = path != NULL ? behind(path, t->path) : NULL;
    for (int i = 0; path != NULL && i < t->count; i++) {
        const char *rest = behind(path, t->fields[i].name);
        if (rest != NULL && (*rest == '\0' || has_parts(t->fields[i].type)))
            return &t->fields[i];
    }
    return NULL;
}

const ll_metric_field *ll_metric_find(const ll_metric_table *const *tables, const char *path)
{
    for (; tables != NULL && *tables != NULL; tables++) {
        const ll_metric_field *field = field_at(*tables, path);
        if (field == NULL && (*tables)->also != NULL)
            field = field_at(*tables, behind(path, (*tables)->also));
        if (field != NULL)
            return field;
    }
    return NULL;
}

/* ---- as JSON ---- */

static void put_text(cJSON *o, const char *name, const char *text)
{
    if (text != NULL)
        cJSON_AddStringToObject(o, name, text);
}

static const char *const tails[LL_TAILS] = {[LL_TAIL_LONG] = "long", [LL_TAIL_EXTREME] = "extreme"};

static cJSON *field_json(const ll_metric_field *f)
{
    cJSON *o = cJSON_CreateObject();
    cJSON_AddStringToObject(o, "name", f->name);
    cJSON_AddStringToObject(o, "type", types[f->type]);
    put_text(o, "unit", f->unit);
    if (f->is_signed)
        cJSON_AddTrueToObject(o, "signed");
    if (f->is_rate)
        cJSON_AddTrueToObject(o, "rate");
    if (f->rare)
        cJSON_AddTrueToObject(o, "rare");
    if (f->tail != LL_TAIL_LIGHT)
        cJSON_AddStringToObject(o, "tail", tails[f->tail]);
    cJSON_AddStringToObject(o, "help", f->help);
    put_text(o, "null", f->null);
    return o;
}

cJSON *ll_metrics_schema(const ll_metric_table *const *tables)
{
    cJSON *list = cJSON_CreateArray();
    for (; tables != NULL && *tables != NULL; tables++) {
        cJSON *o = cJSON_CreateObject(), *fields;
        cJSON_AddStringToObject(o, "path", (*tables)->path);
        put_text(o, "also", (*tables)->also);
        put_text(o, "when", (*tables)->when);
        cJSON_AddStringToObject(o, "help", (*tables)->help);
        fields = cJSON_AddArrayToObject(o, "metrics");
        for (int i = 0; i < (*tables)->count; i++)
            cJSON_AddItemToArray(fields, field_json(&(*tables)->fields[i]));
        cJSON_AddItemToArray(list, o);
    }
    return list;
}
