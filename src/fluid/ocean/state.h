/* The block of an ocean, for the files of this module. */
#pragma once

#include "fluid/core/fft.h"
#include "fluid/ocean/ocean.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is copied whole */

struct ll_ocean {
    ll_ocean_setup setup;
    int64_t at_height, at_dx, at_dz; /* doubles: n x n each */
    int64_t at_method;               /* data of the method */
    int64_t at_end;
};

#pragma GCC diagnostic pop

static inline void *ll_ocean_part(const ll_ocean *o, int64_t offset)
{
    return (char *)(uintptr_t)o + offset;
}

typedef struct ll_ocean_method {
    size_t (*size)(const ll_ocean_setup *setup); /* of its part of the block */
    void (*init)(ll_ocean *o);
    void (*evaluate)(ll_ocean *o, ll_time t);
} ll_ocean_method;

/* An ocean by this method; the method that the setup names is ignored: size of its block, and the block at
 * time 0. */
size_t ll_ocean_size_by(const ll_ocean_method *method, const ll_ocean_setup *setup);
ll_ocean *ll_ocean_init_by(const ll_ocean_method *method, void *block, const ll_ocean_setup *setup);

extern const ll_ocean_method ll_ocean_gerstner, ll_ocean_spectrum, ll_ocean_tiled;

/* Wave of vector k = 2 pi / length (mx, mz), without amplitude and phase. */
ll_wave ll_wave_of(const ll_ocean_setup *setup, int64_t mx, int64_t mz);
double ll_wave_angle(const ll_ocean_setup *setup, const ll_wave *w, ll_time t); /* w t, modulo whole turns */

/* Pierson and Moskowitz's spectrum (J. Geophys. Res. 69, 1964) over angular frequency, m^2 s. */
double ll_ocean_energy(const ll_ocean_setup *setup, double frequency);
