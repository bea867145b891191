/* Motions run from their scenario, for tests. */
#pragma once

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cjson/cJSON.h>
#include <cmocka.h>

#include "session/scenario.h"
#include "session/session.h"

/* The report at the end; the caller deletes it. `text` is a scenario's members without `kind`. */
static inline cJSON *lab_run(const char *text)
{
    char whole[2048];
    ll_session *s;
    assert_true(snprintf(whole, sizeof whole, "{\"kind\":\"motion\",%s}", text) < (int)sizeof whole);
    cJSON *json = cJSON_Parse(whole);
    assert_non_null(json);
    ll_status status = ll_session_create(json, -1, NULL, NULL, &s);
    if (!ll_failed(&status))
        status = ll_session_run_to(s, ll_session_get_info(s).end_tick);
    if (ll_failed(&status))
        fail_msg("%s: %s", text, status.text);
    cJSON *report = ll_session_metrics(s), *metrics = cJSON_DetachItemFromObject(report, "metrics");
    cJSON_Delete(report);
    cJSON_Delete(json);
    ll_session_destroy(s);
    return metrics;
}

/* To the last digit; NAN for null. */
static inline double lab_value(const cJSON *item)
{
    if (item != NULL && cJSON_IsRaw(item))
        return strtod(item->valuestring, NULL);
    return item != NULL && cJSON_IsNumber(item) ? item->valuedouble : NAN;
}

static inline const cJSON *lab_method(const cJSON *metrics, int i)
{
    return cJSON_GetArrayItem(cJSON_GetObjectItem(metrics, "methods"), i);
}

static inline double lab_number(const cJSON *o, const char *name)
{
    return lab_value(cJSON_GetObjectItem(o, name));
}

static inline double lab_state(const cJSON *method, const char *name, int k)
{
    return lab_value(cJSON_GetArrayItem(cJSON_GetObjectItem(method, name), k));
}

static inline const char *lab_status(const cJSON *method)
{
    return cJSON_GetObjectItem(method, "status")->valuestring;
}
