#define LL_GEOMETRY ll_particle_geometry_base
#include "fluid/particle/geometry.inc"

void ll_particle_geometry(ll_particles *p, int32_t from, int32_t to)
{
#if defined(__x86_64__)
    bool avx2 = __builtin_cpu_supports("avx2");
#else
    bool avx2 = false;
#endif
    (avx2 ? ll_particle_geometry_avx2 : ll_particle_geometry_base)(p, from, to);
}
