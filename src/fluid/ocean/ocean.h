/* Surface of an ocean: m, s. Three methods fill the same grid of points: a sum of Gerstner waves,
 * Tessendorf's spectrum by FFT, and a small tile of it that is repeated in space and in a loop.
 *
 * Water is described in the plane (x, z) with heights along y. A point at rest (x, z) is displaced to (x +
 * dx, height, z + dz), for one wave of amplitude A and wave vector k by
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

/* Names, ranges and defaults: ll_ocean_table. */
typedef struct ll_ocean_setup {
    double length;     /* m */
    double depth;      /* m; 0: infinite */
    double gravity;    /* m/s^2 */
    double wind_speed; /* m/s, 19.5 m above the water */
    double wind_angle; /* rad, from x towards z */
    double choppiness; /* scale of the horizontal displacement */
    double loop_s;     /* all frequencies are rounded to multiples of 1 / loop_s; 0: not rounded */
    int64_t seed;
    int64_t n;      /* points per side: 2^a 3^b 5^c, even */
    int64_t waves;  /* of gerstner */
    int64_t tile;   /* points per side of the tile of tiled; divides n */
    int64_t frames; /* of tiled, per loop */
    int32_t method; /* ll_ocean_method_kind */
    int32_t reserved;
} ll_ocean_setup;

extern const ll_param_table ll_ocean_table;

double ll_ocean_frequency(double k, double gravity, double depth); /* dispersion relation, rad/s */

/* Fractions of the wind's energy in waves longer than the box (for `tiled`: the tile) and shorter than two of
 * its cells; significant height of the whole spectrum (Pierson and Moskowitz 1964). */
typedef struct ll_ocean_fit {
    double length; /* m: of the box or the tile */
    double peak;   /* m: wavelength at the spectrum's peak */
    double longer, shorter;
    double height; /* m */
} ll_ocean_fit;

ll_ocean_fit ll_ocean_fit_of(const ll_ocean_setup *setup);

ll_status ll_ocean_check(const ll_ocean_setup *setup); /* checks rules between rows */
size_t ll_ocean_size(const ll_ocean_setup *setup);     /* bytes of the block; setup must be checked */
ll_ocean *ll_ocean_init(void *block, const ll_ocean_setup *setup); /* aligned to 16 */

void ll_ocean_evaluate(ll_ocean *o, ll_time t); /* t >= 0 */

typedef struct ll_ocean_surface { /* rows of constant z: point (i, j) is [j * n + i], at spacing length / n */
    int64_t n;
    double length;
    const double *height, *dx, *dz;
} ll_ocean_surface;

ll_ocean_surface ll_ocean_surface_of(const ll_ocean *o);
const ll_ocean_setup *ll_ocean_setup_of(const ll_ocean *o);

/* Height of the displaced surface at (x, z), for the surface evaluated last. */
double ll_ocean_height_at(const ll_ocean *o, double x, double z);

typedef struct ll_wave {
    double kx, kz, k;        /* rad/m */
    double amplitude, phase; /* m, rad */
    double frequency;        /* rad/s */
    int64_t cycles;          /* per loop */
} ll_wave;

/* Waves of gerstner, for single points of a surface: `waves` has setup->waves elements. */
void ll_ocean_waves(const ll_ocean_setup *setup, ll_wave *waves);

typedef struct ll_ocean_point { /* a point of the water surface */
    double dx, dz, height;      /* m, displacement */
    double u, w, v;             /* m/s along x, z and y */
} ll_ocean_point;

/* Displacement and velocity at `t` of the point at rest at (x, z). */
ll_ocean_point ll_ocean_point_of(const ll_ocean_setup *setup, const ll_wave *waves, double x, double z,
                                 ll_time t);

/* Surface of spectrum at grid point (i, j), as a plain sum over all wave vectors: for tests. */
void ll_ocean_direct(const ll_ocean *o, ll_time t, int64_t i, int64_t j, double *height, double *dx,
                     double *dz);

/* ---- floating bodies ---- */

typedef struct ll_buoy {          /* a box held over (x, z), free to heave, pitch and roll */
    double x, z;                  /* m */
    double width, length, height; /* m along x, z and y */
    double density;               /* relative to water, below 1 */
    double drag;                  /* 1/s: drag of its speed relative to the surface */
    double y, speed;              /* of its centre */
    double pitch, pitch_rate;     /* about z: right end up */
    double roll, roll_rate;       /* about x: far end up */
} ll_buoy;

/* One step of `dt` seconds on the surface evaluated last, whose speed counts as 0. */
void ll_buoy_step(ll_buoy *b, const ll_ocean *o, double dt);
