#include "experiment/archive/rows.h"

#include <math.h>
#include <string.h>

enum { HEAD = 32 }; /* bytes before the metrics */

uint64_t ll_archive_bits(double value)
{
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return isnan(value) ? UINT64_C(0x7ff8000000000000) : bits;
}

static void put(unsigned char *at, uint64_t value, int bytes)
{
    for (int i = 0; i < bytes; i++)
        at[i] = (unsigned char)(value >> (8 * i));
}

static uint64_t get(const unsigned char *at, int bytes)
{
    uint64_t value = 0;
    for (int i = bytes - 1; i >= 0; i--)
        value = value << 8 | at[i];
    return value;
}

static double get_real(const unsigned char *at)
{
    double value;
    uint64_t bits = get(at, 8);
    memcpy(&value, &bits, sizeof value);
    return value;
}

void ll_archive_put_row(FILE *file, const ll_row *row, int metrics)
{
    unsigned char bytes[HEAD + 8 * LL_EXPERIMENT_METRICS_MAX];
    size_t length = strlen(row->error);
    put(bytes, (uint64_t)row->run, 8);
    put(bytes + 8, (uint64_t)row->status, 4);
    put(bytes + 12, length, 4);
    put(bytes + 16, row->hash, 8);
    put(bytes + 24, ll_archive_bits(row->t_s), 8);
    for (int i = 0; i < metrics; i++)
        put(bytes + HEAD + 8 * i, ll_archive_bits(row->metrics[i]), 8);
    fwrite(bytes, 1, (size_t)(HEAD + 8 * metrics), file);
    fwrite(row->error, 1, length, file);
}

ll_status ll_archive_get_row(FILE *file, int metrics, int64_t *left, ll_row *row)
{
    unsigned char bytes[HEAD + 8 * LL_EXPERIMENT_METRICS_MAX];
    size_t size = (size_t)(HEAD + 8 * metrics);
    ll_row_clear(row);
    if (*left < (int64_t)size || fread(bytes, 1, size, file) != size)
        return ll_error(LL_BAD_INPUT, "rows.bin: must have all rows; it is cut off");
    uint64_t status = get(bytes + 8, 4), length = get(bytes + 12, 4);
    *left -= (int64_t)size;
    if (status > LL_ROW_SKIPPED || length >= sizeof row->error || (int64_t)length > *left)
        return ll_error(LL_BAD_INPUT,
                        "rows.bin: a row's status and the length of its error must be possible");
    row->run = (int64_t)get(bytes, 8);
    row->status = (ll_row_status)status;
    row->hash = get(bytes + 16, 8);
    row->t_s = get_real(bytes + 24);
    for (int i = 0; i < metrics; i++)
        row->metrics[i] = get_real(bytes + HEAD + 8 * i);
    *left -= (int64_t)length;
    if (fread(row->error, 1, length, file) != length || memchr(row->error, '\0', length))
        return ll_error(LL_BAD_INPUT, "rows.bin: a row's error must be a text");
    return ll_ok();
}
