/* Parses a specification, and checks all that needs no runs. */
#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/spec/internal.h"
#include "experiment/spec/metric_path.h"
#include "experiment/spec/until.h"
#include "library/library.h"
#include "session/session.h"

/* Replaces the scenario's id by the scenario. */
static ll_status read_scenario(ll_experiment *e, const char *scenarios)
{
    cJSON *scenario = cJSON_GetObjectItemCaseSensitive(e->json, "scenario"), *loaded = NULL;
    if (!cJSON_IsString(scenario) && !cJSON_IsObject(scenario))
        return ll_field_error(LL_BAD_INPUT, "scenario",
                              "scenario: must be an id of the library, or a scenario");
    ll_status status = ll_ok();
    if (cJSON_IsString(scenario)) {
        status = ll_scenario_load(scenarios, scenario->valuestring, &loaded);
        if (status.code == LL_NOT_FOUND)
            status.code = LL_BAD_INPUT;
        if (ll_failed(&status))
            return status;
        snprintf(e->head.scenario_id, sizeof e->head.scenario_id, "%s", scenario->valuestring);
        cJSON_DeleteItemFromObjectCaseSensitive(e->json, "scenario_id");
        cJSON_AddStringToObject(e->json, "scenario_id", e->head.scenario_id);
        cJSON_ReplaceItemInObjectCaseSensitive(e->json, "scenario", loaded);
        scenario = loaded;
    }
    status = ll_scenario_parse(scenario, &e->base);
    if (ll_failed(&status))
        return ll_field_error(LL_BAD_INPUT, "scenario", "scenario: %s", status.text);
    return status;
}

static ll_status read_set(ll_experiment *e)
{
    e->set = cJSON_GetObjectItemCaseSensitive(e->json, "set");
    if (!e->set)
        return ll_ok();
    if (!cJSON_IsObject(e->set))
        return ll_field_error(LL_BAD_INPUT, "set", "set: must be an object of values by path");
    if (cJSON_HasObjectItem(e->set, "kind"))
        return ll_field_error(LL_BAD_INPUT, "set.kind", "set: must not have kind");
    ll_status status = ll_experiment_apply(e->base.kind, e->set, e->base.config);
    if (!ll_failed(&status))
        return status;
    char field[80];
    snprintf(field, sizeof field, "set.%s", status.field);
    return ll_field_error(LL_BAD_INPUT, field, "set: %s", status.text);
}

/* Replaces the source of the workload by its inputs: the inputs are what is kept, and what the key depends
 * on. */
static ll_status read_workload(ll_experiment *e)
{
    const cJSON *workload = cJSON_GetObjectItemCaseSensitive(e->json, "workload");
    if (!workload)
        return ll_ok();
    ll_status status = ll_workload_parse(workload, &e->workload);
    if (!ll_failed(&status))
        cJSON_ReplaceItemInObjectCaseSensitive(e->json, "workload", ll_workload_write(e->workload));
    return status;
}

enum { POINTS_LOOKED_AT = 1000 }; /* points checked for a player that takes the workload's inputs */

/* At the scenario itself (-1) or a point. Refused points are reported in their rows. */
static ll_status check_workload_at(const ll_experiment *e, int64_t point)
{
    ll_scenario scenario = {0};
    if (point < 0)
        return ll_workload_check(e->workload, e->base.kind, e->base.config);
    ll_status status = ll_experiment_open(e, point * e->head.repeats, &scenario);
    if (status.code == LL_BAD_INPUT)
        return ll_error(LL_CONFLICT, "point %lld is refused", (long long)point);
    LL_THEN(status, ll_workload_check(e->workload, scenario.kind, scenario.config));
    ll_scenario_free(&scenario);
    return status;
}

static ll_status check_workload(const ll_experiment *e, const ll_interrupt *interrupt)
{
    if (!e->workload)
        return ll_ok();
    ll_status base = check_workload_at(e, -1), status = base;
    ll_pace pace = ll_pace_by(interrupt, 1);
    for (int64_t p = 0; status.code == LL_CONFLICT && p < e->points && p < POINTS_LOOKED_AT; p++) {
        status = check_workload_at(e, p);
        if (!ll_goes_on(&pace))
            return ll_error(LL_INTERRUPTED, "workload: checked with %lld points", (long long)p + 1);
    }
    if (status.code != LL_CONFLICT)
        return status;
    return ll_field_error(LL_BAD_INPUT, "workload", "%s", base.text);
}

static ll_status add_axis(ll_experiment *e, const cJSON *json, const char *field)
{
    if (e->axis_count == LL_EXPERIMENT_AXES_MAX)
        return ll_field_error(LL_BAD_INPUT, "axes", "axes: must be at most %d", LL_EXPERIMENT_AXES_MAX);
    ll_axis *axis = &e->axes[e->axis_count];
    bool sampled = e->head.sample.method != LL_SAMPLE_NONE;
    LL_TRY(ll_axis_parse(json, field, sampled, e->base.kind->table, e->base.config, axis));
    e->dimension[e->axis_count] = e->dimension_count;
    e->axis_count++;
    for (int i = 0; i < e->axis_count - 1; i++)
        if (strcmp(e->axes[i].path, axis->path) == 0)
            return ll_field_error(LL_BAD_INPUT, field, "%s.path: %s is on another axis", field, axis->path);
    return ll_ok();
}

static ll_status add_zip(ll_experiment *e, const cJSON *zip, const char *field)
{
    int first = e->axis_count, i = 0;
    const cJSON *item;
    if (!cJSON_IsArray(zip) || cJSON_GetArraySize(zip) == 0)
        return ll_field_error(LL_BAD_INPUT, field, "%s.zip: must be an array of axes", field);
    cJSON_ArrayForEach(item, zip)
    {
        char inner[64];
        snprintf(inner, sizeof inner, "%s.zip.%d", field, i++);
        LL_TRY(add_axis(e, item, inner));
        const ll_axis *a = &e->axes[first], *b = &e->axes[e->axis_count - 1];
        if (a->count != b->count)
            return ll_field_error(
                LL_BAD_INPUT, inner,
                "%s has %lld values, but %s.zip.0 has %lld; zipped axes must have the same number", inner,
                (long long)b->count, field, (long long)a->count);
    }
    return ll_ok();
}

static ll_status read_axes(ll_experiment *e)
{
    const cJSON *axes = cJSON_GetObjectItemCaseSensitive(e->json, "axes"), *item;
    int i = 0;
    if (axes && !cJSON_IsArray(axes))
        return ll_field_error(LL_BAD_INPUT, "axes", "axes: must be an array");
    cJSON_ArrayForEach(item, axes)
    {
        char field[32];
        const cJSON *zip = cJSON_GetObjectItemCaseSensitive(item, "zip");
        snprintf(field, sizeof field, "axes.%d", i++);
        if (zip && cJSON_GetArraySize(item) > 1)
            return ll_field_error(LL_BAD_INPUT, field, "%s: must have only zip", field);
        LL_TRY(zip ? add_zip(e, zip, field) : add_axis(e, item, field));
        e->dimension_count++;
    }
    return ll_ok();
}

static ll_status check_axes(const ll_experiment *e, const ll_interrupt *interrupt)
{
    ll_status status = ll_ok();
    for (int a = 0; a < e->axis_count && !ll_failed(&status); a++)
        status = ll_axis_check_values(&e->axes[a], e->base.kind->table, e->base.config, interrupt);
    return status;
}

static ll_status count_runs(ll_experiment *e)
{
    double points = 1;
    char product[96] = "";
    for (int a = 0; a < e->axis_count; a++) {
        if (a > 0 && e->dimension[a] == e->dimension[a - 1])
            continue;
        points *= (double)e->axes[a].count;
        size_t used = strlen(product);
        snprintf(product + used, sizeof product - used, "%s%lld", a ? " x " : "",
                 (long long)e->axes[a].count);
    }
    if (e->head.sample.method != LL_SAMPLE_NONE) {
        ll_sample_request sample = ll_experiment_sample(e);
        points = (double)ll_sample_points(&sample);
        snprintf(product, sizeof product, "%.0f", points);
    }
    if (points * (double)e->head.repeats > LL_EXPERIMENT_RUNS_MAX)
        return ll_field_error(LL_BAD_INPUT, "axes",
                              "axes: have %s points, with %lld repeats %.6g runs; must be at most %d runs",
                              product, (long long)e->head.repeats, points * (double)e->head.repeats,
                              LL_EXPERIMENT_RUNS_MAX);
    e->points = (int64_t)points;
    e->runs = e->points * e->head.repeats;
    if (e->head.traces && e->runs > LL_EXPERIMENT_TRACES_MAX)
        return ll_field_error(LL_BAD_INPUT, "traces", "traces: must have at most %d runs; got %lld",
                              LL_EXPERIMENT_TRACES_MAX, (long long)e->runs);
    return ll_ok();
}

/* ---- metrics ---- */

static ll_status find_metric(const ll_experiment *e, const char *field, const char *path, int standard,
                             int *index)
{
    *index = standard < e->metric_count ? standard : -1;
    for (int i = 0; path[0] && i < e->metric_count; i++)
        if (strcmp(e->metrics[i], path) == 0) {
            *index = i;
            return ll_ok();
        }
    return path[0] ? ll_field_error(LL_BAD_INPUT, field, "%s: must be one of the metrics; got %.100s", field,
                                    path)
                   : ll_ok();
}

static ll_status read_trade(ll_experiment *e)
{
    ll_status status = find_metric(e, "error", e->head.error, 0, &e->error_metric);
    return ll_failed(&status) ? status : find_metric(e, "cost", e->head.cost, 1, &e->cost_metric);
}

/* Metrics of the Pareto front; default: cost and error, if there is a cost. */
static ll_status read_front(ll_experiment *e)
{
    const cJSON *front = cJSON_GetObjectItemCaseSensitive(e->json, "front"), *item;
    if (!front && e->cost_metric >= 0) {
        e->front[e->front_count++] = e->cost_metric;
        e->front[e->front_count++] = e->error_metric;
    }
    if (front && (!cJSON_IsArray(front) || cJSON_GetArraySize(front) < 2 ||
                  cJSON_GetArraySize(front) > LL_EXPERIMENT_METRICS_MAX))
        return ll_field_error(LL_BAD_INPUT, "front", "front: must be an array of 2 to %d of the metrics",
                              LL_EXPERIMENT_METRICS_MAX);
    cJSON_ArrayForEach(item, front)
    {
        char field[32];
        int metric;
        snprintf(field, sizeof field, "front.%d", e->front_count);
        if (!cJSON_IsString(item) || !item->valuestring[0])
            return ll_field_error(LL_BAD_INPUT, field, "%s: must be one of the metrics", field);
        LL_TRY(find_metric(e, field, item->valuestring, -1, &metric));
        for (int i = 0; i < e->front_count; i++)
            if (e->front[i] == metric)
                return ll_field_error(LL_BAD_INPUT, field, "%s: duplicate %.100s", field, item->valuestring);
        e->front[e->front_count++] = metric;
    }
    return ll_ok();
}

static ll_status check_until(const ll_experiment *e)
{
    bool extreme = e->scales[e->until_metric] == LL_SCALE_EXTREME && e->head.interval != LL_INTERVALS_T;
    if (!ll_until_is_set(e))
        return ll_ok();
    if (e->head.until.least > e->head.repeats)
        return ll_field_error(LL_BAD_INPUT, "until.least",
                              "until.least: must be at most repeats, which is %lld; got %lld",
                              (long long)e->head.repeats, (long long)e->head.until.least);
    if (extreme)
        return ll_field_error(
            LL_BAD_INPUT, "until.metric",
            "until.metric: must have an interval of the mean; that of %s depends on rare runs",
            e->metrics[e->until_metric]);
    return ll_ok();
}

static ll_status check_metric(ll_experiment *e, const char *field, const char *path, const cJSON *present,
                              ll_session *session)
{
    if (strchr(path, '@'))
        return ll_windowed_parse(e, field, path, present, session, &e->windowed[e->metric_count]);
    return ll_metric_is_cost(path) ? ll_ok() : ll_metric_check(present, field, path);
}

static ll_status read_metrics(ll_experiment *e, const cJSON *present, ll_session *session)
{
    const cJSON *metrics = cJSON_GetObjectItemCaseSensitive(e->json, "metrics"), *item;
    if (!cJSON_IsArray(metrics) || cJSON_GetArraySize(metrics) == 0 ||
        cJSON_GetArraySize(metrics) > LL_EXPERIMENT_METRICS_MAX)
        return ll_field_error(
            LL_BAD_INPUT, "metrics",
            "metrics: must be an array of 1 to %d paths, such as \"players.0.remote_error_m.mean\"",
            LL_EXPERIMENT_METRICS_MAX);
    cJSON_ArrayForEach(item, metrics)
    {
        char field[32];
        snprintf(field, sizeof field, "metrics.%d", e->metric_count);
        if (!cJSON_IsString(item) || strlen(item->valuestring) > LL_EXPERIMENT_PATH_MAX)
            return ll_field_error(LL_BAD_INPUT, field, "%s: must be a path of at most %d characters", field,
                                  LL_EXPERIMENT_PATH_MAX);
        LL_TRY(check_metric(e, field, item->valuestring, present, session));
        for (int i = 0; i < e->metric_count; i++)
            if (strcmp(e->metrics[i], item->valuestring) == 0)
                return ll_field_error(LL_BAD_INPUT, field, "%s: duplicate %s", field, item->valuestring);
        e->scales[e->metric_count] = ll_metric_scale_of(e->base.kind, present, item->valuestring);
        snprintf(e->metrics[e->metric_count++], sizeof e->metrics[0], "%s", item->valuestring);
    }
    LL_TRY(read_trade(e));
    LL_TRY(find_metric(e, "until.metric", e->head.until.metric, e->error_metric, &e->until_metric));
    LL_TRY(read_front(e));
    LL_TRY(check_until(e));
    return e->head.stop.metric[0] ? ll_metric_check(present, "stop.metric", e->head.stop.metric) : ll_ok();
}

/* ---- whole ---- */

/* Checks paths of metrics with the metrics of the first point at its first tick, or of the scenario itself
 * when the first point's values are refused. */
static ll_status check_with_metrics(ll_experiment *e)
{
    ll_scenario scenario;
    ll_session *session = NULL;
    ll_status status = ll_experiment_open(e, 0, &scenario);
    if (status.code == LL_BAD_INPUT) {
        scenario = (ll_scenario){e->base.kind, ll_param_clone(e->base.kind->table, e->base.config, NULL)};
        if (!scenario.config)
            return ll_error(LL_NO_MEMORY, "out of memory: scenario");
        status = ll_ok();
    }
    LL_THEN(status, ll_session_open_forward(&scenario, NULL, &session));
    if (ll_failed(&status))
        return status;
    cJSON *metrics = ll_session_metric_values(session);
    status = ll_windows_check(e, session);
    LL_THEN(status, read_metrics(e, metrics, session));
    cJSON_Delete(metrics);
    ll_session_destroy(session);
    return status;
}

/* The number of runs before each value of the axes, which takes longest. */
ll_status ll_experiment_parse(const cJSON *json, const char *scenarios, const ll_interrupt *interrupt,
                              ll_experiment **experiment)
{
    *experiment = NULL;
    if (!cJSON_IsObject(json))
        return ll_error(LL_BAD_INPUT, "experiment: must be a JSON object");
    ll_experiment *e = calloc(1, sizeof *e);
    if (!e || !(e->json = cJSON_Duplicate(json, true))) {
        free(e);
        return ll_error(LL_NO_MEMORY, "out of memory: experiment");
    }
    ll_status status = ll_experiment_read_head(json, &e->head);
    LL_THEN(status, read_scenario(e, scenarios));
    LL_THEN(status, read_set(e));
    LL_THEN(status, read_axes(e));
    LL_THEN(status, count_runs(e));
    LL_THEN(status, check_axes(e, interrupt));
    LL_THEN(status, read_workload(e));
    LL_THEN(status, check_workload(e, interrupt));
    LL_THEN(status, check_with_metrics(e));
    if (ll_failed(&status)) {
        ll_experiment_free(e);
        return status;
    }
    *experiment = e;
    return ll_ok();
}
