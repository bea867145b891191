/* `laglab work-precision`: error against cost, one row per refinement level. For a problem of motion a
 * refinement series of each integrator (work_precision_run.h), for a scenario those of the table of series
 * (refinement_series.h). A row is written as soon as it is measured. */
#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/output.h"
#include "cli/verbs.h"
#include "experiment/advise/refinement_series.h"
#include "experiment/advise/work_precision_run.h"
#include "experiment/report/page.h"
#include "param/param.h"
#include "threads/clock.h"

typedef struct request {
    const char *name; /* name of the problem or scenario; NULL: missing */
    const char *methods, *duration, *seeds, *out, *format_name, *scenarios, *report;
    ll_option_list set;
    cJSON *levels; /* of the report; NULL: none */
    const ll_format *format;
} request;

static ll_status write_rows(const ll_table *table, const request *q)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    return ll_argument_write(q->out, q->format, table);
}

/* ---- the report ---- */

/* A refinement level to be drawn; levels with the same `of` are in one plot. */
typedef struct drawn_level {
    int of;
    const char *series, *title, *setting, *counter, *error; /* names */
    double value, cpu_s, count;
    double y, low, high; /* of the error; NaN: none, not drawn */
} drawn_level;

static void draw(cJSON *levels, const drawn_level *r)
{
    if (!levels)
        return;
    cJSON *level = cJSON_CreateObject();
    cJSON_AddNumberToObject(level, "of", r->of);
    cJSON_AddStringToObject(level, "series", r->series);
    cJSON_AddStringToObject(level, "title", r->title);
    cJSON_AddStringToObject(level, "setting", r->setting);
    cJSON_AddStringToObject(level, "counter", r->counter);
    cJSON_AddStringToObject(level, "error", r->error);
    cJSON_AddItemToObject(level, "value", ll_param_number(r->value));
    cJSON_AddItemToObject(level, "cpu_s", ll_param_number(r->cpu_s));
    cJSON_AddItemToObject(level, "count", ll_param_number(r->count));
    cJSON_AddItemToObject(level, "y", ll_param_number(r->y));
    cJSON_AddItemToObject(level, "low", ll_param_number(r->low));
    cJSON_AddItemToObject(level, "high", ll_param_number(r->high));
    cJSON_AddItemToArray(levels, level);
}

/* ---- of a problem ---- */

static const ll_column problem_columns[] = {
    {"problem", LL_CELL_TEXT, false},
    {"method", LL_CELL_TEXT, false},
    {"order", LL_CELL_INT, false},
    {"setting", LL_CELL_TEXT, false},
    {"value", LL_CELL_REAL, false},
    {"status", LL_CELL_TEXT, false},
    {"steps", LL_CELL_INT, false},
    {"rejected", LL_CELL_INT, false},
    {"evaluations", LL_CELL_INT, false},
    {"jacobians", LL_CELL_INT, false},
    {"factorisations", LL_CELL_INT, false},
    {"cpu_min_s", LL_CELL_REAL, false},
    {"cpu_median_s", LL_CELL_REAL, false},
    {"e_final", LL_CELL_REAL, true},
    {"e_max", LL_CELL_REAL, true},
    {"e_l2", LL_CELL_REAL, true},
    {"drift_final", LL_CELL_REAL, true},
    {"drift_max", LL_CELL_REAL, true},
    {"drift_per_s", LL_CELL_REAL, true},
    {"order_observed", LL_CELL_REAL, true},
    {"e_uncertainty", LL_CELL_REAL, true},
    {"predictable_s", LL_CELL_REAL, true},
    {"e_final_weighted", LL_CELL_REAL, true},
    {"e_max_weighted", LL_CELL_REAL, true},
    {"e_l2_weighted", LL_CELL_REAL, true},
};

typedef struct problem_rows {
    _Alignas(8) char params[LL_ODE_PARAMS_MAX];
    ll_work_precision_request order;
    const char *methods;
    const ll_ode_method *const *method; /* the next one */
    const ll_ode_method *measured;
    ll_work_precision
        refinement_levels[LL_WORK_PRECISION_LEVELS_MAX]; /* of the method that was measured last */
    int count, at;
    cJSON *levels;
} problem_rows;

/* Measures until there is a level that was not written yet; only methods that support the problem. */
static bool measure_methods(problem_rows *p, ll_status *status)
{
    while (p->at == p->count && *p->method) {
        p->measured = *p->method++;
        if (!ll_list_contains(p->methods, p->measured->name))
            continue;
        p->at = 0;
        *status = ll_work_precision_series(&p->order, p->measured, p->refinement_levels, &p->count);
        if (status->code == LL_BAD_INPUT && !p->methods)
            *status = ll_ok();
        if (ll_failed(status))
            return false;
    }
    return p->at < p->count;
}

static void draw_step(cJSON *levels, const problem_rows *p, const ll_work_precision *r)
{
    draw(levels, &(drawn_level){.series = p->measured->name,
                                .title = "method",
                                .setting = "step or tolerance",
                                .value = r->setting,
                                .counter = "evaluations",
                                .error = "e_max",
                                .cpu_s = r->cpu_min_s,
                                .count = (double)r->counters.evaluations,
                                .y = r->e_max > 0 ? r->e_max : NAN,
                                .low = NAN,
                                .high = NAN});
}

static bool next_problem_row(void *context, ll_cell *cell, ll_status *status)
{
    problem_rows *p = context;
    if (!measure_methods(p, status))
        return false;
    const ll_work_precision *r = &p->refinement_levels[p->at++];
    ll_put_text(&cell, p->order.problem->name);
    ll_put_text(&cell, p->measured->name);
    ll_ode ode;
    p->order.problem->system(p->params, &ode);
    ll_put_number(&cell, ll_ode_order(p->measured, &ode));
    ll_put_text(&cell, p->measured->adaptive ? "tolerance" : "dt_s");
    ll_put_number(&cell, r->setting);
    ll_put_text(&cell, ll_run_status_names[r->status]);
    const int64_t counts[] = {r->counters.steps, r->counters.rejected, r->counters.evaluations,
                              r->counters.jacobians, r->counters.factorisations};
    const double numbers[] = {r->cpu_min_s,      r->cpu_median_s, r->e_final,       r->e_max,
                              r->e_l2,           r->drift_final,  r->drift_max,     r->drift_per_s,
                              r->order,          r->uncertainty,  r->predictable_s, r->e_final_weighted,
                              r->e_max_weighted, r->e_l2_weighted};
    for (size_t i = 0; i < sizeof counts / sizeof counts[0]; i++)
        ll_put_number(&cell, (double)counts[i]);
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        ll_put_number(&cell, numbers[i]);
    draw_step(p->levels, p, r);
    return true;
}

static ll_status check_methods(const char *list)
{
    for (const char *p = list; p; p = strchr(p, ',') ? strchr(p, ',') + 1 : NULL) {
        char name[64];
        snprintf(name, sizeof name, "%.*s", (int)strcspn(p, ","), p);
        if (!ll_ode_method_find(name))
            return ll_error(LL_BAD_INPUT, "--methods: %s not found; see `laglab methods`", name);
    }
    return ll_ok();
}

static ll_status set_params(const request *q, const ll_ode_problem *problem, void *params)
{
    ll_param_defaults(problem->params, params);
    ll_status status = ll_param_put(problem->params, params, q->set.items, q->set.count);
    LL_THEN(status, ll_param_check(problem->params, params));
    if (!ll_failed(&status) && problem->prepare)
        problem->prepare(params);
    return status;
}

static ll_status set_duration(const request *q, ll_work_precision_request *order)
{
    char *end;
    if (!q->duration)
        return ll_ok();
    order->duration = strtod(q->duration, &end);
    if (*end != '\0' || !(order->duration > 0 && order->duration <= 1e12))
        return ll_error(LL_BAD_INPUT, "--duration: must be above 0 and at most 1e12 s; got %.40s",
                        q->duration);
    return ll_ok();
}

static ll_status measure_problem(const request *q)
{
    problem_rows p = {.methods = q->methods, .method = ll_ode_methods, .levels = q->levels};
    const ll_table table = {problem_columns, sizeof problem_columns / sizeof problem_columns[0],
                            next_problem_row, &p};
    p.order = (ll_work_precision_request){.problem = q->name ? ll_ode_problem_find(q->name) : NULL,
                                          .params = p.params,
                                          .now_ns = ll_process_cpu_ns};
    if (!p.order.problem)
        return ll_error(LL_BAD_INPUT,
                        "PROBLEM: must be one of `laglab problems`, or a scenario with refinement series "
                        "(fluid/cavity, rigid/column, hermite; --help lists all); got %.60s",
                        q->name ? q->name : "none");
    ll_status status = check_methods(q->methods);
    LL_THEN(status, set_params(q, p.order.problem, p.params));
    LL_THEN(status, set_duration(q, &p.order));
    if (!ll_failed(&status))
        measure_methods(&p, &status); /* errors come before any output */
    return ll_failed(&status) ? status : write_rows(&table, q);
}

/* ---- of a scenario ---- */

static const ll_column scenario_columns[] = {
    {"scenario", LL_CELL_TEXT, false},      {"by", LL_CELL_TEXT, false},
    {"series", LL_CELL_TEXT, false},        {"setting", LL_CELL_TEXT, false},
    {"value", LL_CELL_REAL, false},         {"status", LL_CELL_TEXT, false},
    {"cpu_min_s", LL_CELL_REAL, false},     {"cpu_median_s", LL_CELL_REAL, false},
    {"metric", LL_CELL_TEXT, false},        {"error", LL_CELL_REAL, true},
    {"counter", LL_CELL_TEXT, false},       {"count", LL_CELL_REAL, true},
    {"order_observed", LL_CELL_REAL, true}, {"error_low", LL_CELL_REAL, true},
    {"error_high", LL_CELL_REAL, true},     {"seeds", LL_CELL_INT, false},
};

typedef struct scenario_rows {
    ll_refinement_request order;
    const char *scenario;
    const ll_refinement_series *refinement_series; /* the next one */
    ll_refinement_run refinement_run;
    bool measured; /* measured, but not written yet */
    cJSON *levels;
} scenario_rows;

/* The next series of the scenario from `l` on, or the final empty row. */
static const ll_refinement_series *refinement_series_of(const char *scenario, const ll_refinement_series *l)
{
    while (l->scenario && strcmp(scenario, l->scenario) != 0)
        l++;
    return l;
}

static bool measure_refinement_level(scenario_rows *s, ll_status *status)
{
    while (!s->measured && !ll_failed(status)) {
        s->measured = ll_refinement_series_next(&s->refinement_run, status);
        if (s->measured || ll_failed(status) || !s->refinement_series->scenario)
            break;
        s->refinement_run = ll_refinement_series_start(s->refinement_series, &s->order);
        s->refinement_series = refinement_series_of(s->scenario, s->refinement_series + 1);
    }
    return s->measured;
}

static void draw_refinement_level(cJSON *levels, const ll_refinement_level *r)
{
    const ll_refinement_series *of = r->refinement_series;
    draw(levels, &(drawn_level){.of = (int)(of - ll_refinement_series_table),
                                .series = r->series,
                                .title = of->series,
                                .setting = of->setting,
                                .value = strtod(r->setting, NULL),
                                .counter = of->counter,
                                .error = of->error,
                                .cpu_s = r->cpu_min_s,
                                .count = r->counter,
                                .y = r->error,
                                .low = r->error_low,
                                .high = r->error_high});
}

static bool next_scenario_row(void *context, ll_cell *cell, ll_status *status)
{
    scenario_rows *s = context;
    if (!measure_refinement_level(s, status))
        return false;
    s->measured = false;
    const ll_refinement_level *r = &s->refinement_run.refinement_level;
    ll_put_text(&cell, r->refinement_series->scenario);
    ll_put_text(&cell, r->refinement_series->series);
    ll_put_text(&cell, r->series);
    ll_put_text(&cell, r->refinement_series->setting);
    ll_put_number(&cell, strtod(r->setting, NULL));
    ll_put_text(&cell, r->diverged ? "diverged" : "ok");
    ll_put_number(&cell, r->cpu_min_s);
    ll_put_number(&cell, r->cpu_median_s);
    ll_put_text(&cell, r->refinement_series->error);
    ll_put_number(&cell, r->error);
    ll_put_text(&cell, r->refinement_series->counter);
    ll_put_number(&cell, r->counter);
    ll_put_number(&cell, r->order);
    ll_put_number(&cell, r->error_low);
    ll_put_number(&cell, r->error_high);
    ll_put_number(&cell, r->seeds);
    draw_refinement_level(s->levels, r);
    return true;
}

static ll_status measure_scenario(const request *q, const ll_refinement_series *first)
{
    cJSON *json = NULL;
    scenario_rows s = {.scenario = q->name,
                       .refinement_series = refinement_series_of(q->name, first + 1),
                       .levels = q->levels};
    const ll_table table = {scenario_columns, sizeof scenario_columns / sizeof scenario_columns[0],
                            next_scenario_row, &s};
    int64_t seeds = 0;
    ll_status status = ll_argument_json(q->name, q->scenarios, &json);
    if (!ll_failed(&status) && q->seeds)
        status = ll_argument_whole("--seeds", q->seeds, 1, LL_REFINEMENT_SERIES_SEEDS_MAX, &seeds);
    s.order = (ll_refinement_request){.scenario = json,
                                      .sets = q->set.items,
                                      .set_count = q->set.count,
                                      .duration = q->duration,
                                      .methods = q->methods,
                                      .seeds = (int)seeds,
                                      .now_ns = ll_process_cpu_ns};
    s.refinement_run = ll_refinement_series_start(first, &s.order);
    if (!ll_failed(&status) && !measure_refinement_level(&s, &status) && !ll_failed(&status))
        status = ll_error(LL_BAD_INPUT, "%s has no series of the methods %.100s", q->name, q->methods);
    LL_THEN(status, write_rows(&table, q));
    cJSON_Delete(json);
    return status;
}

/* ---- the verb ---- */

static ll_status write_page(request *q)
{
    char title[120], command[200];
    cJSON *data = cJSON_CreateObject();
    snprintf(title, sizeof title, "Speed against error: %.80s", q->name);
    snprintf(command, sizeof command, "laglab work-precision %.80s", q->name);
    cJSON_AddStringToObject(data, "kind", "work-precision");
    cJSON_AddStringToObject(data, "command", command);
    cJSON_AddItemToObject(data, "levels", q->levels);
    q->levels = NULL;
    return ll_page_write(q->report, title, data);
}

int ll_verb_work_precision(int argc, char **argv)
{
    request q = {0};
    const ll_option options[] = {
        {"--methods", "A,B,...", "Only these methods or solvers.", .value = &q.methods},
        {"--set", "NAME=VALUE", "A parameter of the problem, or a path of the scenario.", .list = &q.set},
        {"--duration", "S", "Virtual seconds of a run; default: those of the problem or series.",
         .value = &q.duration},
        {"--seeds", "N",
         "Runs of each level of a netgame, with different seeds; default: that of the series, 10.",
         .value = &q.seeds},
        {"--report", "FILE.html",
         "Writes a page with plots: error against time and against the counted cost.", .value = &q.report},
        {"--out", "FILE", "Output file; default: standard output.", .value = &q.out},
        {"--format", "NAME", "csv, ndjson, json or sqlite; default: by the ending of FILE.",
         .value = &q.format_name},
        {"--scenarios", "DIR", "Folder of the scenario library; default: next to the program.",
         .value = &q.scenarios},
        {0}};
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    ll_status status =
        ll_arguments("work-precision PROBLEM|SCENARIO [OPTION]...: measure each method's error "
                     "against its cost, a row for each step, tolerance, size, number of passes or update "
                     "rate. PROBLEM: see `laglab problems`. SCENARIO: fluid/cavity, fluid/taylor_green, "
                     "fluid/rotation, fluid/poiseuille, fluid/hydrostatic, fluid/dam_break, fluid/sea, "
                     "rigid/column, rigid/pyramid, crates_delta, swarm_interest, hermite, deterministic, "
                     "crates, behind_cover. See also `laglab tradeoff`: families of methods, several "
                     "costs, and which is the cheapest",
                     argc, argv, options, positional, &count);
    if (!ll_failed(&status) && count > 1)
        status = ll_error(LL_BAD_INPUT, "unexpected argument %.100s", positional[1]);
    LL_THEN(status, ll_argument_format(q.format_name, q.out, &q.format));
    if (ll_failed(&status))
        return ll_argument_fail(&status);
    q.name = count ? positional[0] : NULL;
    const ll_refinement_series *refinement_series =
        q.name ? refinement_series_of(q.name, ll_refinement_series_table) : NULL;
    if (q.report)
        q.levels = cJSON_CreateArray();
    status = refinement_series && refinement_series->scenario ? measure_scenario(&q, refinement_series)
                                                              : measure_problem(&q);
    if (!ll_failed(&status) && q.report)
        status = write_page(&q);
    cJSON_Delete(q.levels);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
