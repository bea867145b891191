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
    {"deterministic", "duration_s=20", "server.sync",
     "free,lockstep,lockstep_pipelined,deterministic,rollback", "server.update_hz", "10,20,30,60",
     "players.0.remote_error_m.mean", "players.0.input_latency_ms.mean", 10},
    {"crates", "duration_s=10", "players.0.prediction_scope", "own,contacts,all", "server.update_hz",
     "5,10,20,30,60", "players.0.own_timeline_error_m.mean", "players.0.bandwidth.down_bytes_per_s", 10},
    {"behind_cover", "duration_s=30", "server.hitscan", "none,rewind,client_authoritative",
     "server.max_rewind_ms", "50,100,200,400", "players.1.shots.hitscan.false_misses",
     "players.1.shots.hitscan.shot_behind_cover", 10},
    {"behind_cover", "duration_s=30,server.max_rewind_ms=1000", "server.hitscan", "hybrid",
     "policies.hybrid_none_ms", "150,250,350,500", "players.1.shots.hitscan.false_misses",
     "players.1.shots.hitscan.shot_behind_cover", 10},
    {"behind_cover", "duration_s=30,server.max_rewind_ms=1000", "server.hitscan", "victim_veto",
     "policies.veto_grace_ms", "1,50,100,200,400", "players.1.shots.hitscan.false_misses",
     "players.1.shots.hitscan.shot_behind_cover", 10},
    {"crates_delta", "duration_s=10,server.update_hz=60", "server.snapshot_encoding", "partial,partial_delta",
     "server.snapshot_bytes", "64,128,256,512", "players.0.remote_error_m.mean",
     "players.0.bandwidth.down_bytes_per_s", 10},
    {"swarm_interest", "duration_s=5", "server.snapshot_encoding", "partial,partial_delta,interest",
     "server.snapshot_bytes", "100,200,400,800,1600", "players.0.selection.near_error_m",
     "players.0.bandwidth.down_bytes_per_s", 10},
    {"deterministic", "duration_s=20", "server.sync", "bucket", "bucket_delay_ms", "50,100,150,200,300",
     "players.0.remote_error_m.mean", "players.0.input_latency_ms.mean", 10},
    {"deterministic", "duration_s=20,server.update_hz=60", "server.sync", "deterministic",
     "players.0.input_delay_ticks+players.1.input_delay_ticks+players.2.input_delay_ticks", "4,6,8,12,16",
     "players.0.remote_error_m.mean", "players.0.input_latency_ms.mean", 10},
    {"deterministic", "duration_s=20,server.update_hz=60", "server.sync", "rollback",
     "players.0.input_delay_ticks+players.1.input_delay_ticks+players.2.input_delay_ticks", "1,2,4,8,16",
     "players.0.remote_error_m.mean", "players.0.input_latency_ms.mean", 10},
    {"fluid/sea", "duration_s=1,params.tile=8,params.seed=SEED", "solver.method", "spectrum", "params.n",
     "8,16,32,64,128", "height_error", "significant_height_m", 10},
    {"fluid/sea", "duration_s=1,params.n=128,params.seed=SEED", "solver.method", "tiled", "params.tile",
     "8,16,32,64", "height_error", "significant_height_m", 10},
    {"fluid/sea", "duration_s=1,params.n=128,params.seed=SEED", "solver.method", "gerstner", "params.waves",
     "1,2,4,8,16,32,64", "height_error", "significant_height_m", 10},
    {"fluid/sea", "duration_s=1,params.tile=8,params.seed=SEED", "solver.method", "spectrum", "params.n",
     "8,16,32,64,128", "excess_kurtosis", "significant_height_m", 10},
    {"fluid/sea", "duration_s=1,params.n=128,params.seed=SEED", "solver.method", "tiled", "params.tile",
     "8,16,32,64", "excess_kurtosis", "significant_height_m", 10},
    {"fluid/sea", "duration_s=1,params.n=128,params.seed=SEED", "solver.method", "gerstner", "params.waves",
     "1,2,4,8,16,32,64", "excess_kurtosis", "significant_height_m", 10},
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

bool ll_list_next(const char **list, char *item, size_t size)
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

/* Copies the next of paths that are joined by `+`. */
static bool next_path(const char **paths, char *path, size_t size)
{
    size_t length = strcspn(*paths, "+");
    snprintf(path, size, "%.*s", (int)length, *paths);
    *paths += length + ((*paths)[length] == '+');
    return length > 0;
}

static ll_status put_value(ll_scenario *scenario, const char *paths, const char *value)
{
    char path[96], pair[160];
    ll_status status = ll_ok();
    while (!ll_failed(&status) && next_path(&paths, path, sizeof path)) {
        int length = snprintf(pair, sizeof pair, "%s=%s", path, value);
        if (length < 0 || (size_t)length >= sizeof pair)
            return ll_field_error(LL_BAD_INPUT, path, "%.60s: value is too long: %.60s", path, value);
        status = put_pair(scenario, pair);
    }
    return status;
}

/* A fixed pair, with the number of the run where it says so. */
static void fill_seed(char *pair, size_t size, int run)
{
    char *value = strchr(pair, '=');
    if (value && strcmp(value, "=SEED") == 0)
        snprintf(value, size - (size_t)(value - pair), "=%d", 1 + run);
}

/* Sets the values of the series, then those of the request, then those of the level; rules are checked once
 * all are set. */
static ll_status set_all(const ll_refinement_request *request, const ll_refinement_level *refinement_level,
                         int seed, ll_scenario *scenario)
{
    char pair[96];
    const ll_refinement_series *refinement_series = refinement_level->refinement_series;
    const ll_param_table *table = scenario->kind->table;
    ll_status status = ll_ok();
    for (const char *list = refinement_series->fixed;
         !ll_failed(&status) && ll_list_next(&list, pair, sizeof pair);) {
        fill_seed(pair, sizeof pair, seed);
        status = put_pair(scenario, pair);
    }
    LL_THEN(status, ll_param_put(table, scenario->config, request->sets, request->set_count));
    if (!ll_failed(&status) && request->duration)
        status = put_value(scenario, "duration_s", request->duration);
    LL_THEN(status, put_value(scenario, refinement_series->series, refinement_level->series));
    LL_THEN(status, put_value(scenario, refinement_series->setting, refinement_level->setting));
    return ll_failed(&status) ? status : ll_param_check(table, scenario->config);
}

/* What is not read is not observed, so that the time is that of the techniques. */
static void observe_only_what_is_read(const ll_refinement_request *request,
                                      const ll_refinement_series *refinement_series, ll_session *session)
{
    const char *paths[LL_REFINEMENT_COSTS_MAX + 2] = {refinement_series->error, refinement_series->counter};
    int count = 2;
    for (int i = 0; i < request->cost_count; i++)
        paths[count++] = request->costs[i];
    ll_session_observe_only(session, paths, count);
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
    if (before)
        status = set_all(request, refinement_level, seed, &scenario);
    else
        status = ll_error(LL_NO_MEMORY, "no memory for a scenario");
    if (!ll_failed(&status)) {
        scenario.kind->settle(scenario.config, before);
        ((ll_scenario_head *)scenario.config)->seed += seed;
        status = ll_session_open_forward(&scenario, NULL, session);
        if (!ll_failed(&status))
            observe_only_what_is_read(request, refinement_level->refinement_series, *session);
    } else {
        ll_scenario_free(&scenario);
    }
    free(before);
    return status;
}

typedef struct samples {
    int64_t took[LL_REFINEMENT_SERIES_SEEDS_MAX];
    double errors[LL_REFINEMENT_SERIES_SEEDS_MAX];
    double costs[LL_REFINEMENT_COSTS_MAX][LL_REFINEMENT_SERIES_SEEDS_MAX];
    int runs, cost_counts[LL_REFINEMENT_COSTS_MAX];
    ll_interval_request request, cost_requests[LL_REFINEMENT_COSTS_MAX];
} samples;

static void read_costs(const ll_refinement_request *request, ll_session *session, const ll_sim_kind *kind,
                       const cJSON *metrics, samples *s)
{
    cJSON *of_session = ll_session_cost(session);
    for (int i = 0; i < request->cost_count; i++) {
        const char *path = request->costs[i];
        bool of_metrics = strncmp(path, "cost.", 5) != 0;
        double value =
            fabs(of_metrics ? ll_metric_value(metrics, path) : ll_metric_value(of_session, path + 5));
        s->cost_requests[i].scale = of_metrics ? ll_metric_scale_of(kind, metrics, path) : LL_SCALE_AMOUNT;
        if (isfinite(value))
            s->costs[i][s->cost_counts[i]++] = value;
    }
    cJSON_Delete(of_session);
}

/* Adds a run's metrics to the level, whose error and counter are sums until finish(). */
static void read_metrics(const ll_refinement_request *request, ll_session *session, const ll_sim_kind *kind,
                         ll_refinement_level *refinement_level, samples *s)
{
    cJSON *metrics = ll_session_metric_values(session);
    double error = fabs(ll_metric_value(metrics, refinement_level->refinement_series->error));
    s->request.scale = ll_metric_scale_of(kind, metrics, refinement_level->refinement_series->error);
    if (isfinite(error))
        s->errors[refinement_level->seeds++] = error;
    refinement_level->counter += ll_metric_value(metrics, refinement_level->refinement_series->counter);
    read_costs(request, session, kind, metrics, s);
    cJSON_Delete(metrics);
}

static int by_size(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

/* One run, with the scenario's seed plus `seed`. */
static ll_status run_once(const ll_refinement_request *request, int seed, bool counts,
                          ll_refinement_level *refinement_level, samples *s)
{
    ll_session *session = NULL;
    const ll_sim_kind *kind = NULL;
    LL_TRY(open_refinement_level(request, refinement_level, seed, &kind, &session));
    int64_t from = request->now_ns();
    ll_status status =
        ll_session_run_within(session, ll_session_get_info(session).end_tick, request->interrupt);
    s->took[s->runs++] = request->now_ns() - from;
    refinement_level->diverged = status.code == LL_DIVERGED;
    if (!ll_failed(&status) && counts)
        read_metrics(request, session, kind, refinement_level, s);
    ll_session_destroy(session);
    return refinement_level->diverged ? ll_ok() : status;
}

/* The mean of `n` of the values, which it sorts. */
static ll_measured measured(ll_interval_request *request, double *values, int n, ll_resampler *resampler)
{
    request->values = values;
    request->n = n;
    request->error = 0.05;
    ll_summary summary = ll_summarise(request, values, resampler);
    return (ll_measured){summary.mean, summary.of_mean.low, summary.of_mean.high};
}

/* A cost that is missing in some runs has no mean of all. */
static ll_measured cost_of(samples *s, int cost, int seeds, ll_resampler *resampler)
{
    double *values = s->costs[cost];
    int n = s->cost_counts[cost];
    bool same = true;
    for (int i = 1; i < n; i++)
        same = same && values[i] == values[0];
    if (n == 0 || n < seeds)
        return (ll_measured){NAN, NAN, NAN};
    return same ? (ll_measured){values[0], values[0], values[0]}
                : measured(&s->cost_requests[cost], values, n, resampler);
}

/* Divides sums by counts. */
static void finish(ll_refinement_level *refinement_level, samples *s)
{
    ll_resampler resampler = {0};
    int seeds = refinement_level->seeds;
    refinement_level->error = refinement_level->error_low = refinement_level->error_high = NAN;
    if (refinement_level->diverged) {
        refinement_level->counter = NAN;
        refinement_level->seeds = 0;
    }
    if (refinement_level->seeds > 0) {
        ll_measured error = measured(&s->request, s->errors, seeds, &resampler);
        refinement_level->error = error.value;
        refinement_level->error_low = error.low;
        refinement_level->error_high = error.high;
    }
    for (int i = 0; i < LL_REFINEMENT_COSTS_MAX; i++)
        refinement_level->costs[i] =
            refinement_level->diverged ? (ll_measured){NAN, NAN, NAN} : cost_of(s, i, seeds, &resampler);
    ll_resampler_free(&resampler);
    qsort(s->took, (size_t)s->runs, sizeof *s->took, by_size);
    refinement_level->cpu_min_s = (double)s->took[0] * 1e-9;
    refinement_level->cpu_median_s = (double)s->took[s->runs / 2] * 1e-9;
    refinement_level->runs = s->runs;
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
            status = run_once(request, request->first_seed + n, true, refinement_level, s);
        else if (n == 0 || s->took[0] < LONG_NS)
            status = run_once(request, 0, n == 0, refinement_level, s);
    if (!ll_failed(&status)) {
        refinement_level->counter /= seeds > 0 ? seeds : 1;
        finish(refinement_level, s);
    }
    free(s);
    return status;
}

typedef struct text_end {
    char *text;
    int size, used;
} text_end;

static void add_pair(text_end *t, const char *paths, const char *value)
{
    char path[96];
    while (next_path(&paths, path, sizeof path)) {
        int room = t->size - t->used;
        int length = snprintf(t->text + t->used, (size_t)room, "%s%s=%s", t->used ? " " : "", path, value);
        t->used += length < room ? length : room - 1;
    }
}

void ll_refinement_level_sets(const ll_refinement_level *refinement_level,
                              const ll_refinement_request *request, char *text, int size)
{
    const ll_refinement_series *of = refinement_level->refinement_series;
    text_end t = {text, size, 0};
    char pair[96];
    text[0] = '\0';
    for (const char *list = of->fixed; ll_list_next(&list, pair, sizeof pair);) {
        fill_seed(pair, sizeof pair, request->first_seed);
        char *value = strchr(pair, '=');
        *value++ = '\0';
        if (!request->duration || strcmp(pair, "duration_s") != 0)
            add_pair(&t, pair, value);
    }
    for (int i = 0; i < request->set_count; i++) {
        snprintf(pair, sizeof pair, "%s", request->sets[i]);
        pair[strcspn(pair, "=")] = '\0';
        add_pair(&t, pair, request->sets[i] + strcspn(request->sets[i], "=") + 1);
    }
    if (request->duration)
        add_pair(&t, "duration_s", request->duration);
    add_pair(&t, of->series, refinement_level->series);
    add_pair(&t, of->setting, refinement_level->setting);
}

static bool next_series(ll_refinement_run *c)
{
    do
        if (!ll_list_next(&c->series, c->refinement_level.series, sizeof c->refinement_level.series))
            return false;
    while (!ll_list_contains(c->request->methods, c->refinement_level.series));
    c->settings = c->refinement_level.refinement_series->setting_values;
    c->refinement_level.error = NAN;
    return true;
}

int ll_refinement_series_count(const ll_refinement_series *refinement_series, const char *methods)
{
    char item[32];
    int series = 0, settings = 0;
    for (const char *list = refinement_series->series_values; ll_list_next(&list, item, sizeof item);)
        series += ll_list_contains(methods, item);
    for (const char *list = refinement_series->setting_values; ll_list_next(&list, item, sizeof item);)
        settings++;
    return series * settings;
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
    ll_list_next(&c->settings, refinement_level->setting, sizeof refinement_level->setting);
    *status = measure(c->request, refinement_level);
    if (refinement_level->error > 0 && before.error > 0)
        refinement_level->order = -log(refinement_level->error / before.error) /
                                  log(strtod(refinement_level->setting, NULL) / strtod(before.setting, NULL));
    return !ll_failed(status);
}
