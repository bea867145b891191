/* Fluids in the plane behind one interface: m, kg, s.
 *
 * A method represents a fluid: cells of a grid, particles, the surface of an ocean. A scene sets one of them
 * up and knows what is right there. Both are rows of tables, and a new scene of any method is one more row of
 * ll_fluid_scenes, in scenes.h: the simulation kind, its parameters, the page and the tests read nothing
 * else.
 *
 * The fluid is one relocatable block, laid out by its method, whose size follows from the scene's parameters:
 * a copy is a snapshot. A step calls neither malloc nor a clock and gives the same bits everywhere. */
#pragma once

#include "base/interrupt.h"
#include "param/param.h"

enum {
    LL_FLUID_PARAMS_MAX = 256, /* bytes of a scene's own parameters, and of a method's settings */
    LL_FLUID_NUMBERS_MAX = 48,
    LL_FLUID_POINTS_MAX = 256, /* of a profile */
    LL_FLUID_NOTICES_MAX = 4,
};

#define LL_FLUID_BYTES_MAX (INT64_C(256) << 20) /* of a block; a session holds three */

/* A number that is told of a fluid: `divergence_max`, with its unit in the name where it has one. */
typedef struct ll_fluid_number {
    const char *name;
    double value;
} ll_fluid_number;

/* Why a result is not that of the open sea, the free stream or the equations: a sentence with its numbers. */
typedef struct ll_fluid_notice {
    char text[240];
} ll_fluid_notice;

/* What a person does to the fluid until told otherwise: it is drawn along at `velocity` around a point. */
typedef struct ll_fluid_stir {
    double x, y, velocity_x, velocity_y; /* m, m/s */
    double radius;                       /* m; 0: nothing is stirred */
} ll_fluid_stir;

/* What can be drawn. A field has a value for each of width x height cells that fill the extent, row by row
 * from the bottom; points are records of several values. */
typedef enum ll_fluid_shape { LL_FLUID_FIELD, LL_FLUID_POINTS } ll_fluid_shape;

typedef struct ll_fluid_layer {
    const char *name;           /* `smoke`, `particles`, `surface` */
    const char *help;           /* what a value is, with its unit */
    int32_t shape;              /* ll_fluid_shape */
    const char *const *columns; /* names of a record's values, NULL-terminated: `x_m`, `y_m`, `speed_mps` */
} ll_fluid_layer;

typedef struct ll_fluid_method {
    const char *name; /* `grid`, `particles`, `ocean` */
    const char *help;
    const ll_fluid_layer *layers;
    int layer_count;

    /* Advances by `dt` seconds in as many substeps as it wants. LL_DIVERGED names the step, the cell or the
     * particle, and the reason (a limit of CFL, a value that is not finite); the fluid is then spent. So it
     * is when `pace` (may be NULL) was broken off, whatever is returned. */
    ll_status (*step)(void *block, double dt, ll_pace *pace);
    void (*set_solver)(void *block, const void *solver);
    void (*stir)(void *block, const ll_fluid_stir *stir); /* NULL: nobody can */

    /* The same numbers in the same order for every scene and time; returns the count. The first
     * `traced` of them go into the trace. */
    int (*numbers)(const void *block, ll_fluid_number *out);
    int traced;

    void (*extent)(const void *block, double *x0, double *y0, double *x1, double *y1);
    void (*layer_size)(const void *block, int layer, int32_t *width, int32_t *height); /* points: count, 1 */
    void (*layer_values)(const void *block, int layer, float *out); /* width * height * columns */
} ll_fluid_method;

typedef struct ll_fluid_scene {
    const char *name, *title;
    const char *help;   /* what is in it and what it shows */
    const char *source; /* of what is right */
    const ll_fluid_method *method;
    const ll_param_table *params; /* its own, at most LL_FLUID_PARAMS_MAX bytes: ll_fluid_NAME_params */
    const ll_param_table *solver; /* the method's settings with the defaults that suit the scene; live rows
 may change between steps */
    double duration_s;            /* that it wants */

    /* Whether it can be made; too large a size is refused with the memory that it would take. The field is
     * `params.ROW` or `solver.ROW`. */
    ll_status (*check)(const void *params, const void *solver);
    size_t (*size)(const void *params, const void *solver); /* room for every setting that is live */
    void (*init)(void *block, const void *params, const void *solver);

    /* What the scene knows beside the method's numbers: errors against the reference. NULL: nothing. */
    int (*numbers)(const void *block, ll_fluid_number *out);
    /* Curves to be held against published ones: pairs (coordinate, value), at most LL_FLUID_POINTS_MAX.
     * What is known of the curve `u` is the curve `u_reference`.
     * `index` counts from 0; returns 0 points beyond the last. NULL: there is none. */
    int (*profile)(const void *block, int index, const char **name, double (*pairs)[2]);
    /* What does not fit the box or its cells; at most LL_FLUID_NOTICES_MAX. NULL: nothing is known of that.
     */
    int (*notices)(const void *block, ll_fluid_notice *out);
} ll_fluid_scene;

extern const ll_fluid_scene *const ll_fluid_scenes[];        /* NULL-terminated */
const ll_fluid_scene *ll_fluid_scene_find(const char *name); /* NULL with no such scene */

/* LL_BAD_INPUT with a sentence that tells what `bytes` for `what` are beyond; otherwise ok. */
ll_status ll_fluid_check_bytes(const char *field, const char *what, int64_t bytes);
