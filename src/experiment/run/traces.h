/* Traces of an experiment's runs, as files of a folder. */
#pragma once

#include "experiment/spec/experiment.h"

/* Writes `runN.csv` for each run in [from, to) that is not refused. Creates the folder if needed. Repeats
 * each run for it, on `threads` threads. */
ll_status ll_traces_write(const ll_experiment *experiment, int64_t from, int64_t to, const char *folder,
                          int threads);
