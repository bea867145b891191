/* Results of a player's inputs, and of the predictions that were made with them.
 *
 * Kept by the observer: it sees which packets the link lost and how the server decided, which a client learns
 * in part, late or never. Rates and sums count from `from` of the metrics on; inputs and their results always
 * count. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vtime.h"
#include "netcode/protocol/running_stats.h"

/* inputs, by sequence number; an open input counts as lost when this many more are made */
#define LL_INPUT_HISTORY_RING 512

/* The final result of an input. At any time the number of inputs made equals the sum of all six. */
typedef enum ll_input_result_kind {
    LL_INPUT_IS_OPEN,
    LL_INPUT_WAS_APPLIED,
    LL_INPUT_WAS_REFUSED, /* against a rule: the server applied something else in its place, or nothing */
    LL_INPUT_CAME_LATE,   /* its step was over when it arrived; before it arrives it counts as lost */
    LL_INPUT_WAS_LOST,    /* its step is over and it has not arrived; or its epoch is over */
    LL_INPUT_RESULT_KINDS,
} ll_input_result_kind;

/* What is known of one input on its way. */
typedef enum ll_input_history_flag {
    LL_INPUT_HISTORY_SENT = 1,        /* at least one packet that holds it was not lost */
    LL_INPUT_HISTORY_IN_TIME = 2,     /* taken for its step, or to be applied at the next update */
    LL_INPUT_HISTORY_LATE = 4,        /* came after its step */
    LL_INPUT_HISTORY_REFUSED = 8,     /* against a rule */
    LL_INPUT_HISTORY_ON_ARRIVAL = 16, /* it has no step of its own */
} ll_input_history_flag;

/* Cause of a correction of the own entity. Of several causes between two snapshots the first of these
 * counts. */
typedef enum ll_cause {
    LL_CAUSE_REFUSED, /* the server refused an input */
    LL_CAUSE_LATE,    /* an input arrived after its step or is still on its way, or none was made for it */
    LL_CAUSE_LOSS,    /* every packet that held an input was lost */
    LL_CAUSE_CONTACT, /* all inputs were applied, and other entities could act on the own one */
    LL_CAUSE_OTHER,   /* none of these; and every correction where reconciliation is off */
    LL_CAUSES,
} ll_cause;

extern const char *const ll_cause_names[LL_CAUSES];

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded" /* no padding: the block is hashed */

typedef struct ll_input_history_entry {
    int64_t tick; /* the server's step that it is meant for, or that applied it. Where inputs are applied on
                     arrival, while open: time at which its last packet that was not lost arrives */
    uint32_t seq;
    uint8_t flags;  /* ll_input_history_flag */
    uint8_t result; /* ll_input_result_kind */
    uint8_t reserved[2];
} ll_input_history_entry;

typedef struct ll_input_history {
    ll_input_history_entry input[LL_INPUT_HISTORY_RING];
    int64_t count[LL_INPUT_RESULT_KINDS]; /* by result: their sum is the number made */
    uint32_t newest;                      /* made last in this epoch; 0: none */
    uint32_t open;                        /* no input before this one is open */
    struct {
        int64_t count;
        double sum, max; /* m */
    } corrections[LL_CAUSES];
    int64_t replays, replayed; /* reconciliations that applied inputs again; inputs applied again */
    int64_t applied, skipped;  /* as the client takes them */
    int64_t wrong;             /* taken as applied, but the snapshot does not include them */
    ll_running_stats slack;    /* input slack: ticks that inputs arrived before they were needed */
    ll_running_stats scale;    /* time dilation of the client's frames; 1 at their own length */
    int64_t late, doubled, left_out;
    int64_t starved_before; /* part of the client slot's count from before `from` */
} ll_input_history;

#pragma GCC diagnostic pop

/* Input `seq`; NULL if it is not of this epoch or too old. The ring has no input newer than the newest. */
static inline ll_input_history_entry *ll_input_history_find(ll_input_history *input_history, uint32_t seq)
{
    ll_input_history_entry *input = &input_history->input[seq & (LL_INPUT_HISTORY_RING - 1)];
    return input->seq == seq && seq != 0 ? input : NULL;
}

static inline int64_t ll_input_history_made_count(const ll_input_history *input_history)
{
    int64_t made = 0;
    for (int i = 0; i < LL_INPUT_RESULT_KINDS; i++)
        made += input_history->count[i];
    return made;
}

static inline uint8_t ll_input_history_flags(ll_input_history *input_history, uint32_t seq)
{
    const ll_input_history_entry *input = ll_input_history_find(input_history, seq);
    return input ? input->flags : 0;
}

/* Input `seq`, the newest, was made for the server's step `tick`; LL_NEVER: it is applied on arrival. */
void ll_input_history_made(ll_input_history *input_history, uint32_t seq, int64_t tick);

/* A packet with inputs was sent and arrives at `due`. */
void ll_input_history_sent(ll_input_history *input_history, uint32_t first, uint32_t count, ll_time due);

/* The server accepted the input (IN_TIME), refused it, or received it late; a refused input may also be
 * late. */
void ll_input_history_received(ll_input_history *input_history, uint32_t seq, ll_input_history_flag flag);

/* The server has made `step`: inputs for it and for earlier steps are decided. */
void ll_input_history_stepped(ll_input_history *input_history, int64_t step);

/* The same where the server applies inputs on arrival: all that have arrived are applied. Of the others,
 * those before `unsent_from`, which their client no longer sends, are lost if none of their packets is on its
 * way. */
void ll_input_history_applied(ll_input_history *input_history, int64_t step, uint32_t unsent_from,
                              ll_time now);

/* The open inputs among `first` to `last` will never be applied. */
void ll_input_history_never(ll_input_history *input_history, uint32_t first, uint32_t last);

/* A new epoch: open inputs are discarded, and sequence numbers start again. */
void ll_input_history_resync(ll_input_history *input_history);

/* Whether the state after step `tick` includes the input. */
bool ll_input_history_includes(ll_input_history *input_history, uint32_t seq, int64_t tick);

/* According to the snapshot after step `tick`, the client takes an input as applied, or as skipped. */
void ll_input_history_closed(ll_input_history *input_history, uint32_t seq, bool applied, int64_t tick);

/* The cause of a misprediction with the inputs `first` to `last`: LL_CAUSE_OTHER if all were applied. */
ll_cause ll_input_history_blame(ll_input_history *input_history, uint32_t first, uint32_t last);

void ll_input_history_correction(ll_input_history *input_history, ll_cause cause, double size);
