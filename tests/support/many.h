#ifndef LAGLAB_TESTS_MANY_H
#define LAGLAB_TESTS_MANY_H

#include <stdbool.h>
#include <string.h>

/* `test_ROOM GROUP many`: the group with all of what it otherwise samples, or for longer. A test of tier all
 * (tests_of_many in cmake/tests.cmake). */
static inline bool ll_test_many(int count, char **arguments)
{
    return count > 1 && strcmp(arguments[1], "many") == 0;
}

#endif
