/* For the files of the adviser: results of each setting during the search. */
#pragma once

#include <math.h>

#include "experiment/advise/advise.h"
#include "experiment/format/table.h"

struct cJSON;

enum { COST, ERROR };

enum { LL_ADVISE_FRESH_MAX = 512 }; /* maximum of fresh seeds for one setting */

typedef enum ll_trial_state {
    UNTRIED,
    OPEN,      /* more seeds may decide */
    UNCLEAR,   /* over all its repeats too close to the limit to decide */
    HOPELESS,  /* open, but its one seed was far above the limit */
    HOLDS,     /* over all its repeats */
    VERIFIED,  /* on fresh seeds: the upper bound of its mean holds too */
    RULED_OUT, /* reason: `why` */
} ll_trial_state;

/* Magnitudes of cost and error of each run, in order of seeds. */
typedef struct ll_values {
    double (*of)[2];
    int64_t n, room;
} ll_values;

typedef struct ll_trial {
    int64_t runs, failed, missing; /* `lacking`: failed runs that ended well, but without error or cost */
    ll_sums own[2], fresh[2];      /* magnitudes of cost and error, over the repeats and over fresh seeds */
    ll_values own_values, fresh_values;
    ll_trial_state state;
    const char *why;
} ll_trial;

typedef struct ll_advise_search {
    const ll_advise_request *request;
    const ll_experiment *experiment;
    ll_experiment fresh; /* the same with more repeats, whose seeds follow the experiment's */
    ll_trial *trials;    /* by point */
    int points;
    int best; /* cheapest that holds, verified or not; -1: none */
    int64_t runs, most;
    int64_t kept;   /* runs reserved for verification */
    double scatter; /* relative scatter of the error between seeds, over all runs */
    double burst;   /* events that come together, where the error counts them; at least 1 */
    /* Of single runs with an error above 0: the largest, the smallest, and their common divisor. */
    double largest, least, event;
} ll_advise_search;

/* Half width of the 95 % interval; infinite before the second seed. */
static inline double half(const ll_sums *sums)
{
    return sums->n > 1 ? ll_interval_95(sums->n, sums->squares) : INFINITY;
}

/* False when all seeds give the same: then the deviation from the true mean is unknown. */
static inline bool has_interval(const ll_sums *sums)
{
    return sums[ERROR].n > 1 && (sums[ERROR].squares > 0 || sums[COST].squares > 0);
}

/* Costs less, or the same with a smaller error. Settings share their seeds: means are taken over common
 * ones. */
bool ll_advise_beats(const ll_trial *a, const ll_trial *b);

/* The cheapest wanted setting, by differences to the one with most runs; -1: none. */
int ll_advise_cheapest(const ll_advise_search *s, bool wanted(const ll_trial *t));
static inline bool ll_advise_is_verified(const ll_trial *t)
{
    return t->state == VERIFIED;
}

/* Cost differences, seed by seed. */
ll_sums ll_advise_cost_difference(const ll_trial *a, const ll_trial *b);

/* Whether it costs more, by the 95 % interval of the differences by seed. */
bool ll_advise_costs_more(const ll_trial *a, const ll_trial *b);

/* Runs one more seed, a fresh one or one of the repeats. */
ll_status ll_advise_run(ll_advise_search *s, int point, bool fresh);

void ll_advise_rule_out(ll_trial *t, const char *why);
bool ll_advise_is_undecided(const ll_trial *t); /* it may hold, but no fresh seeds are left */
extern const char ll_advise_undecided[];        /* the reason for those */

/* Half width of the 95 % interval of the mean over the repeats. The variance of few runs is moderated by the
 * scatter of errors elsewhere; that of counts is at least Poisson's. */
double ll_advise_half_width(const ll_advise_search *s, const ll_trial *t);

/* Sums over all seeds of a setting. */
ll_sums ll_advise_all_sums(const ll_trial *t);

/* Whether nothing random affects the setting: fresh seeds give the same as the others. Where events may be
 * rare, equal counts are no evidence. */
bool ll_advise_is_certain(const ll_advise_search *s, const ll_trial *t);

/* Uncertainty of the mean over fresh seeds: half width of the 95 % interval, or a bound for few or no
 * events. */
double ll_advise_uncertainty(const ll_advise_search *s, const ll_trial *t);

/* Fresh seeds after which the upper bound should be below the limit, given the scatter of errors; and how
 * many to run next. */
double ll_advise_needed(const ll_advise_search *s, const ll_trial *t);

/* Probability that the true mean is within the limit, by all seeds of the setting; and how many more fresh
 * seeds may show it if the mean is as small as plausible. */
double ll_advise_chance(const ll_advise_search *s, const ll_trial *t);
double ll_advise_price(const ll_advise_search *s, const ll_trial *t);
double ll_advise_next(const ll_advise_search *s, const ll_trial *t);

/* Whether a setting holds over its repeats clearly enough to be verified. */
bool ll_advise_is_clear(const ll_advise_search *s, const ll_trial *t);

void ll_advise_free_trials(ll_advise_search *s);

/* Runs the next fresh seeds of a setting and updates its state. */
ll_status ll_advise_verify(ll_advise_search *s, int point);

/* Of tried points without a failed run the one with the smallest error; -1: none. */
int ll_advise_least_error(const ll_advise_search *s);

/* The answer described in advise.h. */
struct cJSON *ll_advise_answer(const ll_advise_search *s, bool proven);
