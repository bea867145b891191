/* What became of a player's inputs, and of the predictions that were made with them.
 *
 * The observer's: it sees what the link lost and how the server judged, which a client learns in part and
 * late or not at all. Rates and sums count from the instruments' `from` on; inputs and their verdicts always.
 */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vtime.h"
#include "netcode/protocol/running_stats.h"

#define LL_INPUT_HISTORY_RING                                                                                \
    512 /* inputs, by sequence number; one that is open when so many more are made is lost */

/* The one final verdict of an input. At any time made = the sum of all six. */
typedef enum ll_input_result_kind {
    LL_INPUT_IS_OPEN,
    LL_INPUT_WAS_APPLIED,
    LL_INPUT_WAS_REFUSED, /* against a rule: something else was applied in its place, or nothing */
    LL_INPUT_CAME_LATE,   /* its step was over when it came; until then it is lost */
    LL_INPUT_WAS_LOST,    /* its step is over and it has not come; or it is void, its epoch being over */
    LL_INPUT_VERDICTS,
} ll_input_result_kind;

/* What is known of one input on its way. */
typedef enum ll_input_history_mark {
    LL_INPUT_HISTORY_WENT = 1,         /* at least one packet that holds it was not lost */
    LL_INPUT_HISTORY_IN_TIME = 2,      /* taken for its step, or to be applied at the next update */
    LL_INPUT_HISTORY_LATE = 4,         /* came after its step */
    LL_INPUT_HISTORY_REFUSED = 8,      /* against a rule */
    LL_INPUT_HISTORY_AS_IT_COMES = 16, /* it has no step of its own */
} ll_input_history_mark;

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

typedef struct ll_input_history_entry {
    int64_t
        tick; /* the server's step that it is meant for, or that applied it. Of one that is applied as it
                 comes, while it is open, a time: when the last of its packets arrives that was not lost */
    uint32_t seq;
    uint8_t marks;   /* ll_input_history_mark */
    uint8_t verdict; /* ll_input_result_kind */
    uint8_t reserved[2];
} ll_input_history_entry;

typedef struct ll_input_history {
    ll_input_history_entry input[LL_INPUT_HISTORY_RING];
    int64_t count[LL_INPUT_VERDICTS]; /* by verdict */
    int64_t made;
    uint32_t newest; /* made last in this epoch; 0: none */
    uint32_t open;   /* no input before this one is open */
    struct {
        int64_t count;
        double sum, max; /* m */
    } corrections[LL_CAUSES];
    int64_t replays, replayed; /* M14: reconciliations that applied inputs again, and how many */
    int64_t applied, skipped;  /* as the client takes them */
    int64_t wrong;             /* taken as applied, and the state is without */
    ll_running_stats slack;    /* M9: ticks that inputs came before they were needed */
    ll_running_stats scale;    /* M9: of the client's frames; 1 where they have their own length */
    int64_t late, doubled, left_out;
    int64_t starved_before; /* of the seat's count, those that do not count */
} ll_input_history;

#pragma GCC diagnostic pop

/* Input `seq`; NULL when it is not of this epoch or too old to be known. */
static inline ll_input_history_entry *ll_input_history_find(ll_input_history *input_history, uint32_t seq)
{
    ll_input_history_entry *input = &input_history->input[seq & (LL_INPUT_HISTORY_RING - 1)];
    return seq != 0 && seq <= input_history->newest && input->seq == seq ? input : NULL;
}

static inline uint8_t ll_input_history_marks(ll_input_history *input_history, uint32_t seq)
{
    const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    return input ? input->marks : 0;
}

/* Input `seq`, the newest, was made for the server's step `tick`; LL_NEVER: it is applied as it comes. */
void ll_input_history_made(ll_input_history *input_history, uint32_t seq, int64_t tick);

/* A packet with inputs was put on its way and is `due`. */
void ll_input_history_went(ll_input_history *input_history, uint32_t first, uint32_t count, ll_time due);

/* It was taken (IN_TIME), refused, or came late; what is refused may have come late, too. */
void ll_input_history_judged(ll_input_history *input_history, uint32_t seq, ll_input_history_mark mark);

/* The server has made `step`: inputs that were meant for it or for one before it are decided. */
void ll_input_history_stepped(ll_input_history *input_history, int64_t step);

/* The same where the server applies inputs as they come: all that came are applied. Of the others those up to
 * `unsent_from` - 1, which their client sends no more, are lost when nothing of them is on its way. */
void ll_input_history_drained(ll_input_history *input_history, int64_t step, uint32_t unsent_from,
                              ll_time now);

/* The open ones of inputs `first` to `last` will never be applied. */
void ll_input_history_never(ll_input_history *input_history, uint32_t first, uint32_t last);

/* A new epoch: what was open is void, and numbers begin anew. */
void ll_input_history_meet(ll_input_history *input_history);

/* The state after step `tick` really includes the input. */
bool ll_input_history_includes(ll_input_history *input_history, uint32_t seq, int64_t tick);

/* On the word of the state after step `tick` the client takes an input as applied, or as skipped. */
void ll_input_history_closed(ll_input_history *input_history, uint32_t seq, bool applied, int64_t tick);

/* What must have gone wrong with the inputs `first` to `last`: LL_CAUSE_OTHER when all were applied. */
ll_cause ll_input_history_blame(ll_input_history *input_history, uint32_t first, uint32_t last);

void ll_input_history_correction(ll_input_history *input_history, ll_cause cause, double size);
