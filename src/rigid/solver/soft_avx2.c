/* The build compiles this file alone for AVX2; soft_step.c asks the CPU before it calls into it. */
#ifdef __AVX2__
#define LL_WIDE 4
#else
#define LL_WIDE 1
#endif
#define LOOPS ll_soft_avx2
#define NAME "avx2"
#include "rigid/solver/soft_loops.inc"
