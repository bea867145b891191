/* Files of measured links. A session reads no file: their samples become a profile of the scenario. */
#pragma once

#include "cli/arguments.h"

struct cJSON;

/* Adds a profile to the scenario `json` for each PATH=FILE, and sets the direction of a link at PATH, such as
 * players.0.link.down, to it. */
ll_status ll_link_traces_add(const ll_option_list *traces, struct cJSON *json);
