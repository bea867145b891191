#ifdef __SSE2__
#define LL_WIDE 2
#else
#define LL_WIDE 1
#endif
#define LOOPS ll_soft_sse2
#define NAME "sse2"
#include "rigid/solver/soft_loops.inc"
