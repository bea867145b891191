#include "sim/core/scenario_rows.h"

#define NAMED(NAME) #NAME,
const char *const ll_sim_kind_names[] = {LL_SIM_KINDS(NAMED) NULL};

static const ll_param timeline_rows[] = {
    {.name = "at_s",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_timeline_step, at_s),
     .max = LL_DURATION_MAX_S,
     .unit = "s",
     .required = true,
     .help = "When it takes effect."},
    {.name = "set",
     .type = LL_PARAM_JSON,
     .offset = offsetof(ll_timeline_step, set),
     .max = LL_TIMELINE_SET_MAX,
     .required = true,
     .help = "A merge patch of live parameters, as for a session: {\"players.1.lag_ms\":300}."},
};

const ll_param_table ll_timeline_table = {.name = "timeline_step",
                                          .help = "A change of live parameters at a time.",
                                          .rows = timeline_rows,
                                          .count = sizeof timeline_rows / sizeof timeline_rows[0],
                                          .size = sizeof(ll_timeline_step)};

static const ll_param activity_rows[] = {
    {.name = "metric",
     .type = LL_PARAM_TEXT,
     .offset = offsetof(ll_activity, metric),
     .min = 1,
     .max = LL_METRIC_PATH_MAX,
     .required = true,
     .help = "Path of a number in the metrics, such as players.0.corrections."},
    {.name = "min",
     .type = LL_PARAM_REAL,
     .offset = offsetof(ll_activity, min),
     .min = -1e12,
     .max = 1e12,
     .default_value = 1,
     .help = "It must be at least so much."},
};

const ll_param_table ll_activity_table = {.name = "expect",
                                          .help = "A metric that must have come so far.",
                                          .rows = activity_rows,
                                          .count = sizeof activity_rows / sizeof activity_rows[0],
                                          .size = sizeof(ll_activity)};
