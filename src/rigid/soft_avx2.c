/* Only this file is compiled for AVX2; solve_soft_step.c checks the CPU before it calls it. */
#ifdef __AVX2__
#define LL_WIDE 4
#else
#define LL_WIDE 1
#endif
#define LOOPS ll_soft_avx2
#define NAME "avx2"
#include "rigid/soft_loops.inc"
