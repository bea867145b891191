/* Axis of an experiment: the values of one parameter, as a list or a range. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "base/interrupt.h"
#include "param/param.h"

enum { LL_AXIS_PATH_MAX = 120, LL_AXIS_VALUES_MAX = 10000 };

typedef enum ll_cell_type { LL_CELL_INT, LL_CELL_REAL, LL_CELL_BOOL, LL_CELL_TEXT } ll_cell_type;

typedef struct ll_axis {
    char path[LL_AXIS_PATH_MAX + 8];
    char field[40]; /* where it stands in the specification: `axes.0` */
    ll_cell_type type;
    struct cJSON *values; /* of a list, owned; NULL: a range */
    double from, to;
    int64_t count;
    int32_t scale; /* 0 linear, 1 log */
    bool sampled;  /* range of a sampled experiment without count: any value in it may be drawn */
} ll_axis;

/* Parses `json`; the path must exist in the scenario. `sampled`: a range may lack a count. Errors name the
 * field below `field`. */
ll_status ll_axis_parse(const struct cJSON *json, const char *field, bool sampled,
                        const ll_param_table *table, const void *config, ll_axis *axis);
/* Each value must be in its range. Apart, since this takes long where there are many. */
ll_status ll_axis_check_values(const ll_axis *axis, const ll_param_table *table, const void *config,
                               const ll_interrupt *interrupt);
void ll_axis_free(ll_axis *axis);

/* The k-th of its `count` values; or the value at a position in [0, 1): one of these values, each equally
 * likely, or, for a sampled range, any value in it. Caller deletes. */
struct cJSON *ll_axis_at(const ll_axis *axis, int64_t k);
struct cJSON *ll_axis_sample(const ll_axis *axis, double position);

/* Type of a row's values in tables. */
ll_cell_type ll_axis_type(const ll_param *row);

/* The path with its unit appended: `params.g_m_per_s2`; unchanged if it ends in the unit. */
void ll_axis_column(const char *path, const char *unit, char *name, int size);

/* JSON Schema of an axis, from its table. Caller deletes. */
struct cJSON *ll_axis_schema(void);
