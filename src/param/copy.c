#include <string.h>

#include "param/internal.h"

/* Calls `range` for each used range of bytes. */
static void each_range(const ll_param_table *table, const void *object,
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
    each_range(table, from, copy, &(copying){to, from});
}

static void add(void *context, size_t from, size_t bytes)
{
    (void)from;
    *(size_t *)context += bytes;
}

size_t ll_param_used(const ll_param_table *table, const void *object)
{
    size_t all = 0;
    each_range(table, object, add, &all);
    return all;
}
