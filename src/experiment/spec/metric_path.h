/* Paths into the metrics of a run, such as `players.0.remote_error_m.mean`. */
#pragma once

#include "experiment/statistics/interval.h"
#include "sim/core/sim.h"

struct cJSON;

/* LL_BAD_INPUT for `field` if the path has no number; the message lists what exists. */
ll_status ll_metric_check(const struct cJSON *metrics, const char *field, const char *path);

const struct cJSON *ll_metric_at(const struct cJSON *metrics, const char *path); /* NULL: none */

double ll_metric_value(const struct cJSON *metrics, const char *path); /* NaN: no such number */

/* The part of the metrics on the way to `path` whose `status` is not `ok` (base/run_status.h): then the value
 * at the path is not a measurement. NULL: none. `where` is set to its path, empty for the whole. */
const struct cJSON *ll_metric_failed_part(const struct cJSON *metrics, const char *path, char *where,
                                          int size);

/* Whether the kind declares the metric at the path as signed: better the closer it is to 0. Comparisons take
 * the magnitude of every metric; for signed ones the sign has a meaning too. */
bool ll_metric_is_signed(const ll_sim_kind *kind, const char *path);

/* The scale of the values at the path; `metrics` of a run shows which are flags. Only events that come one by
 * one are counts, whose number is nearly Poisson distributed; events in bursts (corrections after a loss,
 * packets, bytes) and all others are amounts. */
ll_metric_scale ll_metric_scale_of(const ll_sim_kind *kind, const struct cJSON *metrics, const char *path);

/* `cost.ns_per_sim_s` is measured, and not among the metrics of a run: processor time in ns per second of
 * simulated time. It differs each time. */
bool ll_metric_is_cost(const char *path);

/* Whether it is a count per second of the counted time, which begins at warmup_s. */
bool ll_metric_is_rate(const char *path);
