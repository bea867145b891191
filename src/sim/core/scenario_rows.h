/* The rows that every scenario begins with. */
#pragma once

#include "sim/core/sim.h"

extern const char *const ll_sim_kind_names[];
extern const ll_param_table ll_timeline_table, ll_expectation_table;

#define LL_DURATION_MAX_S 3600

#define LL_SCENARIO_ROWS                                                                                     \
    {.name = "kind",                                                                                         \
     .type = LL_PARAM_CHOICE,                                                                                \
     .offset = offsetof(ll_scenario_head, kind),                                                             \
     .choices = ll_sim_kind_names,                                                                           \
     .required = true,                                                                                       \
     .help = "What is simulated."},                                                                          \
        {.name = "title",                                                                                    \
         .type = LL_PARAM_TEXT,                                                                              \
         .offset = offsetof(ll_scenario_head, title),                                                        \
         .max = LL_TITLE_MAX,                                                                                \
         .help = "A short name for people."},                                                                \
        {.name = "paper",                                                                                    \
         .type = LL_PARAM_TEXT,                                                                              \
         .offset = offsetof(ll_scenario_head, paper),                                                        \
         .max = LL_TITLE_MAX,                                                                                \
         .help = "The figure or section of the paper that this shows."},                                     \
        {.name = "text",                                                                                     \
         .type = LL_PARAM_TEXT,                                                                              \
         .offset = offsetof(ll_scenario_head, text),                                                         \
         .max = LL_TEXT_MAX,                                                                                 \
         .help = "What to look at."},                                                                        \
        {.name = "duration_s",                                                                               \
         .type = LL_PARAM_REAL,                                                                              \
         .offset = offsetof(ll_scenario_head, duration_s),                                                   \
         .min = 0.01,                                                                                        \
         .max = LL_DURATION_MAX_S,                                                                           \
         .default_value = 30,                                                                                \
         .unit = "s",                                                                                        \
         .help = "How long it runs."},                                                                       \
        {.name = "seed",                                                                                     \
         .type = LL_PARAM_INT,                                                                               \
         .offset = offsetof(ll_scenario_head, seed),                                                         \
         .max = 9007199254740991,                                                                            \
         .default_value = 1,                                                                                 \
         .help = "Of all random draws."},                                                                    \
        {.name = "timeline",                                                                                 \
         .type = LL_PARAM_ARRAY,                                                                             \
         .offset = offsetof(ll_scenario_head, timeline),                                                     \
         .count_offset = offsetof(ll_scenario_head, timeline_count),                                         \
         .max = LL_TIMELINE_MAX,                                                                             \
         .child = &ll_timeline_table,                                                                        \
         .help = "Changes of live parameters while it runs, in the order of time."},                         \
    {                                                                                                        \
        .name = "expect", .type = LL_PARAM_ARRAY, .offset = offsetof(ll_scenario_head, expect),              \
        .count_offset = offsetof(ll_scenario_head, expect_count), .max = LL_EXPECT_MAX,                      \
        .child = &ll_expectation_table,                                                                      \
        .help = "What must have happened at the end; a run tells whether it did."                            \
    }
