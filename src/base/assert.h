/* Asserts of two levels.
 *
 * LL_ASSERT is cheap and stays on in release builds: a broken invariant stops the program at its cause.
 * LL_VALIDATE is on in debug builds and under the sanitizers only: it calls a whole-structure check, or
 * states an invariant within a loop where a test would cost time. */
#pragma once

#include <stdbool.h>

_Noreturn void ll_assert_failed(const char *expression, const char *file, int line);

#define LL_ASSERT(expression) ((expression) ? (void)0 : ll_assert_failed(#expression, __FILE__, __LINE__))

#ifdef LAGLAB_VALIDATE
#define LL_VALIDATE(expression) LL_ASSERT(expression)
#else
#define LL_VALIDATE(expression) ((void)0)
#endif
