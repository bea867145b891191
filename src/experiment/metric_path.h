/* Paths into the metrics of a run, such as `players.0.remote_error_m.mean`. */
#pragma once

#include "base/status.h"

struct cJSON;

/* LL_BAD_INPUT for `field`: there is no number at the path; the sentence tells what there is. */
ll_status ll_metric_check(const struct cJSON *metrics, const char *field, const char *path);

double ll_metric_value(const struct cJSON *metrics, const char *path); /* NaN where there is none */
