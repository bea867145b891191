/* Shared by the tests of experiments: experiments from text, and given rows. cmocka.h and what it needs come
 * before. */
#pragma once

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "experiment/format/points.h"
#include "experiment/spec/experiment.h"

static inline void must(ll_status status)
{
    if (ll_failed(&status))
        fail_msg("%s", status.text);
}

static inline ll_status parse(const char *text, ll_experiment **e)
{
    cJSON *json = cJSON_Parse(text);
    assert_non_null(json);
    ll_status status = ll_experiment_parse(json, "scenarios", NULL, e);
    cJSON_Delete(json);
    return status;
}

static inline ll_experiment *experiment(const char *text)
{
    ll_experiment *e;
    must(parse(text, &e));
    return e;
}

static inline double value(const ll_experiment *e, int64_t point, const char *path)
{
    cJSON *values = ll_experiment_point(e, point);
    const cJSON *item = cJSON_GetObjectItem(values, path);
    assert_non_null(item);
    double number = cJSON_IsBool(item) ? cJSON_IsTrue(item) : item->valuedouble;
    cJSON_Delete(values);
    return number;
}

#define METRICS "\"metrics\":[\"players.0.own_lead_m.mean\"]"

/* Given rows, by run. */
typedef struct given {
    const ll_row *rows;
    int at, count;
} given;

static inline bool next_given(void *context, ll_row *row, ll_status *status)
{
    given *g = context;
    *status = ll_ok();
    if (g->at == g->count)
        return false;
    *row = g->rows[g->at++];
    return true;
}
