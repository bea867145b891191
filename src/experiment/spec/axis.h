/* What an experiment varies: values of one parameter, as a list or a range. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "param/param.h"

enum { LL_AXIS_PATH_MAX = 120, LL_AXIS_VALUES_MAX = 10000 };

typedef enum ll_cell_type { LL_CELL_INT, LL_CELL_REAL, LL_CELL_BOOL, LL_CELL_TEXT } ll_cell_type;

typedef struct ll_axis {
    char path[LL_AXIS_PATH_MAX + 8];
    ll_cell_type type;
    struct cJSON *values; /* of a list, owned; NULL for a range */
    double from, to;
    int64_t count;
    int32_t scale; /* 0 linear, 1 log */
    bool sampled;  /* a range of a sampled experiment without a count: any value in it may be drawn */
} ll_axis;

/* Reads `json` and holds it against the scenario: the path must be there, each value alone in its range.
 * `sampled` lets a range be without count. Errors name the field below `field` (`axes.0`). */
ll_status ll_axis_parse(const struct cJSON *json, const char *field, bool sampled,
                        const ll_param_table *table, const void *config, ll_axis *axis);
void ll_axis_free(ll_axis *axis);

/* The k-th of its `count` values, or that of a position in [0, 1): one of these values, each as often, or of
 * a sampled range any. Caller deletes. */
struct cJSON *ll_axis_at(const ll_axis *axis, int64_t k);
struct cJSON *ll_axis_sample(const ll_axis *axis, double position);

/* How values of a row are written in a table. */
ll_cell_type ll_axis_type(const ll_param *row);

/* The path with its unit in the name: `params.g_m_per_s2`; paths that end in their unit stay. */
void ll_axis_column(const char *path, const char *unit, char *name, int size);

/* JSON Schema of an axis, from its table. Caller deletes. */
struct cJSON *ll_axis_schema(void);
