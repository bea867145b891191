#include <string.h>

#include "param/internal.h"

static ll_status check_place(const ll_json_location *place, ll_path *path);

static ll_status check_elements(const ll_json_location *array, ll_path *path)
{
    ll_status status = ll_ok();
    int count = ll_count_of(array->row, array->home);
    for (int i = 0; i < count && !ll_failed(&status); i++) {
        ll_json_location element = ll_json_location_of_element(array, i);
        int before = ll_path_push_index(path, i);
        status = check_place(&element, path);
        ll_path_pop(path, before);
    }
    return status;
}

/* Inner tables first: a table's own rules may rely on those of its parts. */
static ll_status check_place(const ll_json_location *place, ll_path *path)
{
    if (place->kind == LL_LOCATION_ARRAY)
        return check_elements(place, path);
    ll_status status = ll_ok();
    if (place->kind == LL_LOCATION_VALUE || place->table == NULL)
        return status;
    for (int i = 0; i < place->table->count && !ll_failed(&status); i++) {
        const ll_param *row = &place->table->rows[i];
        if (ll_row_is_value(row))
            continue;
        ll_json_location inner = ll_json_location_of_row(place, row);
        int before = ll_path_push(path, row->name, strlen(row->name));
        status = check_place(&inner, path);
        ll_path_pop(path, before);
    }
    if (!ll_failed(&status) && place->table->check != NULL) {
        char prefix[LL_PATH_MAX + 2];
        size_t length = (size_t)path->length;
        memcpy(prefix, path->text, length);
        memcpy(prefix + length, length > 0 ? "." : "", length > 0 ? 2 : 1);
        status = place->table->check(place->member, prefix);
    }
    return status;
}

ll_status ll_run_checks(const ll_param_table *table, const void *object)
{
    ll_path path = ll_path_root(table);
    ll_json_location root = ll_json_location_root(table, (void *)object); /* only read */
    return check_place(&root, &path);
}
