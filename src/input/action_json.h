/* A person's controls as JSON: {"player":0,"axes":[1,0],"buttons":0}. */
#pragma once

#include "base/status.h"
#include "input/action.h"

struct cJSON;

/* Fields of errors begin with `path` and a dot unless it is empty. Axes beyond [-1, 1] are errors; missing
 * ones are 0. */
ll_status ll_action_parse(const struct cJSON *json, const char *path, int *player, ll_action *action);
