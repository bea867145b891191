#include "record/trace.h"

#include <stdio.h>
#include <string.h>

#include "base/assert.h"

static void name_column(const ll_trace_line *t, const char *path, int index, const char *name)
{
    char *out = t->names[t->count];
    const char *star = strchr(path, '*');
    if (star == NULL)
        snprintf(out, LL_TRACE_NAME_MAX, "%s%s%s", t->prefix, path, name);
    else
        snprintf(out, LL_TRACE_NAME_MAX, "%s%.*s%d%s%s", t->prefix, (int)(star - path), path, index, star + 1,
                 name);
}

void ll_trace_add(ll_trace_line *t, const char *path, int index, const char *name, double value)
{
    LL_ASSERT(t->count < LL_TRACE_COLUMNS_MAX);
    if (t->names != NULL)
        name_column(t, path, index, name);
    if (t->values != NULL)
        t->values[t->count] = value;
    t->count++;
}

void ll_trace_put(ll_trace_line *t, const ll_metric_table *table, int index, const ll_metric_reading *values)
{
    for (int i = 0; i < table->count; i++) {
        const ll_metric_field *field = &table->fields[i];
        const ll_metric_reading *v = &values[i];
        LL_ASSERT(field->type <= LL_METRIC_FLAG || field->type == LL_METRIC_BY_NAME);
        if (field->type != LL_METRIC_BY_NAME)
            ll_trace_add(t, table->path, index, field->name, v->number);
        else
            for (int k = 0; k < (int)v->number; k++)
                ll_trace_add(t, table->path, index, v->names[k], v->numbers[k]);
    }
}
