#define LL_GEOMETRY ll_particle_geometry_base
#include "fluid/particle/geometry.inc"

ll_particle_pair_geometry ll_particle_geometry_of(const ll_particles *p, int32_t a, int32_t b)
{
    const double *x = ll_particle_values(p, LL_PARTICLE_X), *y = ll_particle_values(p, LL_PARTICLE_Y);
    ll_particle_pair_geometry g = {.ex = x[a] - x[b], .ey = y[a] - y[b]};
    if (p->setup.periodic)
        g.ex = ll_particle_shortest(g.ex, p->wrap / 2, p->wrap);
    double per_h = 1 / p->kernel.h, q = __builtin_sqrt(g.ex * g.ex + g.ey * g.ey) * per_h, s = 1 - q / 2;
    s = 0.5 * (s + __builtin_fabs(s));
    double cube = s * s * s;
    g.slope = p->kernel.slope_scale * cube;
    g.kernel = p->kernel.scale * cube * s * (2 * q + 1);
    return g;
}

void ll_particle_geometry(ll_particles *p, int32_t from, int32_t to)
{
#if defined(__x86_64__)
    bool avx2 = __builtin_cpu_supports("avx2");
#else
    bool avx2 = false;
#endif
    (avx2 ? ll_particle_geometry_avx2 : ll_particle_geometry_base)(p, from, to);
}
