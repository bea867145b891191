#include "experiment/advise/tradeoff.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/advise/work_precision_run.h"
#include "library/library.h"
#include "ode/methods/methods.h"
#include "session/scenario.h"

#define TIMING 1.05 /* least upper bound of a time, over its minimum: what a quiet machine repeats */

enum { STEPS_MAX = 1 << 17 }; /* fixed steps of an integrator: far above those of the fronts */

/* A pass over a family: the first adds rows, the second measures each of them again. */
typedef struct pass {
    ll_tradeoff *tradeoff;
    const ll_tradeoff_request *request;
    int problem, at, first_seed, seeds;
    bool again;
    int64_t seed; /* the scenario's own */
    const cJSON *json;
} pass;

/* ---- rows ---- */

static const ll_tradeoff_problem *problem_of(const pass *p)
{
    return &p->tradeoff->family->problems[p->problem];
}

static bool has_room(ll_tradeoff *t)
{
    if (t->count < t->room)
        return true;
    int room = t->room ? 2 * t->room : 64;
    ll_tradeoff_row *more = realloc(t->rows, (size_t)room * sizeof *more);
    if (more) {
        t->rows = more;
        t->room = room;
    }
    return more != NULL;
}

/* The next row, without its measurement; NULL: no memory. */
static ll_tradeoff_row *next_row(pass *p)
{
    ll_tradeoff *t = p->tradeoff;
    if (!p->again && !has_room(t))
        return NULL;
    ll_tradeoff_row *row = &t->rows[p->at++];
    if (!p->again) {
        *row = (ll_tradeoff_row){.problem = p->problem};
        t->count = p->at;
    }
    return row;
}

static ll_measured time_of(double least, double median)
{
    return (ll_measured){least, least, fmax(median, TIMING * least)};
}

static ll_measured exactly(double value)
{
    return (ll_measured){value, value, value};
}

static void count_step(const pass *p)
{
    if (p->request->done)
        atomic_fetch_add(p->request->done, 1);
}

/* ---- scenarios with refinement series ---- */

static bool is_of(const ll_refinement_series *series, const ll_tradeoff_problem *problem)
{
    return strcmp(series->scenario, problem->scenario) == 0 && strcmp(series->error, problem->error) == 0;
}

static ll_status add_level(pass *p, const ll_refinement_level *level, const ll_refinement_request *request)
{
    const ll_refinement_series *of = level->refinement_series;
    ll_tradeoff_row *row = next_row(p);
    if (!row)
        return ll_error(LL_NO_MEMORY, "out of memory: rows");
    ll_tradeoff_values *v = p->again ? &row->again : &row->values;
    bool random = of->seeds > 0;
    row->by = of->series;
    row->setting = of->setting;
    row->random = random;
    if (!p->again) {
        snprintf(row->method, sizeof row->method, "%s", level->series);
        snprintf(row->value, sizeof row->value, "%s", level->setting);
        ll_refinement_level_sets(level, request, row->sets, sizeof row->sets);
        row->diverged = level->diverged;
    }
    *v = (ll_tradeoff_values){.error = {level->error, level->error_low, level->error_high},
                              .cpu_median_s = level->cpu_median_s,
                              .seed = p->seed + request->first_seed,
                              .seeds = level->seeds};
    if (!random) {
        v->error = exactly(level->error);
        v->seed = p->seed;
    } else if (level->seeds < request->seeds) { /* of runs without an error the mean would be another one */
        v->error = exactly(NAN);
    }
    v->costs[0] = time_of(level->cpu_min_s, level->cpu_median_s);
    for (int c = 0; c < request->cost_count; c++)
        v->costs[1 + c] = level->costs[c];
    return ll_ok();
}

static ll_status measure_scenario(pass *p)
{
    const ll_tradeoff_family *family = p->tradeoff->family;
    const ll_tradeoff_problem *problem = problem_of(p);
    const char *costs[LL_TRADEOFF_COSTS_MAX];
    int cost_count = ll_tradeoff_cost_count(family) - 1;
    ll_refinement_request request = {.scenario = p->json,
                                     .duration = p->request->duration,
                                     .methods = p->request->methods,
                                     .seeds = p->seeds,
                                     .first_seed = p->first_seed,
                                     .now_ns = p->request->now_ns,
                                     .interrupt = p->request->interrupt,
                                     .costs = costs,
                                     .cost_count = cost_count};
    for (int c = 0; c < cost_count; c++)
        costs[c] = family->costs[1 + c].path;
    ll_status status = ll_ok();
    for (const ll_refinement_series *s = ll_refinement_series_table; s->scenario && !ll_failed(&status);
         s++) {
        if (!is_of(s, problem))
            continue;
        for (ll_refinement_run run = ll_refinement_series_start(s, &request);
             !ll_failed(&status) && ll_refinement_series_next(&run, &status);) {
            status = add_level(p, &run.refinement_level, &request);
            count_step(p);
        }
    }
    return status;
}

/* ---- integrators ---- */

static ll_status add_step(pass *p, const ll_ode_method *method, const ll_work_precision *r)
{
    ll_tradeoff_row *row = next_row(p);
    if (!row)
        return ll_error(LL_NO_MEMORY, "out of memory: rows");
    ll_tradeoff_values *v = p->again ? &row->again : &row->values;
    row->by = "methods.0.method";
    row->setting = method->adaptive ? "methods.0.tolerance" : "methods.0.dt_s";
    if (!p->again) {
        snprintf(row->method, sizeof row->method, "%s", method->name);
        snprintf(row->value, sizeof row->value, "%.17g", r->setting);
        snprintf(row->sets, sizeof row->sets, "%s%s%smethods=[{\"method\":\"%s\",\"%s\":%.17g}]",
                 p->request->duration ? "duration_s=" : "", p->request->duration ? p->request->duration : "",
                 p->request->duration ? " " : "", method->name, method->adaptive ? "tolerance" : "dt_s",
                 r->setting);
        row->diverged = r->status != LL_RUN_OK;
    }
    *v = (ll_tradeoff_values){
        .error = exactly(r->e_max_weighted),
        .costs = {time_of(r->cpu_min_s, r->cpu_median_s), exactly((double)r->counters.evaluations)},
        .cpu_median_s = r->cpu_median_s,
        .seed = p->seed,
        .seeds = 1};
    return ll_ok();
}

/* The problem of a scenario of kind motion. */
static ll_status problem_from(const cJSON *json, ll_work_precision_request *order, void *params)
{
    const cJSON *name = cJSON_GetObjectItem(json, "problem"), *given = cJSON_GetObjectItem(json, "params");
    order->problem = cJSON_IsString(name) ? ll_ode_problem_find(name->valuestring) : NULL;
    if (!order->problem)
        return ll_error(LL_BAD_INPUT, "problem: the scenario has none");
    ll_param_defaults(order->problem->params, params);
    if (given)
        LL_TRY(ll_param_merge(order->problem->params, given, params));
    if (order->problem->prepare)
        order->problem->prepare(params);
    order->params = params;
    const cJSON *duration = cJSON_GetObjectItem(json, "duration_s");
    if (order->duration == 0 && cJSON_IsNumber(duration))
        order->duration = duration->valuedouble;
    return ll_ok();
}

static ll_status measure_motion(pass *p)
{
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision levels[LL_WORK_PRECISION_LEVELS_MAX];
    ll_work_precision_request order = {
        .steps_max = STEPS_MAX, .now_ns = p->request->now_ns, .interrupt = p->request->interrupt};
    if (p->request->duration)
        order.duration = strtod(p->request->duration, NULL);
    LL_TRY(problem_from(p->json, &order, params));
    for (const ll_ode_method *const *m = ll_ode_methods; *m; m++) {
        int count = 0;
        if (!ll_list_contains(p->request->methods, (*m)->name))
            continue;
        ll_status status = ll_work_precision_series(&order, *m, levels, &count);
        count_step(p);
        if (status.code == LL_BAD_INPUT)
            continue; /* the method is not for such problems */
        for (int i = 0; i < count && !ll_failed(&status); i++)
            status = add_step(p, *m, &levels[i]);
        if (ll_failed(&status))
            return status;
    }
    return ll_ok();
}

/* ---- passes ---- */

static int steps_of(const ll_tradeoff_problem *problem, const char *methods)
{
    int steps = 0;
    bool has_series = false;
    for (const ll_refinement_series *s = ll_refinement_series_table; s->scenario; s++)
        if (is_of(s, problem)) {
            has_series = true;
            steps += ll_refinement_series_count(s, methods);
        }
    for (const ll_ode_method *const *m = ll_ode_methods; *m && !has_series; m++)
        steps += ll_list_contains(methods, (*m)->name);
    return steps;
}

int64_t ll_tradeoff_steps(const ll_tradeoff_family *family, const ll_tradeoff_request *request)
{
    int64_t steps = 0;
    for (int p = 0; p < ll_tradeoff_problem_count(family); p++)
        steps += steps_of(&family->problems[p], request->methods);
    return request->check_seeds > 0 ? 2 * steps : steps;
}

static ll_status measure_problem(pass *p)
{
    cJSON *json = NULL;
    ll_scenario scenario = {0};
    LL_TRY(ll_scenario_load(p->request->scenarios, problem_of(p)->scenario, &json));
    ll_status status = ll_scenario_parse(json, &scenario);
    if (!ll_failed(&status)) {
        p->json = json;
        p->seed = ((const ll_scenario_head *)scenario.config)->seed;
        status = strcmp(scenario.kind->name, "motion") == 0 ? measure_motion(p) : measure_scenario(p);
    }
    ll_scenario_free(&scenario);
    cJSON_Delete(json);
    return status;
}

static ll_status measure(ll_tradeoff *t, const ll_tradeoff_request *request, bool again)
{
    pass p = {.tradeoff = t,
              .request = request,
              .again = again,
              .first_seed = again ? request->seeds : 0,
              .seeds = again ? request->check_seeds : request->seeds};
    for (; p.problem < ll_tradeoff_problem_count(t->family); p.problem++)
        LL_TRY(measure_problem(&p));
    return ll_ok();
}

ll_status ll_tradeoff_run(const ll_tradeoff_family *family, const ll_tradeoff_request *request,
                          ll_tradeoff *t)
{
    *t = (ll_tradeoff){.family = family};
    LL_TRY(measure(t, request, false));
    if (t->count == 0)
        return ll_error(LL_BAD_INPUT, "--methods: %s has none of %.100s", family->name, request->methods);
    if (request->check_seeds > 0)
        LL_TRY(measure(t, request, true));
    return ll_tradeoff_choose(t);
}

void ll_tradeoff_free(ll_tradeoff *t)
{
    free(t->rows);
    free(t->choices);
    *t = (ll_tradeoff){0};
}
