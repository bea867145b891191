/* Heapsort of an array: n log n for every input, in place. */
#pragma once

#include <stdint.h>

/* Defines `static void name(type *at, int32_t count)`, ascending by `before(a, b)`, a strict order. */
#define LL_HEAP_SORT(name, type, before)                                                                     \
    static void name##_sift(type *at, int32_t root, int32_t count)                                           \
    {                                                                                                        \
        type value = at[root];                                                                               \
        for (int32_t child; (child = 2 * root + 1) < count; root = child) {                                  \
            if (child + 1 < count && before(at[child], at[child + 1]))                                       \
                child++;                                                                                     \
            if (!before(value, at[child]))                                                                   \
                break;                                                                                       \
            at[root] = at[child];                                                                            \
        }                                                                                                    \
        at[root] = value;                                                                                    \
    }                                                                                                        \
                                                                                                             \
    static void name(type *at, int32_t count)                                                                \
    {                                                                                                        \
        for (int32_t i = count / 2; i-- > 0;)                                                                \
            name##_sift(at, i, count);                                                                       \
        for (int32_t i = count; i-- > 1;) {                                                                  \
            type top = at[0];                                                                                \
            at[0] = at[i];                                                                                   \
            at[i] = top;                                                                                     \
            name##_sift(at, 0, i);                                                                           \
        }                                                                                                    \
    }
