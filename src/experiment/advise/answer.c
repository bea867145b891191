/* The adviser's answer: the advice with its evidence. */
#include <cjson/cJSON.h>

#include "experiment/advise/internal.h"

static cJSON *describe(const ll_advise_search *s, int point)
{
    const ll_trial *t = &s->trials[point];
    cJSON *json = cJSON_CreateObject();
    cJSON_AddNumberToObject(json, "point", point);
    cJSON_AddItemToObject(json, "set", ll_experiment_point(s->experiment, point));
    cJSON_AddItemToObject(json, "error", t->runs ? ll_param_number(t->own[ERROR].mean) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "error_ci95",
                          has_interval(t->own) ? ll_param_number(half(&t->own[ERROR])) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "cost", t->runs ? ll_param_number(t->own[COST].mean) : cJSON_CreateNull());
    cJSON_AddNumberToObject(json, "runs", (double)(t->runs + t->failed));
    return json;
}

/* Adds the results on fresh seeds; the error is that over all of its seeds. */
static cJSON *describe_verified(const ll_advise_search *s, int point)
{
    const ll_trial *t = &s->trials[point];
    cJSON *json = describe(s, point), *verified = cJSON_AddObjectToObject(json, "verified");
    ll_sums all = ll_advise_all_sums(t);
    cJSON_ReplaceItemInObject(json, "error", ll_param_number(all.mean));
    cJSON_ReplaceItemInObject(json, "error_ci95",
                              has_interval(t->own) || all.squares > 0
                                  ? ll_param_number(ll_interval_95(all.n, all.squares))
                                  : cJSON_CreateNull());
    cJSON_AddNumberToObject(verified, "runs", (double)t->fresh[ERROR].n);
    cJSON_AddItemToObject(verified, "error", ll_param_number(t->fresh[ERROR].mean));
    cJSON_AddItemToObject(verified, "error_ci95",
                          ll_advise_is_certain(s, t) ? cJSON_CreateNull()
                                                     : ll_param_number(ll_advise_uncertainty(s, t)));
    return json;
}

static const char *reason(const ll_advise_search *s, const ll_trial *t)
{
    if (t->state == RULED_OUT)
        return t->why;
    if (s->best >= 0 && !ll_advise_beats(t, &s->trials[s->best]))
        return "it costs more";
    if (t->state == UNCLEAR && t->fresh[ERROR].n > 0)
        return ll_advise_undecided;
    return t->state == HOLDS || t->state == UNCLEAR ? "not verified" : "not all seeds were run";
}

/* Of settings without a failed run. */
static bool on_front(const ll_advise_search *s, int point)
{
    const ll_trial *t = &s->trials[point];
    double cost = t->own[COST].mean, error = t->own[ERROR].mean;
    for (int p = 0; p < s->points; p++) {
        const ll_trial *o = &s->trials[p];
        double x = o->own[COST].mean, y = o->own[ERROR].mean;
        if (o->runs > 0 && o->failed == 0 && x <= cost && y <= error && (x < cost || y < error))
            return false;
    }
    return t->runs > 0 && t->failed == 0;
}

cJSON *ll_advise_answer(const ll_advise_search *s, bool proven)
{
    const ll_experiment *e = s->experiment;
    /* another one that holds may be cheaper, except by chance */
    int best = ll_advise_cheapest(s, ll_advise_is_verified),
        nearest = best < 0 ? ll_advise_least_error(s) : -1;
    cJSON *json = cJSON_CreateObject();
    cJSON_AddBoolToObject(json, "holds", best >= 0);
    cJSON_AddStringToObject(json, "optimum", proven ? "proven" : "best found");
    cJSON_AddItemToObject(json, "max_error", ll_param_number(s->request->max_error));
    cJSON_AddStringToObject(json, "error_metric", e->metrics[e->error_metric]);
    cJSON_AddStringToObject(json, "cost_metric", e->metrics[e->cost_metric]);
    cJSON_AddItemToObject(json, "advice", best >= 0 ? describe_verified(s, best) : cJSON_CreateNull());
    cJSON_AddItemToObject(json, "nearest", nearest >= 0 ? describe(s, nearest) : cJSON_CreateNull());
    cJSON *front = cJSON_AddArrayToObject(json, "front"), *out = cJSON_AddArrayToObject(json, "ruled_out");
    for (int p = 0; p < s->points; p++) {
        if (on_front(s, p))
            cJSON_AddItemToArray(front, describe(s, p));
        if (s->trials[p].state == UNTRIED || p == best)
            continue;
        cJSON *item = describe(s, p);
        cJSON_AddStringToObject(item, "why", reason(s, &s->trials[p]));
        cJSON_AddItemToArray(out, item);
    }
    cJSON_AddNumberToObject(json, "runs", (double)s->runs);
    cJSON_AddNumberToObject(json, "of_runs", (double)e->runs);
    return json;
}
