/* One page that tells an experiment: error against cost with the Pareto front, error along each axis, all
 * points, and what is needed to repeat it. It needs no other file and prints on paper. */
#pragma once

#include "experiment/table.h"

ll_status ll_report_write(const ll_experiment *experiment, ll_row_source *source, void *context, FILE *file);
