#include "experiment/spec/internal.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "base/hash.h"

const char *const ll_row_status_names[] = {"ok", "stopped", "diverged", "refused", "failed", "skipped"};

void ll_row_clear(ll_row *row)
{
    memset(row, 0, sizeof *row);
    for (int i = 0; i < LL_EXPERIMENT_METRICS_MAX; i++)
        row->metrics[i] = NAN;
}

ll_sample_request ll_experiment_sample(const ll_experiment *e)
{
    return (ll_sample_request){(ll_sampling)e->head.sample.method, e->dimension_count, e->head.sample.count,
                               (uint64_t)e->head.sample.seed};
}

cJSON *ll_experiment_point(const ll_experiment *e, int64_t point)
{
    cJSON *values = cJSON_CreateObject(), *value[LL_EXPERIMENT_AXES_MAX];
    ll_sample_request sample = ll_experiment_sample(e);
    LL_ASSERT(point >= 0 && point < e->points);
    int64_t left = point;
    for (int a = e->axis_count - 1; a >= 0; a--) { /* the last axis varies fastest */
        const ll_axis *axis = &e->axes[a];
        if (sample.method != LL_SAMPLE_NONE) {
            value[a] = ll_axis_sample(axis, ll_sample_coordinate(&sample, e->dimension[a], point));
        } else {
            value[a] = ll_axis_at(axis, left % axis->count);
            if (a == 0 || e->dimension[a - 1] != e->dimension[a])
                left /= axis->count;
        }
    }
    LL_ASSERT(sample.method != LL_SAMPLE_NONE || e->axis_count == 0 || left == 0); /* all digits are used */
    for (int a = 0; a < e->axis_count; a++)
        cJSON_AddItemToObject(values, e->axes[a].path, value[a]);
    return values;
}

int64_t ll_experiment_seed(const ll_experiment *e, int64_t run)
{
    return ((const ll_scenario_head *)e->base.config)->seed + run % e->head.repeats;
}

char *ll_experiment_text(const ll_experiment *e)
{
    return cJSON_PrintUnformatted(e->json);
}

uint64_t ll_experiment_key(const ll_experiment *e)
{
    char *text = ll_experiment_text(e);
    uint64_t key = ll_hash(0, text, text ? strlen(text) : 0);
    free(text);
    return key;
}

ll_status ll_experiment_apply(const ll_sim_kind *kind, const cJSON *values, void *config)
{
    void *before = ll_param_clone(kind->table, config, NULL);
    if (!before)
        return ll_error(LL_NO_MEMORY, "out of memory: scenario");
    ll_status status = ll_param_merge(kind->table, values, config);
    if (!ll_failed(&status))
        kind->settle(config, before);
    free(before);
    return status;
}

ll_status ll_experiment_open(const ll_experiment *e, int64_t run, ll_scenario *scenario)
{
    LL_ASSERT(run >= 0 && run < e->points * e->head.repeats);
    cJSON *values = ll_experiment_point(e, run / e->head.repeats);
    *scenario = (ll_scenario){e->base.kind, ll_param_clone(e->base.kind->table, e->base.config, values)};
    if (!scenario->config) {
        cJSON_Delete(values);
        return ll_error(LL_NO_MEMORY, "out of memory: scenario");
    }
    ll_status status = ll_experiment_apply(scenario->kind, values, scenario->config);
    LL_THEN(status, ll_timeline_check(scenario->kind, scenario->config));
    cJSON_Delete(values);
    ((ll_scenario_head *)scenario->config)->seed = ll_experiment_seed(e, run);
    if (ll_failed(&status))
        ll_scenario_free(scenario);
    return status;
}

void ll_experiment_free(ll_experiment *e)
{
    if (!e)
        return;
    for (int i = 0; i < e->axis_count; i++)
        ll_axis_free(&e->axes[i]);
    ll_scenario_free(&e->base);
    ll_workload_free(e->workload);
    cJSON_Delete(e->json);
    free(e);
}
