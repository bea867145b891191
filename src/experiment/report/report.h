/* One page about an experiment. Its script draws series by technique, any metric against any other, heat
 * maps, distributions and paired differences, and pages through the points. The page needs no other file, nor
 * a network, can be printed, and stays below LL_REPORT_BYTES_MAX for any number of rows: data.h says what is
 * left out then, as the page does. Without scripts it says how to get the points. */
#pragma once

#include "experiment/format/table.h"

enum { LL_REPORT_BYTES_MAX = 2000000 };

/* `version`: version of laglab that made the rows. `results`: the file that has them all; NULL: none is
 * known. */
ll_status ll_report_write(const ll_experiment *experiment, const char *version, const char *results,
                          ll_row_source *source, void *context, FILE *file);
