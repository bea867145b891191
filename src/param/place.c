#include <string.h>

#include "base/assert.h"
#include "param/internal.h"

int32_t ll_count_of(const ll_param *row, const char *object)
{
    int32_t count;
    memcpy(&count, object + row->count_offset, sizeof count);
    return count;
}

const ll_param_table *ll_variant_of(const ll_param *row, const char *object)
{
    return row->variants[ll_count_of(row, object)];
}

bool ll_row_is_value(const ll_param *row)
{
    return row->type != LL_PARAM_OBJECT && row->type != LL_PARAM_VARIANT && row->type != LL_PARAM_ARRAY;
}

bool ll_row_governs(const ll_param_table *table, const ll_param *row)
{
    if (row->type != LL_PARAM_CHOICE)
        return false;
    if (row->chosen != NULL)
        return true;
    for (int i = 0; i < table->count; i++)
        if (table->rows[i].type == LL_PARAM_VARIANT && table->rows[i].count_offset == row->offset)
            return true;
    return false;
}

const ll_param *ll_row_named(const ll_param_table *table, const char *name, size_t length)
{
    if (table == NULL)
        return NULL;
    for (int i = 0; i < table->count; i++) {
        const char *row = table->rows[i].name;
        if (strncmp(row, name, length) == 0 && row[length] == '\0')
            return &table->rows[i];
    }
    return NULL;
}

ll_json_location ll_json_location_root(const ll_param_table *table, void *object)
{
    return (ll_json_location){.kind = LL_LOCATION_OBJECT, .live = true, .member = object, .table = table};
}

ll_json_location ll_json_location_of_row(const ll_json_location *object, const ll_param *row)
{
    ll_json_location place = {.kind = LL_LOCATION_VALUE,
                              .live = object->live && row->live,
                              .row = row,
                              .member = object->member + row->offset,
                              .home_table = object->table,
                              .home = object->member};
    if (row->type == LL_PARAM_ARRAY) {
        place.kind = LL_LOCATION_ARRAY;
    } else if (!ll_row_is_value(row)) {
        place.kind = LL_LOCATION_OBJECT;
        place.table = row->type == LL_PARAM_OBJECT ? row->child : ll_variant_of(row, object->member);
    }
    return place;
}

ll_json_location ll_json_location_of_element(const ll_json_location *array, int index)
{
    ll_json_location place = *array;
    place.kind = LL_LOCATION_OBJECT;
    place.table = array->row->child;
    place.member = array->member + (size_t)index * place.table->size;
    return place;
}

/* A canonical index: no sign, no leading zero; else -1. */
static int index_of(const char *name, size_t length, int count)
{
    if (length == 0 || length > 9 || (length > 1 && name[0] == '0'))
        return -1;
    int index = 0;
    for (size_t i = 0; i < length; i++) {
        if (name[i] < '0' || name[i] > '9')
            return -1;
        index = index * 10 + (name[i] - '0');
    }
    return index < count ? index : -1;
}

bool ll_json_location_step(ll_json_location *place, const char *name, size_t length)
{
    if (place->kind == LL_LOCATION_ARRAY) {
        int index = index_of(name, length, ll_count_of(place->row, place->home));
        if (index < 0)
            return false;
        *place = ll_json_location_of_element(place, index);
        return true;
    }
    const ll_param *row = place->kind == LL_LOCATION_OBJECT ? ll_row_named(place->table, name, length) : NULL;
    if (row == NULL)
        return false;
    *place = ll_json_location_of_row(place, row);
    return true;
}

const ll_param *ll_param_find(const ll_param_table *table, void *object, const char *path, void **member)
{
    ll_json_location place = ll_json_location_root(table, object);
    for (;;) {
        size_t length = strcspn(path, ".");
        if (!ll_json_location_step(&place, path, length))
            return NULL;
        if (path[length] == '\0')
            break;
        path += length + 1;
    }
    if (member != NULL)
        *member = place.member;
    return place.row;
}
