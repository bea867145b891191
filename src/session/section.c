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

ll_section *ll_section_new(ll_rows *rows, uint32_t seq)
{
    ll_section *section = calloc(1, sizeof *section);
    if (section == NULL) {
        ll_rows_free(rows);
        return NULL;
    }
    atomic_init(&section->references, 1);
    section->rows = rows;
    section->seq = seq;
    return section;
}

void ll_section_retain(ll_section *section)
{
    atomic_fetch_add_explicit(&section->references, 1, memory_order_relaxed);
}

void ll_section_release(ll_section *section)
{
    if (section == NULL || atomic_fetch_sub_explicit(&section->references, 1, memory_order_acq_rel) != 1)
        return;
    for (ll_encoding *e = section->encodings, *next; e != NULL; e = next) {
        next = e->next;
        free(e->bytes.bytes);
        free(e);
    }
    ll_rows_free(section->rows);
    free(section);
}

/* Deflates `from` (raw); false when the result is not smaller. */
static bool deflate_into(const ll_buffer *from, ll_buffer *to)
{
    z_stream z = {.next_in = (Bytef *)from->bytes, .avail_in = (uInt)from->size};
    if (deflateInit2(&z, DEFLATE_LEVEL, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
        return false;
    char *out = ll_buffer_grow(to, from->size);
    z.next_out = (Bytef *)out;
    z.avail_out = out != NULL ? (uInt)from->size : 0;
    bool done = out != NULL && deflate(&z, Z_FINISH) == Z_STREAM_END;
    to->size -= out != NULL ? z.avail_out : 0;
    deflateEnd(&z);
    return done;
}

/* Only planes and large whole sections shrink enough. */
static bool worth_deflating(const ll_section *section, bool whole, size_t size)
{
    return size >= DEFLATE_FROM && (whole || section->rows->record->form == LL_FORM_GRID);
}

static void put_binary(const ll_section *section, const ll_section *base, ll_buffer *out)
{
    ll_buffer body = {0}, packed = {0};
    ll_rows_encode(section->rows, base != NULL ? base->rows : NULL, &body);
    bool deflated = worth_deflating(section, base == NULL, body.size) && deflate_into(&body, &packed);
    const ll_buffer *sent = deflated ? &packed : &body;
    ll_buffer_varint(out, (uint64_t)section->rows->record->id);
    ll_buffer_varint(out, 4 * (uint64_t)sent->size + (base == NULL ? 2 : 0) + (deflated ? 1 : 0));
    ll_buffer_add(out, sent->bytes, sent->size);
    out->failed = out->failed || sent->failed;
    free(body.bytes);
    free(packed.bytes);
}

static void put_json(const ll_section *section, const ll_section *base, ll_buffer *out)
{
    ll_buffer_text(out, ",\"");
    ll_buffer_text(out, section->rows->record->name);
    ll_buffer_text(out, "\":");
    ll_rows_json(section->rows, base != NULL ? base->rows->first + base->rows->count : 0, out);
}

const ll_buffer *ll_section_encode(ll_section *section, const ll_section *base, ll_frame_format format)
{
    ll_encoding *e = section->encodings;
    if (format == LL_FRAME_JSON && section->rows->record->form != LL_FORM_LOG)
        base = NULL;
    while (e != NULL &&
           !(e->format == format && e->whole == (base == NULL) && (base == NULL || e->base == base->seq)))
        e = e->next;
    if (e != NULL)
        return &e->bytes;
    e = calloc(1, sizeof *e);
    if (e == NULL)
        return NULL;
    *e = (ll_encoding){.next = section->encodings,
                       .format = format,
                       .whole = base == NULL,
                       .base = base != NULL ? base->seq : 0};
    section->encodings = e;
    (format == LL_FRAME_JSON ? put_json : put_binary)(section, base, &e->bytes);
    return &e->bytes;
}
