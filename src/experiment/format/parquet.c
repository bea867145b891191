/* Apache Parquet: PLAIN values, uncompressed, version 1 data pages, one per column and row group. No Debian
 * library writes it. Footer and page headers are Thrift structs in the compact protocol; field numbers and
 * enums are those of parquet.thrift. */
#include <stdlib.h>
#include <string.h>

#include "base/version.h"
#include "experiment/format/formats.h"
#include "record/buffer.h"

enum { GROUP_ROWS = 50000 };

/* ---- bytes ---- */

static void put_byte(ll_buffer *b, unsigned value)
{
    ll_buffer_add(b, &(unsigned char){(unsigned char)value}, 1);
}

/* Little endian, like the machines supported. */
static void put_u32(ll_buffer *b, uint32_t value)
{
    ll_buffer_add(b, &value, sizeof value);
}

/* ---- Thrift's compact protocol ---- */

enum { TYPE_I32 = 5, TYPE_I64 = 6, TYPE_BINARY = 8, TYPE_LIST = 9, TYPE_STRUCT = 12 };

static void put_zigzag(ll_buffer *b, int64_t value)
{
    ll_buffer_varint(b, ll_zigzag(value));
}

/* `last`: number of the previous field in the same struct. */
static void put_field(ll_buffer *b, int *last, int number, int type)
{
    put_byte(b, (unsigned)(number - *last) << 4 | (unsigned)type);
    *last = number;
}

static void put_int(ll_buffer *b, int *last, int number, int type, int64_t value)
{
    put_field(b, last, number, type);
    put_zigzag(b, value);
}

static void put_binary(ll_buffer *b, const char *text)
{
    size_t length = strlen(text);
    ll_buffer_varint(b, length);
    ll_buffer_add(b, text, length);
}

static void put_list(ll_buffer *b, int *last, int number, int type, int count)
{
    put_field(b, last, number, TYPE_LIST);
    if (count < 15) {
        put_byte(b, (unsigned)count << 4 | (unsigned)type);
    } else {
        put_byte(b, 0xf0 | (unsigned)type);
        ll_buffer_varint(b, (uint64_t)count);
    }
}

static void put_stop(ll_buffer *b)
{
    put_byte(b, 0);
}

/* ---- columns ---- */

enum { PHYSICAL_BOOLEAN = 0, PHYSICAL_INT64 = 2, PHYSICAL_DOUBLE = 5, PHYSICAL_BYTE_ARRAY = 6 };

static const int physical[] = {[LL_CELL_INT] = PHYSICAL_INT64,
                               [LL_CELL_REAL] = PHYSICAL_DOUBLE,
                               [LL_CELL_BOOL] = PHYSICAL_BOOLEAN,
                               [LL_CELL_TEXT] = PHYSICAL_BYTE_ARRAY};

/* A column of the present row group: its values, and a bit per row: value present. */
typedef struct column {
    ll_buffer values, present;
    int64_t count; /* of present values */
} column;

typedef struct chunk {
    int64_t offset, size, rows;
} chunk;

static void put_bit(ll_buffer *b, int64_t index, bool bit)
{
    if (index % 8 == 0)
        put_byte(b, 0);
    if (bit && !b->failed)
        b->bytes[b->size - 1] = (char)(b->bytes[b->size - 1] | 1 << (index % 8));
}

static void put_cell(column *c, ll_cell_type type, const ll_cell *cell, int64_t row)
{
    put_bit(&c->present, row, !cell->null);
    if (cell->null)
        return;
    if (type == LL_CELL_BOOL) {
        put_bit(&c->values, c->count, cell->number != 0);
    } else if (type == LL_CELL_INT) {
        ll_buffer_add(&c->values, &(int64_t){(int64_t)cell->number}, sizeof(int64_t));
    } else if (type == LL_CELL_REAL) {
        ll_buffer_add(&c->values, &cell->number, sizeof cell->number);
    } else {
        put_u32(&c->values, (uint32_t)strlen(cell->text));
        ll_buffer_add(&c->values, cell->text, strlen(cell->text));
    }
    c->count++;
}

/* The definition levels as one bit-packed run of the RLE hybrid: its groups have eight levels each. */
static void put_levels(ll_buffer *page, const column *c, int64_t rows)
{
    ll_buffer run = {0};
    ll_buffer_varint(&run, (uint64_t)((rows + 7) / 8) << 1 | 1);
    put_u32(page, (uint32_t)(run.size + c->present.size));
    ll_buffer_add(page, run.bytes, run.size);
    ll_buffer_add(page, c->present.bytes, c->present.size);
    page->failed |= run.failed;
    free(run.bytes);
}

static void put_page_header(ll_buffer *header, size_t size, int64_t rows)
{
    enum { DATA_PAGE = 0, ENCODING_PLAIN = 0, ENCODING_RLE = 3 };
    int last = 0, inner = 0;
    put_int(header, &last, 1, TYPE_I32, DATA_PAGE);
    put_int(header, &last, 2, TYPE_I32, (int64_t)size); /* uncompressed */
    put_int(header, &last, 3, TYPE_I32, (int64_t)size); /* compressed */
    put_field(header, &last, 5, TYPE_STRUCT);
    put_int(header, &inner, 1, TYPE_I32, rows);
    put_int(header, &inner, 2, TYPE_I32, ENCODING_PLAIN);
    put_int(header, &inner, 3, TYPE_I32, ENCODING_RLE);
    put_int(header, &inner, 4, TYPE_I32, ENCODING_RLE);
    put_stop(header);
    put_stop(header);
}

/* ---- the file ---- */

typedef struct writer {
    const ll_table *table;
    FILE *file;
    int64_t offset, rows, total;
    column columns[LL_COLUMNS_MAX];
    chunk *chunks; /* column_count per row group */
    int groups;
    bool failed;
} writer;

static void out(writer *w, const void *data, size_t size)
{
    fwrite(data, 1, size, w->file);
    w->offset += (int64_t)size;
}

static void end_group(writer *w)
{
    int n = w->table->column_count;
    chunk *bigger = realloc(w->chunks, (size_t)(w->groups + 1) * (size_t)n * sizeof *bigger);
    if (!bigger) {
        w->failed = true;
        return;
    }
    w->chunks = bigger;
    for (int i = 0; i < n; i++) {
        column *c = &w->columns[i];
        ll_buffer header = {0}, page = {0};
        int64_t from = w->offset;
        if (w->table->columns[i].nullable)
            put_levels(&page, c, w->rows);
        ll_buffer_add(&page, c->values.bytes, c->values.size);
        put_page_header(&header, page.size, w->rows);
        out(w, header.bytes, header.size);
        out(w, page.bytes, page.size);
        w->chunks[w->groups * n + i] = (chunk){from, w->offset - from, w->rows};
        w->failed |= header.failed || page.failed || c->values.failed || c->present.failed;
        c->values.size = c->present.size = 0;
        c->count = 0;
        free(header.bytes);
        free(page.bytes);
    }
    w->groups++;
    w->total += w->rows;
    w->rows = 0;
}

static void put_schema(ll_buffer *b, const ll_table *t)
{
    enum { REQUIRED = 0, OPTIONAL = 1, CONVERTED_UTF8 = 0 };
    int root = 0;
    put_field(b, &root, 4, TYPE_BINARY);
    put_binary(b, "laglab");
    put_int(b, &root, 5, TYPE_I32, t->column_count);
    put_stop(b);
    for (int i = 0; i < t->column_count; i++) {
        const ll_column *c = &t->columns[i];
        int last = 0;
        put_int(b, &last, 1, TYPE_I32, physical[c->type]);
        put_int(b, &last, 3, TYPE_I32, c->nullable ? OPTIONAL : REQUIRED);
        put_field(b, &last, 4, TYPE_BINARY);
        put_binary(b, c->name);
        if (c->type == LL_CELL_TEXT)
            put_int(b, &last, 6, TYPE_I32, CONVERTED_UTF8);
        put_stop(b);
    }
}

static void put_chunk(ll_buffer *b, const ll_column *c, const chunk *k)
{
    int outer = 0, last = 0;
    put_int(b, &outer, 2, TYPE_I64, k->offset);
    put_field(b, &outer, 3, TYPE_STRUCT);
    put_int(b, &last, 1, TYPE_I32, physical[c->type]);
    put_list(b, &last, 2, TYPE_I32, 2);
    put_zigzag(b, 0); /* PLAIN */
    put_zigzag(b, 3); /* RLE, for the levels */
    put_list(b, &last, 3, TYPE_BINARY, 1);
    put_binary(b, c->name);
    put_int(b, &last, 4, TYPE_I32, 0); /* uncompressed */
    put_int(b, &last, 5, TYPE_I64, k->rows);
    put_int(b, &last, 6, TYPE_I64, k->size);
    put_int(b, &last, 7, TYPE_I64, k->size);
    put_int(b, &last, 9, TYPE_I64, k->offset);
    put_stop(b);
    put_stop(b);
}

static void put_group(ll_buffer *b, const ll_table *t, const chunk *chunks)
{
    int last = 0;
    int64_t size = 0;
    put_list(b, &last, 1, TYPE_STRUCT, t->column_count);
    for (int i = 0; i < t->column_count; i++) {
        put_chunk(b, &t->columns[i], &chunks[i]);
        size += chunks[i].size;
    }
    put_int(b, &last, 2, TYPE_I64, size);
    put_int(b, &last, 3, TYPE_I64, chunks[0].rows);
    put_stop(b);
}

static void put_footer(writer *w)
{
    const ll_table *t = w->table;
    ll_buffer b = {0};
    int last = 0;
    put_int(&b, &last, 1, TYPE_I32, 1);
    put_list(&b, &last, 2, TYPE_STRUCT, t->column_count + 1);
    put_schema(&b, t);
    put_int(&b, &last, 3, TYPE_I64, w->total);
    put_list(&b, &last, 4, TYPE_STRUCT, w->groups);
    for (int g = 0; g < w->groups; g++)
        put_group(&b, t, &w->chunks[g * t->column_count]);
    put_field(&b, &last, 6, TYPE_BINARY);
    char program[16 + LL_VERSION_MAX];
    snprintf(program, sizeof program, "laglab version %s", ll_version);
    put_binary(&b, program);
    put_stop(&b);
    uint32_t size = (uint32_t)b.size;
    put_u32(&b, size);
    ll_buffer_add(&b, "PAR1", 4);
    out(w, b.bytes, b.size);
    w->failed |= b.failed;
    free(b.bytes);
}

static ll_status write(const ll_table *t, FILE *file)
{
    ll_cell cells[LL_COLUMNS_MAX];
    ll_status status = ll_ok();
    writer *w = calloc(1, sizeof *w);
    if (!w)
        return ll_error(LL_NO_MEMORY, "out of memory: Parquet file");
    w->table = t;
    w->file = file;
    out(w, "PAR1", 4);
    while (!ferror(file) && !w->failed && t->next(t->context, cells, &status)) {
        for (int i = 0; i < t->column_count; i++)
            put_cell(&w->columns[i], t->columns[i].type, &cells[i], w->rows);
        if (++w->rows == GROUP_ROWS)
            end_group(w);
    }
    if (w->rows > 0)
        end_group(w);
    put_footer(w);
    if (w->failed && !ll_failed(&status))
        status = ll_error(LL_NO_MEMORY, "out of memory: Parquet file");
    for (int i = 0; i < t->column_count; i++) {
        free(w->columns[i].values.bytes);
        free(w->columns[i].present.bytes);
    }
    free(w->chunks);
    free(w);
    return ll_format_end(file, &status);
}

const ll_format ll_format_parquet = {"parquet", "application/vnd.apache.parquet",
                                     "Apache Parquet, columns of one type", write};
