#include "experiment/report/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

enum { LEVEL = 6 };

static bool make_room(ll_pack *p, size_t more)
{
    if (p->size + more <= p->room)
        return true;
    size_t room = 2 * p->room > p->size + more ? 2 * p->room : p->size + more;
    uint8_t *bytes = realloc(p->bytes, room);
    p->short_of_memory |= bytes == NULL;
    if (!bytes)
        return false;
    p->bytes = bytes;
    p->room = room;
    return true;
}

/* The leading bytes of a double, rounded to nearest; all NaN are one. */
static uint64_t leading(double value, int planes)
{
    uint64_t bits;
    int rest = 64 - 8 * planes;
    if (isnan(value))
        return 0x7ff8000000000000u >> rest;
    memcpy(&bits, &value, sizeof bits);
    if (rest > 0 && isfinite(value)) {
        uint64_t up = bits + (UINT64_C(1) << (rest - 1));
        bits = (up >> 52 & 0x7ff) == 0x7ff ? bits : up;
    }
    return bits >> rest;
}

/* Each value is combined with the one before, so that what repeats becomes 0. */
void ll_pack_add(ll_pack *p, int planes, int64_t count, ll_pack_value *at, const void *context)
{
    size_t n = (size_t)count;
    uint64_t before = 0;
    if (p->short_of_memory || !make_room(p, n * (size_t)planes))
        return;
    uint8_t *to = p->bytes + p->size;
    for (size_t k = 0; k < n; k++) {
        uint64_t now = leading(at(context, (int64_t)k), planes), code = now ^ before;
        before = now;
        for (int b = 0; b < planes; b++)
            to[(size_t)b * n + k] = (uint8_t)(code >> 8 * (planes - 1 - b));
    }
    p->size += n * (size_t)planes;
}

ll_status ll_pack_deflate(ll_pack *p)
{
    uLongf size = compressBound((uLong)p->size);
    p->deflated = p->short_of_memory ? NULL : malloc(size);
    if (!p->deflated ||
        compress2(p->deflated, &size, p->bytes ? p->bytes : (const Bytef *)"", (uLong)p->size, LEVEL) != Z_OK)
        return ll_error(LL_NO_MEMORY, "out of memory: columns of the report");
    p->deflated_size = size;
    return ll_ok();
}

size_t ll_pack_text_size(const ll_pack *p)
{
    return (p->deflated_size + 2) / 3 * 4;
}

void ll_pack_write(const ll_pack *p, FILE *file)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < p->deflated_size; i += 3) {
        size_t left = p->deflated_size - i;
        uint32_t three = (uint32_t)p->deflated[i] << 16 | (left > 1 ? (uint32_t)p->deflated[i + 1] << 8 : 0) |
                         (left > 2 ? p->deflated[i + 2] : 0);
        char four[] = {digits[three >> 18], digits[three >> 12 & 63],
                       left > 1 ? digits[three >> 6 & 63] : '=', left > 2 ? digits[three & 63] : '='};
        fwrite(four, 1, sizeof four, file);
    }
}

void ll_pack_free(ll_pack *p)
{
    free(p->bytes);
    free(p->deflated);
    *p = (ll_pack){0};
}
