#include "experiment/ladder.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/scenario.h"
#include "session/session.h"

enum { REPEATS = 3 };

#define LONG_NS 200000000 /* a run of more than so long is not repeated */

const ll_ladder ll_ladders[] = {
    {"fluid/cavity", "duration_s=20", "solver.advection", "semi_lagrangian,maccormack,central", "params.n",
     "16,32,64", "error_max", "visits"},
    {"fluid/cavity", "duration_s=5,params.n=32,solver.tolerance=0", "solver.pressure",
     "jacobi,gauss_seidel,sor,pcg,multigrid", "solver.sweeps", "1,2,4,8,16,32", "divergence_max", "visits"},
    {"fluid/taylor_green", "duration_s=2,params.viscosity_m2ps=0.01", "solver.advection",
     "semi_lagrangian,maccormack,bfecc,central", "params.n", "16,32,64,128", "error_l2", "visits"},
    {"fluid/rotation", "duration_s=1", "solver.advection", "semi_lagrangian,maccormack,bfecc", "params.n",
     "32,64,128", "error_l1", "visits"},
    {"fluid/poiseuille", "duration_s=1,solver.iterations=30", "solver.method", "wcsph,pbf,dfsph",
     "params.size", "16,24,32,48", "velocity_error_rms", "visits"},
    {"fluid/hydrostatic", "duration_s=5,solver.iterations=100", "solver.method", "wcsph,pbf,dfsph",
     "params.size", "10,20,40", "pressure_error_rms", "visits"},
    {"fluid/hydrostatic", "duration_s=5,params.size=20", "solver.method", "pbf,dfsph", "solver.iterations",
     "1,2,4,8,16,32,64,128", "pressure_error_rms", "visits"},
    {"rigid/column", "duration_s=3,beside=[],params.offset=0", "solver.method", "soft_step,tgs_sticky,xpbd",
     "solver.substeps", "1,2,4,8,16,32", "sag_m", "passes_per_s"},
    {0},
};

bool ll_listed(const char *list, const char *name)
{
    size_t length = strlen(name);
    for (const char *p = list; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL)
        if (strncmp(p, name, length) == 0 && (p[length] == ',' || p[length] == '\0'))
            return true;
    return list == NULL;
}

/* Cuts the next of a comma-separated list into `item`; false at its end. */
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
        return ll_field_error(LL_BAD_INPUT, path, "%.60s is too long a value: %.60s", path, value);
    return put_pair(scenario, pair);
}

/* What the ladder wants, then what was asked for, then the rung; rules hold for all of it together. */
static ll_status set_all(const ll_ladder_order *order, const ll_rung *rung, ll_scenario *scenario)
{
    char pair[96];
    const ll_ladder *ladder = rung->ladder;
    const ll_param_table *table = scenario->kind->table;
    ll_status status = ll_ok();
    for (const char *list = ladder->fixed; !ll_failed(&status) && next_item(&list, pair, sizeof pair);)
        status = put_pair(scenario, pair);
    if (!ll_failed(&status))
        status = ll_param_put(table, scenario->config, order->sets, order->set_count);
    if (!ll_failed(&status) && order->duration)
        status = put_value(scenario, "duration_s", order->duration);
    if (!ll_failed(&status))
        status = put_value(scenario, ladder->series, rung->series);
    if (!ll_failed(&status))
        status = put_value(scenario, ladder->setting, rung->setting);
    return ll_failed(&status) ? status : ll_param_check(table, scenario->config);
}

static ll_status open_rung(const ll_ladder_order *order, const ll_rung *rung, ll_session **session)
{
    ll_scenario scenario = {0};
    ll_status status = ll_scenario_parse(order->scenario, &scenario);
    if (ll_failed(&status))
        return status;
    size_t size = scenario.kind->table->size;
    void *before = malloc(size);
    if (before) {
        memcpy(before, scenario.config, size);
        status = set_all(order, rung, &scenario);
    } else {
        status = ll_error(LL_NO_MEMORY, "no memory for a scenario");
    }
    if (!ll_failed(&status)) {
        scenario.kind->settle(scenario.config, before);
        status = ll_session_open(&scenario, NULL, NULL, session);
    } else {
        ll_scenario_free(&scenario);
    }
    free(before);
    return status;
}

static double number(const cJSON *metrics, const char *name)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(metrics, name);
    if (cJSON_IsRaw(item)) /* to the last digit */
        return strtod(item->valuestring, NULL);
    return cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static void read_metrics(ll_session *session, ll_rung *rung)
{
    cJSON *report = ll_session_metrics(session);
    const cJSON *metrics = cJSON_GetObjectItemCaseSensitive(report, "metrics");
    rung->error = fabs(number(metrics, rung->ladder->error));
    rung->counter = number(metrics, rung->ladder->counter);
    cJSON_Delete(report);
}

static int by_size(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static ll_status measure(const ll_ladder_order *order, ll_rung *rung)
{
    int64_t took[REPEATS];
    int n = 0;
    rung->error = rung->counter = rung->order = NAN;
    do {
        ll_session *session = NULL;
        ll_status status = open_rung(order, rung, &session);
        if (ll_failed(&status))
            return status;
        int64_t from = order->now_ns();
        status = ll_session_run_to(session, ll_session_get_info(session).end_tick);
        took[n++] = order->now_ns() - from;
        rung->diverged = status.code == LL_DIVERGED;
        if (!ll_failed(&status))
            read_metrics(session, rung);
        ll_session_destroy(session);
        if (ll_failed(&status) && !rung->diverged)
            return status;
    } while (n < REPEATS && took[0] < LONG_NS);
    qsort(took, (size_t)n, sizeof *took, by_size);
    rung->cpu_min_s = (double)took[0] * 1e-9;
    rung->cpu_median_s = (double)took[n / 2] * 1e-9;
    return ll_ok();
}

static bool next_series(ll_climb *c)
{
    do
        if (!next_item(&c->series, c->rung.series, sizeof c->rung.series))
            return false;
    while (!ll_listed(c->order->methods, c->rung.series));
    c->settings = c->rung.ladder->setting_values;
    c->rung.error = NAN;
    return true;
}

ll_climb ll_ladder_start(const ll_ladder *ladder, const ll_ladder_order *order)
{
    return (ll_climb){
        .order = order, .series = ladder->series_values, .settings = "", .rung = {.ladder = ladder}};
}

bool ll_ladder_next(ll_climb *c, ll_status *status)
{
    ll_rung *rung = &c->rung, before;
    if (*c->settings == '\0' && !next_series(c))
        return false;
    before = *rung;
    next_item(&c->settings, rung->setting, sizeof rung->setting);
    *status = measure(c->order, rung);
    if (rung->error > 0 && before.error > 0)
        rung->order = -log(rung->error / before.error) /
                      log(strtod(rung->setting, NULL) / strtod(before.setting, NULL));
    return !ll_failed(status);
}
