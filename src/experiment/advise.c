#include "experiment/advise.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/detmath.h"
#include "base/rng.h"
#include "experiment/points.h"
#include "experiment/surrogate.h"

enum { COST, ERROR };

#define LEAST_RUNS 10
#define TINY 1e-12     /* below it, costs and errors are equal */
#define FAR 15         /* errors are told apart up to so many factors of e from the limit */
#define WORTH 2e-3     /* a saving, as a part of the cost, that is not worth a run */
#define FIRST_PART 0.3 /* of the runs that may be spent go to an even spread */

/* Welford's sums over the seeds of a point. */
typedef struct trial {
    int64_t runs, failed;
    double mean[2], squares[2];
    bool tried, holds, ruled_out;
} trial;

typedef struct search {
    const ll_advice_order *order;
    const ll_experiment *experiment;
    ll_surrogate *surrogate;
    trial *trials; /* by point */
    int points, best;
    int64_t runs, most;
} search;

/* ---- running ---- */

static ll_status run_once(search *s, int point)
{
    trial *t = &s->trials[point];
    ll_row row;
    ll_status status = ll_experiment_run(
        s->experiment, point * s->experiment->head.repeats + t->runs + t->failed, NULL, &row);
    if (ll_failed(&status))
        return status;
    s->runs++;
    double value[2] = {fabs(row.metrics[s->experiment->cost_metric]),
                       fabs(row.metrics[s->experiment->error_metric])};
    bool good = ll_row_good(&row) && isfinite(value[0]) && isfinite(value[1]);
    t->failed += !good;
    t->runs += good;
    for (int k = 0; k < 2 && good; k++) {
        double delta = value[k] - t->mean[k];
        t->mean[k] += delta / (double)t->runs;
        t->squares[k] += delta * (value[k] - t->mean[k]);
    }
    return status;
}

/* Half of the 95 % interval of the error; nothing is known of it before the second seed. */
static double half(const trial *t)
{
    return t->runs > 1 ? ll_interval_95(t->runs, t->squares[ERROR]) : INFINITY;
}

/* Seeds that all give the same tell nothing of how far off that is. */
static bool has_interval(const trial *t)
{
    return t->runs > 1 && (t->squares[ERROR] > 0 || t->squares[COST] > 0);
}

static void judge(const search *s, trial *t)
{
    int64_t repeats = s->experiment->head.repeats;
    if (t->failed > 0)
        t->ruled_out = true;
    else if (t->runs == repeats)
        t->ruled_out = !(t->holds = t->mean[ERROR] <= s->order->max_error);
    else
        t->ruled_out = t->mean[ERROR] - half(t) > s->order->max_error;
}

static void tell(search *s, int point)
{
    const trial *t = &s->trials[point];
    double limit = ll_log(s->order->max_error), values[2];
    double error = t->runs == 0 ? limit + FAR : ll_log(fmax(t->mean[ERROR], TINY));
    values[COST] = ll_log(fmax(t->mean[COST], TINY));
    values[ERROR] = fmin(fmax(error, limit - FAR), limit + FAR);
    if (t->runs == 0) { /* it failed: its cost says nothing */
        double deviation[2], mean[2];
        ll_surrogate_expect(s->surrogate, point, mean, deviation);
        values[COST] = mean[COST];
    }
    ll_surrogate_tell(s->surrogate, point, values);
    ll_surrogate_fit(s->surrogate);
}

static bool worth_more(const search *s, const trial *t)
{
    bool cheaper = s->best < 0 || t->mean[COST] < s->trials[s->best].mean[COST];
    return !t->holds && !t->ruled_out && cheaper && s->runs < s->most;
}

/* With a single seed the error has no interval: a point that misses by so much more than others scatter is
 * not run again. */
static bool hopeless(const search *s, const trial *t)
{
    return t->runs == 1 && s->experiment->head.repeats > 1 && t->mean[ERROR] > 2 * s->order->max_error;
}

static ll_status try_point(search *s, int point)
{
    trial *t = &s->trials[point];
    ll_status status = ll_ok();
    if (!t->tried)
        status = ll_surrogate_see(s->surrogate, point);
    t->tried = true;
    int64_t next = 1;
    do {
        while (!ll_failed(&status) && t->runs + t->failed < next && s->runs < s->most)
            status = run_once(s, point);
        judge(s, t);
        t->ruled_out |= hopeless(s, t);
        next = next * 2 < s->experiment->head.repeats ? next * 2 : s->experiment->head.repeats;
    } while (!ll_failed(&status) && worth_more(s, t));
    if (!ll_failed(&status))
        tell(s, point);
    if (t->holds && (s->best < 0 || t->mean[COST] < s->trials[s->best].mean[COST]))
        s->best = point;
    return status;
}

/* ---- choosing ---- */

static double density(double z)
{
    return 0.3989422804014327 * ll_exp(-z * z / 2);
}

/* Expected saving in log cost against the best, times the chance to hold; before one holds, that chance, and
 * of equal chances the cheaper. */
static double promise(const search *s, int point)
{
    double mean[2], deviation[2];
    ll_surrogate_expect(s->surrogate, point, mean, deviation);
    double chance = ll_normal_cdf((ll_log(s->order->max_error) - mean[ERROR]) / deviation[ERROR]);
    if (s->best < 0)
        return chance * ll_exp(-0.02 * (mean[COST] - ll_log(TINY)));
    double saved = ll_log(fmax(s->trials[s->best].mean[COST], TINY)) - mean[COST],
           z = saved / deviation[COST];
    return chance * (saved * ll_normal_cdf(z) + deviation[COST] * density(z));
}

static int most_promising(const search *s, double *most)
{
    int found = -1;
    *most = 0;
    for (int p = 0; p < s->points; p++) {
        if (s->trials[p].tried)
            continue;
        double value = promise(s, p);
        if (value > *most) {
            *most = value;
            found = p;
        }
    }
    return found;
}

static int most_doubtful(const search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++)
        if (!s->trials[p].tried && (found < 0 || ll_surrogate_doubt(s->surrogate, p) >
                                                     ll_surrogate_doubt(s->surrogate, found) * (1 + 1e-9)))
            found = p;
    return found;
}

/* A tried point that was left has a cost above the best's, which only falls: it need not be looked at again.
 */
static ll_status look(search *s)
{
    ll_status status = ll_ok();
    int64_t spread = (int64_t)(FIRST_PART * (double)s->most);
    int first = 0;
    while (!ll_failed(&status) && s->runs < spread && first >= 0 && first < s->most / 3) {
        int point = most_doubtful(s);
        if (point < 0)
            break;
        status = try_point(s, point);
        first++;
    }
    while (!ll_failed(&status) && s->runs < s->most) {
        double most;
        int point = most_promising(s, &most);
        if (point < 0 || (s->best >= 0 && most < WORTH))
            break;
        status = try_point(s, point);
    }
    return status.code == LL_LIMIT ? ll_ok() : status;
}

/* ---- answering ---- */

static cJSON *describe(const search *s, int point)
{
    const trial *t = &s->trials[point];
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "point", point);
    cJSON_AddItemToObject(json, "set", ll_experiment_point(s->experiment, point));
    cJSON_AddItemToObject(json, "error", t->runs ? ll_param_number(t->mean[ERROR]) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "error_ci95",
                          has_interval(t) ? ll_param_number(half(t)) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "cost", t->runs ? ll_param_number(t->mean[COST]) : cJSON_CreateNull());
    cJSON_AddNumberToObject(json, "runs", (double)(t->runs + t->failed));
    return json;
}

static const char *reason(const search *s, const trial *t)
{
    if (t->failed > 0)
        return "a run failed";
    if (t->ruled_out)
        return "the error is above the limit";
    return s->best >= 0 && t->mean[COST] >= s->trials[s->best].mean[COST] ? "it costs more"
                                                                          : "not all seeds were run";
}

static bool on_front(const search *s, int point)
{
    const trial *t = &s->trials[point];
    for (int p = 0; p < s->points; p++) {
        const trial *o = &s->trials[p];
        if (o->runs > 0 && o->mean[COST] <= t->mean[COST] && o->mean[ERROR] <= t->mean[ERROR] &&
            (o->mean[COST] < t->mean[COST] || o->mean[ERROR] < t->mean[ERROR]))
            return false;
    }
    return t->runs > 0;
}

static int least_error(const search *s)
{
    int found = -1;
    for (int p = 0; p < s->points; p++)
        if (s->trials[p].runs > 0 && (found < 0 || s->trials[p].mean[ERROR] < s->trials[found].mean[ERROR]))
            found = p;
    return found;
}

static cJSON *answer_of(const search *s)
{
    const ll_experiment *e = s->experiment;
    int nearest = s->best < 0 ? least_error(s) : -1;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddBoolToObject(json, "holds", s->best >= 0);
    cJSON_AddItemToObject(json, "max_error", ll_param_number(s->order->max_error));
    cJSON_AddStringToObject(json, "error_metric", e->metrics[e->error_metric]);
    cJSON_AddStringToObject(json, "cost_metric", e->metrics[e->cost_metric]);
    cJSON_AddItemToObject(json, "advice", s->best >= 0 ? describe(s, s->best) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "nearest", nearest >= 0 ? describe(s, nearest) : cJSON_CreateNull());
    cJSON *front = cJSON_AddArrayToObject(json, "front"), *out = cJSON_AddArrayToObject(json, "ruled_out");
    for (int p = 0; p < s->points; p++) {
        if (on_front(s, p))
            cJSON_AddItemToArray(front, describe(s, p));
        if (!s->trials[p].tried || p == s->best)
            continue;
        cJSON *item = describe(s, p);
        cJSON_AddStringToObject(item, "why", reason(s, &s->trials[p]));
        cJSON_AddItemToArray(out, item);
    }
    cJSON_AddNumberToObject(json, "runs", (double)s->runs);
    cJSON_AddNumberToObject(json, "of_runs", (double)e->runs);
    return json;
}

static ll_status check(const ll_advice_order *order)
{
    const ll_experiment *e = order->experiment;
    if (!(order->max_error > 0 && isfinite(order->max_error)))
        return ll_field_error(LL_BAD_INPUT, "max_error", "max_error must be above 0; got %g",
                              order->max_error);
    if (e->cost_metric < 0)
        return ll_field_error(LL_BAD_INPUT, "cost",
                              "cost must name a metric: the adviser weighs it against the error");
    if (e->head.sample.method != LL_SAMPLE_NONE)
        return ll_field_error(LL_BAD_INPUT, "sample",
                              "sample is not for the adviser, which chooses its points itself");
    if (e->points > LL_SURROGATE_POINTS_MAX)
        return ll_field_error(LL_BAD_INPUT, "axes", "axes give %lld points; the adviser takes at most %d",
                              (long long)e->points, LL_SURROGATE_POINTS_MAX);
    return ll_ok();
}

ll_status ll_advise(const ll_advice_order *order, cJSON **answer)
{
    const ll_experiment *e = order->experiment;
    ll_status status = check(order);
    *answer = NULL;
    if (ll_failed(&status))
        return status;
    search s = {.order = order, .experiment = e, .points = (int)e->points, .best = -1};
    s.most = order->most_runs > 0 ? order->most_runs : e->runs / 5 > LEAST_RUNS ? e->runs / 5 : LEAST_RUNS;
    s.trials = calloc((size_t)e->points, sizeof *s.trials);
    status =
        s.trials ? ll_surrogate_create(e, &s.surrogate) : ll_error(LL_NO_MEMORY, "no memory for the adviser");
    if (!ll_failed(&status))
        status = look(&s);
    if (!ll_failed(&status))
        *answer = answer_of(&s);
    ll_surrogate_free(s.surrogate);
    free(s.trials);
    return status;
}
