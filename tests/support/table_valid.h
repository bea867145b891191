/* Whether tables of records and metrics keep the rules of their rows. LL_BAD_INPUT: which rule is broken. */
#pragma once

#include "record/metric.h"
#include "record/record.h"

/* Whether names, codings, keys and the form's own fields are valid. */
ll_status record_valid(const ll_record *record);

/* Whether names, helps and paths are sound and none stands twice. */
ll_status metrics_valid(const ll_metric_table *const *tables);
