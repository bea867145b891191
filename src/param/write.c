#include <string.h>

#include <cjson/cJSON.h>

#include "param/internal.h"

static cJSON *write_object(const ll_json_location *place);

static cJSON *write_pair(const char *member)
{
    double value[2];
    memcpy(value, member, sizeof value);
    cJSON *pair = cJSON_CreateArray();
    cJSON_AddItemToArray(pair, ll_param_number(value[0]));
    cJSON_AddItemToArray(pair, ll_param_number(value[1]));
    return pair;
}

static cJSON *write_points(const ll_param *row, const char *member)
{
    cJSON *points = cJSON_CreateArray();
    int32_t count = ll_count_of(row, member - row->offset);
    for (int i = 0; i < count; i++)
        cJSON_AddItemToArray(points, write_pair(member + (size_t)i * 2 * sizeof(double)));
    return points;
}

static cJSON *write_numbers(const ll_param *row, const char *member)
{
    cJSON *numbers = cJSON_CreateArray();
    int32_t count = ll_count_of(row, member - row->offset);
    for (int32_t i = 0; i < count; i++) {
        double value;
        memcpy(&value, member + (size_t)i * sizeof value, sizeof value);
        cJSON_AddItemToArray(numbers, ll_param_number(value));
    }
    return numbers;
}

cJSON *ll_write_value(const ll_param *row, const char *member)
{
    switch (row->type) {
    case LL_PARAM_REAL: {
        double value;
        memcpy(&value, member, sizeof value);
        return ll_param_number(value);
    }
    case LL_PARAM_INT: {
        int64_t value;
        memcpy(&value, member, sizeof value);
        return ll_param_number((double)value);
    }
    case LL_PARAM_BOOL: {
        bool value;
        memcpy(&value, member, sizeof value);
        return cJSON_CreateBool(value);
    }
    case LL_PARAM_CHOICE: {
        int32_t value;
        memcpy(&value, member, sizeof value);
        return cJSON_CreateString(row->choices[value]);
    }
    case LL_PARAM_JSON:
        return member[0] == '\0' ? cJSON_CreateObject() : cJSON_Parse(member);
    case LL_PARAM_VECTOR:
        return write_pair(member);
    case LL_PARAM_POINTS:
        return write_points(row, member);
    case LL_PARAM_NUMBERS:
        return write_numbers(row, member);
    default:
        return cJSON_CreateString(member);
    }
}

static cJSON *write_array(const ll_json_location *place)
{
    cJSON *array = cJSON_CreateArray();
    int count = ll_count_of(place->row, place->home);
    for (int i = 0; array != NULL && i < count; i++) {
        ll_json_location element = ll_json_location_of_element(place, i);
        cJSON *item = write_object(&element);
        if (!cJSON_AddItemToArray(array, item)) {
            cJSON_Delete(item);
            cJSON_Delete(array);
            return NULL;
        }
    }
    return array;
}

static cJSON *write_object(const ll_json_location *place)
{
    cJSON *object = cJSON_CreateObject();
    int count = place->table == NULL ? 0 : place->table->count;
    for (int i = 0; object != NULL && i < count; i++) {
        ll_json_location inner = ll_json_location_of_row(place, &place->table->rows[i]);
        cJSON *item = inner.kind == LL_LOCATION_ARRAY    ? write_array(&inner)
                      : inner.kind == LL_LOCATION_OBJECT ? write_object(&inner)
                                                         : ll_write_value(inner.row, inner.member);
        if (!cJSON_AddItemToObject(object, inner.row->name, item)) {
            cJSON_Delete(item);
            cJSON_Delete(object);
            return NULL;
        }
    }
    return object;
}

cJSON *ll_param_write(const ll_param_table *table, const void *object)
{
    ll_json_location root = ll_json_location_root(table, (void *)object); /* only read */
    return write_object(&root);
}
