/* Fluids in the plane behind one interface: m, kg, s; extensive quantities are per metre of depth.
 *
 * A method represents a fluid: cells of a grid, particles, the surface of an ocean. A scene sets one of them
 * up and knows its reference solution. Both are rows of tables. A new scene is one more row of
 * ll_fluid_scenes, in scenes.h; the simulation kind, its parameters, the page and the tests read nothing
 * else.
 *
 * The fluid is one relocatable block, laid out by its method, with a size that follows from the scene's
 * parameters: a copy is a snapshot. A step calls neither malloc nor a clock and gives the same bits
 * everywhere. */
#pragma once

#include "base/interrupt.h"
#include "fluid/core/rows.h"
#include "param/param.h"
#include "record/metric.h"

enum {
    LL_FLUID_PARAMS_MAX = 256, /* bytes of a scene's parameters, and of a method's settings */
    LL_FLUID_NUMBERS_MAX = 48,
    LL_FLUID_POINTS_MAX = 256, /* per profile */
    LL_FLUID_NOTICES_MAX = 4,
};

/* Per block: 2048 x 2048 cells, or a million particles. The daemon refuses much smaller ones. */
#define LL_FLUID_BYTES_MAX (INT64_C(2) << 30)

/* A reported number of a fluid: a row of a table of metrics, with the unit in the name if it has one. */
typedef struct ll_fluid_number {
    const char *name;
    double value;
} ll_fluid_number;

#define LL_FLUID_NUMBER(type, name, unit, value, help, null) {#name, (double)(value)},

/* Writes the rows of a list of metrics (record/metric.h) to `out`: their count. */
#define LL_FLUID_TELL(out, LIST)                                                                             \
    ll_fluid_tell(out, (const ll_fluid_number[]){LIST(LL_FLUID_NUMBER)},                                     \
                  sizeof((const ll_fluid_number[]){LIST(LL_FLUID_NUMBER)}) / sizeof(ll_fluid_number))

static inline int ll_fluid_tell(ll_fluid_number *out, const ll_fluid_number *all, size_t count)
{
    for (size_t i = 0; i < count; i++)
        out[i] = all[i];
    return (int)count;
}

#define LL_FLUID_AGAIN "side_by_side.*"           /* where the tables stand once more */
#define LL_FLUID_FAILED "The fluid has diverged." /* when all of them are null */

/* Why a result differs from the open sea, the free stream or the equations: a sentence with numbers. */
typedef struct ll_fluid_notice {
    char text[240];
} ll_fluid_notice;

/* Pointer drag: fluid around a point is dragged along at `velocity`, until changed. */
typedef struct ll_drag_force {
    double x, y, velocity_x, velocity_y; /* m, m/s */
    double radius;                       /* m; 0: none */
} ll_drag_force;

/* Layers to draw. A field has one value per cell, width x height cells that fill the extent, row by row from
 * the bottom. Points are records of several values. */
typedef enum ll_fluid_shape { LL_FLUID_FIELD, LL_FLUID_POINTS } ll_fluid_shape;

typedef struct ll_fluid_layer {
    const char *name;           /* `smoke`, `particles`, `surface` */
    const char *help;           /* meaning of a value, with its unit */
    int32_t shape;              /* ll_fluid_shape */
    const char *const *columns; /* names of a record's values, NULL-terminated: `x_m`, `y_m`, `speed_mps` */
} ll_fluid_layer;

typedef struct ll_fluid_method {
    const char *name; /* `grid`, `particles`, `ocean` */
    const char *help;
    const ll_fluid_layer *layers;
    int layer_count;

    /* Advances by `dt` seconds in as many substeps as needed. LL_DIVERGED names the step, the cell or the
     * particle, and the reason (CFL limit, a value that is not finite); the fluid cannot be used any more.
     * The same holds after the pace of `run` was broken off, with any status. NULL: no pace, one thread. */
    ll_status (*step)(void *block, double dt, const ll_fluid_run *run);
    void (*set_solver)(void *block, const void *solver);
    /* Of the state: what a step starts from. What it recomputes does not count. NULL: of the whole block. */
    uint64_t (*hash)(const void *block);
    void (*drag_force)(void *block, const ll_drag_force *drag_force); /* NULL: not supported */

    /* The same numbers in the same order for every scene and time, the rows of `metrics`; returns their
     * count. Those of `traced`, which are the first, are in the trace too. */
    int (*numbers)(const void *block, ll_fluid_number *out);
    const ll_metric_table *metrics, *traced;

    void (*extent)(const void *block, double *x0, double *y0, double *x1, double *y1);
    void (*layer_size)(const void *block, int layer, int32_t *width, int32_t *height); /* points: count, 1 */
    void (*layer_values)(const void *block, int layer, float *out); /* width * height * columns */
} ll_fluid_method;

typedef struct ll_fluid_scene {
    const char *name, *title;
    const char *help;   /* contents, and what it shows */
    const char *source; /* of the reference */
    const ll_fluid_method *method;
    const ll_param_table
        *params; /* its parameters, at most LL_FLUID_PARAMS_MAX bytes: ll_fluid_NAME_params */
    const ll_param_table
        *solver; /* settings of the method with the scene's defaults; live rows may change between steps */
    double duration_s; /* default duration */

    /* Whether it can be made; the error for too large a size names the memory that it needs. The field is
     * `params.ROW` or `solver.ROW`. */
    ll_status (*check)(const void *params, const void *solver);
    size_t (*size)(const void *params, const void *solver); /* room for every live setting */
    void (*init)(void *block, const void *params, const void *solver);

    /* The scene's own numbers: errors against the reference; the rows of `metrics`, or none of them. NULL:
     * none. */
    int (*numbers)(const void *block, ll_fluid_number *out);
    const ll_metric_table *metrics;
    /* Curves to compare with published ones: pairs (coordinate, value), at most LL_FLUID_POINTS_MAX. The
     * reference of the curve `u` is the curve `u_reference`. `index` counts from 0; returns 0 points beyond
     * the last. NULL: none. */
    int (*profile)(const void *block, int index, const char **name, double (*pairs)[2]);
    /* What the box or its cells cannot represent; at most LL_FLUID_NOTICES_MAX. NULL: unknown. */
    int (*notices)(const void *block, ll_fluid_notice *out);
} ll_fluid_scene;

extern const ll_fluid_scene *const ll_fluid_scenes[];        /* NULL-terminated */
const ll_fluid_scene *ll_fluid_scene_find(const char *name); /* NULL if there is no such scene */

/* LL_BAD_INPUT if `bytes` for `what` exceed the limit. */
ll_status ll_fluid_check_bytes(const char *field, const char *what, int64_t bytes);
