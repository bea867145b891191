/* POST /advise: which setting is the cheapest that stays within an error. */
#include <cjson/cJSON.h>

#include "daemon/api.h"
#include "daemon/problem.h"
#include "experiment/advise.h"

enum { RUNS_MOST = 2000 }; /* of one answer, which is waited for */

static ll_status read_order(const ll_api *api, const cJSON *body, ll_advice_order *order,
                            ll_experiment **experiment)
{
    static const char *const names[] = {"experiment", "max_error", "runs", NULL};
    const cJSON *max_error = cJSON_GetObjectItemCaseSensitive(body, "max_error");
    const cJSON *runs = cJSON_GetObjectItemCaseSensitive(body, "runs");
    ll_status status = ll_api_only(body, names);
    if (!ll_failed(&status) && !cJSON_IsNumber(max_error))
        status = ll_field_error(LL_BAD_INPUT, "max_error", "max_error must be a number above 0.");
    if (!ll_failed(&status) && runs &&
        !(cJSON_IsNumber(runs) && runs->valuedouble >= 1 && runs->valuedouble <= RUNS_MOST))
        status = ll_field_error(LL_BAD_INPUT, "runs", "runs must be a number from 1 to %d.", RUNS_MOST);
    if (!ll_failed(&status))
        status = ll_experiment_parse(cJSON_GetObjectItemCaseSensitive(body, "experiment"), api->scenarios,
                                     experiment);
    if (ll_failed(&status))
        return status;
    int64_t fifth = (*experiment)->runs / 5;
    *order = (ll_advice_order){.experiment = *experiment,
                               .max_error = max_error->valuedouble,
                               .most_runs = runs                ? (int64_t)runs->valuedouble
                                            : fifth > RUNS_MOST ? RUNS_MOST
                                                                : 0};
    return status;
}

void ll_post_advise(void *context, const ll_http_request *request, ll_http_response *response)
{
    ll_api *api = context;
    ll_advice_order order;
    ll_experiment *experiment = NULL;
    cJSON *answer = NULL;
    if (!ll_api_started(api, request, response))
        return;
    cJSON *body = ll_api_body(request, response);
    if (!body)
        return;
    ll_status status = read_order(api, body, &order, &experiment);
    if (!ll_failed(&status) && !ll_host_allows_creation(api->host, request->peer))
        status = ll_error(LL_LIMIT, "Too many sessions and experiments were made from this address.");
    if (!ll_failed(&status))
        status = ll_advise(&order, &answer);
    if (ll_failed(&status))
        ll_api_problem(response, request, &status);
    else
        ll_http_json(response, 200, answer);
    cJSON_Delete(answer);
    ll_experiment_free(experiment);
    cJSON_Delete(body);
}
