#include "experiment/advise/tradeoff.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "experiment/advise/work_precision_run.h"
#include "library/library.h"
#include "ode/methods/methods.h"
#include "session/scenario.h"

#define TIMING 1.05 /* least upper bound of a time, over its minimum: what a quiet machine repeats */

enum { STEPS_MAX = 1 << 17 }; /* fixed steps of an integrator: far above those of the fronts */

/* A problem of the family, as its series need it. */
typedef struct place {
    cJSON *json; /* the scenario */
    int64_t seed;
    bool motion;
    ll_work_precision_request order; /* of kind motion */
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
} place;

/* One method of a problem, setting after setting, then the same again for the check. */
typedef struct series {
    int problem;
    const ll_refinement_series *of; /* NULL: an integrator */
    const ll_ode_method *integrator;
    char method[40];
    ll_refinement_request refinement;
    ll_refinement_run levels;
    ll_work_precision_request order;
    ll_work_precision_run *motion; /* NULL: not begun, or ended */
    ll_tradeoff_row *rows;
    int most, count; /* rows at most, and so far */
    int at;          /* the next setting; -1: the pass has not begun */
    bool again, busy, over;
} series;

struct ll_tradeoff_run {
    const ll_tradeoff_family *family;
    const ll_tradeoff_request *request;
    const char *costs[LL_TRADEOFF_COSTS_MAX]; /* other than time */
    place places[LL_TRADEOFF_PROBLEMS_MAX];
    series *series;
    int series_count;
    pthread_mutex_t lock; /* guards the rest, `at`, `again`, `busy`, `over`, and rows up to their counts */
    int64_t done;
    bool failed;
};

/* ---- values ---- */

static ll_measured time_of(double least, double median)
{
    return (ll_measured){least, least, fmax(median, TIMING * least)};
}

static ll_measured exactly(double value)
{
    return (ll_measured){value, value, value};
}

static ll_tradeoff_values values_of_level(const series *s, int64_t seed)
{
    const ll_refinement_level *level = &s->levels.refinement_level;
    ll_tradeoff_values v = {.error = {level->error, level->error_low, level->error_high},
                            .cpu_median_s = level->cpu_median_s,
                            .runs = level->runs,
                            .seed = seed + s->refinement.first_seed,
                            .seeds = level->seeds};
    if (s->of->seeds == 0) {
        v.error = exactly(level->error);
        v.seed = seed;
    } else if (level->seeds < s->refinement.seeds) { /* of runs without an error the mean would be another */
        v.error = exactly(NAN);
    }
    v.costs[0] = time_of(level->cpu_min_s, level->cpu_median_s);
    for (int c = 0; c < s->refinement.cost_count; c++)
        v.costs[1 + c] = level->costs[c];
    return v;
}

static ll_tradeoff_values values_of_step(const ll_work_precision *r, int64_t seed)
{
    return (ll_tradeoff_values){
        .error = exactly(r->e_max_weighted),
        .costs = {time_of(r->cpu_min_s, r->cpu_median_s), exactly((double)r->counters.evaluations)},
        .cpu_median_s = r->cpu_median_s,
        .runs = r->runs,
        .seed = seed,
        .seeds = 1};
}

/* ---- a setting: true if there was one, with its row ---- */

static bool measure_level(const place *at, series *s, ll_tradeoff_row *row, ll_status *status)
{
    if (s->at < 0) {
        s->at = 0;
        s->levels = ll_refinement_series_start(s->of, &s->refinement);
    }
    if (!ll_refinement_series_next(&s->levels, status))
        return false;
    const ll_refinement_level *level = &s->levels.refinement_level;
    *row = (ll_tradeoff_row){.problem = s->problem,
                             .by = s->of->series,
                             .setting = s->of->setting,
                             .random = s->of->seeds > 0,
                             .diverged = level->diverged,
                             .values = values_of_level(s, at->seed)};
    snprintf(row->method, sizeof row->method, "%s", s->method);
    snprintf(row->value, sizeof row->value, "%s", level->setting);
    ll_refinement_level_sets(level, &s->refinement, row->sets, sizeof row->sets);
    return true;
}

static bool measure_step(const ll_tradeoff_run *run, const place *at, series *s, ll_tradeoff_row *row,
                         ll_status *status)
{
    ll_work_precision r;
    if (s->at < 0) {
        s->at = 0;
        *status = ll_work_precision_start(&s->order, s->integrator, &s->motion);
        if (status->code == LL_BAD_INPUT)
            *status = ll_ok(); /* the method is not for such problems: no row */
    }
    if (ll_failed(status) || !s->motion)
        return false;
    if (!ll_work_precision_next(s->motion, &r, status)) {
        ll_work_precision_end(s->motion);
        s->motion = NULL;
        return false;
    }
    const char *duration = run->request->duration, *setting = s->integrator->adaptive ? "tolerance" : "dt_s";
    *row = (ll_tradeoff_row){.problem = s->problem,
                             .by = "methods.0.method",
                             .setting = s->integrator->adaptive ? "methods.0.tolerance" : "methods.0.dt_s",
                             .diverged = r.status != LL_RUN_OK,
                             .values = values_of_step(&r, at->seed)};
    snprintf(row->method, sizeof row->method, "%s", s->method);
    snprintf(row->value, sizeof row->value, "%.17g", r.setting);
    snprintf(row->sets, sizeof row->sets, "%s%s%smethods=[{\"method\":\"%s\",\"%s\":%.17g}]",
             duration ? "duration_s=" : "", duration ? duration : "", duration ? " " : "", s->method, setting,
             r.setting);
    return true;
}

/* ---- what is next ---- */

/* The series whose next setting is the coarsest, and of those the first; NULL: none is free. Locked. */
static series *choose_series(ll_tradeoff_run *run)
{
    series *best = NULL;
    for (int i = 0; i < run->series_count; i++) {
        series *s = &run->series[i];
        if (!s->busy && !s->over &&
            (!best || s->again < best->again || (s->again == best->again && s->at < best->at)))
            best = s;
    }
    return best;
}

/* The pass over a series is over: the check follows, or nothing. Locked. */
static void end_pass(ll_tradeoff_run *run, series *s)
{
    run->done += s->most - s->count;
    s->at = -1;
    s->over = s->again || run->request->check_seeds == 0;
    s->again = true;
    s->refinement.first_seed = run->request->seeds;
    s->refinement.seeds = run->request->check_seeds;
}

static void put_row(ll_tradeoff_run *run, series *s, const ll_tradeoff_row *row)
{
    LL_ASSERT(s->again ? s->at < s->count : s->count < s->most);
    if (s->again)
        s->rows[s->at].again = row->values;
    else
        s->rows[s->count++] = *row;
    s->at++;
    run->done++;
}

bool ll_tradeoff_next(ll_tradeoff_run *run, const ll_interrupt *interrupt, ll_status *status)
{
    ll_tradeoff_row row;
    *status = ll_ok();
    pthread_mutex_lock(&run->lock);
    series *s = run->failed ? NULL : choose_series(run);
    if (s)
        s->busy = true;
    pthread_mutex_unlock(&run->lock);
    if (!s)
        return false;
    const place *at = &run->places[s->problem];
    s->refinement.interrupt = s->order.interrupt = interrupt;
    bool measured = s->of ? measure_level(at, s, &row, status) : measure_step(run, at, s, &row, status);
    pthread_mutex_lock(&run->lock);
    s->busy = false;
    run->failed = run->failed || ll_failed(status);
    if (measured)
        put_row(run, s, &row);
    else if (!ll_failed(status))
        end_pass(run, s);
    pthread_mutex_unlock(&run->lock);
    return !ll_failed(status);
}

/* ---- what there is ---- */

int64_t ll_tradeoff_done(ll_tradeoff_run *run)
{
    pthread_mutex_lock(&run->lock);
    int64_t done = run->done;
    pthread_mutex_unlock(&run->lock);
    return done;
}

static ll_status copy_rows(ll_tradeoff_run *run, ll_tradeoff *t)
{
    bool checked = true;
    int count = 0;
    for (int i = 0; i < run->series_count; i++) {
        count += run->series[i].count;
        checked = checked && run->series[i].over;
    }
    t->rows = malloc((size_t)count * sizeof *t->rows + 1);
    if (!t->rows)
        return ll_error(LL_NO_MEMORY, "out of memory: rows");
    for (int i = 0; i < run->series_count; i++) {
        memcpy(&t->rows[t->count], run->series[i].rows, (size_t)run->series[i].count * sizeof *t->rows);
        t->count += run->series[i].count;
    }
    for (int i = 0; i < count && !checked; i++)
        t->rows[i].again = (ll_tradeoff_values){0};
    return ll_ok();
}

ll_status ll_tradeoff_so_far(ll_tradeoff_run *run, ll_tradeoff *t)
{
    *t = (ll_tradeoff){.family = run->family};
    pthread_mutex_lock(&run->lock);
    ll_status status = copy_rows(run, t);
    pthread_mutex_unlock(&run->lock);
    return ll_failed(&status) ? status : ll_tradeoff_choose(t);
}

void ll_tradeoff_free(ll_tradeoff *t)
{
    free(t->rows);
    free(t->choices);
    *t = (ll_tradeoff){0};
}

/* ---- series of a family ---- */

static bool is_of(const ll_refinement_series *of, const ll_tradeoff_problem *problem)
{
    return strcmp(of->scenario, problem->scenario) == 0 && strcmp(of->error, problem->error) == 0;
}

/* Calls `each` with every series of a problem that the request wants. */
static void list_series(const ll_tradeoff_problem *problem, const char *methods,
                        void (*each)(void *context, const ll_refinement_series *of,
                                     const ll_ode_method *integrator, const char *method, int most),
                        void *context)
{
    char method[40];
    bool refined = false;
    for (const ll_refinement_series *of = ll_refinement_series_table; of->scenario; of++) {
        if (!is_of(of, problem))
            continue;
        refined = true;
        for (const char *list = of->series_values; ll_list_next(&list, method, sizeof method);)
            if (ll_list_contains(methods, method))
                each(context, of, NULL, method, ll_refinement_series_count(of, method));
    }
    for (const ll_ode_method *const *m = ll_ode_methods; *m && !refined; m++)
        if (ll_list_contains(methods, (*m)->name))
            each(context, NULL, *m, (*m)->name, ll_work_precision_levels(*m, STEPS_MAX));
}

static void count_steps(void *context, const ll_refinement_series *of, const ll_ode_method *integrator,
                        const char *method, int most)
{
    (void)of, (void)integrator, (void)method;
    *(int64_t *)context += most;
}

int64_t ll_tradeoff_steps(const ll_tradeoff_family *family, const ll_tradeoff_request *request)
{
    int64_t steps = 0;
    for (int p = 0; p < ll_tradeoff_problem_count(family); p++)
        list_series(&family->problems[p], request->methods, count_steps, &steps);
    return request->check_seeds > 0 ? 2 * steps : steps;
}

/* ---- opening ---- */

typedef struct listing {
    ll_tradeoff_run *run;
    int problem;
    bool full; /* no memory */
} listing;

static void add_series(void *context, const ll_refinement_series *of, const ll_ode_method *integrator,
                       const char *method, int most)
{
    listing *l = context;
    ll_tradeoff_run *run = l->run;
    series *more = realloc(run->series, (size_t)(run->series_count + 1) * sizeof *more);
    ll_tradeoff_row *rows = calloc((size_t)most, sizeof *rows);
    run->series = more ? more : run->series;
    l->full = l->full || !more || !rows;
    if (l->full) {
        free(rows);
        return;
    }
    series *s = &run->series[run->series_count++];
    *s = (series){.problem = l->problem,
                  .of = of,
                  .integrator = integrator,
                  .order = run->places[l->problem].order,
                  .rows = rows,
                  .most = most,
                  .at = -1};
    snprintf(s->method, sizeof s->method, "%s", method);
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

static ll_status open_place(const ll_tradeoff_run *run, int problem, place *at)
{
    const ll_tradeoff_request *request = run->request;
    ll_scenario scenario = {0};
    LL_TRY(ll_scenario_load(request->scenarios, run->family->problems[problem].scenario, &at->json));
    ll_status status = ll_scenario_parse(at->json, &scenario);
    if (!ll_failed(&status)) {
        at->seed = ((const ll_scenario_head *)scenario.config)->seed;
        if (strcmp(scenario.kind->name, "motion") == 0) {
            at->order = (ll_work_precision_request){
                .steps_max = STEPS_MAX,
                .now_ns = request->now_ns,
                .duration = request->duration ? strtod(request->duration, NULL) : 0};
            status = problem_from(at->json, &at->order, at->params);
        }
    }
    ll_scenario_free(&scenario);
    return status;
}

/* What points into the run, when its series have their place. */
static void complete_series(ll_tradeoff_run *run)
{
    for (int i = 0; i < run->series_count; i++) {
        series *s = &run->series[i];
        s->refinement = (ll_refinement_request){.scenario = run->places[s->problem].json,
                                                .duration = run->request->duration,
                                                .methods = s->method,
                                                .seeds = run->request->seeds,
                                                .now_ns = run->request->now_ns,
                                                .costs = run->costs,
                                                .cost_count = ll_tradeoff_cost_count(run->family) - 1};
    }
}

ll_status ll_tradeoff_open(const ll_tradeoff_family *family, const ll_tradeoff_request *request,
                           ll_tradeoff_run **out)
{
    *out = NULL;
    if (ll_tradeoff_steps(family, request) == 0)
        return ll_error(LL_BAD_INPUT, "--methods: %s has none of %.100s", family->name, request->methods);
    ll_tradeoff_run *run = *out = calloc(1, sizeof *run);
    if (!run)
        return ll_error(LL_NO_MEMORY, "out of memory: measurement");
    run->family = family;
    run->request = request;
    pthread_mutex_init(&run->lock, NULL);
    for (int c = 1; c < ll_tradeoff_cost_count(family); c++)
        run->costs[c - 1] = family->costs[c].path;
    listing l = {.run = run};
    ll_status status = ll_ok();
    for (; l.problem < ll_tradeoff_problem_count(family) && !ll_failed(&status); l.problem++) {
        status = open_place(run, l.problem, &run->places[l.problem]);
        if (!ll_failed(&status))
            list_series(&family->problems[l.problem], request->methods, add_series, &l);
    }
    if (l.full)
        status = ll_error(LL_NO_MEMORY, "out of memory: rows");
    complete_series(run);
    if (ll_failed(&status)) {
        ll_tradeoff_close(run);
        *out = NULL;
    }
    return status;
}

void ll_tradeoff_close(ll_tradeoff_run *run)
{
    if (!run)
        return;
    for (int i = 0; i < run->series_count; i++) {
        ll_work_precision_end(run->series[i].motion);
        free(run->series[i].rows);
    }
    for (int p = 0; p < LL_TRADEOFF_PROBLEMS_MAX; p++)
        cJSON_Delete(run->places[p].json);
    pthread_mutex_destroy(&run->lock);
    free(run->series);
    free(run);
}

ll_status ll_tradeoff_measure(const ll_tradeoff_family *family, const ll_tradeoff_request *request,
                              ll_tradeoff *t)
{
    ll_tradeoff_run *run;
    *t = (ll_tradeoff){.family = family};
    LL_TRY(ll_tradeoff_open(family, request, &run));
    ll_status status = ll_ok();
    while (ll_tradeoff_next(run, NULL, &status))
        ;
    LL_THEN(status, ll_tradeoff_so_far(run, t));
    ll_tradeoff_close(run);
    if (!ll_failed(&status) && t->count == 0)
        return ll_error(LL_BAD_INPUT, "--methods: none of %.100s is for problems of %s", request->methods,
                        family->name);
    return status;
}
