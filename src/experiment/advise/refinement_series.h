/* Work-precision of whole scenarios: refinement series. A series varies one setting (cells, particles,
 * sweeps, substeps, an update rate) for one method, solver or technique; each level has its cost and its
 * error against a known result of the scene. Levels with randomness are run with several seeds, and their
 * error is the mean. work_precision_run.h does the same for integrators, against solutions. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "base/status.h"

struct cJSON;

/* Values are texts as in `--set`, separated by commas. */
typedef struct ll_refinement_series {
    const char *scenario; /* id in the library */
    const char *fixed;    /* `path=value` of every run, separated by commas. The value SEED is the number of
                             the run, from 1: a seed that is not the scenario's */
    const char *series;   /* path that distinguishes the series */
    const char *series_values;  /* its values */
    const char *setting;        /* path that distinguishes the levels; a number. Several, joined by `+`: all
                                   get it */
    const char *setting_values; /* cheapest first */
    const char *error;          /* path of a metric: better when closer to 0 */
    const char *counter;        /* path of a metric: work or cost, in addition to time */
    int seeds;                  /* runs of a level, with different seeds; 0: nothing is random */
} ll_refinement_series;

enum { LL_REFINEMENT_SERIES_SEEDS_MAX = 1000, LL_REFINEMENT_COSTS_MAX = 4 };

extern const ll_refinement_series ll_refinement_series_table[]; /* the last row has no scenario */

/* A mean over seeds with the bounds of its 95 % interval (interval.h). Without randomness, and where all
 * seeds gave the same cost, the bounds are the value. NaN: none. */
typedef struct ll_measured {
    double value, low, high;
} ll_measured;

typedef struct ll_refinement_level {
    const ll_refinement_series *refinement_series;
    char series[32], setting[32];
    bool diverged;
    double error, counter;        /* means over the seeds; NaN when one diverged or none has the metric */
    int seeds;                    /* seeds that have the error */
    double error_low, error_high; /* bounds of its 95 % interval (interval.h); NaN: none */
    ll_measured costs[LL_REFINEMENT_COSTS_MAX]; /* those of the request */
    double cpu_min_s, cpu_median_s;
    int runs;     /* whose time was measured */
    double order; /* against the previous level: -log of errors over log of settings; NaN for the first */
} ll_refinement_level;

typedef struct ll_refinement_request {
    const struct cJSON *scenario; /* from the library */
    const char *const *sets;      /* `path=value`; set after those of series and levels */
    int set_count;
    const char *duration;          /* s; NULL: that of the series */
    const char *methods;           /* series to run, separated by commas; NULL: all */
    int seeds;                     /* replaces the series' seeds, if it has any; 0: the series' */
    int first_seed;                /* added to the scenario's seed in the first run, one more in each other */
    int64_t (*now_ns)(void);       /* CPU time */
    const ll_interrupt *interrupt; /* of each run; NULL: none */
    /* Paths of metrics that are measured too, or of the session's cost, such as `cost.block_bytes`. */
    const char *const *costs;
    int cost_count;
} ll_refinement_request;

/* Levels of a series; `methods` as in a request. */
int ll_refinement_series_count(const ll_refinement_series *refinement_series, const char *methods);

/* A series in progress. */
typedef struct ll_refinement_run {
    const ll_refinement_request *request;
    const char *series, *settings;        /* remaining values: of `series`, of `settings` */
    ll_refinement_level refinement_level; /* the last one */
} ll_refinement_run;

ll_refinement_run ll_refinement_series_start(const ll_refinement_series *refinement_series,
                                             const ll_refinement_request *request);

/* Measures the next level; false after the last level of the last series, or on failure. LL_BAD_INPUT: a
 * value is invalid for the scenario; LL_INTERRUPTED. A run that diverges also makes a level. */
bool ll_refinement_series_next(ll_refinement_run *refinement_run, ll_status *status);

/* Writes what distinguishes the level's first run from the scenario, as `path=value` separated by spaces. */
void ll_refinement_level_sets(const ll_refinement_level *refinement_level,
                              const ll_refinement_request *request, char *text, int size);

/* Whether `name` is in the comma-separated `list`; NULL contains all. */
bool ll_list_contains(const char *list, const char *name);
/* Copies the next item of a comma-separated list into `item`; false at its end. */
bool ll_list_next(const char **list, char *item, size_t size);
