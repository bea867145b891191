#include "daemon/http/documents.h"

#include <errno.h>
#include <fcntl.h>
#include <fts.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "base/hash.h"
#include "daemon/support/gzip.h"

#define FILE_MAX (64 << 20) /* bytes of one file, which stays in memory */

static const char *type_of(const char *name)
{
    static const struct {
        const char *suffix, *type;
    } types[] = {{".html", "text/html; charset=utf-8"},
                 {".js", "text/javascript; charset=utf-8"},
                 {".mjs", "text/javascript; charset=utf-8"},
                 {".css", "text/css; charset=utf-8"},
                 {".json", "application/json"},
                 {".map", "application/json"},
                 {".svg", "image/svg+xml"},
                 {".png", "image/png"},
                 {".jpg", "image/jpeg"},
                 {".ico", "image/x-icon"},
                 {".webp", "image/webp"},
                 {".woff2", "font/woff2"},
                 {".txt", "text/plain; charset=utf-8"},
                 {".md", "text/plain; charset=utf-8"},
                 {".csv", "text/csv; charset=utf-8"},
                 {".yaml", "application/yaml"},
                 {".wasm", "application/wasm"},
                 {".webmanifest", "application/manifest+json"}};
    const char *dot = strrchr(name, '.');
    for (size_t i = 0; dot != NULL && i < sizeof types / sizeof *types; i++)
        if (strcasecmp(dot, types[i].suffix) == 0)
            return types[i].type;
    return "application/octet-stream";
}

/* ---- collecting ---- */

ll_status ll_documents_add(ll_documents *documents, const char *address, const char *type, char *bytes,
                           size_t size)
{
    char *own = strdup(address);
    if (documents->count == documents->capacity) {
        size_t capacity = 2 * documents->capacity + 64;
        ll_document *list = realloc(documents->list, capacity * sizeof *list);
        documents->list = list != NULL ? list : documents->list;
        documents->capacity = list != NULL ? capacity : documents->capacity;
    }
    if (bytes == NULL || own == NULL || documents->count == documents->capacity) {
        free(own);
        free(bytes);
        return ll_error(LL_NO_MEMORY, "out of memory: %s", address);
    }
    documents->list[documents->count++] =
        (ll_document){.address = own, .type = type, .bytes = bytes, .size = size};
    return ll_ok();
}

static ll_status cannot_read(const char *name, int error)
{
    return ll_error(error == ENOENT ? LL_NOT_FOUND : LL_IO, "cannot read %s: %s", name, strerror(error));
}

ll_status ll_documents_add_file(ll_documents *documents, const char *address, const char *name)
{
    FILE *file = fopen(name, "rbe");
    off_t size = file != NULL && fseeko(file, 0, SEEK_END) == 0 ? ftello(file) : -1;
    ll_status status = size < 0 ? cannot_read(name, errno)
                       : size > FILE_MAX
                           ? ll_error(LL_LIMIT, "%s: must have at most %d MiB", name, FILE_MAX >> 20)
                           : ll_ok();
    char *bytes = ll_failed(&status) ? NULL : malloc((size_t)size + 1);
    if (bytes != NULL) {
        rewind(file);
        size = (off_t)fread(bytes, 1, (size_t)size, file); /* less where it is being written */
        bytes[size] = '\0';
    }
    if (file != NULL)
        fclose(file);
    LL_TRY(status);
    return ll_documents_add(documents, address, type_of(name), bytes, (size_t)size);
}

ll_status ll_documents_read(ll_documents *documents, const char *folder)
{
    ll_status status = ll_ok();
    char *const roots[] = {(char *)(uintptr_t)folder, NULL};
    FTS *walk = fts_open(roots, FTS_LOGICAL | FTS_NOCHDIR, NULL);
    if (walk == NULL)
        return cannot_read(folder, errno);
    for (FTSENT *at; !ll_failed(&status) && (at = fts_read(walk)) != NULL;)
        if (at->fts_level > 0 && at->fts_name[0] == '.')
            fts_set(walk, at, FTS_SKIP);
        else if (at->fts_info == FTS_F)
            status = ll_documents_add_file(documents, at->fts_path + strlen(folder), at->fts_path);
        else if (at->fts_info == FTS_DNR || at->fts_info == FTS_ERR || at->fts_info == FTS_NS)
            status = cannot_read(at->fts_path, at->fts_errno);
    fts_close(walk);
    return status;
}

/* ---- finishing ---- */

static int by_address(const void *a, const void *b)
{
    const ll_document *one = a, *other = b;
    return strcmp(one->address, other->address);
}

ll_document *ll_documents_find(const ll_documents *documents, const char *address)
{
    const ll_document wanted = {.address = (char *)(uintptr_t)address};
    return documents->count == 0
               ? NULL
               : bsearch(&wanted, documents->list, documents->count, sizeof wanted, by_address);
}

/* The documents that a page at `/` reads, which are the values of attributes that name one, get their second
 * addresses. */
static ll_status link_page(const ll_documents *documents, ll_document *page)
{
    char *made = NULL, path[256];
    size_t size = 0;
    FILE *out = open_memstream(&made, &size);
    if (out == NULL)
        return ll_error(LL_NO_MEMORY, "out of memory: %s", page->address);
    for (const char *at = page->bytes, *end; *at != '\0'; at = end) {
        const char *value = strstr(at, "=\"");
        end = value != NULL ? value + 2 : at + strlen(at);
        fwrite(at, 1, (size_t)(end - at), out);
        int length = snprintf(path, sizeof path, "/%.*s", (int)strcspn(end, "\""), end);
        if (value != NULL && length < (int)sizeof path && ll_documents_find(documents, path) != NULL)
            fprintf(out, "%s/", documents->digest);
    }
    if (fclose(out) != 0) {
        free(made);
        return ll_error(LL_NO_MEMORY, "out of memory: %s", page->address);
    }
    free(page->bytes);
    page->bytes = made;
    page->size = size;
    return ll_ok();
}

bool ll_document_is_page(const ll_document *document)
{
    return strncmp(document->type, "text/html", 9) == 0;
}

ll_status ll_documents_finish(ll_documents *documents)
{
    uint64_t all = 0;
    if (documents->count > 0)
        qsort(documents->list, documents->count, sizeof *documents->list, by_address);
    for (size_t i = 0; i < documents->count; i++) {
        const ll_document *document = &documents->list[i];
        all = ll_hash(all, document->address, strlen(document->address));
        all = ll_hash(all, document->bytes, document->size);
    }
    snprintf(documents->digest, sizeof documents->digest, "%016llx", (unsigned long long)all);
    for (size_t i = 0; i < documents->count; i++) {
        ll_document *document = &documents->list[i];
        if (ll_document_is_page(document) && strrchr(document->address, '/') == document->address)
            LL_TRY(link_page(documents, document));
        snprintf(document->tag, sizeof document->tag, "%016llx",
                 (unsigned long long)ll_hash(0, document->bytes, document->size));
    }
    return ll_ok();
}

void ll_documents_free(ll_documents *documents)
{
    for (size_t i = 0; i < documents->count; i++) {
        ll_document_gzip *gzip = atomic_load(&documents->list[i].gzip);
        if (gzip != NULL)
            free(gzip->bytes);
        free(gzip);
        free(documents->list[i].address);
        free(documents->list[i].bytes);
    }
    free(documents->list);
    *documents = (ll_documents){0};
}

/* ---- compression ---- */

bool ll_document_compresses(const ll_document *document)
{
    return ll_gzip_compresses(document->type);
}

static const ll_document_gzip *make_gzip(ll_document *document)
{
    ll_document_gzip *kept = NULL;
    ll_document_gzip *made = calloc(1, sizeof *made);
    ll_status status = made == NULL ? ll_error(LL_NO_MEMORY, "%s", "")
                                    : ll_gzip_bytes(document->bytes, document->size, LL_GZIP_SMALLEST, NULL,
                                                    &made->bytes, &made->size);
    if (!ll_failed(&status) && atomic_compare_exchange_strong(&document->gzip, &kept, made))
        return made;
    if (made != NULL)
        free(made->bytes); /* another thread was faster */
    free(made);
    return kept;
}

const ll_document_gzip *ll_document_compressed(ll_document *document)
{
    const ll_document_gzip *gzip = atomic_load(&document->gzip);
    if (gzip == NULL && ll_document_compresses(document))
        gzip = make_gzip(document);
    return gzip != NULL && gzip->size < document->size ? gzip : NULL;
}
