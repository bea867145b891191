/* Vocabularies as tables.
 *
 * A row gives a value's name, type, unit, range, default and help. Parsing, validation, PATCH, the JSON
 * Schema, the command line's help and the page's controls all come from rows; nothing else in the program
 * knows a range.
 *
 * A table describes a C struct: each row names the offset of its member. Objects and arrays nest by rows that
 * point to another table, so that a path such as `players.1.link.up.jitter_ms` reaches any value. */
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
    LL_PARAM_JSON,    /* char[max + 1]: a JSON object as minimal text; empty for {} */
    LL_PARAM_OBJECT,  /* nested struct described by `child` */
    LL_PARAM_VARIANT, /* nested struct whose table is `variants[i]`, i the CHOICE at `count_offset`
                         (parameters of a game or a problem); that row must come earlier in the table. The
                         structs share the storage at `offset`. A NULL table takes no parameters. Parsing the
                         choice sets the variant's defaults first. */
    LL_PARAM_VECTOR,  /* double[2], written [x, y]: both in [min, max] */
    LL_PARAM_POINTS,  /* double[max][2], written [[x, y], ...]: at most `max` points, coordinates of at most
                         `default_value` in size; an int32_t at `count_offset` holds their number. Default:
                         none. */
    LL_PARAM_NUMBERS, /* double[max], written [x, y, ...]: at most `max` numbers from vector[0] to vector[1];
                         an int32_t at `count_offset` holds how many. Default: none. */
    LL_PARAM_ARRAY, /* `max` nested structs in a row; an int32_t at `count_offset` holds how many are used */
} ll_param_type;

typedef struct ll_param_table ll_param_table;

typedef struct ll_param {
    const char *name;
    ll_param_type type;
    size_t offset;
    double min, max;            /* of a number; of a text's length; of an array's count */
    double default_value;       /* default of REAL, INT, BOOL, CHOICE */
    const char *text;           /* default of TEXT (NULL is empty) */
    double vector[2];           /* default of VECTOR; range of NUMBERS */
    const char *unit;           /* `ms`, `Hz`, `%`, `m/s`; NULL: none */
    const char *const *choices; /* NULL-terminated */
    const ll_param_table *child;
    const ll_param_table *const *variants;
    size_t count_offset; /* of the count of an ARRAY, POINTS or NUMBERS, of a VARIANT's choice */
    bool live;           /* can change while a session runs */
    bool required;       /* must be given */
    const char *help;    /* one sentence */
    /* Of a CHOICE that sets other rows (a preset): sets them in `object`, the struct of the row's table.
     * Called whenever the choice is given, by parse, patch or set, also with an unchanged value, before the
     * later rows. It may change only later rows, no choice that others depend on, and nothing for the
     * default. NULL: none. */
    void (*chosen)(void *object, int choice);
    /* Of an ARRAY whose elements are differences from `object`, the struct of the row's table: initialises an
     * element before it is read. It may read only earlier rows. NULL: the defaults. */
    void (*begin)(const void *object, void *element);
} ll_param;

struct ll_param_table {
    const char *name; /* `player`, `link`: the schema's definition */
    const char *help;
    const ll_param *rows;
    int count;
    size_t size; /* of the struct */
    /* Rules between values; called after all rows, inner tables first. NULL: none. `path`: prefix of field
     * names: `players.1.`, or empty at the root. */
    ll_status (*check)(const void *object, const char *path);
    /* Set where the last row is an array that the struct ends with, and the struct is never copied by
     * assignment: a clone has no elements of that array beyond its count. */
    bool is_cut;
};
/* Of the initialiser of a row: its name, its type without LL_PARAM_, and the member that it describes. */
#define LL_PARAM_ROW(name_, type_, struct_, member_)                                                         \
    .name = (name_), .type = LL_PARAM_##type_, .offset = offsetof(struct_, member_)
/* Of the initialiser of a table: an array of rows, and the type of the struct that they describe, or one. */
#define LL_PARAM_ROWS(rows_, type_)                                                                          \
    .rows = (rows_), .count = sizeof(rows_) / sizeof(rows_)[0], .size = sizeof(type_)

/* Sets every row to its default and every other byte to zero; arrays become empty. */
void ll_param_defaults(const ll_param_table *table, void *object);
/* The same for memory that is all zero; of that it writes the rows only, so that long lists cost memory only
 * if given. */
void ll_param_defaults_in_zeros(const ll_param_table *table, void *object);

/* Copies used bytes: elements of the outer arrays beyond their counts do not change in `to`, so that long
 * lists cost memory only if given. `to` must be zeros or a configuration. */
void ll_param_copy(const ll_param_table *table, void *to, const void *from);
/* A copy in memory of its own, which the caller frees. NULL: no memory. Where the table `is_cut` the last
 * array of the copy cannot grow; `patch`, unless NULL, is what will be parsed or merged into the copy: where
 * it names that array, all elements are there. */
void *ll_param_clone(const ll_param_table *table, const void *object, const struct cJSON *patch);
size_t ll_param_clone_size(const ll_param_table *table, const void *object, const struct cJSON *patch);
size_t ll_param_used(const ll_param_table *table, const void *object); /* bytes that ll_param_copy copies */
/* Calls `range` for each range of these bytes, in ascending order; the last ends with the struct. */
void ll_param_each_range(const ll_param_table *table, const void *object,
                         void (*range)(void *context, size_t from, size_t bytes), void *context);

/* Reads `json` over `object`. Unknown keys, wrong types, values out of range (NaN and infinities too),
 * missing required rows and arrays that are too long are errors that name the path, the range and the value;
 * `object` is then unchanged. */
ll_status ll_param_parse(const ll_param_table *table, const struct cJSON *json, void *object);

/* Reports a change of a patch, one value per call, in the order of the patch (choices that other values
 * depend on first): `path` is the full dotted path, `value` the new value as JSON text. Called after the
 * whole patch was found valid; an error stops the walk and leaves the object unchanged. */
typedef ll_status ll_param_change(void *context, const char *path, const char *value);

/* Applies a JSON merge patch (RFC 7396) to live rows, all or nothing. A row that is not live, or is within
 * one that is not, is rejected with LL_CONFLICT; `null` for a row, and a value given twice, are errors. Array
 * elements are addressed by an object with indices as keys ({"players":{"1":{...}}}), by an array of equal
 * length ({"players":[{},{...}]}), and any value by its dotted path ({"players.1.lag_ms":250}); `change` may
 * be NULL. */
ll_status ll_param_patch(const ll_param_table *table, const struct cJSON *patch, void *object,
                         ll_param_change *change, void *context);

/* The same for all rows, live or not, before a run. An array replaces the old one. */
ll_status ll_param_merge(const ll_param_table *table, const struct cJSON *patch, void *object);

/* Sets one value by path. `value` is JSON, or bare text for texts and choices (`--set server.sync=lockstep`).
 * With `live_only` a row that is not live is rejected. An object is merged; an array is replaced unless
 * `live_only`. */
ll_status ll_param_set(const ll_param_table *table, void *object, const char *path, const char *value,
                       bool live_only);

/* Sets `count` values, each written path=value, like ll_param_set without live_only; all or nothing. Their
 * order does not matter, but the later of two of the same path counts. Rules between values are not checked:
 * call ll_param_check when all are set. */
ll_status ll_param_put(const ll_param_table *table, void *object, const char *const *sets, int count);
ll_status ll_param_check(const ll_param_table *table, const void *object);

/* The whole object as JSON, in the tables' order. The caller deletes it. NULL: out of memory. */
struct cJSON *ll_param_write(const ll_param_table *table, const void *object);

/* A JSON number, written with the fewest of 15 to 17 digits that read back as `value`. cJSON itself would
 * round some: these are raw items (cJSON_IsRaw) with `valuedouble` set, which all functions here read as
 * numbers. Null if it is not finite: JSON has no infinity. */
struct cJSON *ll_param_number(double value);

/* The fewest of 15 to 17 digits that read back as `value`. */
void ll_number_text(double value, char out[32]);

/* The number at a dotted path of a document, including indices into arrays; NULL: none. */
const struct cJSON *ll_param_number_at(const struct cJSON *json, const char *path);

/* A JSON Schema (2020-12) object with `$defs` for nested tables; units are in `x-unit`, `live` in `x-live`.
 * The caller deletes it. */
struct cJSON *ll_param_schema(const ll_param_table *table);
/* Makes such a schema a part of another: its `$defs` move to those of the other, `$schema` goes. Tables that
 * both have in common are one definition. */
void ll_param_schema_part(struct cJSON *part, struct cJSON *defs);

/* Checks a table and those within it: names, ranges, defaults, offsets. For tests. */
ll_status ll_param_table_valid(const ll_param_table *table);

/* Finds a row and its member in `object` by dotted path; `players.1` gives the row of the array and the
 * element. NULL if it does not exist; `member` may be NULL. */
const ll_param *ll_param_find(const ll_param_table *table, void *object, const char *path, void **member);
