/* Plots of a report: error against cost, and each metric along each dimension of the axes. */
#pragma once

#include "experiment/format/points.h"

/* Maximum number of plots along dimensions, of marks of each, and of rows of its table: a reader whose
 * browser runs no scripts sees these, all others more. A note says how many were left out. */
enum { LL_REPORT_MULTIPLES_MAX = 4, LL_REPORT_MARKS_MAX = 200, LL_REPORT_ROWS_SHOWN = 30 };

/* Points must have their front marked. `where`: HTML, where to find all points. */
ll_status ll_report_plots_write(const ll_experiment *experiment, const ll_points *points, const char *where,
                                FILE *file);
