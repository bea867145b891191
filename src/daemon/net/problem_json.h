/* Problem documents as JSON. */
#pragma once

#include "base/status.h"

struct cJSON;

int ll_http_problem_status(ll_code code); /* LL_BAD_INPUT -> 400 and so on */
const char *ll_http_reason(int status);   /* `Not Found` */

/* {"type","title","status","detail","instance","errors"} as JSON. Caller deletes. NULL without memory.
 * `instance` may be NULL. Also the content of a stream's {"type":"error","problem":{...}}. */
struct cJSON *ll_http_problem_json(int status, const ll_status *error, const char *instance);
