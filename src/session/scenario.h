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

/* A scenario of a file of one's own. */
ll_status ll_scenario_read(const char *path, struct cJSON **json);

/* The library: `directory` holds ID.json, also in folders (`paper/fig11`). An id has only [a-z0-9_/-]. */
ll_status ll_scenario_load(const char *directory, const char *id, struct cJSON **json);
/* [{"id","title","paper","kind","game","text"}], by name. */
ll_status ll_scenario_list(const char *directory, struct cJSON **list);
/* The same of the experiments there, which are no scenarios: [{"id","title","text"}]. */
ll_status ll_scenario_list_experiments(const char *directory, struct cJSON **list);

/* JSON Schema of scenarios of the kind of this name; NULL: of all kinds. Caller deletes. */
ll_status ll_scenario_schema(const char *kind, struct cJSON **schema);
