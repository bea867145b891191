/* Sections of frames and their encodings. */
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "session/section.h"

/* One encoding of a section: format and base. */
struct ll_encoding {
    ll_encoding *next;
    ll_frame_format format;
    bool whole;
    uint32_t base; /* seq of the base section; whole: none */
    ll_buffer bytes;
};

/* Below this size deflating saves too little for its time. */
enum { DEFLATE_FROM = 1024, DEFLATE_LEVEL = 1 };

size_t ll_section_bytes(const ll_rows *rows)
{
    return sizeof(ll_section) + ll_rows_copy_bytes(rows);
}

ll_section *ll_section_put(void *memory, ll_frame *home, const ll_rows *rows, uint32_t seq)
{
    ll_section *section = memory;
    *section = (ll_section){.home = home, .seq = seq, .rows = (ll_rows *)(section + 1)};
    _Static_assert(sizeof *section % _Alignof(ll_rows) == 0, "the rows follow the section");
    ll_rows_copy_to(section->rows, rows);
    return section;
}

ll_section *ll_section_new(const ll_rows *rows, uint32_t seq)
{
    void *memory = malloc(ll_section_bytes(rows));
    if (memory == NULL)
        return NULL;
    ll_section *section = ll_section_put(memory, NULL, rows, seq);
    atomic_init(&section->references, 1);
    return section;
}

void ll_section_drop_encodings(ll_section *section)
{
    for (ll_encoding *e = section->encodings, *next; e != NULL; e = next) {
        next = e->next;
        free(e->bytes.bytes);
        free(e);
    }
}

/* Deflates (raw) the bytes from `begin` on; false, without a change, when they would not be fewer. */
static bool deflate_from(ll_buffer *b, size_t begin)
{
    size_t size = b->size - begin;
    z_stream z = {.avail_in = (uInt)size, .avail_out = (uInt)size};
    char *out = ll_buffer_reserve(b, size);
    if (out == NULL || deflateInit2(&z, DEFLATE_LEVEL, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return false;
    z.next_in = (Bytef *)b->bytes + begin;
    z.next_out = (Bytef *)out;
    bool done = deflate(&z, Z_FINISH) == Z_STREAM_END;
    deflateEnd(&z);
    if (done) {
        memmove(b->bytes + begin, out, size - z.avail_out);
        b->size = begin + size - z.avail_out;
    }
    return done;
}

/* Only planes and large whole sections shrink enough. */
static bool worth_deflating(const ll_rows *rows, bool whole, size_t size)
{
    return size >= DEFLATE_FROM && (whole || rows->record->form == LL_FORM_GRID);
}

void ll_section_encode(const ll_rows *rows, const ll_rows *base, ll_buffer *out)
{
    ll_buffer_varint(out, (uint64_t)rows->record->id);
    size_t begin = out->size;
    ll_rows_encode(rows, base, out);
    bool deflated = worth_deflating(rows, base == NULL, out->size - begin) && deflate_from(out, begin);
    ll_buffer_insert_varint(out, begin,
                            4 * (uint64_t)(out->size - begin) + (base == NULL ? 2 : 0) + (deflated ? 1 : 0));
}

static void put_binary(const ll_section *section, const ll_section *base, ll_buffer *out)
{
    ll_section_encode(section->rows, base != NULL ? base->rows : NULL, out);
}

static void put_json(const ll_section *section, const ll_section *base, ll_buffer *out)
{
    ll_buffer_text(out, ",\"");
    ll_buffer_text(out, section->rows->record->name);
    ll_buffer_text(out, "\":");
    ll_rows_json(section->rows, base != NULL ? base->rows->first + base->rows->count : 0, out);
}

static void put(const ll_section *section, const ll_section *base, ll_frame_format format, ll_buffer *out)
{
    (format == LL_FRAME_JSON ? put_json : put_binary)(section, base, out);
}

/* Makes the encoding when it is wanted first. NULL without memory. */
static const ll_encoding *encoding(ll_section *section, const ll_section *base, ll_frame_format format)
{
    ll_encoding *e = section->encodings;
    while (e != NULL &&
           !(e->format == format && e->whole == (base == NULL) && (base == NULL || e->base == base->seq)))
        e = e->next;
    if (e != NULL)
        return e;
    e = calloc(1, sizeof *e);
    if (e == NULL)
        return NULL;
    *e = (ll_encoding){.next = section->encodings,
                       .format = format,
                       .whole = base == NULL,
                       .base = base != NULL ? base->seq : 0};
    section->encodings = e;
    put(section, base, format, &e->bytes);
    return e;
}

void ll_section_write(ll_section *section, const ll_section *base, ll_frame_format format, bool shared,
                      ll_buffer *out)
{
    if (format == LL_FRAME_JSON && section->rows->record->form != LL_FORM_LOG)
        base = NULL;
    if (format == LL_FRAME_BINARY && section->delta != NULL && base != NULL && base->seq == section->base) {
        ll_buffer_add(out, section->delta, section->delta_size);
        return;
    }
    if (!shared) {
        put(section, base, format, out);
        return;
    }
    const ll_encoding *e = encoding(section, base, format);
    if (e != NULL)
        ll_buffer_add(out, e->bytes.bytes, e->bytes.size);
    out->failed = out->failed || e == NULL || e->bytes.failed;
}
