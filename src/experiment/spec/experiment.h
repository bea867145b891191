/* An experiment: a scenario, what is varied, how often each point is repeated, and which metrics are kept.
 *
 * A row is a pure function of (specification, index): it can be run on any thread or machine, again after a
 * crash, and in any order (but for the metric cost.ns_per_sim_s, which is measured). Run i is repeat i %
 * repeats of point i / repeats; repeat r has the scenario's seed
 * + r, at every point, so that points differ by their parameters and not by their luck. */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "experiment/spec/axis.h"
#include "experiment/statistics/interval.h"
#include "experiment/statistics/sample.h"
#include "session/scenario.h"
#include "session/workload.h"

enum {
    LL_EXPERIMENT_AXES_MAX = 20,
    LL_EXPERIMENT_METRICS_MAX = 32,
    LL_EXPERIMENT_PATH_MAX = 120,
    LL_EXPERIMENT_RUNS_MAX = 10000000,
    LL_EXPERIMENT_TRACES_MAX = 1000, /* runs of an experiment whose traces are kept */
};

typedef enum ll_interval_choice { LL_INTERVALS_AUTO, LL_INTERVALS_T } ll_interval_choice;

/* What has one value, in a table of its own. */
typedef struct ll_experiment_head {
    char title[LL_TITLE_MAX + 8];
    char text[LL_TEXT_MAX + 8];
    char scenario_id[LL_EXPERIMENT_PATH_MAX +
                     8]; /* that the scenario was read from; empty when it was given whole */
    /* Which of the metrics are the two sides of the trade, for the report and the adviser; empty: the first
     * and the second. */
    char error[LL_EXPERIMENT_PATH_MAX + 8], cost[LL_EXPERIMENT_PATH_MAX + 8];
    int64_t repeats;
    bool traces; /* `sweep` writes each run's, too */
    char reserved[3];
    int32_t interval; /* ll_interval_choice */
    struct {
        int32_t method, reserved; /* ll_sampling */
        int64_t count, seed;
    } sample;
    struct {
        char metric[LL_EXPERIMENT_PATH_MAX + 8]; /* empty: runs go to their end */
        double above, every_s;
    } stop;
    struct {
        char metric[LL_EXPERIMENT_PATH_MAX + 8]; /* empty: the error */
        double half_width, relative;             /* of the interval, at most; 0: no such rule */
        int64_t least;
    } until;
} ll_experiment_head;

typedef struct ll_experiment {
    ll_experiment_head head;
    ll_scenario base;      /* with the fixed overrides */
    struct cJSON *json;    /* the specification, with the scenario in it: all that another machine needs */
    struct cJSON *set;     /* the fixed overrides, within `json`; may be NULL */
    ll_workload *workload; /* the inputs of every run; NULL: there are none */
    ll_axis axes[LL_EXPERIMENT_AXES_MAX];
    int dimension[LL_EXPERIMENT_AXES_MAX]; /* of each axis: zipped ones share it */
    int axis_count, dimension_count;
    char metrics[LL_EXPERIMENT_METRICS_MAX][LL_EXPERIMENT_PATH_MAX + 8];
    ll_metric_scale scales[LL_EXPERIMENT_METRICS_MAX];
    int metric_count;
    int until_metric;
    int front[LL_EXPERIMENT_METRICS_MAX],
        front_count;               /* whose front is told: cost and error, or those named */
    int error_metric, cost_metric; /* indices into `metrics`; cost_metric < 0: there is none */
    int64_t points, runs;
} ll_experiment;

/* Reads and checks all that can be checked without running: paths, values, the number of runs, metrics.
 * `scenarios` is the folder of the library. Errors name the field, its range and the value. */
ll_status ll_experiment_parse(const struct cJSON *json, const char *scenarios, ll_experiment **experiment);
void ll_experiment_free(ll_experiment *experiment);

/* The specification as text, with the scenario in it. Caller frees. NULL without memory. */
char *ll_experiment_text(const ll_experiment *experiment);

/* What differs between two experiments gives other keys: specification and scenario. */
uint64_t ll_experiment_key(const ll_experiment *experiment);

ll_sample_order ll_experiment_sample(const ll_experiment *experiment);

/* The varied parameters at a point: {"players.0.lag_ms":100}. Caller deletes. */
struct cJSON *ll_experiment_point(const ll_experiment *experiment, int64_t point);
/* Why runs will have no metrics, or some of them: sentences, by what the scenario's kind knows of the points
 * before they are run. Caller deletes. */
struct cJSON *ll_experiment_notices(const ll_experiment *experiment);
int64_t ll_experiment_seed(const ll_experiment *experiment, int64_t run);

struct cJSON *ll_experiment_schema(void);

/* ---- rows ---- */

typedef enum ll_row_status {
    LL_ROW_OK,
    LL_ROW_STOPPED,  /* by the stop rule */
    LL_ROW_DIVERGED, /* the run, or a part that metrics are of; `error` tells when and where */
    LL_ROW_REFUSED,  /* these values do not go together; there are no metrics */
    LL_ROW_FAILED,   /* a part that metrics are of gave up or was not run: `error` tells which and why */
    LL_ROW_SKIPPED,  /* not made: the runs of its point before it were enough (until.h) */
} ll_row_status;

extern const char *const ll_row_status_names[];

typedef struct ll_row {
    int64_t run;
    ll_row_status status;
    char error[200];
    uint64_t hash;                             /* of the state at the end */
    double t_s;                                /* virtual time at the end */
    double metrics[LL_EXPERIMENT_METRICS_MAX]; /* NaN where there is none, as of what diverged or failed */
} ll_row;

/* Whether it ended well. */
static inline bool ll_row_good(const ll_row *row)
{
    return row->status == LL_ROW_OK || row->status == LL_ROW_STOPPED;
}

void ll_row_clear(ll_row *row); /* all 0, without metrics; rows are compared and stored as bytes */

/* Fails for want of memory, and with LL_INTERRUPTED (`interrupt` may be NULL). */
ll_status ll_experiment_run(const ll_experiment *experiment, int64_t run, const ll_interrupt *interrupt,
                            ll_row *row);

/* The scenario of a run: to be opened live, together with the workload. */
ll_status ll_experiment_open(const ll_experiment *experiment, int64_t run, ll_scenario *scenario);

/* The trace of a run as CSV, as `laglab run --trace` writes it: it is run again for that. Ends where the run
 * ended, or with the last tick before it diverged. LL_BAD_INPUT: it was refused. */
ll_status ll_experiment_trace(const ll_experiment *experiment, int64_t run, const ll_interrupt *interrupt,
                              void (*write)(void *context, const char *text, size_t length), void *context);
