/* What verbs read: files, standard input, the library. */
#pragma once

#include <limits.h>
#include <stdio.h>

#include "experiment/spec/experiment.h"

/* The text of a file. Caller frees. */
ll_status ll_argument_text(const char *path, char **text);

/* JSON of a file, of `-` for standard input, or of an id of the library: an experiment or a scenario.
 * `scenarios` NULL: beside the program. Where an experiment names a file of its workload, relative to its own
 * (of standard input, to the folder that one is in), its text is put in place of the name. Caller deletes. */
ll_status ll_argument_json(const char *name, const char *scenarios, struct cJSON **json);

ll_status ll_experiment_load(const char *name, const char *scenarios, ll_experiment **experiment);
/* From JSON, with the same library. */
ll_status ll_experiment_from(const struct cJSON *json, const char *scenarios, ll_experiment **experiment);

/* Where the scenarios are: `scenarios`, or when that is NULL beside the program. */
const char *ll_scenario_folder(const char *scenarios, char folder[PATH_MAX]);
/* A scenario by its id, of a file, or of `-` for standard input. Caller deletes. */
ll_status ll_scenario_argument(const char *name, const char *scenarios, struct cJSON **json);
/* All of a file, which may hold any byte, up to 64 MiB; `name` is for errors. Caller frees. */
ll_status ll_input_whole(FILE *file, const char *name, char **text, size_t *length);
