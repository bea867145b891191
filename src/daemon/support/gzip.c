#include "daemon/support/gzip.h"

#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <zlib.h>

#include "daemon/support/tasks.h"

enum { PIECE = 64 << 10, GZIP_WINDOW = 15 + 16, MEMORY = 8 };

bool ll_gzip_compresses(const char *type)
{
    static const char *const types[] = {"application/json",        "application/x-ndjson",
                                        "application/schema+json", "application/problem+json",
                                        "application/yaml",        "image/svg+xml"};
    size_t size = strcspn(type, "; ");
    if (strncasecmp(type, "text/", 5) == 0)
        return true;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strlen(types[i]) == size && strncasecmp(type, types[i], size) == 0)
            return true;
    return false;
}

/* Receives compressed bytes; false: no space. */
typedef struct sink {
    FILE *file; /* NULL: to `bytes` */
    char *bytes;
    size_t size, capacity;
} sink;

static bool put(sink *s, const void *bytes, size_t size)
{
    if (s->file)
        return fwrite(bytes, 1, size, s->file) == size;
    if (s->size + size > s->capacity) {
        size_t capacity = 2 * (s->size + size);
        char *grown = realloc(s->bytes, capacity);
        if (!grown)
            return false;
        s->bytes = grown;
        s->capacity = capacity;
    }
    memcpy(s->bytes + s->size, bytes, size);
    s->size += size;
    return true;
}

static bool deflate_into(z_stream *z, const void *bytes, size_t size, bool last, sink *s)
{
    unsigned char piece[PIECE];
    z->next_in = (unsigned char *)(uintptr_t)bytes;
    z->avail_in = (uInt)size;
    do {
        z->next_out = piece;
        z->avail_out = sizeof piece;
        deflate(z, last ? Z_FINISH : Z_NO_FLUSH); /* cannot fail if used correctly */
        if (!put(s, piece, sizeof piece - z->avail_out))
            return false;
    } while (z->avail_out == 0);
    return true;
}

static ll_status init_deflate(z_stream *z, int level)
{
    memset(z, 0, sizeof *z);
    return deflateInit2(z, level, Z_DEFLATED, GZIP_WINDOW, MEMORY, Z_DEFAULT_STRATEGY) == Z_OK
               ? ll_ok()
               : ll_error(LL_NO_MEMORY, "out of memory: compressing the answer");
}

static ll_status check_task(struct ll_task *task, size_t done)
{
    return !task || ll_task_yield(task)
               ? ll_ok()
               : ll_error(LL_INTERRUPTED, "interrupted after compressing %.1f MiB of the answer",
                          (double)done / 1048576.0);
}

ll_status ll_gzip_bytes(const void *bytes, size_t size, int level, struct ll_task *task, char **out,
                        size_t *out_size)
{
    z_stream z;
    sink s = {0};
    ll_status status = init_deflate(&z, level);
    if (ll_failed(&status))
        return status;
    for (size_t at = 0, step; !ll_failed(&status) && (at < size || at == 0); at += step) {
        step = size - at < PIECE ? size - at : PIECE;
        bool last = at + step == size;
        if (!deflate_into(&z, (const char *)bytes + at, step, last, &s))
            status = ll_error(LL_NO_MEMORY, "out of memory: compressing the answer");
        else
            status = check_task(task, at);
        if (last)
            break;
    }
    deflateEnd(&z);
    if (ll_failed(&status)) {
        free(s.bytes);
        return status;
    }
    *out = s.bytes;
    *out_size = s.size;
    return status;
}

ll_status ll_gzip_file(FILE *in, FILE *out, struct ll_task *task)
{
    z_stream z;
    sink s = {.file = out};
    char piece[PIECE];
    size_t done = 0, got = PIECE;
    ll_status status = init_deflate(&z, LL_GZIP_FAST);
    if (ll_failed(&status))
        return status;
    rewind(in);
    while (!ll_failed(&status) && got == PIECE) {
        got = fread(piece, 1, PIECE, in);
        done += got;
        if (ferror(in) || !deflate_into(&z, piece, got, got < PIECE, &s))
            status = ll_error(LL_IO, "No space on disk for the compressed answer.");
        else
            status = check_task(task, done);
    }
    deflateEnd(&z);
    return status;
}
