#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>

#include "base/assert.h"
#include "param/internal.h"

void ll_param_each_range(const ll_param_table *table, const void *object,
                         void (*range)(void *context, size_t from, size_t bytes), void *context)
{
    size_t at = 0;
    for (int i = 0; i < table->count; i++) {
        const ll_param *row = &table->rows[i];
        if (row->type != LL_PARAM_ARRAY || row->offset < at) /* bytes before it belong to the current range */
            continue;
        size_t used = (size_t)ll_count_of(row, object) * row->child->size;
        range(context, at, row->offset + used - at);
        at = row->offset + (size_t)row->max * row->child->size;
    }
    range(context, at, table->size - at);
}

typedef struct copying {
    char *to;
    const char *from;
} copying;

static void copy(void *context, size_t from, size_t bytes)
{
    const copying *c = context;
    memcpy(c->to + from, c->from + from, bytes);
}

void ll_param_copy(const ll_param_table *table, void *to, const void *from)
{
    ll_param_each_range(table, from, copy, &(copying){to, from});
}

/* By its key or by the path of something in it. */
static bool names(const cJSON *patch, const ll_param *row)
{
    size_t length = strlen(row->name);
    for (const cJSON *item = patch != NULL ? patch->child : NULL; item != NULL; item = item->next)
        if (strncmp(item->string, row->name, length) == 0 &&
            (item->string[length] == '\0' || item->string[length] == '.'))
            return true;
    return false;
}

size_t ll_param_clone_size(const ll_param_table *table, const void *object, const cJSON *patch)
{
    const ll_param *last = table->is_cut ? &table->rows[table->count - 1] : NULL;
    if (last == NULL || names(patch, last))
        return table->size;
    LL_ASSERT(last->type == LL_PARAM_ARRAY &&
              last->offset + (size_t)last->max * last->child->size == table->size);
    return last->offset + (size_t)ll_count_of(last, object) * last->child->size;
}

void *ll_param_clone(const ll_param_table *table, const void *object, const cJSON *patch)
{
    void *clone = calloc(1, ll_param_clone_size(table, object, patch));
    if (clone != NULL)
        ll_param_copy(table, clone, object);
    return clone;
}

static void add(void *context, size_t from, size_t bytes)
{
    (void)from;
    *(size_t *)context += bytes;
}

size_t ll_param_used(const ll_param_table *table, const void *object)
{
    size_t all = 0;
    ll_param_each_range(table, object, add, &all);
    return all;
}
