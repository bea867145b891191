#include "sim/core/scenario_rows.h"

#define NAMED(NAME) #NAME,
const char *const ll_sim_kind_names[] = {LL_SIM_KINDS(NAMED) NULL};

static const ll_param timeline_rows[] = {
    {LL_PARAM_ROW("at_s", REAL, ll_timeline_step, at_s), .max = LL_DURATION_MAX_S, .unit = "s",
     .required = true, .help = "Virtual time at which it takes effect."},
    {LL_PARAM_ROW("set", JSON, ll_timeline_step, set), .max = LL_TIMELINE_SET_MAX, .required = true,
     .help = "A merge patch of live parameters, as for a session: {\"players.1.lag_ms\":300}."},
};

const ll_param_table ll_timeline_table = {.name = "timeline_step",
                                          .help = "A change of live parameters at a given time.",
                                          LL_PARAM_ROWS(timeline_rows, ll_timeline_step)};

static const ll_param expectation_rows[] = {
    {LL_PARAM_ROW("metric", TEXT, ll_expectation, metric), .min = 1, .max = LL_METRIC_PATH_MAX,
     .required = true, .help = "Path of a number in the metrics, e.g. players.0.corrections."},
    {LL_PARAM_ROW("min", REAL, ll_expectation, min), .min = -1e12, .max = 1e12, .default_value = 1,
     .help = "Minimum."},
};

const ll_param_table ll_expectation_table = {.name = "expect",
                                             .help = "A metric and its required minimum.",
                                             LL_PARAM_ROWS(expectation_rows, ll_expectation)};
