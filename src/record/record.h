/* What is streamed, as tables.
 *
 * A record describes the rows of one section of the stream: the struct that a room fills, and of each of its
 * fields the name, unit, coding and help. From it come the binary layout, the JSON, the schema, AsyncAPI, the
 * tables in docs, and the page's decoder and constants: nothing else in the program writes a field's name.
 *
 * Rows travel as integers. A field's coding says how a value becomes one, rounded once; what is sent are
 * differences of such integers, which are exact, so that errors cannot add up. Every integer lies within
 * +-(2^51 - 1), of which the ends stand for the infinities, and -2^51 for what is not known: the difference
 * of any two fits into a double of JavaScript.
 *
 * A field is added at the end of its record, so that a decoder that does not know it reads the others. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "record/channel.h"

#define LL_FIELDS_MAX 49 /* of a record: the mask of those that changed is a varint */

#define LL_INTEGER_MAX ((INT64_C(1) << 51) - 1) /* an infinity, as its negative */
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
    LL_CODE_INT,  /* of a whole number: itself */
    LL_CODE_STEP, /* of a real one: round(value * 2^bits) */
    LL_CODE_REAL, /* with `bits` (at most 39) of its mantissa: equal relative steps. 23 are exact for a float
                   */
} ll_coding;

typedef struct ll_record_field {
    const char *name;
    const char *unit; /* `m`, `ms`; NULL: it has none */
    const char *help; /* what it is; of a real number that may be not known also when it is null */
    size_t offset;
    ll_type type;
    ll_coding coding;
    int bits;
    /* NULL-terminated. With `flags` the name of each bit from the lowest on (an empty one: not used), else
     * that of each value from 0 on. NULL: it is a number. */
    const char *const *names;
    bool flags;
} ll_record_field;

typedef enum ll_form {
    LL_FORM_ONE,      /* one row */
    LL_FORM_BY_INDEX, /* row i was row i before */
    LL_FORM_KEYED,    /* rows ascend by their first `keys` fields, by which they are found again; two may have
                         the same */
    LL_FORM_LOG,      /* numbered rows that never change: those since the last that was sent */
    LL_FORM_GRID,     /* as BY_INDEX, each with a plane of bytes, row by row; its first two fields are the
                         plane's width and height */
} ll_form;

#define LL_KEYS_MAX 4

typedef struct ll_record {
    const char *name;   /* in JSON and in every decoder */
    ll_channel channel; /* that a viewer subscribes to for it */
    const char *help;
    int id; /* on the wire; of no other record */
    ll_form form;
    int keys;
    size_t size; /* of the struct */
    const ll_record_field *fields;
    int count;
} ll_record;

/* Type and offset follow from the struct: the table cannot disagree with it. */
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

/* Rows of a table: a whole number, one with a name for each value, a set of named bits, and real numbers. */
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

/* Steps that are fine enough to be drawn, for all records alike. */
enum {
    LL_BITS_M = 13,    /* 0.12 mm */
    LL_BITS_MPS = 10,  /* 1 mm/s */
    LL_BITS_RAD = 12,  /* 0.014 degrees */
    LL_BITS_MS = 7,    /* 8 us */
    LL_BITS_S = 20,    /* 1 us */
    LL_BITS_RATIO = 10 /* 0.1 % */
};

/* Whether names, codings, keys and the form's own fields are sound. For tests. */
ll_status ll_record_valid(const ll_record *record);

/* The integer of a field of `row`, a struct; and the value that it stands for (NaN: not known). */
int64_t ll_field_integer(const ll_record_field *field, const void *row);
double ll_field_value(const ll_record_field *field, int64_t integer);

/* NULL when there is none. */
const ll_record *ll_record_named(const ll_record *const *records, const char *name);
