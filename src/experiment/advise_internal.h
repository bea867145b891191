/* For the files of the adviser: what is known of each setting while it searches. */
#pragma once

#include <math.h>

#include "experiment/advise.h"
#include "experiment/surrogate.h"
#include "experiment/table.h"

struct cJSON;

enum { COST, ERROR };

typedef enum ll_trial_state {
    UNTRIED,
    OPEN,      /* more seeds may tell */
    UNCLEAR,   /* it holds over all its repeats, so near the limit that this may be luck */
    HOPELESS,  /* open, but its one seed was far above the limit */
    HOLDS,     /* over all its repeats */
    VERIFIED,  /* on fresh seeds: so does the upper bound of its mean */
    RULED_OUT, /* `why` */
} ll_trial_state;

typedef struct ll_trial {
    int64_t runs, failed;
    ll_sums own[2], fresh[2]; /* cost and error by magnitude, over the repeats and over fresh seeds */
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
    int64_t kept; /* of them for verifying the best */
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

/* Costs less, or as much with less error. */
static inline bool beats(const ll_trial *a, const ll_trial *b)
{
    double x = a->own[COST].mean, y = b->own[COST].mean;
    if (fabs(x - y) > 1e-12 * fmax(x, y))
        return x < y;
    return a->own[ERROR].mean < b->own[ERROR].mean;
}

/* Whether nothing random reaches the setting: fresh seeds give what the others gave. Where events may be
 * rare, equal counts say little. */
bool ll_advise_is_certain(const ll_advise_search *s, const ll_trial *t);

/* By how much the mean over fresh seeds may be off. */
double ll_advise_doubt(const ll_advise_search *s, const ll_trial *t);

/* The answer of advise.h. */
struct cJSON *ll_advise_answer(const ll_advise_search *s, bool proven);
