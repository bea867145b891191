#include "daemon/http/http_problem.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void ll_http_problem_as(ll_http_response *response, const ll_http_request *request, int status,
                        const ll_status *error)
{
    cJSON *problem = ll_http_problem_json(status, error, request != NULL ? request->path : NULL);
    ll_http_json(response, status, problem);
    if (!response->failed)
        snprintf(response->type, sizeof response->type, "application/problem+json");
}

void ll_http_problem(ll_http_response *response, const ll_http_request *request, const ll_status *error)
{
    int status = ll_http_problem_status(error->code);
    if (status == 429 || status == 503)
        ll_http_problem_later(response, request, status, 5, error);
    else
        ll_http_problem_as(response, request, status, error);
}

void ll_http_problem_later(ll_http_response *response, const ll_http_request *request, int status,
                           int retry_after_s, const ll_status *error)
{
    char seconds[16];
    snprintf(seconds, sizeof seconds, "%d", retry_after_s);
    ll_http_problem_as(response, request, status, error);
    ll_http_set_header(response, "Retry-After", seconds);
}
