/* Scenarios and experiments in files. */
#pragma once

#include "base/status.h"

struct cJSON;

/* Reads a scenario from a user's file. */
ll_status ll_scenario_read(const char *path, struct cJSON **json);

/* Loads from the library: `directory` has ID.json, also in folders (`paper/fig11`). An id has only
 * [a-z0-9_/-]. */
ll_status ll_scenario_load(const char *directory, const char *id, struct cJSON **json);
/* [{"id","title","paper","kind","game","text"}], by name. */
ll_status ll_scenario_list(const char *directory, struct cJSON **list);
/* The same for the experiments in it: [{"id","title","text"}]. */
ll_status ll_scenario_list_experiments(const char *directory, struct cJSON **list);
