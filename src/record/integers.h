/* Integers of a record's rows.
 *
 * LL_INTEGERS defines a record's own conversion, in which the compiler knows the table: no switch over types
 * and codings is left. Records of most frames have one; others go through ll_field_integer. */
#pragma once

#include <math.h>
#include <string.h>

#include "base/assert.h"
#include "record/record.h"

static inline int64_t ll_integer_within(int64_t integer)
{
    return integer > LL_INTEGER_MAX ? LL_INTEGER_MAX : integer < -LL_INTEGER_MAX ? -LL_INTEGER_MAX : integer;
}

static inline int64_t ll_whole_of(const ll_record_field *f, const char *at)
{
    switch (f->type) {
    case LL_TYPE_BOOL:
        return *(const bool *)at;
    case LL_TYPE_U8:
        return *(const uint8_t *)at;
    case LL_TYPE_U16:
        return *(const uint16_t *)(const void *)at;
    case LL_TYPE_U32:
        return *(const uint32_t *)(const void *)at;
    case LL_TYPE_I32:
        return *(const int32_t *)(const void *)at;
    default:
        LL_ASSERT(f->type == LL_TYPE_I64);
        return ll_integer_within(*(const int64_t *)(const void *)at);
    }
}

static inline double ll_real_of(const ll_record_field *f, const char *at)
{
    LL_ASSERT(f->type == LL_TYPE_F32 || f->type == LL_TYPE_F64);
    return f->type == LL_TYPE_F32 ? (double)*(const float *)(const void *)at
                                  : *(const double *)(const void *)at;
}

static inline double ll_power_of_2(int exponent)
{
    uint64_t bits = (uint64_t)(1023 + exponent) << 52;
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Most fields of a frame are steps: without a branch on the sign, which no processor can predict. */
static inline int64_t ll_step_of(double value, int bits)
{
    double scaled = value * ll_power_of_2(bits);
    if (fabs(scaled) < (double)LL_INTEGER_MAX)
        return (int64_t)(scaled + copysign(0.5, scaled));
    if (value != value)
        return LL_INTEGER_NONE;
    return value < 0 ? -LL_INTEGER_MAX : LL_INTEGER_MAX;
}

/* The bits of a positive double ascend with its value, exponent before mantissa: rounding to the highest bits
 * rounds to equal relative steps. */
static inline int64_t ll_real_step_of(double value, int bits)
{
    uint64_t pattern;
    if (value != value)
        return LL_INTEGER_NONE;
    if (value - value != 0)
        return value < 0 ? -LL_INTEGER_MAX : LL_INTEGER_MAX;
    memcpy(&pattern, &value, sizeof pattern);
    pattern &= INT64_MAX; /* clears the sign */
    int drop = 52 - bits;
    int64_t integer = (int64_t)((pattern + (UINT64_C(1) << (drop - 1))) >> drop);
    return value < 0 ? -integer : integer;
}

static inline __attribute__((always_inline)) int64_t ll_integer_of(const ll_record_field *f, const void *row)
{
    const char *at = (const char *)row + f->offset;
    if (f->coding == LL_CODE_INT)
        return ll_whole_of(f, at);
    double value = ll_real_of(f, at);
    return f->coding == LL_CODE_STEP ? ll_step_of(value, f->bits) : ll_real_step_of(value, f->bits);
}

/* Unrolled over the fields of a constant table. */
#define LL_INTEGERS(name, S, table)                                                                          \
    static void name(const void *structs, int count, int64_t *to)                                            \
    {                                                                                                        \
        enum { FIELDS = sizeof(table) / sizeof(table)[0] };                                                  \
        _Static_assert(FIELDS <= LL_FIELDS_MAX, "as often as the loop below is unrolled");                   \
        for (const S *row = structs; row < (const S *)structs + count; row++, to += FIELDS) {                \
            _Pragma("GCC unroll 49") for (int k = 0; k < FIELDS; k++) to[k] =                                \
                ll_integer_of(&(table)[k], row);                                                             \
        }                                                                                                    \
    }
