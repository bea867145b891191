/* The baseline of comparisons: a point. */
#pragma once

#include "experiment/format/table.h"

/* `first`, the number of a point, or values by path, `players.0.lag_ms=100,server.update_hz=30`: the first
 * point that has them all. LL_BAD_INPUT for `field`: no such point. */
ll_status ll_compare_point(const ll_experiment *experiment, const char *field, const char *text,
                           int64_t *point);

/* Its rows, of a source that is at its first run. Caller frees. */
ll_status ll_compare_rows(const ll_experiment *experiment, int64_t point, ll_row_source *source,
                          void *context, ll_row **rows, int64_t *count);
