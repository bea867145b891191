/* include/laglab.h by sessions. */
#include <cjson/cJSON.h>
#include <laglab.h>
#include <locale.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/version.h"
#include "embed/paths.h"
#include "experiment/spec/metric_path.h"
#include "input/action.h"
#include "library/library.h"
#include "session/scenario.h"
#include "session/session.h"

struct laglab_run {
    ll_session *session; /* NULL: it could not be opened */
    ll_status last;      /* of the last call that failed */
    cJSON *report;       /* metrics of the present tick; NULL: not read yet */
    ll_paths paths;      /* of its numbers; empty: not listed yet */
    locale_t own, callers;
};

/* Numbers are read and written with a point, in a program of any locale: each call is between these two. */
static void begin(laglab_run *run)
{
    run->callers = uselocale(run->own);
}

static void end(laglab_run *run)
{
    uselocale(run->callers);
}

static laglab_code code_of(ll_code code)
{
    switch (code) {
    case LL_OK:
        return LAGLAB_OK;
    case LL_BAD_INPUT:
        return LAGLAB_BAD_INPUT;
    case LL_NOT_FOUND:
        return LAGLAB_NOT_FOUND;
    case LL_CONFLICT:
        return LAGLAB_CONFLICT;
    case LL_DIVERGED:
        return LAGLAB_DIVERGED;
    case LL_NO_MEMORY:
        return LAGLAB_NO_MEMORY;
    default:
        return LAGLAB_FAILED;
    }
}

/* Ends a call, and keeps a failure for laglab_error. */
static laglab_code answer(laglab_run *run, ll_status status)
{
    end(run);
    if (ll_failed(&status))
        run->last = status;
    return code_of(status.code);
}

static const ll_status closed_error = {LL_CONFLICT, "", "the scenario could not be opened"};

static void forget_report(laglab_run *run)
{
    ll_paths_free(&run->paths);
    cJSON_Delete(run->report);
    run->report = NULL;
}

/* NULL: no memory. */
static const cJSON *metrics_of(laglab_run *run)
{
    if (!run->report)
        run->report = ll_session_metrics(run->session);
    return cJSON_GetObjectItemCaseSensitive(run->report, "metrics");
}

/* ---- opening ---- */

const char *laglab_version(void)
{
    return ll_version;
}

static ll_status open_read(cJSON **json, const char *const *sets, laglab_run *run)
{
    int count = 0;
    while (sets && sets[count])
        count++;
    LL_TRY(ll_scenario_override(json, sets, count, (const char *const[]){NULL}));
    ll_scenario scenario = {0};
    LL_TRY(ll_scenario_parse(*json, &scenario));
    return ll_session_open_unwatched(&scenario, &run->session);
}

/* The text of a scenario, or with a folder its id. */
static laglab_code open_new(const char *folder, const char *text, const char *const *sets, laglab_run **out)
{
    laglab_run *run = *out = calloc(1, sizeof *run);
    if (run)
        run->own = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    if (!run || !run->own) {
        free(run);
        *out = NULL;
        return LAGLAB_NO_MEMORY;
    }
    begin(run);
    cJSON *json = NULL;
    ll_status status =
        folder ? ll_scenario_load(folder, text, &json) : ll_json_parse(text, strlen(text), &json);
    LL_THEN(status, open_read(&json, sets, run));
    cJSON_Delete(json);
    return answer(run, status);
}

laglab_code laglab_open(const char *json, const char *const *sets, laglab_run **run)
{
    return open_new(NULL, json, sets, run);
}

laglab_code laglab_open_named(const char *folder, const char *id, const char *const *sets, laglab_run **run)
{
    return open_new(folder, id, sets, run);
}

void laglab_close(laglab_run *run)
{
    if (!run)
        return;
    forget_report(run);
    if (run->session)
        ll_session_destroy(run->session);
    freelocale(run->own);
    free(run);
}

const char *laglab_error(const laglab_run *run)
{
    return run ? run->last.text : "out of memory: run";
}

const char *laglab_error_field(const laglab_run *run)
{
    return run ? run->last.field : "";
}

/* ---- time ---- */

int64_t laglab_tick(const laglab_run *run)
{
    return run->session ? ll_session_get_info(run->session).tick : 0;
}

int64_t laglab_end_tick(const laglab_run *run)
{
    return run->session ? ll_session_get_info(run->session).end_tick : 0;
}

double laglab_time_s(const laglab_run *run)
{
    return run->session ? ll_to_s(ll_session_get_info(run->session).time) : 0;
}

laglab_code laglab_run_to(laglab_run *run, int64_t tick)
{
    begin(run);
    forget_report(run);
    return answer(run, run->session ? ll_session_run_to(run->session, tick) : closed_error);
}

/* ---- changing ---- */

/* {"path": value} of path=value. A value that is no JSON is a text, as of --set. Caller deletes. */
static ll_status patch_of(const char *set, cJSON **patch)
{
    const char *equals = strchr(set, '=');
    *patch = NULL;
    if (!equals)
        return ll_error(LL_BAD_INPUT, "set: must be path=value; got %.100s", set);
    char *path = strndup(set, (size_t)(equals - set));
    cJSON *value = NULL;
    ll_status status = ll_json_parse(equals + 1, strlen(equals + 1), &value);
    if (ll_failed(&status))
        value = cJSON_CreateString(equals + 1);
    *patch = cJSON_CreateObject();
    if (path && value && cJSON_AddItemToObject(*patch, path, value)) {
        free(path);
        return ll_ok();
    }
    free(path);
    cJSON_Delete(value);
    cJSON_Delete(*patch);
    *patch = NULL;
    return ll_error(LL_NO_MEMORY, "out of memory: set");
}

laglab_code laglab_set(laglab_run *run, const char *set)
{
    begin(run);
    if (!run->session)
        return answer(run, closed_error);
    cJSON *patch;
    ll_status status = patch_of(set, &patch);
    LL_THEN(status, ll_session_patch(run->session, 0, patch));
    cJSON_Delete(patch);
    forget_report(run);
    return answer(run, status);
}

laglab_code laglab_input(laglab_run *run, int player, double axis_0, double axis_1, uint32_t buttons)
{
    begin(run);
    if (!run->session)
        return answer(run, closed_error);
    if (!(fabs(axis_0) <= 1 && fabs(axis_1) <= 1))
        return answer(
            run, ll_field_error(LL_BAD_INPUT, "axes", "axes: must be -1 to 1; got %g, %g", axis_0, axis_1));
    if (buttons > LL_BUTTONS)
        return answer(run, ll_field_error(LL_BAD_INPUT, "buttons", "buttons: must be 0 to %d; got %u",
                                          LL_BUTTONS, (unsigned)buttons));
    const ll_action action = {.axis = {(float)axis_0, (float)axis_1}, .buttons = buttons};
    forget_report(run);
    return answer(run, ll_session_input(run->session, 0, player, &action));
}

/* ---- reading ---- */

uint64_t laglab_hash(laglab_run *run)
{
    begin(run);
    uint64_t hash = run->session ? ll_session_hash(run->session) : 0;
    end(run);
    return hash;
}

static ll_status find_number(laglab_run *run, const char *path, double *value)
{
    const cJSON *metrics = metrics_of(run);
    if (!metrics)
        return ll_error(LL_NO_MEMORY, "out of memory: metrics");
    LL_TRY(ll_metric_check(metrics, "path", path));
    *value = ll_metric_value(metrics, path);
    return ll_ok();
}

laglab_code laglab_metric(laglab_run *run, const char *path, double *value)
{
    *value = NAN;
    begin(run);
    return answer(run, run->session ? find_number(run, path, value) : closed_error);
}

static ll_status find_text(laglab_run *run, const char *path, const char **text)
{
    const cJSON *metrics = metrics_of(run), *found = metrics ? ll_metric_at(metrics, path) : NULL;
    if (!metrics)
        return ll_error(LL_NO_MEMORY, "out of memory: metrics");
    if (!cJSON_IsString(found) && !cJSON_IsNull(found))
        return ll_field_error(LL_BAD_INPUT, "path", "path: the scenario has no metric %.100s that is a text",
                              path);
    *text = cJSON_IsString(found) ? found->valuestring : NULL;
    return ll_ok();
}

laglab_code laglab_metric_text(laglab_run *run, const char *path, const char **text)
{
    *text = NULL;
    begin(run);
    return answer(run, run->session ? find_text(run, path, text) : closed_error);
}

static const ll_paths *paths_of(laglab_run *run)
{
    begin(run);
    if (run->session && run->paths.count == 0)
        ll_paths_list(metrics_of(run), &run->paths);
    end(run);
    return &run->paths;
}

size_t laglab_metric_count(laglab_run *run)
{
    return paths_of(run)->count;
}

const char *laglab_metric_path(laglab_run *run, size_t index)
{
    const ll_paths *paths = paths_of(run);
    return index < paths->count ? paths->items[index] : NULL;
}

char *laglab_json(laglab_run *run, laglab_document which)
{
    begin(run);
    cJSON *document = !run->session              ? NULL
                      : which == LAGLAB_SCENARIO ? ll_session_params(run->session)
                      : which == LAGLAB_METRICS  ? ll_session_metrics(run->session)
                      : which == LAGLAB_STATE    ? ll_session_state(run->session)
                                                 : NULL;
    char *text = document ? cJSON_PrintUnformatted(document) : NULL;
    cJSON_Delete(document);
    end(run);
    return text;
}

void laglab_free(char *text)
{
    cJSON_free(text);
}
