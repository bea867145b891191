/* Surface of an ocean: m, s. Three methods fill the same grid of points: a sum of Gerstner waves,
 * Tessendorf's spectrum by FFT, and a small tile of it that is played in a loop and repeated.
 *
 * Water is described in the plane (x, z) with heights along y. A point at rest (x, z) is displaced to
 * (x + dx, height, z + dz), for one wave of amplitude A and wave vector k by
 *   dx, dz = -choppiness k / |k| A sin(k . x - w t + phase),  height = A cos(k . x - w t + phase),
 * with w^2 = g |k| tanh(|k| depth). The square of `length` repeats, so k are multiples of 2 pi / length.
 *
 * An ocean is one relocatable block. A surface is a function of time alone, the same bits everywhere. */
#pragma once

#include <stddef.h>

#include "base/vtime.h"
#include "param/param.h"

typedef struct ll_ocean ll_ocean;

typedef enum ll_ocean_method_kind {
    LL_OCEAN_GERSTNER,
    LL_OCEAN_SPECTRUM,
    LL_OCEAN_TILED,
    LL_OCEAN_METHODS
} ll_ocean_method_kind;

extern const char *const ll_ocean_method_names[LL_OCEAN_METHODS + 1]; /* NULL-terminated */
const char *ll_ocean_method_help(ll_ocean_method_kind kind);          /* method, cost and source */

/* Names, ranges and defaults: ll_ocean_table. */
typedef struct ll_ocean_setup {
    double length;     /* m */
    double depth;      /* m; 0: deeper than any wave reaches */
    double gravity;    /* m/s^2 */
    double wind_speed; /* m/s, 19.5 m above the water */
    double wind_angle; /* rad, from x towards z */
    double choppiness; /* of the displacement along the water */
    double loop_s;     /* all frequencies are multiples of 1 / loop_s; 0: none is changed */
    int64_t seed;
    int64_t n;      /* points along a side: 2^a 3^b 5^c, even */
    int64_t waves;  /* of gerstner */
    int64_t tile;   /* points along a side of the tile of tiled; divides n */
    int64_t frames; /* of tiled, in a loop */
    int32_t method; /* ll_ocean_method_kind */
    int32_t reserved;
} ll_ocean_setup;

extern const ll_param_table ll_ocean_table;

double ll_ocean_frequency(double k, double gravity, double depth); /* rad/s by the dispersion relation */

/* Shares of the wind's energy in waves that are longer than the box (of `tiled`: the tile), and in such as
 * are shorter than two of its cells; and the significant height of all of it (Pierson and Moskowitz 1964). */
typedef struct ll_ocean_fit {
    double length; /* m: of the box or the tile */
    double peak;   /* m: length of the waves at the spectrum's peak */
    double longer, shorter;
    double height; /* m */
} ll_ocean_fit;

ll_ocean_fit ll_ocean_fit_of(const ll_ocean_setup *setup);

ll_status ll_ocean_check(const ll_ocean_setup *setup);             /* rules that tie rows together */
size_t ll_ocean_size(const ll_ocean_setup *setup);                 /* bytes of the block; setup is checked */
ll_ocean *ll_ocean_init(void *block, const ll_ocean_setup *setup); /* aligned to 16 */

void ll_ocean_evaluate(ll_ocean *o, ll_time t); /* t >= 0 */

typedef struct ll_ocean_surface { /* rows of constant z: point (i, j) is [j * n + i], at length / n apart */
    int64_t n;
    double length;
    const double *height, *dx, *dz;
} ll_ocean_surface;

ll_ocean_surface ll_ocean_surface_of(const ll_ocean *o);
const ll_ocean_setup *ll_ocean_setup_of(const ll_ocean *o);

/* Height of the displaced surface above the place (x, z), of the surface that was evaluated last. */
double ll_ocean_height_at(const ll_ocean *o, double x, double z);

typedef struct ll_wave {
    double kx, kz, k;        /* rad/m */
    double amplitude, phase; /* m, rad */
    double frequency;        /* rad/s */
    int64_t cycles;          /* in a loop */
} ll_wave;

/* The wave `index` of gerstner, from 0 to waves - 1. */
ll_wave ll_ocean_wave(const ll_ocean *o, int64_t index);

/* The waves of gerstner without a grid, so that a few points of a surface cost no more than they are:
 * `waves` has setup->waves places. */
void ll_ocean_waves(const ll_ocean_setup *setup, ll_wave *waves);

typedef struct ll_ocean_point { /* a point of the water's surface */
    double dx, dz, height;      /* m from its rest */
    double u, w, v;             /* m/s along x, z and y */
} ll_ocean_point;

/* What `waves` do at `t` to the point that rests at (x, z). */
ll_ocean_point ll_ocean_point_of(const ll_ocean_setup *setup, const ll_wave *waves, double x, double z,
                                 ll_time t);

/* The same surface of spectrum at grid point (i, j), as a plain sum over all wave vectors: for tests. */
void ll_ocean_direct(const ll_ocean *o, ll_time t, int64_t i, int64_t j, double *height, double *dx,
                     double *dz);

/* ---- what floats ---- */

typedef struct ll_buoy {          /* a box held over (x, z), free to heave, pitch and roll */
    double x, z;                  /* m */
    double width, length, height; /* m along x, z and y */
    double density;               /* of the box over that of water, below 1 */
    double drag;                  /* 1/s: of its speed against the water's surface */
    double y, speed;              /* of its middle */
    double pitch, pitch_rate;     /* about z: its right end up */
    double roll, roll_rate;       /* about x: its far end up */
} ll_buoy;

/* One step of `dt` seconds over the surface that was evaluated last, the surface's speed taken as 0. */
void ll_buoy_step(ll_buoy *b, const ll_ocean *o, double dt);
