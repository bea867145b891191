/* Advice: the cheapest setting that stays within an error. A search for it is a job, which requests start,
 * poll and end. */
#include <stdlib.h>

#include <cjson/cJSON.h>

#include "daemon/api/api.h"
#include "daemon/support/tasks.h"
#include "experiment/advise/advise.h"

#define PATH "/api/v1/advise/"

enum { RUNS_MOST = 2000 }; /* runs in one answer */

static ll_status read_advise_request(const ll_api *api, const cJSON *body, const ll_interrupt *interrupt,
                                     ll_advise_request *request, ll_experiment **experiment)
{
    static const char *const names[] = {"experiment", "max_error", "runs", NULL};
    const cJSON *max_error = cJSON_GetObjectItemCaseSensitive(body, "max_error");
    const cJSON *runs = cJSON_GetObjectItemCaseSensitive(body, "runs");
    ll_status status = ll_api_only(body, names);
    if (!ll_failed(&status) && !cJSON_IsNumber(max_error))
        status = ll_field_error(LL_BAD_INPUT, "max_error", "max_error: must be a number above 0.");
    if (!ll_failed(&status) && runs &&
        !(cJSON_IsNumber(runs) && runs->valuedouble >= 1 && runs->valuedouble <= RUNS_MOST))
        status = ll_field_error(LL_BAD_INPUT, "runs", "runs: must be a number from 1 to %d.", RUNS_MOST);
    LL_THEN(status, ll_experiment_parse(cJSON_GetObjectItemCaseSensitive(body, "experiment"), api->scenarios,
                                        interrupt, experiment));
    if (ll_failed(&status))
        return status;
    *request = (ll_advise_request){.experiment = *experiment,
                                   .max_error = max_error->valuedouble,
                                   .most_runs = runs ? (int64_t)runs->valuedouble : 0};
    request->most_runs = ll_advise_runs(request) < RUNS_MOST ? ll_advise_runs(request) : RUNS_MOST;
    return status;
}

/* Owns what the job's specification refers to. */
typedef struct advice_search {
    ll_advise_request request;
    ll_experiment *experiment;
} advice_search;

static void free_search(void *context)
{
    advice_search *q = context;
    ll_experiment_free(q->experiment);
    free(q);
}

static ll_status answer(void *context, const ll_interrupt *interrupt, _Atomic int64_t *done, cJSON **json)
{
    advice_search *q = context;
    q->request.interrupt = interrupt;
    q->request.runs = done;
    ll_status status = ll_advise(&q->request, json);
    if (status.code == LL_INTERRUPTED)
        return ll_error(LL_INTERRUPTED, "interrupted after %lld runs", (long long)atomic_load(done));
    return status;
}

void ll_post_advise(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response) || !ll_api_may_create(api, request, response) ||
        !ll_api_rate(api, request, response, ll_api_class_key(api, request), NULL))
        return;
    cJSON *body = ll_api_body(request, response);
    advice_search *q = body ? calloc(1, sizeof *q) : NULL;
    if (!q) {
        response->failed = body != NULL;
        cJSON_Delete(body);
        return;
    }
    ll_interrupt interrupt = ll_task_interrupt(request->task);
    ll_status status = read_advise_request(api, body, &interrupt, &q->request, &q->experiment);
    LL_THEN(status, ll_advise_check(&q->request));
    if (ll_failed(&status)) {
        free_search(q);
        ll_api_problem(response, request, &status);
    } else {
        ll_job_spec spec = {.run = answer,
                            .free = free_search,
                            .context = q,
                            .most = ll_advise_runs(&q->request),
                            .client = request->peer};
        char id[LL_ID_LENGTH + 1], key[LL_KEY_LENGTH + 1];
        status = ll_jobs_add(api->jobs, &spec, id, key);
        if (ll_api_good(response, request, &status))
            ll_api_begun(response, PATH, id, key);
    }
    cJSON_Delete(body);
}

void ll_get_advice(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response))
        return;
    cJSON *json = cJSON_CreateObject();
    ll_status status = ll_jobs_describe(api->jobs, request->parameter[0], json);
    ll_api_result(response, request, &status, json);
}

void ll_delete_advice(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    if (!ll_api_started(api, request, response))
        return;
    const char *key = ll_api_key(request, response, "the advice's owner_key");
    if (!key)
        return;
    ll_status status =
        ll_jobs_remove(api->jobs, request->parameter[0], ll_api_is_operator(api, key) ? NULL : key);
    if (ll_api_good(response, request, &status))
        response->status = 204;
}
