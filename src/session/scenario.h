/* Scenarios: JSON files that name a kind, its parameters and a duration. */
#pragma once

#include <stddef.h>

#include "base/status.h"
#include "sim/core/sim.h"

struct cJSON;

typedef struct ll_scenario {
    const ll_sim_kind *kind;
    void *config; /* the kind's struct; its first member is an ll_scenario_head; owned */
} ll_scenario;

ll_status ll_scenario_parse(const struct cJSON *json, ll_scenario *scenario);
/* The same of the parameters of a session that runs: changes may have made steps of its timeline invalid,
 * which it skips. */
ll_status ll_scenario_parse_running(const struct cJSON *json, ll_scenario *scenario);
/* Of what ll_scenario_parse checks only the timeline: the order of its steps, and that each can be set. */
ll_status ll_timeline_check(const ll_sim_kind *kind, const void *config);
void ll_scenario_free(ll_scenario *scenario);

/* Sets values of a scenario's JSON through its tables, each path=value, in any order: see ll_param_put. Those
 * of `later` (NULL ends them) are set after these, one by one, so that a wrong value before them is refused
 * too. Rules between values are checked when all are set. `*json` is then a new document with all values, in
 * place of the old one, which is deleted; unchanged on an error. */
ll_status ll_scenario_override(struct cJSON **json, const char *const *sets, int count,
                               const char *const *later);

/* Parses JSON of at most LL_JSON_DEPTH levels of nesting and LL_JSON_VALUES values, which the largest
 * scenario (four profiles of a link) and experiment have; errors name line and column. Caller deletes. */
#define LL_JSON_DEPTH 32
#define LL_JSON_VALUES 100000
ll_status ll_json_parse(const char *text, size_t length, struct cJSON **json);

/* JSON Schema of scenarios of this kind; kind NULL: of all kinds. Caller deletes. */
ll_status ll_scenario_schema(const char *kind, struct cJSON **schema);
