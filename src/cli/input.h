/* Input of verbs: files, standard input, the library. */
#pragma once

#include <limits.h>
#include <stdio.h>

#include "experiment/spec/experiment.h"

/* The text of a file. Caller frees. */
ll_status ll_argument_text(const char *path, char **text);

/* JSON of a file, of `-` for standard input, or of a library id: an experiment or a scenario. `scenarios`
 * NULL: next to the program. If an experiment has the file name of a workload, relative to the experiment's
 * file (for standard input, to the working directory), the workload's text replaces it. Caller deletes. */
ll_status ll_argument_json(const char *name, const char *scenarios, struct cJSON **json);

ll_status ll_experiment_load(const char *name, const char *scenarios, ll_experiment **experiment);
/* An experiment from JSON, with the same library. */
ll_status ll_experiment_from(const struct cJSON *json, const char *scenarios, ll_experiment **experiment);

/* Folder of the scenarios: `scenarios`, or, when that is NULL, next to the program. */
const char *ll_scenario_folder(const char *scenarios, char folder[PATH_MAX]);
/* A scenario by its id, from a file, or from `-` for standard input. Caller deletes. */
ll_status ll_scenario_argument(const char *name, const char *scenarios, struct cJSON **json);
/* The whole content of a file, any bytes, at most 64 MiB; errors have `name`. Caller frees. */
ll_status ll_input_whole(FILE *file, const char *name, char **text, size_t *length);
