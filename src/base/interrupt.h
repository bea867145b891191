/* How a computation that may take long is broken off from outside: it asks between pieces of about a
 * millisecond whether it may go on. Who is asked may also let it wait, so nothing may be locked meanwhile. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ll_interrupt {
    bool (*go_on)(void *context); /* false: end now */
    int64_t (*now_ns)(void);      /* a steady clock, by which pieces are measured */
    void *context;
} ll_interrupt;

/* The size of pieces, in whatever they count. Begins as {1}. */
typedef struct ll_piece {
    int64_t size, began;
} ll_piece;

/* Asks (NULL is never broken off), and makes the next piece larger or smaller as the last was short or long.
 */
static inline bool ll_next_piece(ll_piece *piece, const ll_interrupt *interrupt)
{
    enum { SHORT_NS = 500000, LONG_NS = 2000000 };
    if (!interrupt) {
        piece->size = INT32_MAX;
        return true;
    }
    int64_t took = piece->began ? interrupt->now_ns() - piece->began : SHORT_NS;
    if (took < SHORT_NS && piece->size < INT32_MAX / 2)
        piece->size *= 2;
    else if (took > LONG_NS && piece->size > 1)
        piece->size /= 2;
    bool more = interrupt->go_on(interrupt->context);
    piece->began = interrupt->now_ns();
    return more;
}
