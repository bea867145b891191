/* Interrupts a long computation: every millisecond or so it asks whether to go on. The callback may wait, so
 * no lock may be held. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct ll_interrupt {
    bool (*go_on)(void *context); /* false: stop now */
    int64_t (*now_ns)(void);      /* a steady clock, to measure pieces */
    void *context;
} ll_interrupt;

/* Size of pieces, in any unit of work. Starts as {1}. */
typedef struct ll_piece {
    int64_t size, began;
} ll_piece;

/* Asks (NULL: always goes on), and adjusts the size of the next piece to the time that the last one took. */
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

/* The same inside of a computation whose rounds are short: it asks each time, and calls the
 * interrupt now and then. The result of a computation that was broken off is of no use. NULL is never broken
 * off. */
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

/* `first`: rounds before it asks for the first time. Reading a clock costs as much as a short round: rounds
 * that surely take less than a millisecond together need no question. */
static inline ll_pace ll_pace_by(const ll_interrupt *interrupt, int first)
{
    return (ll_pace){.interrupt = interrupt, .piece = {first, 0}, .left = first};
}

static inline bool ll_broken_off(const ll_pace *pace)
{
    return pace && pace->broken;
}
