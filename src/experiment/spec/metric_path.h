/* Paths into the metrics of a run, such as `players.0.remote_error_m.mean`. */
#pragma once

#include "experiment/statistics/interval.h"
#include "sim/core/sim.h"

struct cJSON;

/* LL_BAD_INPUT for `field`: there is no number at the path; the sentence tells what there is. */
ll_status ll_metric_check(const struct cJSON *metrics, const char *field, const char *path);

double ll_metric_value(const struct cJSON *metrics, const char *path); /* NaN where there is none */

/* The part of the metrics on the way to `path` that has a `status` other than `ok` (base/run_status.h): what
 * the path leads to is then nothing measured. NULL: there is none. `where` is set to its path, empty for the
 * whole. */
const struct cJSON *ll_metric_failed_part(const struct cJSON *metrics, const char *path, char *where,
                                          int size);

/* Whether the kind declares the metric at the path as one that may be below 0 and is better the nearer it is
 * to 0. Comparisons take the magnitude of every metric; of these the sign says something beside. */
bool ll_metric_is_signed(const ll_sim_kind *kind, const char *path);

/* What the values at the path are, whose value in `metrics` of some run tells flags: counts are only those of
 * events that come one by one, so that their number is near to Poisson's; what comes in bursts (corrections
 * after a loss, packets, bytes) and all else is an amount. */
ll_metric_scale ll_metric_scale_of(const ll_sim_kind *kind, const struct cJSON *metrics, const char *path);

/* `cost.ns_per_sim_s`, which is measured beside a run and is none of its own metrics: nanoseconds of a
 * processor's time for a second of simulated time. It differs each time. */
bool ll_metric_is_cost(const char *path);

/* Whether it is a count for each second that was counted: from warmup_s on. */
bool ll_metric_is_rate(const char *path);
