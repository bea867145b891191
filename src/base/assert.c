#include "base/assert.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

/* Not by stderr: the only variable of libc that the engine would name, and a shared library of objects that
 * were compiled for a program could not (cmake/library.cmake). */
_Noreturn void ll_assert_failed(const char *expression, const char *file, int line)
{
    dprintf(STDERR_FILENO, "%s:%d: broken invariant: %s\n", file, line, expression);
    abort();
}
