/* The data of a report for its script: a head in JSON, and columns of points, of paired differences and of
 * runs (pack.h). As much as there is room for: first all statistics of all points exactly, then fewer digits,
 * fewer statistics, and at last a random sample of the points; single runs as far as room is left. The head
 * says which. */
#pragma once

#include "experiment/format/points.h"
#include "experiment/report/differences.h"
#include "experiment/report/rows.h"

/* `room`: maximum bytes. */
ll_status ll_report_data_write(const ll_report_rows *rows, const ll_points *points,
                               const ll_differences *differences, const char *version, size_t room,
                               FILE *file);
