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

/* The same inside of a computation whose rounds are short: it asks each time, and somebody else is asked now
 * and then. What was broken off is of no use. NULL is never broken off. */
typedef struct ll_pace {
    const ll_interrupt *interrupt;
    ll_piece piece;
    int64_t left; /* rounds of the piece */
    bool broken;
} ll_pace;

static inline bool ll_goes_on(ll_pace *pace)
{
    enum { MOST = 32 }; /* rounds are of many lengths */
    if (!pace || !pace->interrupt)
        return true;
    if (pace->broken || --pace->left > 0)
        return !pace->broken;
    pace->broken = !ll_next_piece(&pace->piece, pace->interrupt);
    if (pace->piece.size > MOST)
        pace->piece.size = MOST;
    pace->left = pace->piece.size;
    return !pace->broken;
}

static inline ll_pace ll_pace_by(const ll_interrupt *interrupt)
{
    return (ll_pace){.interrupt = interrupt, .piece = {1, 0}};
}

static inline bool ll_broken_off(const ll_pace *pace)
{
    return pace && pace->broken;
}
