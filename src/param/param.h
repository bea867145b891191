/* Vocabularies as tables.
 *
 * A row gives a value's name, type, unit, range, default and help. From rows come parsing, validation, PATCH,
 * the JSON Schema, the command line's help and the page's controls: nothing else in the program knows a
 * range.
 *
 * A table describes a C struct: each row names the offset of its member. Objects and arrays nest by rows
 * that point to another table, so that a path such as `players.1.link.up.jitter_ms` reaches any value. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct cJSON;

typedef enum ll_param_type {
    LL_PARAM_REAL,    /* double: finite, in [min, max] */
    LL_PARAM_INT,     /* int64_t in [min, max] */
    LL_PARAM_BOOL,    /* bool */
    LL_PARAM_CHOICE,  /* int32_t: index into `choices` */
    LL_PARAM_TEXT,    /* char[max + 1], NUL-terminated; valid UTF-8 without control characters */
    LL_PARAM_JSON,    /* char[max + 1]: a JSON object as text, as short as it goes; empty for {} */
    LL_PARAM_OBJECT,  /* nested struct described by `child` */
    LL_PARAM_VARIANT, /* nested struct whose table is `variants[i]`, i the CHOICE at `count_offset` (a game's
                         or a problem's own params); that row must stand before this one in the table. The
                         structs share the storage at `offset`. A NULL table takes no params. When the choice
                         is parsed, the variant's defaults are set first. */
    LL_PARAM_VECTOR,  /* double[2], written [x, y]: both in [min, max] */
    LL_PARAM_POINTS,  /* double[max][2], written [[x, y], ...]: at most `max` points, no coordinate larger in
                         size  than `standard`; an int32_t at `count_offset` holds how many are in use. None at
                         first. */
    LL_PARAM_ARRAY,   /* `max` nested structs in a row; an int32_t at `count_offset` holds how many are in use
                       */
} ll_param_type;

typedef struct ll_param_table ll_param_table;

typedef struct ll_param {
    const char *name;
    ll_param_type type;
    size_t offset;
    double min, max;            /* of a number; of a text's length; of an array's count */
    double standard;            /* default of REAL, INT, BOOL, CHOICE */
    const char *text;           /* default of TEXT (NULL is empty) */
    double vector[2];           /* default of VECTOR */
    const char *unit;           /* `ms`, `Hz`, `%`, `m/s`; NULL when there is none */
    const char *const *choices; /* NULL-terminated */
    const ll_param_table *child;
    const ll_param_table *const *variants;
    size_t count_offset; /* of an ARRAY's or POINTS' count, of a VARIANT's choice */
    bool live;           /* may be changed while a session runs */
    bool required;       /* must be given */
    const char *help;    /* one sentence */
    /* Of a CHOICE that stands for values of other rows (a preset): sets them in `object`, the struct of the
     * row's table. Called whenever the choice is given, by parse, patch or set and also when it stays as it
     * was, before the rows that stand after it. It may change only those, of them no choice that others
     * depend on, and nothing for the default. NULL when there is none. */
    void (*chosen)(void *object, int choice);
    /* Of an ARRAY whose elements say how they differ from `object`, the struct of the row's table: sets an
     * element before it is read. It may read only rows that stand before this one. NULL: the defaults. */
    void (*begin)(const void *object, void *element);
} ll_param;

struct ll_param_table {
    const char *name; /* `player`, `link`: the schema's definition */
    const char *help;
    const ll_param *rows;
    int count;
    size_t size; /* of the struct */
    /* Rules that tie values together; called after all rows, inner tables first. NULL when there are none.
     * `path` is what stands before a field's name: `players.1.`, or empty at the root. */
    ll_status (*check)(const void *object, const char *path);
};

/* Sets every row to its default and every other byte to zero; arrays become empty. */
void ll_param_defaults(const ll_param_table *table, void *object);

/* Copies what is in use: elements of the outer arrays beyond their counts stay as they are in `to`, so that
 * long lists cost memory only where they are given; `to` begins as zeros or as a configuration. */
void ll_param_copy(const ll_param_table *table, void *to, const void *from);
size_t ll_param_used(const ll_param_table *table, const void *object); /* bytes that it copies */

/* Reads `json` over `object`. Unknown keys, wrong types, values out of range (also NaN and infinities),
 * missing required rows and arrays that are too long are errors that name the path, the range and the value;
 * `object` is then unchanged. */
ll_status ll_param_parse(const ll_param_table *table, const struct cJSON *json, void *object);

/* What a patch changes, one value a call, in the order of the patch (but choices that other values depend on
 * first): `path` is the full dotted path, `value` the new value as JSON text. Called when the whole patch has
 * been found right; an error stops the walk and the object stays as it was. */
typedef ll_status ll_param_change(void *context, const char *path, const char *value);

/* Applies a JSON merge patch (RFC 7396) to live rows, all or nothing. A row that is not live, or stands
 * within one that is not, is refused with LL_CONFLICT; `null` for a row, and a value given twice, are errors.
 * Array elements are addressed by an object with indices as keys ({"players":{"1":{...}}}), by an array of as
 * many elements
 * ({"players":[{},{...}]}), and any value by its dotted path ({"players.1.lag_ms":250}); `change` may be
 * NULL. */
ll_status ll_param_patch(const ll_param_table *table, const struct cJSON *patch, void *object,
                         ll_param_change *change, void *context);

/* The same for all rows, live or not, before anything runs. An array that is given as an array replaces what
 * is there. */
ll_status ll_param_merge(const ll_param_table *table, const struct cJSON *patch, void *object);

/* Sets one value by path. `value` is JSON, or bare text for texts and choices (`--set server.sync=lockstep`).
 * With `live_only` a row that is not live is refused. An object is merged; an array is replaced when
 * `live_only` is off. */
ll_status ll_param_set(const ll_param_table *table, void *object, const char *path, const char *value,
                       bool live_only);

/* Sets `count` values, each written path=value, as ll_param_set does of rows that need not be live; all or
 * nothing. Their order does not matter, but of two of one path the later counts. Rules that tie values
 * together are not checked yet: ll_param_check does, when all is set that was asked for. */
ll_status ll_param_put(const ll_param_table *table, void *object, const char *const *sets, int count);
ll_status ll_param_check(const ll_param_table *table, const void *object);

/* The whole object as JSON, in the tables' order. Caller deletes. NULL without memory. */
struct cJSON *ll_param_write(const ll_param_table *table, const void *object);

/* A JSON number that is written with the fewest of 15 to 17 digits that read back as `value`. cJSON itself
 * rounds some: those are raw items (cJSON_IsRaw) with `valuedouble` set, which all functions here read as
 * numbers. */
struct cJSON *ll_param_number(double value);

/* The fewest of 15 to 17 digits that read back as `value`. */
void ll_number_text(double value, char out[32]);

/* The number at a dotted path of a document, indices into arrays included; NULL with none. */
const struct cJSON *ll_param_number_at(const struct cJSON *json, const char *path);

/* A JSON Schema (2020-12) object with `$defs` for nested tables; units stand in `x-unit`, `live` in `x-live`.
 * Caller deletes. */
struct cJSON *ll_param_schema(const ll_param_table *table);

/* Whether the table itself and those within are sound: names, ranges, defaults, offsets. For tests. */
ll_status ll_param_table_valid(const ll_param_table *table);

/* Finds a row and its member in `object` by dotted path; `players.1` gives the row of the array and the
 * element. NULL with no such path; `member` may be NULL. */
const ll_param *ll_param_find(const ll_param_table *table, void *object, const char *path, void **member);
