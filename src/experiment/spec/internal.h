/* Shared by the files of an experiment. */
#pragma once

#include "experiment/spec/experiment.h"

/* Reads the members with a table; the caller reads the other keys, unknown ones are refused. */
ll_status ll_experiment_read_head(const struct cJSON *json, ll_experiment_head *head);
