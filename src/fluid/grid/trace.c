#define LL_TRACING ll_grid_tracing_base
#include "fluid/grid/trace.inc"

const ll_grid_tracing *ll_grid_tracing_here(void)
{
#if defined(__x86_64__)
    return __builtin_cpu_supports("avx2") ? &ll_grid_tracing_avx2 : &ll_grid_tracing_base;
#else
    return &ll_grid_tracing_base;
#endif
}
