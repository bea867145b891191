/* Columns of traces, as tables.
 *
 * A table of columns is written as one of metrics (record/metric.h): a list with a row X(type, name, unit,
 * value, help, null) per column. Its path is the beginning of the columns' names; a `*` in it stands for the
 * index of a player, a method or a body. A row by_name has a column for each of its names, named by it alone.
 *
 *   static const ll_metric_table body_columns = {
 *       .path = "*_", .help = "A body.", LL_METRICS_FROM(BODY_COLUMNS)};
 *
 *   LL_TRACE_PUT(trace, &body_columns, i, BODY_COLUMNS);
 *
 * The same function puts the names for the header and the values of each line, so that they agree. */
#pragma once

#include "record/metric.h"

enum { LL_TRACE_NAME_MAX = 48, LL_TRACE_COLUMNS_MAX = 1536 };

typedef struct ll_trace_line {
    char (*names)[LL_TRACE_NAME_MAX]; /* LL_TRACE_COLUMNS_MAX each; NULL: not wanted */
    double *values;
    int count;
    char prefix[24]; /* of all names from now on, such as `side_by_side0_` */
} ll_trace_line;

/* Adds a column; `index` is that of the path's `*`. */
void ll_trace_add(ll_trace_line *trace, const char *path, int index, const char *name, double value);

/* Adds the columns of a table: numbers, counts, flags and numbers by name. */
void ll_trace_put(ll_trace_line *trace, const ll_metric_table *table, int index,
                  const ll_metric_reading *values);

#define LL_TRACE_PUT(trace, table, index, LIST)                                                              \
    ll_trace_put(trace, table, index, (const ll_metric_reading[]){LIST(LL_METRIC_READING)})
