/* Shared by the files of this room. */
#pragma once

#include "base/utf8.h"
#include "param/param.h"

#define LL_PATH_MAX 160
#define LL_ROWS_MAX 128  /* per table */
#define LL_POINTS_MAX 64 /* per row */

/* Larger integers are not exact in a double, which JSON numbers are read into. */
#define LL_WHOLE_MAX 9007199254740991.0

/* ---- path.c: current position in the document ---- */

typedef struct ll_path {
    const char *root; /* name of the document, for an empty path */
    int length;
    char text[LL_PATH_MAX];
} ll_path;

ll_path ll_path_root(const ll_param_table *table);
/* Appends `.name`; returns the old length, for ll_path_pop. User input is made printable and cut. */
int ll_path_push(ll_path *path, const char *name, size_t length);
int ll_path_push_index(ll_path *path, int index);
void ll_path_pop(ll_path *path, int length);
const char *ll_path_subject(const ll_path *path); /* beginning of a message */

/* ---- text.c ---- */

typedef struct ll_writer {
    char *out;
    size_t size, used;
} ll_writer;

void ll_append(ll_writer *writer, const char *format, ...) __attribute__((format(printf, 2, 3)));
void ll_append_printable(ll_writer *writer, const char *text, size_t length, size_t limit);

/* The allowed counts of a row, `1 to 8` or `at most 8`. */
void ll_count_range(const ll_param *row, char *out, size_t size);

/* The name in `table` that `name` is probably a misspelling of, or NULL. */
const char *ll_nearest_name(const ll_param_table *table, const char *name, size_t length);

/* ---- place.c: walks a table and its object by names ---- */

typedef enum ll_json_location_kind {
    LL_LOCATION_VALUE,
    LL_LOCATION_OBJECT,
    LL_LOCATION_ARRAY
} ll_json_location_kind;

typedef struct ll_json_location {
    ll_json_location_kind kind;
    bool live;                        /* all rows of the path are live */
    const ll_param *row;              /* last row of the path; NULL at the root */
    char *member;                     /* the value, the struct or the first element */
    const ll_param_table *table;      /* of an OBJECT: its rows; NULL: it takes none */
    const ll_param_table *home_table; /* of a VALUE: the table of `row` */
    char *home;                       /* its struct */
} ll_json_location;

ll_json_location ll_json_location_root(const ll_param_table *table, void *object);
/* Goes down by one name or index. False if it does not exist. */
bool ll_json_location_step(ll_json_location *place, const char *name, size_t length);
ll_json_location ll_json_location_of_row(const ll_json_location *object, const ll_param *row);
ll_json_location ll_json_location_of_element(const ll_json_location *array, int index);
const ll_param *ll_row_named(const ll_param_table *table, const char *name, size_t length);
bool ll_row_is_value(const ll_param *row);
bool ll_row_governs(const ll_param_table *table, const ll_param *row); /* other values depend on it */
int32_t ll_count_of(const ll_param *row, const char *object); /* count of an ARRAY, choice of a VARIANT */
const ll_param_table *ll_variant_of(const ll_param *row, const char *object); /* may be NULL */

/* ---- defaults.c ---- */

/* Clears the storage of every VARIANT that depends on `choice` and sets the defaults of the current one. */
void ll_reset_variants(const ll_param_table *table, const ll_param *choice, char *object);

/* ---- message.c: error messages ---- */

ll_status ll_wrong_type(const ll_path *path, const char *expected, const struct cJSON *got);
ll_status ll_out_of_range(const ll_path *path, const ll_param *row, const struct cJSON *got);
ll_status ll_not_a_choice(const ll_path *path, const ll_param *row, const struct cJSON *got);
ll_status ll_unknown_name(ll_path *path, const ll_json_location *place, const char *name, size_t length);

/* ---- value.c ---- */

/* Sets the value at `place` from `json`, and nothing else. */
ll_status ll_value_set(const ll_json_location *place, const struct cJSON *json, const ll_path *path);
/* Consequences of the value at `place`, if it is a choice: variants are reset, if `changed`, and the row's
 * `chosen` is called. */
void ll_value_follow(const ll_json_location *place, bool changed);

/* ---- parse.c ---- */

ll_status ll_parse_object(const ll_json_location *place, const struct cJSON *json, ll_path *path);
ll_status ll_parse_array(const ll_json_location *place, const struct cJSON *json, ll_path *path);

/* ---- check.c ---- */

ll_status ll_run_checks(const ll_param_table *table, const void *object);

/* ---- patch.c ---- */

typedef struct ll_patch_options {
    bool live_only;
    bool unchecked;          /* rules between values wait for ll_param_check */
    bool texts;              /* values are texts from a command line */
    ll_param_change *change; /* may be NULL */
    void *context;
} ll_patch_options;

ll_status ll_patch_apply(const ll_param_table *table, const struct cJSON *patch, void *object,
                         const ll_patch_options *options);

/* ---- set.c ---- */

/* Command-line text as JSON for `row`, which may be NULL. The caller deletes it. NULL: out of memory. */
struct cJSON *ll_read_text(const ll_param *row, const char *text);

/* ---- write.c ---- */

struct cJSON *ll_write_value(const ll_param *row, const char *member);
