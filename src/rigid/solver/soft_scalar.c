#define LL_WIDE 1
#define LOOPS ll_soft_scalar
#define NAME "scalar"
#include "rigid/solver/soft_loops.inc"
