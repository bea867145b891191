/* Constant documents: the page's files and what describes the API. All are made before the daemon answers and
 * never change. Each has an ETag, is compressed once, and has a second address, `/DIGEST` before its own,
 * that a client may keep forever: DIGEST is that of all documents, the same for daemons of the same build,
 * and another when any document is. Pages of HTML, which have only the address that people know, name the
 * second addresses of the files that they read. */
#pragma once

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

#define LL_DOCUMENT_DIGEST 16 /* characters of 0-9 and a-f */

typedef struct ll_document_gzip {
    size_t size;
    char *bytes;
} ll_document_gzip;

typedef struct ll_document {
    char *address; /* path, and query in the order of the alphabet */
    const char *type;
    char *bytes;
    size_t size;
    char tag[LL_DOCUMENT_DIGEST + 1];
    _Atomic(ll_document_gzip *) gzip; /* made when first wanted */
} ll_document;

typedef struct ll_documents {
    ll_document *list; /* ordered by address once they are finished */
    size_t count, capacity;
    char digest[LL_DOCUMENT_DIGEST + 1];
} ll_documents;

/* Takes `bytes` (malloc'ed). `type` must outlive the documents. */
ll_status ll_documents_add(ll_documents *documents, const char *address, const char *type, char *bytes,
                           size_t size);
/* A file, by its own type; LL_NOT_FOUND: there is none. */
ll_status ll_documents_add_file(ll_documents *documents, const char *address, const char *name);
/* All files of a folder, by their paths in it; not those whose names begin with a dot. LL_NOT_FOUND: no
 * folder. */
ll_status ll_documents_read(ll_documents *documents, const char *folder);
/* After the last one. */
ll_status ll_documents_finish(ll_documents *documents);
void ll_documents_free(ll_documents *documents);

ll_document *ll_documents_find(const ll_documents *documents, const char *address);
bool ll_document_is_page(const ll_document *document); /* HTML */
/* Whether clients that take gzip get it so, if it is smaller. */
bool ll_document_compresses(const ll_document *document);
/* NULL: it does not compress, or there is no memory. Any thread. */
const ll_document_gzip *ll_document_compressed(ll_document *document);
