/* The build compiles this file alone for AVX2; geometry.c asks the CPU before it calls into it. */
#define LL_GEOMETRY ll_particle_geometry_avx2
#include "fluid/particle/geometry.inc"
