/* What the handlers of classes share: the class of a request, locked, and what answers contain. */
#pragma once

#include "daemon/api/api.h"
#include "daemon/class/classes.h"

/* The class of the path's first parameter, a code or an id; NULL: the error was answered. */
ll_class_entry *ll_api_class(ll_api *api, const ll_http_request *request, ll_http_response *response);
/* NULL: the class has ended, and a 404 was answered. */
ll_class *ll_api_lock_class(ll_class_entry *entry, const ll_http_request *request,
                            ll_http_response *response);
void ll_api_refuse(const ll_http_request *request, ll_http_response *response,
                   const char *sentence); /* 403 */
/* A body that may be left out; NULL: a 400 was answered. The caller deletes it. */
struct cJSON *ll_api_optional_body(const ll_http_request *request, ll_http_response *response);
void ll_api_class_links(const ll_class_entry *entry, struct cJSON *json); /* adds `links` */
