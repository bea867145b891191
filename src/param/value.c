/* One value from JSON into its member. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

/* A number written raw by ll_param_number reads like any other. */
static bool number_of(const cJSON *json, double *value)
{
    if (!cJSON_IsNumber(json) && !cJSON_IsRaw(json))
        return false;
    if (cJSON_IsNumber(json)) {
        *value = json->valuedouble;
        return true;
    }
    char *end;
    *value = strtod(json->valuestring, &end);
    return end != json->valuestring && *end == '\0';
}

/* NaN is outside of every range; infinities too, since ranges are finite (ll_param_table_valid). */
static bool within(double value, double min, double max)
{
    return value >= min && value <= max;
}

static ll_status set_real(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    double value;
    if (!number_of(json, &value))
        return ll_wrong_type(path, "a number", json);
    if (!within(value, place->row->min, place->row->max))
        return ll_out_of_range(path, place->row, json);
    memcpy(place->member, &value, sizeof value);
    return ll_ok();
}

static ll_status set_int(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    double value;
    if (!number_of(json, &value))
        return ll_wrong_type(path, "a whole number", json);
    if (!within(value, place->row->min, place->row->max) || !within(value, -LL_WHOLE_MAX, LL_WHOLE_MAX))
        return ll_out_of_range(path, place->row, json);
    int64_t whole = (int64_t)value;
    if ((double)whole != value)
        return ll_out_of_range(path, place->row, json);
    memcpy(place->member, &whole, sizeof whole);
    return ll_ok();
}

static ll_status set_bool(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    if (!cJSON_IsBool(json))
        return ll_wrong_type(path, "true or false", json);
    bool value = cJSON_IsTrue(json);
    memcpy(place->member, &value, sizeof value);
    return ll_ok();
}

static ll_status set_choice(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    int32_t choice = 0;
    if (!cJSON_IsString(json))
        return ll_not_a_choice(path, row, json);
    while (row->choices[choice] != NULL && strcmp(row->choices[choice], json->valuestring) != 0)
        choice++;
    if (row->choices[choice] == NULL)
        return ll_not_a_choice(path, row, json);
    memcpy(place->member, &choice, sizeof choice);
    return ll_ok();
}

static ll_status set_text(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    if (!cJSON_IsString(json))
        return ll_wrong_type(path, "a text", json);
    const char *text = json->valuestring;
    size_t length = strlen(text);
    if ((double)length < row->min || (double)length > row->max) {
        char range[48];
        ll_count_range(row, range, sizeof range);
        return ll_field_error(LL_BAD_INPUT, path->text, "%s: must be a text of %s bytes; got %zu",
                              ll_path_subject(path), range, length);
    }
    for (const char *at = text; *at != '\0';) {
        int sequence = ll_utf8_printable(at);
        if (sequence == 0)
            return ll_field_error(LL_BAD_INPUT, path->text,
                                  "%s: must be valid UTF-8 without control characters; got 0x%02x at byte %d",
                                  ll_path_subject(path), (unsigned)(unsigned char)*at, (int)(at - text));
        at += sequence;
    }
    memset(place->member, 0, (size_t)row->max + 1); /* equal texts are equal bytes */
    memcpy(place->member, text, length);
    return ll_ok();
}

/* Its reader decides what it may contain. */
static ll_status set_json(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    if (!cJSON_IsObject(json))
        return ll_wrong_type(path, "an object", json);
    char *text = cJSON_PrintUnformatted(json);
    if (text == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory");
    size_t length = strlen(text);
    bool fits = (double)length <= row->max;
    memset(place->member, 0, (size_t)row->max + 1);
    if (fits)
        memcpy(place->member, text, length);
    cJSON_free(text);
    return fits ? ll_ok()
                : ll_field_error(LL_BAD_INPUT, path->text, "%s: must be at most %.0f bytes of JSON; got %zu",
                                 ll_path_subject(path), row->max, length);
}

static bool is_pair(const cJSON *json, double min, double max, double out[2])
{
    return cJSON_IsArray(json) && cJSON_GetArraySize(json) == 2 && number_of(json->child, &out[0]) &&
           number_of(json->child->next, &out[1]) && within(out[0], min, max) && within(out[1], min, max);
}

static ll_status no_pair(const ll_path *path, const char *what, double min, double max, const ll_param *row,
                         const cJSON *json)
{
    char low[32], high[32], expected[128];
    ll_number_text(min, low);
    ll_number_text(max, high);
    ll_writer writer = {expected, sizeof expected, 0};
    ll_append(&writer, "%s of numbers from %s to %s%s%s", what, low, high, row->unit ? " " : "",
              row->unit ? row->unit : "");
    return ll_wrong_type(path, expected, json);
}

static ll_status set_vector(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    double value[2];
    if (!is_pair(json, row->min, row->max, value))
        return no_pair(path, "a pair [x, y]", row->min, row->max, row, json);
    memcpy(place->member, value, sizeof value);
    return ll_ok();
}

static ll_status set_points(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    int32_t count = cJSON_GetArraySize(json);
    if (!cJSON_IsArray(json))
        return ll_wrong_type(path, "an array of points [x, y]", json);
    if (count > row->max)
        return ll_field_error(LL_BAD_INPUT, path->text, "%s: must have at most %.0f points; got %d",
                              ll_path_subject(path), row->max, count);
    double points[LL_POINTS_MAX][2] = {{0}};
    int i = 0;
    for (const cJSON *item = json->child; item != NULL; item = item->next)
        if (!is_pair(item, -row->default_value, row->default_value, points[i++]))
            return no_pair(path, "an array of pairs [x, y]", -row->default_value, row->default_value, row,
                           item);
    memcpy(place->member, points, (size_t)row->max * sizeof points[0]);
    memcpy(place->home + row->count_offset, &count, sizeof count);
    return ll_ok();
}

static ll_status set_numbers(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    int32_t count = cJSON_GetArraySize(json);
    if (!cJSON_IsArray(json))
        return ll_wrong_type(path, "an array of numbers", json);
    if (count > row->max)
        return ll_field_error(LL_BAD_INPUT, path->text, "%s: must have at most %.0f numbers; got %d",
                              ll_path_subject(path), row->max, count);
    double *numbers = (double *)(void *)place->member;
    const ll_param range = {
        .type = LL_PARAM_REAL, .min = row->vector[0], .max = row->vector[1], .unit = row->unit};
    int32_t i = 0;
    for (const cJSON *item = json->child; item != NULL; item = item->next, i++) {
        ll_path element = *path;
        ll_path_push_index(&element, i);
        if (!number_of(item, &numbers[i]))
            return ll_wrong_type(&element, "a number", item);
        if (!within(numbers[i], range.min, range.max))
            return ll_out_of_range(&element, &range, item);
    }
    memset(numbers + count, 0,
           (size_t)(row->max - count) * sizeof *numbers); /* equal lists are equal bytes */
    memcpy(place->home + row->count_offset, &count, sizeof count);
    return ll_ok();
}

ll_status ll_value_set(const ll_json_location *place, const cJSON *json, const ll_path *path)
{
    switch (place->row->type) {
    case LL_PARAM_REAL:
        return set_real(place, json, path);
    case LL_PARAM_INT:
        return set_int(place, json, path);
    case LL_PARAM_BOOL:
        return set_bool(place, json, path);
    case LL_PARAM_CHOICE:
        return set_choice(place, json, path);
    case LL_PARAM_JSON:
        return set_json(place, json, path);
    case LL_PARAM_VECTOR:
        return set_vector(place, json, path);
    case LL_PARAM_POINTS:
        return set_points(place, json, path);
    case LL_PARAM_NUMBERS:
        return set_numbers(place, json, path);
    default:
        return set_text(place, json, path);
    }
}

void ll_value_follow(const ll_json_location *place, bool changed)
{
    if (place->row->type != LL_PARAM_CHOICE)
        return;
    if (changed)
        ll_reset_variants(place->home_table, place->row, place->home);
    int32_t choice;
    memcpy(&choice, place->member, sizeof choice);
    if (place->row->chosen != NULL)
        place->row->chosen(place->home, choice);
}
