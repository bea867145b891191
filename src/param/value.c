/* One value from JSON into its member. */
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

/* A number that ll_param_number wrote raw reads like any other. */
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

/* A NaN is outside of every range; an infinity too, since ranges are finite (ll_param_table_valid). */
static bool within(double value, double min, double max)
{
    return value >= min && value <= max;
}

static ll_status set_real(const ll_place *place, const cJSON *json, const ll_path *path)
{
    double value;
    if (!number_of(json, &value))
        return ll_wrong_type(path, "a number", json);
    if (!within(value, place->row->min, place->row->max))
        return ll_out_of_range(path, place->row, json);
    memcpy(place->member, &value, sizeof value);
    return ll_ok();
}

static ll_status set_int(const ll_place *place, const cJSON *json, const ll_path *path)
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

static ll_status set_bool(const ll_place *place, const cJSON *json, const ll_path *path)
{
    if (!cJSON_IsBool(json))
        return ll_wrong_type(path, "true or false", json);
    bool value = cJSON_IsTrue(json);
    memcpy(place->member, &value, sizeof value);
    return ll_ok();
}

static ll_status set_choice(const ll_place *place, const cJSON *json, const ll_path *path)
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

static ll_status set_text(const ll_place *place, const cJSON *json, const ll_path *path)
{
    const ll_param *row = place->row;
    if (!cJSON_IsString(json))
        return ll_wrong_type(path, "a text", json);
    const char *text = json->valuestring;
    size_t length = strlen(text);
    if ((double)length < row->min || (double)length > row->max) {
        char range[48];
        ll_writer writer = {range, sizeof range, 0};
        if (row->min > 0)
            ll_append(&writer, "%.0f to %.0f", row->min, row->max);
        else
            ll_append(&writer, "at most %.0f", row->max);
        return ll_field_error(LL_BAD_INPUT, path->text, "%s must be a text of %s bytes; got %zu",
                              ll_path_subject(path), range, length);
    }
    for (const char *at = text; *at != '\0';) {
        int sequence = ll_utf8_printable(at);
        if (sequence == 0)
            return ll_field_error(LL_BAD_INPUT, path->text,
                                  "%s must be valid UTF-8 without control characters; got 0x%02x at byte %d",
                                  ll_path_subject(path), (unsigned)(unsigned char)*at, (int)(at - text));
        at += sequence;
    }
    memset(place->member, 0, (size_t)row->max + 1); /* equal texts are equal bytes */
    memcpy(place->member, text, length);
    return ll_ok();
}

/* What it may hold is up to whoever reads it. */
static ll_status set_json(const ll_place *place, const cJSON *json, const ll_path *path)
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
                : ll_field_error(LL_BAD_INPUT, path->text, "%s must be at most %.0f bytes of JSON; got %zu",
                                 ll_path_subject(path), row->max, length);
}

ll_status ll_value_set(const ll_place *place, const cJSON *json, const ll_path *path)
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
    default:
        return set_text(place, json, path);
    }
}

void ll_value_follow(const ll_place *place, bool changed)
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
