/* The build compiles this file alone for AVX2; trace.c asks the CPU before it calls into it. */
#define LL_TRACING ll_grid_tracing_avx2
#include "fluid/grid/trace.inc"
