#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "param/internal.h"

static ll_status parse_place(const ll_json_location *place, const cJSON *json, ll_path *path)
{
    if (place->kind == LL_LOCATION_OBJECT)
        return ll_parse_object(place, json, path);
    if (place->kind == LL_LOCATION_ARRAY)
        return ll_parse_array(place, json, path);
    ll_status status = ll_value_set(place, json, path);
    if (!ll_failed(&status))
        ll_value_follow(place, true);
    return status;
}

/* Sorts the members of `json` by rows. Ends at the first name that is unknown or repeated, so that long user
 * input is not slow. */
static ll_status gather(const ll_json_location *place, const cJSON *json, ll_path *path, const cJSON **given)
{
    for (const cJSON *item = json->child; item != NULL; item = item->next) {
        size_t length = strlen(item->string);
        const ll_param *row = ll_row_named(place->table, item->string, length);
        if (row == NULL)
            return ll_unknown_name(path, place, item->string, length);
        const cJSON **seen = &given[row - place->table->rows];
        if (*seen != NULL) {
            ll_path_push(path, row->name, length);
            return ll_field_error(LL_BAD_INPUT, path->text, "%s is given twice", path->text);
        }
        *seen = item;
    }
    return ll_ok();
}

/* In the order of the rows, because other values depend on a choice, which may be later in the document. */
ll_status ll_parse_object(const ll_json_location *place, const cJSON *json, ll_path *path)
{
    const cJSON *given[LL_ROWS_MAX] = {NULL};
    if (!cJSON_IsObject(json))
        return ll_wrong_type(path, "an object", json);
    LL_ASSERT(place->table == NULL || place->table->count <= LL_ROWS_MAX);
    ll_status status = gather(place, json, path, given);
    for (int i = 0; place->table != NULL && i < place->table->count && !ll_failed(&status); i++) {
        const ll_param *row = &place->table->rows[i];
        int before = ll_path_push(path, row->name, strlen(row->name));
        if (given[i] != NULL) {
            ll_json_location inner = ll_json_location_of_row(place, row);
            status = parse_place(&inner, given[i], path);
        } else if (row->required) {
            status = ll_field_error(LL_BAD_INPUT, path->text, "%s is missing", path->text);
        }
        ll_path_pop(path, before);
    }
    return status;
}

static ll_status wrong_count(const ll_param *row, const ll_path *path, int count)
{
    char range[32];
    ll_count_range(row, range, sizeof range);
    return ll_field_error(LL_BAD_INPUT, path->text, "%s: must have %s elements; got %d", path->text, range,
                          count);
}

ll_status ll_parse_array(const ll_json_location *place, const cJSON *json, ll_path *path)
{
    const ll_param *row = place->row;
    if (!cJSON_IsArray(json))
        return ll_wrong_type(path, "an array", json);
    int32_t count = cJSON_GetArraySize(json);
    if (count < row->min || count > row->max)
        return wrong_count(row, path, count);
    int32_t had = ll_count_of(row, place->home); /* those after it are zero already */
    if (had > count)
        memset(place->member + (size_t)count * row->child->size, 0, (size_t)(had - count) * row->child->size);
    memcpy(place->home + row->count_offset, &count, sizeof count);

    ll_status status = ll_ok();
    int index = 0;
    for (const cJSON *item = json->child; item != NULL && !ll_failed(&status); item = item->next, index++) {
        ll_json_location element = ll_json_location_of_element(place, index);
        int before = ll_path_push_index(path, index);
        ll_param_defaults(element.table, element.member);
        if (row->begin != NULL)
            row->begin(place->home, element.member);
        status = ll_parse_object(&element, item, path);
        ll_path_pop(path, before);
    }
    return status;
}

/* Elements that `to` has no longer are cleared, so that equal configurations are equal bytes. */
static void replace(const ll_param_table *table, void *to, const void *from)
{
    for (int i = 0; i < table->count; i++) {
        const ll_param *row = &table->rows[i];
        if (row->type != LL_PARAM_ARRAY)
            continue;
        int32_t had = ll_count_of(row, to), has = ll_count_of(row, from);
        if (had > has)
            memset((char *)to + row->offset + (size_t)has * row->child->size, 0,
                   (size_t)(had - has) * row->child->size);
    }
    ll_param_copy(table, to, from);
}

ll_status ll_param_parse(const ll_param_table *table, const cJSON *json, void *object)
{
    void *copy = ll_param_clone(table, object, json);
    if (copy == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory");
    ll_path path = ll_path_root(table);
    ll_json_location root = ll_json_location_root(table, copy);
    ll_status status = ll_parse_object(&root, json, &path);
    LL_THEN(status, ll_run_checks(table, copy));
    if (!ll_failed(&status))
        replace(table, object, copy);
    free(copy);
    return status;
}
