/* Scenarios: JSON files that name a kind, its parameters and a duration. */
#pragma once

#include <stddef.h>

#include "base/status.h"
#include "sim/core/sim.h"

struct cJSON;

typedef struct ll_scenario {
    const ll_sim_kind *kind;
    void *config; /* the kind's struct, begins with ll_scenario_head; owned */
} ll_scenario;

ll_status ll_scenario_parse(const struct cJSON *json, ll_scenario *scenario);
void ll_scenario_free(ll_scenario *scenario);

/* JSON text of a document of at most `LL_JSON_DEPTH` levels; errors name line and column. Caller deletes. */
#define LL_JSON_DEPTH 32
ll_status ll_json_parse(const char *text, size_t length, struct cJSON **json);

/* JSON Schema of scenarios of the kind of this name; NULL: of all kinds. Caller deletes. */
ll_status ll_scenario_schema(const char *kind, struct cJSON **schema);
