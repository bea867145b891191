/* Work against precision of whole scenarios: a ladder of one setting (cells, particles, sweeps, substeps, an
 * update rate) per series (a method, a solver, a technique), each rung with its cost and with its error
 * against what the scene knows to be right. What luck has a part in is run with several seeds: its error is
 * their mean. work_precision_run.h is the same of the integrators, against solutions. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct cJSON;

/* Values are texts as in `--set`, separated by commas. */
typedef struct ll_refinement_series {
    const char *scenario;       /* id in the library */
    const char *fixed;          /* `path=value` of every run, separated by commas */
    const char *series;         /* path of what makes a series */
    const char *series_values;  /* of it */
    const char *setting;        /* path of what makes a rung; a number */
    const char *setting_values; /* from the cheapest */
    const char *error;          /* path of a metric: nearer to 0 is better */
    const char *counter;        /* path of a metric: work done or paid, beside the time that it took */
    int seeds;                  /* runs of a rung, each with its own; 0: nothing is random */
} ll_refinement_series;

enum { LL_REFINEMENT_SERIES_SEEDS_MAX = 1000 };

extern const ll_refinement_series ll_ladders[]; /* ends with a row of no scenario */

typedef struct ll_refinement_level {
    const ll_refinement_series *refinement_series;
    char series[32], setting[32];
    bool diverged;
    double error, counter;        /* means over the seeds; NaN where one diverged, or none has the metric */
    int seeds;                    /* that have the error */
    double error_low, error_high; /* of its 95 % interval (interval.h); NaN: none */
    double cpu_min_s, cpu_median_s;
    double order; /* of this rung against the one before: -log of errors over log of settings; NaN for the
                     first */
} ll_refinement_level;

typedef struct ll_refinement_request {
    const struct cJSON *scenario; /* the library's */
    const char *const *sets;      /* `path=value`; what makes the series and the rungs goes before them */
    int set_count;
    const char *duration;    /* s; NULL: the ladder's */
    const char *methods;     /* series to run, separated by commas; NULL: all */
    int seeds;               /* in place of the ladder's, where that has some; 0: the ladder's */
    int64_t (*now_ns)(void); /* CPU time */
} ll_refinement_request;

/* On the way up. */
typedef struct ll_refinement_run {
    const ll_refinement_request *order;
    const char *series, *settings;        /* that are left: of the ladder, of the series */
    ll_refinement_level refinement_level; /* the last */
} ll_refinement_run;

ll_refinement_run ll_refinement_series_start(const ll_refinement_series *refinement_series,
                                             const ll_refinement_request *order);

/* The next rung; false after the last of the last series, or when it failed. LL_BAD_INPUT: a value does not
 * go with the scenario. A run that diverges is a rung. */
bool ll_refinement_series_next(ll_refinement_run *refinement_run, ll_status *status);

/* Whether `name` is one of the comma-separated `list`; NULL lists all. */
bool ll_listed(const char *list, const char *name);
