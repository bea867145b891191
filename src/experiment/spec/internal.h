/* What the files of an experiment share. */
#pragma once

#include "experiment/spec/experiment.h"

/* What has one value, by the table; other keys are left to the caller, unknown ones refused. */
ll_status ll_experiment_read_head(const struct cJSON *json, ll_experiment_head *head);

/* Merges values into a configuration and makes dependent ones agree. */
ll_status ll_experiment_apply(const ll_sim_kind *kind, const struct cJSON *values, void *config);
