#include "experiment/advise/refinement_series.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/spec/metric_path.h"
#include "experiment/statistics/summary.h"
#include "session/scenario.h"
#include "session/session.h"

enum { REPEATS = 3 };

#define LONG_NS 200000000 /* a longer run is not repeated */

const ll_refinement_series ll_refinement_series_table[] = {
    {"fluid/cavity", "duration_s=20", "solver.advection", "semi_lagrangian,maccormack,central", "params.n",
     "16,32,64", "error_max", "cell_visits", 0},
    {"fluid/cavity", "duration_s=5,params.n=32,solver.tolerance=0", "solver.pressure",
     "jacobi,gauss_seidel,sor,pcg,multigrid", "solver.sweeps", "1,2,4,8,16,32", "divergence_max",
     "cell_visits", 0},
    {"fluid/taylor_green", "duration_s=2,params.viscosity_m2ps=0.01", "solver.advection",
     "semi_lagrangian,maccormack,bfecc,central", "params.n", "16,32,64,128", "error_l2", "cell_visits", 0},
    {"fluid/rotation", "duration_s=1", "solver.advection", "semi_lagrangian,maccormack,bfecc", "params.n",
     "32,64,128", "error_l1", "cell_visits", 0},
    {"fluid/poiseuille", "duration_s=1,solver.iterations=30", "solver.method", "wcsph,pbf,dfsph",
     "params.size", "16,24,32,48", "velocity_error_rms", "cell_visits", 0},
    {"fluid/hydrostatic", "duration_s=5,solver.iterations=100", "solver.method", "wcsph,pbf,dfsph",
     "params.size", "10,20,40", "pressure_error_rms", "cell_visits", 0},
    {"fluid/hydrostatic", "duration_s=5,params.size=20", "solver.method", "pbf,dfsph", "solver.iterations",
     "1,2,4,8,16,32,64,128", "pressure_error_rms", "cell_visits", 0},
    {"rigid/column", "duration_s=3,side_by_side=[],params.offset=0", "solver.method",
     "soft_step,tgs_sticky,xpbd", "solver.substeps", "1,2,4,8,16,32", "sag_m", "passes_per_s", 0},
    {"rigid/pyramid", "duration_s=3", "solver.method", "soft_step,tgs_sticky,xpbd,avbd", "solver.substeps",
     "1,2,4,8,16", "drift_worst_m", "passes_per_s", 0},
    {"fluid/dam_break", "duration_s=1", "solver.method", "wcsph,pbf,dfsph", "params.size", "12,16,24,32",
     "front_error", "cell_visits", 0},
    {"crates_delta", "duration_s=10", "server.snapshot_encoding", "full,quantised,delta", "server.update_hz",
     "5,10,20,30,60", "players.0.remote_error_m.mean", "players.0.bandwidth.down_bytes_per_s", 10},
    {"hermite", "duration_s=20", "players.0.interpolation_method", "linear,hermite", "server.update_hz",
     "2,4,8,16,32", "players.0.timeline_error_m.mean", "players.0.bandwidth.down_bytes_per_s", 10},
    {"deterministic", "duration_s=20", "server.sync", "free,lockstep_pipelined,deterministic,rollback",
     "server.update_hz", "10,20,30,60", "players.0.remote_error_m.mean", "players.0.input_latency_ms.mean",
     10},
    {"crates", "duration_s=10", "players.0.prediction_scope", "own,contacts,all", "server.update_hz",
     "5,10,20,30,60", "players.0.own_timeline_error_m.mean", "players.0.bandwidth.down_bytes_per_s", 10},
    {"behind_cover", "duration_s=30", "server.hitscan", "none,rewind,client_authoritative",
     "server.max_rewind_ms", "50,100,200,400", "players.1.shots.hitscan.false_misses",
     "players.1.shots.hitscan.shot_behind_cover", 10},
    {0},
};

bool ll_list_contains(const char *list, const char *name)
{
    size_t length = strlen(name);
    for (const char *p = list; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL)
        if (strncmp(p, name, length) == 0 && (p[length] == ',' || p[length] == '\0'))
            return true;
    return list == NULL;
}

/* Copies the next item of a comma-separated list into `item`; false at its end. */
static bool next_item(const char **list, char *item, size_t size)
{
    if (**list == '\0')
        return false;
    size_t length = strcspn(*list, ",");
    snprintf(item, size, "%.*s", (int)length, *list);
    *list += length + ((*list)[length] == ',');
    return true;
}

static ll_status put_pair(ll_scenario *scenario, const char *pair)
{
    return ll_param_put(scenario->kind->table, scenario->config, &pair, 1);
}

static ll_status put_value(ll_scenario *scenario, const char *path, const char *value)
{
    char pair[160];
    int length = snprintf(pair, sizeof pair, "%s=%s", path, value);
    if (length < 0 || (size_t)length >= sizeof pair)
        return ll_field_error(LL_BAD_INPUT, path, "%.60s: value is too long: %.60s", path, value);
    return put_pair(scenario, pair);
}

/* Sets the values of the series, then those of the request, then those of the level; rules are checked once
 * all are set. */
static ll_status set_all(const ll_refinement_request *request, const ll_refinement_level *refinement_level,
                         ll_scenario *scenario)
{
    char pair[96];
    const ll_refinement_series *refinement_series = refinement_level->refinement_series;
    const ll_param_table *table = scenario->kind->table;
    ll_status status = ll_ok();
    for (const char *list = refinement_series->fixed;
         !ll_failed(&status) && next_item(&list, pair, sizeof pair);)
        status = put_pair(scenario, pair);
    LL_THEN(status, ll_param_put(table, scenario->config, request->sets, request->set_count));
    if (!ll_failed(&status) && request->duration)
        status = put_value(scenario, "duration_s", request->duration);
    LL_THEN(status, put_value(scenario, refinement_series->series, refinement_level->series));
    LL_THEN(status, put_value(scenario, refinement_series->setting, refinement_level->setting));
    return ll_failed(&status) ? status : ll_param_check(table, scenario->config);
}

static ll_status open_refinement_level(const ll_refinement_request *request,
                                       const ll_refinement_level *refinement_level, int seed,
                                       const ll_sim_kind **kind, ll_session **session)
{
    ll_scenario scenario = {0};
    ll_status status = ll_scenario_parse(request->scenario, &scenario);
    if (ll_failed(&status))
        return status;
    *kind = scenario.kind;
    void *before = ll_param_clone(scenario.kind->table, scenario.config, NULL);
    if (before) {
        status = set_all(request, refinement_level, &scenario);
    } else {
        status = ll_error(LL_NO_MEMORY, "no memory for a scenario");
    }
    if (!ll_failed(&status)) {
        scenario.kind->settle(scenario.config, before);
        ((ll_scenario_head *)scenario.config)->seed += seed;
        status = ll_session_open(&scenario, NULL, NULL, session);
    } else {
        ll_scenario_free(&scenario);
    }
    free(before);
    return status;
}

/* Adds a run's metrics to the level, whose error and counter are sums until finish(). */
static void read_metrics(ll_session *session, const ll_sim_kind *kind, ll_refinement_level *refinement_level,
                         double *errors, ll_interval_request *request)
{
    cJSON *report = ll_session_metrics(session);
    const cJSON *metrics = cJSON_GetObjectItemCaseSensitive(report, "metrics");
    double error = fabs(ll_metric_value(metrics, refinement_level->refinement_series->error));
    request->scale = ll_metric_scale_of(kind, metrics, refinement_level->refinement_series->error);
    if (isfinite(error))
        errors[refinement_level->seeds++] = error;
    refinement_level->counter += ll_metric_value(metrics, refinement_level->refinement_series->counter);
    cJSON_Delete(report);
}

static int by_size(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

typedef struct samples {
    int64_t took[LL_REFINEMENT_SERIES_SEEDS_MAX];
    double errors[LL_REFINEMENT_SERIES_SEEDS_MAX];
    int runs;
    ll_interval_request request;
} samples;

/* One run, with the scenario's seed plus `seed`. */
static ll_status run_once(const ll_refinement_request *request, int seed, bool counts,
                          ll_refinement_level *refinement_level, samples *s)
{
    ll_session *session = NULL;
    const ll_sim_kind *kind = NULL;
    LL_TRY(open_refinement_level(request, refinement_level, seed, &kind, &session));
    int64_t from = request->now_ns();
    ll_status status = ll_session_run_to(session, ll_session_get_info(session).end_tick);
    s->took[s->runs++] = request->now_ns() - from;
    refinement_level->diverged = status.code == LL_DIVERGED;
    if (!ll_failed(&status) && counts)
        read_metrics(session, kind, refinement_level, s->errors, &s->request);
    ll_session_destroy(session);
    return refinement_level->diverged ? ll_ok() : status;
}

/* Divides sums by counts. */
static void finish(ll_refinement_level *refinement_level, samples *s)
{
    ll_resampler resampler = {0};
    s->request.values = s->errors;
    s->request.n = refinement_level->seeds;
    s->request.error = 0.05;
    refinement_level->error = refinement_level->error_low = refinement_level->error_high = NAN;
    if (refinement_level->diverged) {
        refinement_level->counter = NAN;
        refinement_level->seeds = 0;
    }
    if (refinement_level->seeds > 0 && !refinement_level->diverged) {
        ll_summary summary = ll_summarise(&s->request, s->errors, &resampler);
        refinement_level->error = summary.mean;
        refinement_level->error_low = summary.of_mean.low;
        refinement_level->error_high = summary.of_mean.high;
    }
    ll_resampler_free(&resampler);
    qsort(s->took, (size_t)s->runs, sizeof *s->took, by_size);
    refinement_level->cpu_min_s = (double)s->took[0] * 1e-9;
    refinement_level->cpu_median_s = (double)s->took[s->runs / 2] * 1e-9;
}

/* Runs every seed once, or repeats one run to measure its time. */
static ll_status measure(const ll_refinement_request *request, ll_refinement_level *refinement_level)
{
    samples *s = calloc(1, sizeof *s);
    int seeds = refinement_level->refinement_series->seeds == 0 ? 0
                : request->seeds > 0                            ? request->seeds
                                                                : refinement_level->refinement_series->seeds;
    ll_status status = s ? ll_ok() : ll_error(LL_NO_MEMORY, "out of memory: refinement level");
    refinement_level->order = NAN;
    refinement_level->error = refinement_level->counter = 0;
    refinement_level->seeds = 0;
    refinement_level->diverged = false;
    for (int n = 0; !ll_failed(&status) && !refinement_level->diverged && n < (seeds ? seeds : REPEATS); n++)
        if (seeds > 0)
            status = run_once(request, n, true, refinement_level, s);
        else if (n == 0 || s->took[0] < LONG_NS)
            status = run_once(request, 0, n == 0, refinement_level, s);
    if (!ll_failed(&status)) {
        refinement_level->counter /= seeds > 0 ? seeds : 1;
        finish(refinement_level, s);
    }
    free(s);
    return status;
}

static bool next_series(ll_refinement_run *c)
{
    do
        if (!next_item(&c->series, c->refinement_level.series, sizeof c->refinement_level.series))
            return false;
    while (!ll_list_contains(c->request->methods, c->refinement_level.series));
    c->settings = c->refinement_level.refinement_series->setting_values;
    c->refinement_level.error = NAN;
    return true;
}

ll_refinement_run ll_refinement_series_start(const ll_refinement_series *refinement_series,
                                             const ll_refinement_request *request)
{
    return (ll_refinement_run){.request = request,
                               .series = refinement_series->series_values,
                               .settings = "",
                               .refinement_level = {.refinement_series = refinement_series}};
}

bool ll_refinement_series_next(ll_refinement_run *c, ll_status *status)
{
    ll_refinement_level *refinement_level = &c->refinement_level, before;
    if (*c->settings == '\0' && !next_series(c))
        return false;
    before = *refinement_level;
    next_item(&c->settings, refinement_level->setting, sizeof refinement_level->setting);
    *status = measure(c->request, refinement_level);
    if (refinement_level->error > 0 && before.error > 0)
        refinement_level->order = -log(refinement_level->error / before.error) /
                                  log(strtod(refinement_level->setting, NULL) / strtod(before.setting, NULL));
    return !ll_failed(status);
}
