/* The columns of all tables of results. */
#include "experiment/format/table_internal.h"

const ll_metric_table *const ll_result_columns[] = {
    &ll_run_columns,        &ll_end_columns,         &ll_version_columns,
    &ll_point_columns,      &ll_count_columns,       &ll_statistics_columns,
    &ll_difference_columns, &ll_sensitivity_columns, NULL};
