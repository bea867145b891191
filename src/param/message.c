#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

#define LIST_SHOWN 130 /* bytes of a list of names */
#define VALUE_SHOWN 40

static bool is_pair(const cJSON *json)
{
    return cJSON_IsArray(json) && cJSON_GetArraySize(json) == 2 && cJSON_IsNumber(json->child) &&
           cJSON_IsNumber(json->child->next);
}

static void append_value(ll_writer *writer, const cJSON *json)
{
    if (cJSON_IsString(json)) {
        ll_append(writer, "\"");
        ll_append_printable(writer, json->valuestring, strlen(json->valuestring), VALUE_SHOWN);
        ll_append(writer, "\"");
    } else if (cJSON_IsNumber(json)) {
        char number[32];
        ll_number_text(json->valuedouble, number);
        ll_append(writer, "%s", number);
    } else if (is_pair(json)) {
        char x[32], y[32];
        ll_number_text(json->child->valuedouble, x);
        ll_number_text(json->child->next->valuedouble, y);
        ll_append(writer, "[%s, %s]", x, y);
    } else if (cJSON_IsObject(json) || cJSON_IsArray(json)) {
        ll_append(writer, "an %s", cJSON_IsObject(json) ? "object" : "array");
    } else if (cJSON_IsRaw(json)) {
        ll_append_printable(writer, json->valuestring, strlen(json->valuestring), VALUE_SHOWN);
    } else {
        ll_append(writer, "%s", cJSON_IsTrue(json) ? "true" : cJSON_IsFalse(json) ? "false" : "null");
    }
}

ll_status ll_wrong_type(const ll_path *path, const char *expected, const cJSON *got)
{
    char value[96];
    append_value(&(ll_writer){value, sizeof value, 0}, got);
    return ll_field_error(LL_BAD_INPUT, path->text, "%s: must be %s; got %s", ll_path_subject(path), expected,
                          value);
}

/* "0 to 1000 ms" */
static void append_range(ll_writer *writer, double min, double max, const char *unit)
{
    char low[32], high[32];
    ll_number_text(min, low);
    ll_number_text(max, high);
    bool from = min > -1e300, to = max < 1e300; /* a row without a limit */
    if (from && to)
        ll_append(writer, "%s to %s", low, high);
    else
        ll_append(writer, "%s%s",
                  from ? "at least "
                  : to ? "at most "
                       : "finite",
                  from ? low
                  : to ? high
                       : "");
    if (unit != NULL)
        ll_append(writer, " %s", unit);
}

ll_status ll_out_of_range(const ll_path *path, const ll_param *row, const cJSON *got)
{
    char range[96];
    ll_writer writer = {range, sizeof range, 0};
    double min = row->min, max = row->max;
    if (row->type == LL_PARAM_INT) {
        ll_append(&writer, "a whole number from ");
        min = min < -LL_WHOLE_MAX ? -LL_WHOLE_MAX : min;
        max = max > LL_WHOLE_MAX ? LL_WHOLE_MAX : max;
    }
    append_range(&writer, min, max, row->unit);
    return ll_wrong_type(path, range, got);
}

/* "a, b, c"; a long list ends in "..." */
static void append_names(ll_writer *writer, const char *(*name)(const void *, int), const void *context,
                         int count)
{
    for (int i = 0; i < count; i++) {
        const char *text = name(context, i);
        if (writer->used + strlen(", ") + strlen(text) + sizeof ", ..." > writer->size) {
            ll_append(writer, i > 0 ? ", ..." : "...");
            return;
        }
        ll_append(writer, "%s%s", i > 0 ? ", " : "", text);
    }
}

static const char *choice_name(const void *context, int i)
{
    return ((const ll_param *)context)->choices[i];
}

static const char *row_name(const void *context, int i)
{
    return ((const ll_param_table *)context)->rows[i].name;
}

ll_status ll_not_a_choice(const ll_path *path, const ll_param *row, const cJSON *got)
{
    char list[LIST_SHOWN];
    int count = 0;
    while (row->choices[count] != NULL)
        count++;
    ll_writer writer = {list, sizeof list, 0};
    ll_append(&writer, "one of ");
    append_names(&writer, choice_name, row, count);
    return ll_wrong_type(path, list, got);
}

static ll_status unknown_index(const ll_path *path, const ll_json_location *array)
{
    int count = ll_count_of(array->row, array->home);
    if (count == 0)
        return ll_field_error(LL_BAD_INPUT, path->text, "%s does not exist: %s is empty", path->text,
                              array->row->name);
    return ll_field_error(LL_BAD_INPUT, path->text, "%s does not exist: the index in %s must be 0 to %d",
                          path->text, array->row->name, count - 1);
}

ll_status ll_unknown_name(ll_path *path, const ll_json_location *place, const char *name, size_t length)
{
    int before = ll_path_push(path, name, length);
    const char *subject = path->length > 0 ? path->text : "the empty name";
    ll_status status;
    const char *nearest =
        place->kind == LL_LOCATION_OBJECT ? ll_nearest_name(place->table, name, length) : NULL;
    if (place->kind == LL_LOCATION_ARRAY) {
        status = unknown_index(path, place);
    } else if (nearest != NULL) {
        status =
            ll_field_error(LL_BAD_INPUT, path->text, "%s is unknown; did you mean %s?", subject, nearest);
    } else if (place->kind == LL_LOCATION_VALUE || place->table == NULL || place->table->count == 0) {
        status = ll_field_error(LL_BAD_INPUT, path->text, "%s is unknown: it has no members", subject);
    } else {
        char list[LIST_SHOWN];
        append_names(&(ll_writer){list, sizeof list, 0}, row_name, place->table, place->table->count);
        status = ll_field_error(LL_BAD_INPUT, path->text, "%s is unknown; known are %s", subject, list);
    }
    ll_path_pop(path, before);
    return status;
}
