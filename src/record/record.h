/* Tables of all streamed data.
 *
 * A record describes the rows of one section of the stream: the struct that a room fills, and the name, unit,
 * coding and help of each field. Binary layout, JSON, schema, AsyncAPI, tables in docs, and the page's
 * decoder and constants are all made from it: no other code has the names of the fields.
 *
 * Rows are sent as integers. A field's coding converts a value to an integer, rounded once; differences of
 * these integers are sent, which are exact, so that errors cannot accumulate. Every integer is within +-(2^51
 * - 1), whose ends are the infinities, and -2^51 is an unknown value: the difference of any two is exact in a
 * double of JavaScript.
 *
 * New fields are added at the end of a record, so that a decoder that does not know them can still read the
 * others. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "record/channel.h"

#define LL_FIELDS_MAX 49 /* of a record: the mask of changed fields is a varint */

#define LL_INTEGER_MAX ((INT64_C(1) << 51) - 1) /* infinity; negative: minus infinity */
#define LL_INTEGER_NONE (-(INT64_C(1) << 51))   /* NaN: null in JSON */

typedef enum ll_type {
    LL_TYPE_BOOL,
    LL_TYPE_U8,
    LL_TYPE_U16,
    LL_TYPE_U32,
    LL_TYPE_I32,
    LL_TYPE_I64,
    LL_TYPE_F32,
    LL_TYPE_F64
} ll_type;

typedef enum ll_coding {
    LL_CODE_INT,  /* whole number: unchanged */
    LL_CODE_STEP, /* real number: round(value * 2^bits) */
    LL_CODE_REAL, /* real number with `bits` (at most 39) of its mantissa: equal relative steps; 23 are exact
                     for a float */
} ll_coding;

typedef struct ll_record_field {
    const char *name;
    const char *unit; /* `m`, `ms`; NULL: none */
    const char *help; /* meaning; for real numbers that may be unknown also when they are null */
    size_t offset;
    ll_type type;
    ll_coding coding;
    int bits;
    /* NULL-terminated. With `flags` the names of the bits, lowest first (empty: unused), else of the values
     * from 0. NULL: a number. */
    const char *const *names;
    bool flags;
} ll_record_field;

typedef enum ll_form {
    LL_FORM_ONE,      /* one row */
    LL_FORM_BY_INDEX, /* rows are matched by index */
    LL_FORM_KEYED, /* rows are sorted and matched by their first `keys` fields; two rows may have equal keys
                    */
    LL_FORM_LOG,   /* numbered rows that never change: those after the last one sent */
    LL_FORM_GRID,  /* as BY_INDEX, each row with a plane of bytes, row by row; its first two fields are the
                      plane's width and height */
} ll_form;

#define LL_KEYS_MAX 4

typedef struct ll_record {
    const char *name;   /* in JSON and in every decoder */
    ll_channel channel; /* the channel that includes it */
    const char *help;
    int id; /* on the wire; unique */
    ll_form form;
    int keys;
    size_t size; /* of the struct */
    const ll_record_field *fields;
    int count;
    void (*integers)(const void *structs, int count, int64_t *to); /* of `count` structs; NULL: by the table
                                                                      (integers.h) */
} ll_record;

/* Type and offset are taken from the struct, so that the table always agrees with it. */
#define LL_TYPE_OF(member)                                                                                   \
    _Generic((member), bool                                                                                  \
             : LL_TYPE_BOOL, uint8_t                                                                         \
             : LL_TYPE_U8, uint16_t                                                                          \
             : LL_TYPE_U16, uint32_t                                                                         \
             : LL_TYPE_U32, int32_t                                                                          \
             : LL_TYPE_I32, int64_t                                                                          \
             : LL_TYPE_I64, float                                                                            \
             : LL_TYPE_F32, double                                                                           \
             : LL_TYPE_F64)

#define LL_FIELD_AS(S, m, coding_, bits_, unit_, help_)                                                      \
    .name = #m, .unit = unit_, .help = help_, .offset = offsetof(S, m), .type = LL_TYPE_OF(((S *)0)->m),     \
    .coding = coding_, .bits = bits_

/* Table rows: a whole number, one with names of values, a set of named bits, and real numbers. */
#define LL_INT(S, m, unit, help)                                                                             \
    {                                                                                                        \
        LL_FIELD_AS(S, m, LL_CODE_INT, 0, unit, help)                                                        \
    }
#define LL_ENUM(S, m, names_, help)                                                                          \
    {                                                                                                        \
        LL_FIELD_AS(S, m, LL_CODE_INT, 0, NULL, help), .names = names_                                       \
    }
#define LL_FLAGS(S, m, names_, help)                                                                         \
    {                                                                                                        \
        LL_FIELD_AS(S, m, LL_CODE_INT, 0, NULL, help), .names = names_, .flags = true                        \
    }
#define LL_STEP(S, m, bits, unit, help)                                                                      \
    {                                                                                                        \
        LL_FIELD_AS(S, m, LL_CODE_STEP, bits, unit, help)                                                    \
    }
#define LL_REAL(S, m, bits, unit, help)                                                                      \
    {                                                                                                        \
        LL_FIELD_AS(S, m, LL_CODE_REAL, bits, unit, help)                                                    \
    }

#define LL_ROWS_OF(S, table)                                                                                 \
    .size = sizeof(S), .fields = (table), .count = (int)(sizeof(table) / sizeof(table)[0])

/* Bits of STEP, fine enough for drawing; the same in all records. */
enum {
    LL_BITS_M = 13,    /* 0.12 mm */
    LL_BITS_MPS = 10,  /* 1 mm/s */
    LL_BITS_RAD = 12,  /* 0.014 degrees */
    LL_BITS_MS = 7,    /* 8 us */
    LL_BITS_S = 20,    /* 1 us */
    LL_BITS_RATIO = 10 /* 0.1 % */
};

/* The integer of a field of `row`, a struct; and the value of an integer (NaN: unknown). */
int64_t ll_field_integer(const ll_record_field *field, const void *row);
double ll_field_value(const ll_record_field *field, int64_t integer);
