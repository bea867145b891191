/* Requests that start, poll and end a job (jobs.h). */
#pragma once

#include "daemon/api/api.h"
#include "daemon/jobs/jobs.h"

/* LL_LIMIT: the address has created too much; counts one more. */
ll_status ll_api_job_allowed(ll_api *api, const ll_http_request *request);

/* Starts it, and answers 202 with `id`, `owner_key` and `links`, or the error. `path` ends with a slash. */
void ll_api_job_start(ll_api *api, const ll_http_request *request, ll_http_response *response,
                      ll_job_spec *spec, const char *path);

void ll_api_job_get(ll_api *api, const ll_http_request *request, ll_http_response *response,
                    ll_job_kind kind);
/* `whose`: names the key that it needs. */
void ll_api_job_delete(ll_api *api, const ll_http_request *request, ll_http_response *response,
                       ll_job_kind kind, const char *whose);
