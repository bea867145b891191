/* An experiment: a scenario, its varied parameters, the number of repeats of each point, and the metrics that
 * are kept.
 *
 * A row is a pure function of (specification, index): it can be run on any thread or machine, again after a
 * crash, and in any order (except the metric cost.ns_per_sim_s, which is measured). Run i is repeat i %
 * repeats of point i / repeats; repeat r has the scenario's seed + r at every point, so that points differ
 * only by their parameters (common random numbers). */
#pragma once

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "experiment/spec/axis.h"
#include "experiment/spec/window.h"
#include "experiment/statistics/interval.h"
#include "experiment/statistics/sample.h"
#include "session/scenario.h"
#include "session/session.h"
#include "session/workload.h"

enum {
    LL_EXPERIMENT_AXES_MAX = 20,
    LL_EXPERIMENT_METRICS_MAX = 32,
    LL_EXPERIMENT_PATH_MAX = 120,
    LL_EXPERIMENT_RUNS_MAX = 10000000,
    LL_EXPERIMENT_TRACES_MAX = 1000, /* runs of an experiment with traces */
};

typedef enum ll_interval_choice { LL_INTERVALS_AUTO, LL_INTERVALS_T } ll_interval_choice;

/* Members with single values, which have a table. */
typedef struct ll_experiment_head {
    char title[LL_TITLE_MAX + 8];
    char text[LL_TEXT_MAX + 8];
    char scenario_id[LL_EXPERIMENT_PATH_MAX +
                     8]; /* file that the scenario was read from; empty if it was given whole */
    /* Error and cost metric, for the report and the adviser; empty: the first and the second metric. */
    char error[LL_EXPERIMENT_PATH_MAX + 8], cost[LL_EXPERIMENT_PATH_MAX + 8];
    int64_t repeats;
    bool traces; /* `sweep` also writes traces of all runs */
    char reserved[3];
    int32_t interval; /* ll_interval_choice */
    struct {
        int32_t method, reserved; /* ll_sampling */
        int64_t count, seed;
    } sample;
    struct {
        char metric[LL_EXPERIMENT_PATH_MAX + 8]; /* empty: no early end */
        double above, every_s;
    } stop;
    struct {
        char metric[LL_EXPERIMENT_PATH_MAX + 8]; /* empty: the error metric */
        double half_width, relative;             /* maximum half width of the interval; 0: no such rule */
        int64_t least;
    } until;
    int32_t window_count, reserved_2;
    ll_window windows[LL_WINDOWS_MAX];
} ll_experiment_head;

typedef struct ll_experiment {
    ll_experiment_head head;
    ll_scenario base;      /* with the fixed values */
    struct cJSON *json;    /* the specification, including the scenario: complete for another machine */
    struct cJSON *set;     /* the fixed values, within `json`; may be NULL */
    ll_workload *workload; /* the inputs of every run; NULL: none */
    ll_axis axes[LL_EXPERIMENT_AXES_MAX];
    int dimension[LL_EXPERIMENT_AXES_MAX]; /* by axis: zipped ones share a dimension */
    int axis_count, dimension_count;
    char metrics[LL_EXPERIMENT_METRICS_MAX][LL_EXPERIMENT_PATH_MAX + 8];
    ll_metric_scale scales[LL_EXPERIMENT_METRICS_MAX];
    ll_windowed windowed[LL_EXPERIMENT_METRICS_MAX]; /* by metric */
    int metric_count;
    int until_metric;
    int front[LL_EXPERIMENT_METRICS_MAX],
        front_count;               /* of the Pareto front: cost and error, or those named */
    int error_metric, cost_metric; /* indices into `metrics`; cost_metric < 0: none */
    int64_t points, runs;
} ll_experiment;

/* Parses a specification and checks all that needs no runs: paths, the number of runs, values, metrics.
 * `scenarios` is the folder of the library. Errors name the field, its range and the value; LL_INTERRUPTED:
 * `interrupt` (may be NULL) broke it off. */
ll_status ll_experiment_parse(const struct cJSON *json, const char *scenarios, const ll_interrupt *interrupt,
                              ll_experiment **experiment);
void ll_experiment_free(ll_experiment *experiment);

/* The specification as text, with the scenario. Caller frees. NULL without memory. */
char *ll_experiment_text(const ll_experiment *experiment);

/* Hash of specification and scenario: different experiments have different keys. */
uint64_t ll_experiment_key(const ll_experiment *experiment);

ll_sample_request ll_experiment_sample(const ll_experiment *experiment);

/* The varied parameters at a point: {"players.0.lag_ms":100}. Caller deletes. */
struct cJSON *ll_experiment_point(const ll_experiment *experiment, int64_t point);
/* Reasons why runs will lack metrics, as far as the scenario's kind knows them before the runs: a list of
 * sentences. Caller deletes. */
struct cJSON *ll_experiment_notices(const ll_experiment *experiment);
int64_t ll_experiment_seed(const ll_experiment *experiment, int64_t run);

struct cJSON *ll_experiment_schema(void);
/* The schemas of scenarios and of experiments as two of `$defs`, to which api/openapi.yaml refers. Each
 * stands next to the definitions that it refers to, not around them: generators of types take nested ones for
 * properties. */
struct cJSON *ll_schemas(void);

/* ---- rows ---- */

typedef enum ll_row_status {
    LL_ROW_OK,
    LL_ROW_STOPPED,  /* ended by the stop rule */
    LL_ROW_DIVERGED, /* the run diverged, or a part that has metrics; `error` names time and part */
    LL_ROW_REFUSED,  /* invalid combination of values; no metrics */
    LL_ROW_FAILED,   /* a part that has metrics failed or was not run: `error` names it and the reason */
    LL_ROW_SKIPPED,  /* not run: the point had enough runs (until.h) */
} ll_row_status;

extern const char *const ll_row_status_names[];

typedef struct ll_row {
    int64_t run;
    ll_row_status status;
    char error[200];
    uint64_t hash;                             /* of the final state */
    double t_s;                                /* virtual time at the end */
    double metrics[LL_EXPERIMENT_METRICS_MAX]; /* NaN: missing, as after a divergence or failure */
} ll_row;

/* Whether the run has all metrics. */
static inline bool ll_row_good(const ll_row *row)
{
    return row->status == LL_ROW_OK || row->status == LL_ROW_STOPPED;
}

void ll_row_clear(ll_row *row); /* all bytes 0, no metrics; rows are compared and stored as bytes */

/* Fails without memory, and with LL_INTERRUPTED. `interrupt` and `kept` may be NULL; a thread that makes many
 * runs passes them the same `kept`. */
ll_status ll_experiment_run(const ll_experiment *experiment, int64_t run, const ll_interrupt *interrupt,
                            ll_kept_block *kept, ll_row *row);

/* Merges values into a configuration and sets dependent ones. */
ll_status ll_experiment_apply(const ll_sim_kind *kind, const struct cJSON *values, void *config);

/* The scenario of a run, with the workload, to open it live. */
ll_status ll_experiment_open(const ll_experiment *experiment, int64_t run, ll_scenario *scenario);

/* Repeats a run, and has its ticks read from a copy at tick 0: up to `to`, where it ended, or the last tick
 * before it diverged. LL_BAD_INPUT: the run was refused. */
typedef ll_status ll_run_reader(void *context, ll_session *copy, int64_t to);
ll_status ll_experiment_read_run(const ll_experiment *experiment, int64_t run, const ll_interrupt *interrupt,
                                 ll_run_reader *read, void *context);

/* The trace of a run as CSV, as from `laglab run --trace`. */
ll_status ll_experiment_trace(const ll_experiment *experiment, int64_t run, const ll_interrupt *interrupt,
                              void (*write)(void *context, const char *text, size_t length), void *context);
