/* Parameters that every scenario starts with. */
#pragma once

#include "sim/core/sim.h"

extern const char *const ll_sim_kind_names[];
extern const ll_param_table ll_timeline_table, ll_expectation_table;

#define LL_DURATION_MAX_S 3600

#define LL_SCENARIO_ROWS                                                                                     \
    {LL_PARAM_ROW("kind", CHOICE, ll_scenario_head, kind), .choices = ll_sim_kind_names, .required = true,   \
     .help = "Kind of simulation."},                                                                         \
        {LL_PARAM_ROW("title", TEXT, ll_scenario_head, title), .max = LL_TITLE_MAX,                          \
         .help = "Short name for display."},                                                                 \
        {LL_PARAM_ROW("paper", TEXT, ll_scenario_head, paper), .max = LL_TITLE_MAX,                          \
         .help = "Figure or section of the paper that the scenario shows."},                                 \
        {LL_PARAM_ROW("text", TEXT, ll_scenario_head, text), .max = LL_TEXT_MAX,                             \
         .help = "What the scenario shows and where to see it."},                                            \
        {LL_PARAM_ROW("duration_s", REAL, ll_scenario_head, duration_s),                                     \
         .min = 0.01,                                                                                        \
         .max = LL_DURATION_MAX_S,                                                                           \
         .default_value = 30,                                                                                \
         .unit = "s",                                                                                        \
         .help = "Length of the simulation."},                                                               \
        {LL_PARAM_ROW("seed", INT, ll_scenario_head, seed), .max = 9007199254740991, .default_value = 1,     \
         .help = "Random seed."},                                                                            \
        {LL_PARAM_ROW("timeline", ARRAY, ll_scenario_head, timeline),                                        \
         .count_offset = offsetof(ll_scenario_head, timeline_count), .max = LL_TIMELINE_MAX,                 \
         .child = &ll_timeline_table,                                                                        \
         .help = "Changes of live parameters during the run, in the order of time."},                        \
    {                                                                                                        \
        LL_PARAM_ROW("expect", ARRAY, ll_scenario_head, expect),                                             \
            .count_offset = offsetof(ll_scenario_head, expect_count), .max = LL_EXPECT_MAX,                  \
            .child = &ll_expectation_table,                                                                  \
            .help = "Minimum of each of these metrics at the end; a run reports whether they were reached."  \
    }
