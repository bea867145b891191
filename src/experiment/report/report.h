/* One page about an experiment: error against cost with the Pareto front, metrics along each axis, all
 * points, and how to repeat it. The page needs no other file and can be printed. It stays below some 2 MB for
 * any number of points: marks represent several points, tables have some, and notes say so. */
#pragma once

#include "experiment/format/table.h"

/* `version`: version of laglab that made the rows. */
ll_status ll_report_write(const ll_experiment *experiment, const char *version, ll_row_source *source,
                          void *context, FILE *file);
