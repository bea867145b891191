#include "support/golden.h"

#include <inttypes.h>
#include <stdio.h>

#include <cjson/cJSON.h>

#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"

static double number(const cJSON *object, const char *name)
{
    return cJSON_GetObjectItem(object, name)->valuedouble;
}

static ll_status add_expectations(const char *id, const cJSON *expect, char *line, int used)
{
    const cJSON *item;
    char separator = ',';
    if (cJSON_GetArraySize(expect) == 0)
        return ll_error(LL_BAD_INPUT, "%s names no expect", id);
    cJSON_ArrayForEach(item, expect)
    {
        const char *metric = cJSON_GetObjectItem(item, "metric")->valuestring;
        if (!cJSON_IsTrue(cJSON_GetObjectItem(item, "met")))
            return ll_error(LL_BAD_INPUT, "%s: %s is %g, less than %g", id, metric, number(item, "value"),
                            number(item, "min"));
        used += snprintf(line + used, (size_t)(GOLDEN_LINE_MAX - used), "%c%s=%.17g", separator, metric,
                         number(item, "value"));
        separator = ';';
    }
    return ll_ok();
}

ll_status golden_line(const char *id, char line[GOLDEN_LINE_MAX])
{
    cJSON *json = NULL, *report = NULL;
    ll_session *s = NULL;
    int used;
    ll_status status = ll_scenario_load("scenarios", id, &json);
    if (!ll_failed(&status))
        status = ll_session_create(json, -1, NULL, NULL, &s);
    if (!ll_failed(&status))
        status = ll_session_run_to(s, ll_session_get_info(s).end_tick);
    if (ll_failed(&status))
        goto cleanup;
    used = snprintf(line, GOLDEN_LINE_MAX, "%s,%" PRId64 ",%016" PRIx64, id, ll_session_get_info(s).tick,
                    ll_session_hash(s));
    report = ll_session_metrics(s);
    status = add_expectations(id, cJSON_GetObjectItem(cJSON_GetObjectItem(report, "metrics"), "expect"), line,
                              used);
cleanup:
    cJSON_Delete(report);
    ll_session_destroy(s);
    cJSON_Delete(json);
    return status;
}
