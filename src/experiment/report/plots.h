/* The plots of a report: error against cost, and each metric along each dimension of the axes. */
#pragma once

#include "experiment/format/points.h"

/* In all a report draws at most so many metrics along dimensions: what is left out is told. */
enum { LL_REPORT_MULTIPLES_MAX = 24 };

/* Points with their front marked. `where`: HTML that tells where all points are. */
ll_status ll_report_plots_write(const ll_experiment *experiment, const ll_points *points, const char *where,
                                FILE *file);
