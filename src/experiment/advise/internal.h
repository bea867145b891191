/* For the files of the adviser: what is known of each setting while it searches. */
#pragma once

#include <math.h>

#include "experiment/advise/advise.h"
#include "experiment/advise/surrogate.h"
#include "experiment/format/table.h"

struct cJSON;

enum { COST, ERROR };

enum { LL_ADVISE_FRESH_MOST = 512 }; /* seeds that no search has seen, for one setting */

typedef enum ll_trial_state {
    UNTRIED,
    OPEN,      /* more seeds may tell */
    UNCLEAR,   /* over all its repeats so near the limit that it may hold, or may not */
    HOPELESS,  /* open, but its one seed was far above the limit */
    HOLDS,     /* over all its repeats */
    VERIFIED,  /* on fresh seeds: so does the upper bound of its mean */
    RULED_OUT, /* `why` */
} ll_trial_state;

/* Cost and error of each run by magnitude, in the order of seeds. */
typedef struct ll_values {
    double (*of)[2];
    int64_t n, room;
} ll_values;

typedef struct ll_trial {
    int64_t runs, failed, lacking; /* `lacking` of those that failed ended well, without error or cost */
    ll_sums own[2], fresh[2];      /* cost and error by magnitude, over the repeats and over fresh seeds */
    ll_values own_values, fresh_values;
    ll_trial_state state;
    const char *why;
} ll_trial;

typedef struct ll_advise_search {
    const ll_advise_request *order;
    const ll_experiment *experiment;
    ll_experiment fresh; /* the same with more repeats: their seeds are those behind the experiment's */
    ll_surrogate *surrogate;
    ll_trial *trials; /* by point */
    int points;
    int best; /* cheapest that holds, verified or not; -1: none does */
    int64_t runs, most;
    int64_t kept;   /* of them for verifying what was found */
    double scatter; /* of the error between seeds, relative, over all that was run */
    double burst;   /* how many events come at once, where the error counts them; at least 1 */
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

/* The cheapest of those that are wanted, by their differences to the one with most runs; -1: there is none.
 */
int ll_advise_cheapest(const ll_advise_search *s, bool wanted(const ll_trial *t));
static inline bool ll_advise_is_verified(const ll_trial *t)
{
    return t->state == VERIFIED;
}

/* By how much it costs more, seed by seed. */
ll_sums ll_advise_apart(const ll_trial *a, const ll_trial *b);

/* Whether it costs more, by the 95 % interval of the differences seed by seed. */
bool ll_advise_is_dearer(const ll_trial *a, const ll_trial *b);

/* Whether two settings gave the same at every seed that both have run, by which nothing tells them apart. */
bool ll_advise_is_twin(const ll_trial *a, const ll_trial *b);

/* By how much, as a logarithm, the mean over a setting's seeds so far is below that over all repeats, as
 * others show that have run them all. */
double ll_advise_shift(const ll_advise_search *s, const ll_trial *t, int output);

/* One run more, of a fresh seed or of the repeats. */
ll_status ll_advise_run(ll_advise_search *s, int point, bool fresh);

void ll_advise_rule_out(ll_trial *t, const char *why);
bool ll_advise_is_unsure(const ll_trial *t); /* it may hold after all, and more fresh seeds there are not */
extern const char ll_advise_unsure[];        /* the reason of those */

/* Half of the 95 % interval of the mean over the repeats. The variance of few runs is moderated by how errors
 * scatter elsewhere; counts are no surer than Poisson's. */
double ll_advise_half(const ll_advise_search *s, const ll_trial *t);

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

/* The chance that the true mean is within the limit, by all seeds of the setting; and how many fresh ones
 * more may show it if it is as small as it may well be. */
double ll_advise_chance(const ll_advise_search *s, const ll_trial *t);
double ll_advise_price(const ll_advise_search *s, const ll_trial *t);
double ll_advise_next(const ll_advise_search *s, const ll_trial *t);

/* Whether a setting holds so surely over its repeats that it is worth to verify it. */
bool ll_advise_is_clear(const ll_advise_search *s, const ll_trial *t);

void ll_advise_free_trials(ll_advise_search *s);

/* The next fresh seeds of a setting, and what they show. */
ll_status ll_advise_verify(ll_advise_search *s, int point);

/* The answer of advise.h. */
struct cJSON *ll_advise_answer(const ll_advise_search *s, bool proven);
