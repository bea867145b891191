#ifndef LAGLAB_TESTS_STRIDE_H
#define LAGLAB_TESTS_STRIDE_H

/* Of many like cases a test takes each LL_TEST_STRIDE-th: all of them, but under the sanitizers. These look
 * for errors of memory and arithmetic, in five to twenty times the time; the numbers are checked by the
 * release build. */
#ifdef LAGLAB_VALIDATE
enum { LL_TEST_STRIDE = 4 };
#else
enum { LL_TEST_STRIDE = 1 };
#endif

#endif
