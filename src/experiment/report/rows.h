/* The metrics of an experiment's runs, held while its rows are read for a report. */
#pragma once

#include "experiment/format/table.h"

enum { LL_REPORT_ROWS_MAX = 4000000 }; /* values: 32 MB */

typedef struct ll_report_rows {
    const ll_experiment *experiment;
    ll_row_source *source;
    void *context;
    int64_t kept;   /* first repeats of each point that are held; 0: none */
    double *values; /* by metric, point and repeat; NaN: missing. NULL: none */
} ll_report_rows;

ll_status ll_report_rows_open(ll_report_rows *rows, const ll_experiment *experiment, ll_row_source *source,
                              void *context);
bool ll_report_rows_next(void *rows, ll_row *row, ll_status *status); /* an ll_row_source function */
void ll_report_rows_close(ll_report_rows *rows);

static inline double *ll_report_rows_at(const ll_report_rows *rows, int metric, int64_t point)
{
    return rows->values + (metric * rows->experiment->points + point) * rows->kept;
}
