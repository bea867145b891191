/* Errors as RFC 9457 problem documents, the only form in which the daemon reports errors. */
#pragma once

#include <stddef.h>

#include "base/status.h"
#include "daemon/http/http.h"
#include "daemon/net/problem_json.h"

/* Turns the response into a problem document. The HTTP status follows from the code; `errors` names the
 * field. */
void ll_http_problem(ll_http_response *response, const ll_http_request *request, const ll_status *error);

/* The same with an explicit HTTP status; `error` has field and message. */
void ll_http_problem_as(ll_http_response *response, const ll_http_request *request, int status,
                        const ll_status *error);

/* 429 and 503 with Retry-After. */
void ll_http_problem_later(ll_http_response *response, const ll_http_request *request, int status,
                           int retry_after_s, const ll_status *error);
