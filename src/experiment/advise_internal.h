/* For the files of the adviser: what is known of each setting while it searches. */
#pragma once

#include <math.h>

#include "experiment/advise.h"
#include "experiment/surrogate.h"
#include "experiment/table.h"

struct cJSON;

enum { COST, ERROR };

enum { LL_ADVISE_FRESH_MOST = 256 }; /* seeds that no search has seen, for one setting */

typedef enum ll_trial_state {
    UNTRIED,
    OPEN,      /* more seeds may tell */
    UNCLEAR,   /* it holds over all its repeats, so near the limit that this may be luck */
    HOPELESS,  /* open, but its one seed was far above the limit */
    HOLDS,     /* over all its repeats */
    VERIFIED,  /* on fresh seeds: so does the upper bound of its mean */
    RULED_OUT, /* `why` */
} ll_trial_state;

enum { LL_ADVISE_LEVELS = 18 }; /* powers of 2 up to the most repeats */

typedef struct ll_trial {
    int64_t runs, failed, lacking; /* `lacking` of those that failed ended well, without error or cost */
    ll_sums own[2], fresh[2];      /* cost and error by magnitude, over the repeats and over fresh seeds */
    double first[LL_ADVISE_LEVELS][2]; /* their means over the first 1, 2, 4, ... repeats */
    ll_trial_state state;
    const char *why;
} ll_trial;

typedef struct ll_advise_search {
    const ll_advice_order *order;
    const ll_experiment *experiment;
    ll_experiment fresh; /* the same with more repeats: their seeds are those behind the experiment's */
    ll_surrogate *surrogate;
    ll_trial *trials; /* by point */
    int points;
    int best; /* cheapest that holds, verified or not; -1: none does */
    int64_t runs, most;
    int64_t kept;   /* of them for verifying what was found */
    double scatter; /* of the error between seeds, relative, over all that was run */
    /* Of single runs whose error is above 0: the largest and the least, and what all are multiples of. */
    double largest, least, event;
} ll_advise_search;

/* Half of the 95 % interval; nothing is known of it before the second seed. */
static inline double half(const ll_sums *sums)
{
    return sums->n > 1 ? ll_interval_95(sums->n, sums->squares) : INFINITY;
}

/* Seeds that all give the same tell nothing of how far off that is. */
static inline bool has_interval(const ll_sums *sums)
{
    return sums[ERROR].n > 1 && (sums[ERROR].squares > 0 || sums[COST].squares > 0);
}

/* Costs less, or as much with less error. Settings share their seeds: means are taken over the same ones. */
bool ll_advise_beats(const ll_trial *a, const ll_trial *b);

/* By how much, as a logarithm, the mean over a setting's seeds so far is below that over all repeats, as
 * others show that have run them all. */
double ll_advise_shift(const ll_advise_search *s, const ll_trial *t, int output);

/* One run more, of a fresh seed or of the repeats. */
ll_status ll_advise_run(ll_advise_search *s, int point, bool fresh);

void ll_advise_rule_out(ll_trial *t, const char *why);
bool ll_advise_is_unsure(const ll_trial *t); /* it may hold after all */

/* Of all seeds of a setting. */
ll_sums ll_advise_pooled(const ll_trial *t);

/* Whether nothing random reaches the setting: fresh seeds give what the others gave. Where events may be
 * rare, equal counts say little. */
bool ll_advise_is_certain(const ll_advise_search *s, const ll_trial *t);

/* By how much the mean over fresh seeds may be off: half of the 95 % interval, or what bounds events of which
 * few were seen, or none. */
double ll_advise_doubt(const ll_advise_search *s, const ll_trial *t);

/* Fresh seeds after which the upper bound is below the limit, by how errors scatter; and how many come next.
 */
double ll_advise_needed(const ll_advise_search *s, const ll_trial *t);
double ll_advise_next(const ll_advise_search *s, const ll_trial *t);

/* Whether a setting holds so surely over its repeats that it is worth to verify it. */
bool ll_advise_is_clear(const ll_advise_search *s, const ll_trial *t);

/* The next fresh seeds of a setting, and what they show. */
ll_status ll_advise_verify(ll_advise_search *s, int point);

/* The answer of advise.h. */
struct cJSON *ll_advise_answer(const ll_advise_search *s, bool proven);
