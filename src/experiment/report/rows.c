#include "experiment/report/rows.h"

#include <math.h>
#include <stdlib.h>

ll_status ll_report_rows_open(ll_report_rows *r, const ll_experiment *e, ll_row_source *source, void *context)
{
    int64_t most = LL_REPORT_ROWS_MAX / (e->points * e->metric_count);
    *r = (ll_report_rows){e, source, context, most < e->head.repeats ? most : e->head.repeats, NULL};
    int64_t count = e->points * e->metric_count * r->kept;
    if (count == 0)
        return ll_ok();
    r->values = malloc((size_t)count * sizeof *r->values);
    if (!r->values)
        return ll_error(LL_NO_MEMORY, "out of memory: rows of the report");
    for (int64_t k = 0; k < count; k++)
        r->values[k] = NAN;
    return ll_ok();
}

bool ll_report_rows_next(void *rows, ll_row *row, ll_status *status)
{
    ll_report_rows *r = rows;
    if (!r->source(r->context, row, status))
        return false;
    int64_t point = row->run / r->experiment->head.repeats, repeat = row->run % r->experiment->head.repeats;
    for (int m = 0; m < r->experiment->metric_count && repeat < r->kept; m++)
        ll_report_rows_at(r, m, point)[repeat] = row->metrics[m];
    return true;
}

void ll_report_rows_close(ll_report_rows *r)
{
    free(r->values);
    r->values = NULL;
}
