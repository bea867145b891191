#include <string.h>

#include "base/assert.h"
#include "param/internal.h"

static void set_value(const ll_param *row, char *member)
{
    switch (row->type) {
    case LL_PARAM_REAL:
        memcpy(member, &row->default_value, sizeof row->default_value);
        break;
    case LL_PARAM_INT: {
        int64_t value = (int64_t)row->default_value;
        memcpy(member, &value, sizeof value);
        break;
    }
    case LL_PARAM_BOOL: {
        bool value = row->default_value != 0;
        memcpy(member, &value, sizeof value);
        break;
    }
    case LL_PARAM_CHOICE: {
        int32_t value = (int32_t)row->default_value;
        memcpy(member, &value, sizeof value);
        break;
    }
    case LL_PARAM_TEXT: {
        size_t length = row->text == NULL ? 0 : strlen(row->text);
        LL_ASSERT(length <= (size_t)row->max);
        if (length > 0)
            memcpy(member, row->text, length); /* the rest is zero */
        break;
    }
    case LL_PARAM_VECTOR:
        memcpy(member, row->vector, sizeof row->vector);
        break;
    case LL_PARAM_POINTS:
    case LL_PARAM_NUMBERS:
    case LL_PARAM_JSON:
    case LL_PARAM_OBJECT:
    case LL_PARAM_VARIANT:
    case LL_PARAM_ARRAY:
        break;
    }
}

static void set_rows(const ll_param_table *table, char *object)
{
    for (int i = 0; i < table->count; i++) {
        const ll_param *row = &table->rows[i];
        if (row->type == LL_PARAM_OBJECT) {
            set_rows(row->child, object + row->offset);
        } else if (row->type == LL_PARAM_VARIANT) {
            const ll_param_table *variant = ll_variant_of(row, object);
            if (variant != NULL)
                set_rows(variant, object + row->offset);
        } else {
            set_value(row, object + row->offset);
        }
    }
}

/* Cleared first, so that equal configurations are equal bytes. */
void ll_param_defaults(const ll_param_table *table, void *object)
{
    memset(object, 0, table->size);
    set_rows(table, object);
}

void ll_param_defaults_in_zeros(const ll_param_table *table, void *object)
{
    set_rows(table, object);
}

static size_t storage_of(const ll_param *variant_row, const ll_param *choice)
{
    size_t size = 0;
    for (int i = 0; choice->choices[i] != NULL; i++) {
        const ll_param_table *variant = variant_row->variants[i];
        if (variant != NULL && variant->size > size)
            size = variant->size;
    }
    return size;
}

void ll_reset_variants(const ll_param_table *table, const ll_param *choice, char *object)
{
    for (int i = 0; i < table->count; i++) {
        const ll_param *row = &table->rows[i];
        if (row->type != LL_PARAM_VARIANT || row->count_offset != choice->offset)
            continue;
        memset(object + row->offset, 0, storage_of(row, choice));
        const ll_param_table *variant = ll_variant_of(row, object);
        if (variant != NULL)
            set_rows(variant, object + row->offset);
    }
}
