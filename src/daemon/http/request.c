#include <string.h>

#include "daemon/http/internal.h"

const char *ll_http_query(const ll_http_request *request, const char *name)
{
    const http_exchange *exchange = request->impl;
    const char *value = NULL;
    size_t size;
    if (MHD_lookup_connection_value_n(exchange->connection, MHD_GET_ARGUMENT_KIND, name, strlen(name), &value,
                                      &size) == MHD_NO) {
        return NULL;
    }
    return value != NULL ? value : "";
}

const char *ll_http_header(const ll_http_request *request, const char *name)
{
    const http_exchange *exchange = request->impl;
    return MHD_lookup_connection_value(exchange->connection, MHD_HEADER_KIND, name);
}
