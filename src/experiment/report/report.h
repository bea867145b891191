/* One page that tells an experiment: error against cost with the Pareto front, metrics along each axis, all
 * points, and what is needed to repeat it. It needs no other file and prints on paper. However many points
 * there are it stays below some 2 MB: marks stand for several, tables list some, and say so. */
#pragma once

#include "experiment/format/table.h"

/* `version`: of the laglab that made the rows. */
ll_status ll_report_write(const ll_experiment *experiment, const char *version, ll_row_source *source,
                          void *context, FILE *file);
