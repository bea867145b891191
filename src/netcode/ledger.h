/* What became of a player's inputs, and of the predictions that were made with them.
 *
 * The observer's: it sees what the link lost and how the server judged, which a client learns in part and
 * late or not at all. Rates and sums count from the instruments' `from` on; `fate` is kept always. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "netcode/gauge.h"

#define LL_LEDGER_RING 512 /* inputs, by sequence number; more than a client keeps open */

/* What is known of one input. */
typedef enum ll_ledger_mark {
    LL_LEDGER_WENT = 1,    /* at least one packet that holds it was not lost */
    LL_LEDGER_IN_TIME = 2, /* taken for its step, or to be applied at the next update */
    LL_LEDGER_LATE = 4,    /* came after its step */
    LL_LEDGER_REFUSED = 8, /* against a rule */
} ll_ledger_mark;

/* Why a state corrected the own entity (M6). Of several reasons between two states the first of these counts.
 */
typedef enum ll_cause {
    LL_CAUSE_REFUSED, /* the server refused an input */
    LL_CAUSE_LATE,    /* an input came after its step, or is still on its way; or none was made for it */
    LL_CAUSE_LOSS,    /* every packet that held an input was lost */
    LL_CAUSE_CONTACT, /* all inputs were applied, and others could act on the entity */
    LL_CAUSE_OTHER,   /* none of these; and every correction where reconciliation is off */
    LL_CAUSES,
} ll_cause;

extern const char *const ll_cause_names[LL_CAUSES];

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* the block is hashed: no byte may be left to chance */

typedef struct ll_ledger {
    uint8_t fate[LL_LEDGER_RING];
    uint16_t step[LL_LEDGER_RING]; /* low bits of the server's first step that could apply it */
    struct {
        int64_t count;
        double sum, max; /* m */
    } corrections[LL_CAUSES];
    int64_t replays, replayed; /* M14: reconciliations that applied inputs again, and how many */
    int64_t applied, skipped;  /* as the client takes them */
    int64_t wrong;             /* taken as applied, and the state is without */
    ll_gauge slack;            /* M9: ticks that inputs came before they were needed */
    ll_gauge scale;            /* M9: of the client's frames; 1 where they have their own length */
    int64_t late, doubled, left_out;
    int64_t starved_before; /* of the seat's count, those that do not count */
} ll_ledger;

#pragma GCC diagnostic pop

static inline uint8_t *ll_ledger_fate(ll_ledger *ledger, uint32_t seq)
{
    return &ledger->fate[seq & (LL_LEDGER_RING - 1)];
}

/* On the word of the state after step `tick` the client takes an input as applied, or as skipped. */
void ll_ledger_closed(ll_ledger *ledger, uint32_t seq, bool applied, int64_t tick);

/* What must have gone wrong with the inputs `first` to `last`: LL_CAUSE_OTHER when all were applied. */
ll_cause ll_ledger_blame(ll_ledger *ledger, uint32_t first, uint32_t last);

void ll_ledger_correction(ll_ledger *ledger, ll_cause cause, double size);
