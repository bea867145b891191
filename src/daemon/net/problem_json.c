#include "daemon/net/problem_json.h"

#include <cjson/cJSON.h>
#include <stdio.h>
#include <string.h>

int ll_http_problem_status(ll_code code)
{
    switch (code) {
    case LL_OK:
        return 200;
    case LL_BAD_INPUT:
        return 400;
    case LL_NOT_FOUND:
        return 404;
    case LL_FORBIDDEN:
        return 403;
    case LL_CONFLICT:
        return 409;
    case LL_LIMIT:
        return 429;
    case LL_IO:
        return 503;
    case LL_NO_MEMORY:
        return 503;
    case LL_UNAVAILABLE:
    case LL_INTERRUPTED:
        return 503;
    case LL_DIVERGED:
        return 409; /* the state of the session no longer allows it */
    }
    return 500;
}

const char *ll_http_reason(int status)
{
    static const struct {
        int status;
        const char *reason;
    } known[] = {{101, "Switching Protocols"},
                 {200, "OK"},
                 {201, "Created"},
                 {202, "Accepted"},
                 {204, "No Content"},
                 {304, "Not Modified"},
                 {400, "Bad Request"},
                 {401, "Unauthorized"},
                 {403, "Forbidden"},
                 {404, "Not Found"},
                 {405, "Method Not Allowed"},
                 {406, "Not Acceptable"},
                 {408, "Request Timeout"},
                 {409, "Conflict"},
                 {410, "Gone"},
                 {412, "Precondition Failed"},
                 {413, "Content Too Large"},
                 {415, "Unsupported Media Type"},
                 {416, "Range Not Satisfiable"},
                 {421, "Misdirected Request"},
                 {426, "Upgrade Required"},
                 {428, "Precondition Required"},
                 {429, "Too Many Requests"},
                 {431, "Request Header Fields Too Large"},
                 {500, "Internal Server Error"},
                 {501, "Not Implemented"},
                 {503, "Service Unavailable"},
                 {505, "HTTP Version Not Supported"},
                 {507, "Insufficient Storage"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (known[i].status == status)
            return known[i].reason;
    return "Error";
}

cJSON *ll_http_problem_json(int status, const ll_status *error, const char *instance)
{
    cJSON *problem = cJSON_CreateObject();
    bool whole = cJSON_AddStringToObject(problem, "type", "about:blank") != NULL &&
                 cJSON_AddStringToObject(problem, "title", ll_http_reason(status)) != NULL &&
                 cJSON_AddNumberToObject(problem, "status", status) != NULL &&
                 cJSON_AddStringToObject(problem, "detail", error->text) != NULL;
    if (instance != NULL)
        whole = cJSON_AddStringToObject(problem, "instance", instance) != NULL && whole;
    if (error->field[0] != '\0') {
        cJSON *errors = cJSON_AddArrayToObject(problem, "errors"), *entry = cJSON_CreateObject();
        whole = cJSON_AddItemToArray(errors, entry) && whole;
        whole = cJSON_AddStringToObject(entry, "field", error->field) != NULL &&
                cJSON_AddStringToObject(entry, "detail", error->text) != NULL && whole;
    }
    if (!whole) {
        cJSON_Delete(problem);
        return NULL;
    }
    return problem;
}
