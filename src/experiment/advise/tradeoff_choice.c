/* Fronts, levels, choices, and whether these hold. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "experiment/advise/tradeoff.h"

/* The rows of a problem with one of its costs. */
typedef struct view {
    const ll_tradeoff *tradeoff;
    int first, count; /* rows of the problem, which are consecutive */
    int cost;
    ll_front_point *now, *again; /* by row */
    double *bounds;              /* space for one per row */
} view;

static int method_number(const ll_tradeoff_row *rows, int at)
{
    int k = 0;
    while (strcmp(rows[k].method, rows[at].method) != 0)
        k++;
    return k;
}

static ll_front_point point_of(const ll_tradeoff_values *v, int cost, int method)
{
    const ll_measured *c = &v->costs[cost];
    if (v->seeds == 0)
        return (ll_front_point){NAN, NAN, NAN, NAN, NAN, method, false};
    return (ll_front_point){c->value, c->low, c->high, v->error.value, v->error.high, method, false};
}

static void see_cost(view *w, int cost)
{
    const ll_tradeoff_row *rows = &w->tradeoff->rows[w->first];
    w->cost = cost;
    for (int i = 0; i < w->count; i++) {
        w->now[i] = point_of(&rows[i].values, cost, method_number(rows, i));
        w->again[i] = point_of(&rows[i].again, cost, w->now[i].method);
    }
}

/* ---- whether a choice holds ---- */

static bool is_same_cost(const ll_front_point *a, const ll_front_point *b)
{
    return !ll_front_certainly_cheaper(a, b) && !ll_front_certainly_cheaper(b, a);
}

/* Methods other than the chosen one, whose cost does not differ certainly from it, in either measurement. */
static void name_ties(const view *w, ll_tradeoff_choice *choice)
{
    const ll_tradeoff_row *rows = &w->tradeoff->rows[w->first];
    int chosen = choice->row - w->first;
    const ll_front_point *const measured[] = {w->now, w->again};
    for (int method = 0; method < w->count; method++) {
        bool tied = false;
        for (int m = 0; m < 2 && method != w->now[chosen].method; m++) {
            int other = ll_front_cheapest_of(measured[m], w->count, choice->level, method);
            tied = tied || (other >= 0 && is_same_cost(&measured[m][chosen], &measured[m][other]));
        }
        size_t used = strlen(choice->tied);
        if (tied)
            snprintf(choice->tied + used, sizeof choice->tied - used, "%s%s", used ? ", " : "",
                     rows[method].method);
    }
}

static void check(const view *w, ll_tradeoff_choice *choice)
{
    const ll_tradeoff_row *rows = &w->tradeoff->rows[w->first];
    int chosen = choice->row - w->first;
    const ll_front_point *p = &w->again[chosen];
    int best = ll_front_cheapest(w->again, w->count, choice->level);
    const ll_tradeoff_row *row = &rows[chosen];
    choice->checked = row->again.seeds > 0;
    choice->cheapest_again = best < 0 ? -1 : w->first + best;
    if (!choice->checked)
        return;
    bool within = p->error_high <= choice->level;
    bool beaten = within && ll_front_certainly_cheaper(&w->again[best], p);
    choice->holds = within && !beaten;
    if (!within)
        snprintf(choice->why, sizeof choice->why, "its error is %.3g, at most %.3g", p->error, p->error_high);
    else if (beaten || best != chosen)
        snprintf(choice->why, sizeof choice->why, "%s %.6g %s: %.4g against %.4g", rows[best].method,
                 strtod(rows[best].value, NULL), beaten ? "is cheaper" : "is as cheap", w->again[best].cost,
                 p->cost);
    else
        snprintf(choice->why, sizeof choice->why, "the cheapest again, at %.4g", p->cost);
}

const char *ll_tradeoff_verdict(const ll_tradeoff_choice *choice)
{
    if (choice->row < 0)
        return "nothing";
    return !choice->checked ? "not checked" : choice->holds ? "holds" : "does not hold";
}

static ll_tradeoff_choice choose(const view *w, int problem, double level)
{
    ll_tradeoff_choice choice = {
        .problem = problem, .cost = w->cost, .level = level, .row = -1, .cheapest_again = -1};
    int found = ll_front_cheapest(w->now, w->count, level);
    if (found < 0)
        return choice;
    choice.row = w->first + found;
    check(w, &choice);
    name_ties(w, &choice);
    return choice;
}

/* ---- a problem ---- */

/* Levels from the rows on the front of a cost other than time. */
static int find_levels(const view *w, int costs, double levels[LL_FRONT_LEVELS])
{
    const ll_tradeoff_row *rows = &w->tradeoff->rows[w->first];
    int n = 0;
    for (int i = 0; i < w->count; i++) {
        bool on = false;
        for (int c = 1; c < costs; c++)
            on = on || rows[i].front[c];
        if (on)
            w->bounds[n++] = rows[i].values.error.high;
    }
    return ll_front_levels(w->bounds, n, levels);
}

static ll_status choose_of_problem(ll_tradeoff *t, view *w, int problem)
{
    int costs = ll_tradeoff_cost_count(t->family);
    double levels[LL_FRONT_LEVELS];
    for (int c = 0; c < costs; c++) {
        see_cost(w, c);
        LL_TRY(ll_front_mark(w->now, w->count));
        for (int i = 0; i < w->count; i++)
            t->rows[w->first + i].front[c] = w->now[i].front;
    }
    int count = find_levels(w, costs, levels);
    for (int c = 0; c < costs; c++) {
        see_cost(w, c);
        for (int k = 0; k < count; k++)
            t->choices[t->choice_count++] = choose(w, problem, levels[k]);
    }
    return ll_ok();
}

ll_status ll_tradeoff_choose(ll_tradeoff *t)
{
    int problems = ll_tradeoff_problem_count(t->family);
    size_t each = (size_t)t->count * sizeof(ll_front_point) + 1;
    view w = {.tradeoff = t, .now = malloc(each), .again = malloc(each), .bounds = malloc(each)};
    free(t->choices);
    t->choice_count = 0;
    t->choices = calloc((size_t)(problems * LL_TRADEOFF_COSTS_MAX * LL_FRONT_LEVELS), sizeof *t->choices);
    ll_status status = w.now && w.again && w.bounds && t->choices
                           ? ll_ok()
                           : ll_error(LL_NO_MEMORY, "out of memory: choices");
    for (int problem = 0; problem < problems && !ll_failed(&status); problem++) {
        w.first += w.count;
        w.count = 0;
        while (w.first + w.count < t->count && t->rows[w.first + w.count].problem == problem)
            w.count++;
        status = choose_of_problem(t, &w, problem);
    }
    free(w.now);
    free(w.again);
    free(w.bounds);
    return status;
}
