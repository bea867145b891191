#include <math.h>
#include <string.h>

#include "experiment/spec/experiment.h"

const char *const ll_row_status_names[] = {"ok", "stopped", "diverged", "refused", "failed", "skipped"};

void ll_row_clear(ll_row *row)
{
    memset(row, 0, sizeof *row);
    for (int i = 0; i < LL_EXPERIMENT_METRICS_MAX; i++)
        row->metrics[i] = NAN;
}
