/* `laglab tradeoff`: families of methods on fronts of error and several costs, and the cheapest method at
 * three levels of error, measured again. `work-precision` measures one problem, with any parameters of it. */
#include <cjson/cJSON.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/arguments.h"
#include "cli/input.h"
#include "cli/output.h"
#include "cli/verbs.h"
#include "experiment/advise/tradeoff.h"
#include "experiment/report/page.h"
#include "experiment/report/tradeoff_json.h"
#include "threads/clock.h"

enum { FAMILIES_MAX = 16, SEEDS_DEFAULT = 20 };

typedef struct request {
    const char *seeds, *check_seeds, *methods, *duration, *out, *winners, *format_name, *report, *page,
        *scenarios;
    const ll_format *format;
    bool list;
    ll_tradeoff families[FAMILIES_MAX];
    int count;
} request;

/* ---- tables: a row per setting and cost, and a row per choice ---- */

static const ll_column row_columns[] = {
    {"family", LL_CELL_TEXT, false},     {"scenario", LL_CELL_TEXT, false},
    {"by", LL_CELL_TEXT, false},         {"method", LL_CELL_TEXT, false},
    {"setting", LL_CELL_TEXT, false},    {"value", LL_CELL_REAL, false},
    {"status", LL_CELL_TEXT, false},     {"metric", LL_CELL_TEXT, false},
    {"error", LL_CELL_REAL, true},       {"error_low", LL_CELL_REAL, true},
    {"error_high", LL_CELL_REAL, true},  {"cost", LL_CELL_TEXT, false},
    {"cost_value", LL_CELL_REAL, true},  {"cost_low", LL_CELL_REAL, true},
    {"cost_high", LL_CELL_REAL, true},   {"front", LL_CELL_BOOL, false},
    {"cpu_min_s", LL_CELL_REAL, true},   {"cpu_median_s", LL_CELL_REAL, true},
    {"seed", LL_CELL_INT, false},        {"seeds", LL_CELL_INT, false},
    {"check_seed", LL_CELL_INT, true},   {"check_seeds", LL_CELL_INT, true},
    {"check_error", LL_CELL_REAL, true}, {"check_error_high", LL_CELL_REAL, true},
    {"check_cost", LL_CELL_REAL, true},  {"set", LL_CELL_TEXT, false},
    {"link", LL_CELL_TEXT, false},
};

static const ll_column winner_columns[] = {
    {"family", LL_CELL_TEXT, false},
    {"scenario", LL_CELL_TEXT, false},
    {"metric", LL_CELL_TEXT, false},
    {"cost", LL_CELL_TEXT, false},
    {"level", LL_CELL_REAL, false},
    {"method", LL_CELL_TEXT, true},
    {"setting", LL_CELL_TEXT, true},
    {"value", LL_CELL_REAL, true},
    {"error", LL_CELL_REAL, true},
    {"error_high", LL_CELL_REAL, true},
    {"cost_value", LL_CELL_REAL, true},
    {"seed", LL_CELL_INT, true},
    {"seeds", LL_CELL_INT, true},
    {"check_seed", LL_CELL_INT, true},
    {"check_seeds", LL_CELL_INT, true},
    {"check_error", LL_CELL_REAL, true},
    {"check_error_high", LL_CELL_REAL, true},
    {"check_cost", LL_CELL_REAL, true},
    {"check_cheapest", LL_CELL_TEXT, true},
    {"verdict", LL_CELL_TEXT, false},
    {"figures", LL_CELL_TEXT, false},
    {"as_cheap", LL_CELL_TEXT, false},
    {"link", LL_CELL_TEXT, true},
};

/* The place in the rows or choices of all families. */
typedef struct cursor {
    const request *q;
    int family, at, cost;
    char link[1500];
} cursor;

/* Of a check; null if there was none. */
static void put_seeds(ll_cell **cell, const ll_tradeoff_values *v)
{
    ll_put_number(cell, v->seeds ? (double)v->seed : NAN);
    ll_put_number(cell, v->seeds ? (double)v->seeds : NAN);
}

static void put_check(ll_cell **cell, const ll_tradeoff_values *v, int cost)
{
    put_seeds(cell, v);
    ll_put_number(cell, v->seeds ? v->error.value : NAN);
    ll_put_number(cell, v->seeds ? v->error.high : NAN);
    ll_put_number(cell, v->seeds ? v->costs[cost].value : NAN);
}

static void put_row(cursor *c, const ll_tradeoff *t, const ll_tradeoff_row *row, ll_cell *cell)
{
    const ll_tradeoff_problem *problem = &t->family->problems[row->problem];
    const ll_measured *cost = &row->values.costs[c->cost];
    const ll_tradeoff_values *v = &row->values;
    const char *const texts[] = {t->family->name, problem->scenario, row->by, row->method, row->setting};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        ll_put_text(&cell, texts[i]);
    ll_put_number(&cell, strtod(row->value, NULL));
    ll_put_text(&cell, row->diverged ? "diverged" : "ok");
    ll_put_text(&cell, problem->error);
    const double errors[] = {v->error.value, v->error.low, v->error.high};
    for (int i = 0; i < 3; i++)
        ll_put_number(&cell, errors[i]);
    ll_put_text(&cell, t->family->costs[c->cost].path);
    const double numbers[] = {cost->value,       cost->low,       cost->high,      row->front[c->cost],
                              v->costs[0].value, v->cpu_median_s, (double)v->seed, v->seeds};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++)
        ll_put_number(&cell, numbers[i]);
    put_check(&cell, &row->again, c->cost);
    ll_put_text(&cell, row->sets);
    ll_tradeoff_address(t, row, c->q->page, c->link, sizeof c->link);
    ll_put_text(&cell, c->link);
}

static bool next_row(void *context, ll_cell *cells, ll_status *status)
{
    (void)status;
    cursor *c = context;
    while (c->family < c->q->count) {
        const ll_tradeoff *t = &c->q->families[c->family];
        if (c->at < t->count && c->cost < ll_tradeoff_cost_count(t->family)) {
            put_row(c, t, &t->rows[c->at], cells);
            c->cost++;
            return true;
        }
        c->cost = 0;
        if (++c->at >= t->count) {
            c->at = 0;
            c->family++;
        }
    }
    return false;
}

static void put_nulls(ll_cell **cell, int count)
{
    while (count-- > 0)
        *(*cell)++ = (ll_cell){.null = true};
}

static void put_choice(cursor *c, const ll_tradeoff *t, const ll_tradeoff_choice *choice, ll_cell *cell)
{
    const ll_tradeoff_problem *problem = &t->family->problems[choice->problem];
    const char *const texts[] = {t->family->name, problem->scenario, problem->error,
                                 t->family->costs[choice->cost].path};
    const ll_tradeoff_row *row = choice->row < 0 ? NULL : &t->rows[choice->row];
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        ll_put_text(&cell, texts[i]);
    ll_put_number(&cell, choice->level);
    if (row) {
        ll_put_text(&cell, row->method);
        ll_put_text(&cell, row->setting);
        ll_put_number(&cell, strtod(row->value, NULL));
        ll_put_number(&cell, row->values.error.value);
        ll_put_number(&cell, row->values.error.high);
        ll_put_number(&cell, row->values.costs[choice->cost].value);
        put_seeds(&cell, &row->values);
        put_check(&cell, &row->again, choice->cost);
    } else {
        put_nulls(&cell, 13);
    }
    int best = choice->checked ? choice->cheapest_again : -1;
    *cell++ = (ll_cell){.null = best < 0, .text = best < 0 ? NULL : t->rows[best].method};
    ll_put_text(&cell, ll_tradeoff_verdict(choice));
    ll_put_text(&cell, choice->why);
    ll_put_text(&cell, choice->tied);
    if (row)
        ll_tradeoff_address(t, row, c->q->page, c->link, sizeof c->link);
    *cell++ = (ll_cell){.null = !row, .text = row ? c->link : NULL};
}

static bool next_choice(void *context, ll_cell *cells, ll_status *status)
{
    (void)status;
    cursor *c = context;
    while (c->family < c->q->count) {
        const ll_tradeoff *t = &c->q->families[c->family];
        if (c->at < t->choice_count) {
            put_choice(c, t, &t->choices[c->at++], cells);
            return true;
        }
        c->at = 0;
        c->family++;
    }
    return false;
}

/* ---- what is asked for ---- */

static ll_status not_a_family(const char *name)
{
    char known[300] = "";
    for (const ll_tradeoff_family *f = ll_tradeoff_families; f->name; f++)
        snprintf(known + strlen(known), sizeof known - strlen(known), "%s%s", *known ? ", " : "", f->name);
    return ll_error(LL_BAD_INPUT, "FAMILY: must be one of %s; got %.60s", known, name);
}

static ll_status take_families(request *q, const char *const *names, int count)
{
    for (int i = 0; i < count; i++) {
        const ll_tradeoff_family *family = ll_tradeoff_family_find(names[i]);
        if (!family)
            return not_a_family(names[i]);
        for (int k = 0; k < q->count; k++)
            if (q->families[k].family == family)
                return ll_error(LL_BAD_INPUT, "FAMILY: duplicate %s", family->name);
        q->families[q->count++].family = family;
    }
    for (const ll_tradeoff_family *f = ll_tradeoff_families; count == 0 && f->name; f++)
        q->families[q->count++].family = f;
    return ll_ok();
}

static ll_status take_numbers(const request *q, ll_tradeoff_request *order)
{
    int64_t seeds = SEEDS_DEFAULT, check = SEEDS_DEFAULT;
    if (q->seeds)
        LL_TRY(
            ll_argument_whole("--seeds", q->seeds, LL_INTERVAL_MIN, LL_REFINEMENT_SERIES_SEEDS_MAX, &seeds));
    if (q->check_seeds && strcmp(q->check_seeds, "0") == 0)
        check = 0;
    else if (q->check_seeds)
        LL_TRY(ll_argument_whole("--check-seeds", q->check_seeds, LL_INTERVAL_MIN,
                                 LL_REFINEMENT_SERIES_SEEDS_MAX, &check));
    order->seeds = (int)seeds;
    order->check_seeds = (int)check;
    if (q->duration) {
        char *end;
        double duration = strtod(q->duration, &end);
        if (*end != '\0' || !(duration > 0 && duration <= 1e6))
            return ll_error(LL_BAD_INPUT, "--duration: must be above 0 and at most 1e6 s; got %.40s",
                            q->duration);
        order->duration = q->duration;
    }
    return ll_ok();
}

/* ---- output ---- */

static void print_winners(const request *q)
{
    for (int f = 0; f < q->count; f++) {
        const ll_tradeoff *t = &q->families[f];
        for (int i = 0; i < t->choice_count; i++) {
            const ll_tradeoff_choice *c = &t->choices[i];
            const ll_tradeoff_row *row = c->row < 0 ? NULL : &t->rows[c->row];
            printf("%s, %s, error <= %.2g, least %s: ", t->family->name,
                   t->family->problems[c->problem].scenario, c->level, t->family->costs[c->cost].path);
            if (row)
                printf("%s %.6g", row->method, strtod(row->value, NULL));
            printf("%s; %s%s%s%s%s%s\n", row ? "" : "none", ll_tradeoff_verdict(c), *c->why ? " (" : "",
                   c->why, *c->why ? ")" : "", *c->tied ? "; as cheap: " : "", c->tied);
        }
    }
}

static ll_status write_tables(const request *q)
{
    cursor rows = {.q = q}, choices = {.q = q};
    const ll_table row_table = {row_columns, sizeof row_columns / sizeof row_columns[0], next_row, &rows};
    const ll_table winner_table = {winner_columns, sizeof winner_columns / sizeof winner_columns[0],
                                   next_choice, &choices};
    LL_TRY(ll_argument_write(q->out, q->format, &row_table));
    if (q->winners) {
        const ll_format *format;
        LL_TRY(ll_argument_format(q->format_name, q->winners, &format));
        LL_TRY(ll_argument_write(q->winners, format, &winner_table));
    }
    if (q->out)
        print_winners(q);
    return ll_ok();
}

static ll_status write_page(const request *q)
{
    char command[200] = "laglab tradeoff";
    cJSON *data = cJSON_CreateObject(), *families = cJSON_AddArrayToObject(data, "families");
    for (int i = 0; i < q->count; i++) {
        snprintf(command + strlen(command), sizeof command - strlen(command), " %s",
                 q->families[i].family->name);
        cJSON_AddItemToArray(families, ll_tradeoff_json(&q->families[i]));
    }
    cJSON_AddStringToObject(data, "kind", "tradeoff");
    cJSON_AddStringToObject(data, "command", command);
    cJSON_AddStringToObject(data, "address", q->page);
    return ll_page_write(q->report, "Speed against error", data);
}

static ll_status measure(request *q, const ll_tradeoff_request *order)
{
    for (int i = 0; i < q->count; i++)
        LL_TRY(ll_tradeoff_measure(q->families[i].family, order, &q->families[i]));
    return ll_ok();
}

int ll_verb_tradeoff(int argc, char **argv)
{
    request q = {.page = "http://127.0.0.1:8080/"};
    char folder[PATH_MAX];
    const ll_option options[] = {
        {"--methods", "A,B,...", "Only these methods.", .value = &q.methods},
        {"--seeds", "N", "Runs of each setting of what is random, 10 to 1000; default 20.",
         .value = &q.seeds},
        {"--check-seeds", "N",
         "Runs of each setting on fresh seeds, 10 to 1000, which check the choices; default 20. 0: no check.",
         .value = &q.check_seeds},
        {"--duration", "S", "Virtual seconds of a run; default: those of each series.", .value = &q.duration},
        {"--out", "FILE", "Rows, one per setting and cost; default: standard output.", .value = &q.out},
        {"--winners", "FILE", "The choices: one per problem, cost and level of error.", .value = &q.winners},
        {"--format", "NAME", "csv, ndjson, json or sqlite; default: by the ending of FILE.",
         .value = &q.format_name},
        {"--report", "FILE.html", "Writes a page with plots and choices.", .value = &q.report},
        {"--page", "URL", "Where the page is, for links to live sessions; default http://127.0.0.1:8080/.",
         .value = &q.page},
        {"--scenarios", "DIR", "Folder of the scenario library; default: next to the program.",
         .value = &q.scenarios},
        {"--list", NULL, "Prints the families with their problems and costs, as JSON.", .flag = &q.list},
        {0}};
    const char *positional[LL_POSITIONAL_MAX];
    int count;
    ll_tradeoff_request order = {.now_ns = ll_process_cpu_ns};
    ll_status status = ll_arguments(
        "tradeoff [FAMILY...] [OPTION]...: speed against error of families of methods, all by default: "
        "integrators, contact_solvers, pressure_solvers, particles, oceans, snapshots, synchronisation, "
        "lag_compensation. Each method at each of its own settings, on the front of the error and each cost; "
        "at three levels of error the cheapest, measured again on fresh seeds",
        argc, argv, options, positional, &count);
    if (!ll_failed(&status) && q.list)
        return ll_print_json(ll_tradeoff_families_json());
    LL_THEN(status, take_families(&q, positional, count));
    LL_THEN(status, take_numbers(&q, &order));
    LL_THEN(status, ll_argument_format(q.format_name, q.out, &q.format));
    order.methods = q.methods;
    order.scenarios = ll_scenario_folder(q.scenarios, folder);
    LL_THEN(status, measure(&q, &order));
    LL_THEN(status, write_tables(&q));
    LL_THEN(status, q.report ? write_page(&q) : ll_ok());
    for (int i = 0; i < q.count; i++)
        ll_tradeoff_free(&q.families[i]);
    return ll_failed(&status) ? ll_argument_fail(&status) : 0;
}
