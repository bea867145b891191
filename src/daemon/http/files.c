/* Constant documents by their paths: the files of the page. */
#include <stdio.h>
#include <string.h>

#include "daemon/http/internal.h"
#include "daemon/support/keys.h"

void ll_http_take_digest(http_exchange *exchange)
{
    const ll_documents *documents = exchange->http->app.documents;
    char *path = exchange->path;
    size_t prefix = 1 + LL_DOCUMENT_DIGEST;
    if (strspn(path + 1, "0123456789abcdef") != LL_DOCUMENT_DIGEST || path[prefix] != '/')
        return;
    bool ours = documents != NULL && strncmp(path + 1, documents->digest, LL_DOCUMENT_DIGEST) == 0;
    exchange->named = ours ? HTTP_OUR_DIGEST : HTTP_OTHER_DIGEST;
    memmove(path, path + prefix, strlen(path + prefix) + 1);
}

/* `/K7QF`, as it stands on the board of a class: to the page, which joins it. Whether there is such a class
 * is not looked up here, where nothing would limit guessing. */
static bool answer_code(http_exchange *exchange)
{
    char code[LL_CODE_LENGTH + 1], to[32];
    if (exchange->named != HTTP_ITS_ADDRESS || !ll_code_read(exchange->path + 1, code))
        return false;
    snprintf(to, sizeof to, "/#class=%s", code);
    exchange->response.status = 302;
    ll_http_set_header(&exchange->response, "Location", to);
    ll_http_set_header(&exchange->response, "Cache-Control", "no-cache");
    return true;
}

void ll_http_file(http_exchange *exchange)
{
    const ll_documents *documents = exchange->http->app.documents;
    const char *path = exchange->path;
    char name[512];
    int length = snprintf(name, sizeof name, "%s%s", path,
                          *path != '\0' && path[strlen(path) - 1] == '/' ? "index.html" : "");
    ll_document *document =
        documents != NULL && length < (int)sizeof name ? ll_documents_find(documents, name) : NULL;
    /* A page has only the address that people know. */
    if (document != NULL && !(ll_document_is_page(document) && exchange->named != HTTP_ITS_ADDRESS))
        exchange->response.document = document;
    else if (!answer_code(exchange))
        ll_http_refuse(exchange, 404, LL_NOT_FOUND, "", "path not found");
}
