/* Only this file is compiled for AVX2; particle_geometry.c checks the CPU before it calls it. */
#define LL_GEOMETRY ll_particle_geometry_avx2
#include "fluid/particle_geometry.inc"
