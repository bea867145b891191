/* Speed against error of families of methods: every method at every setting of its own, each cost against the
 * error, the front, and at three levels of error the cheapest method, checked by measuring everything again.
 *
 * A family has problems: a scenario and a metric of its error. What is measured of a problem are the
 * refinement series of that scenario with that error (refinement_series.h), or, of kind motion, every
 * integrator (work_precision_run.h). All of them are on one front. The first cost is always processor time.
 *
 * Levels are chosen per problem (ll_front_levels) from the upper bounds of the errors on the fronts of the
 * other costs, so that they do not depend on the machine. A choice is the cheapest setting whose upper bound
 * of the error is within the level. It holds if that is so again on fresh seeds, and nothing else that is
 * within the level there is cheaper beyond the intervals of both costs. Without randomness the errors cannot
 * differ; then it is the processor time that is measured again.
 *
 * The coarsest setting of every method comes first, then the next of every method, so that a plot of all
 * methods is there early and becomes finer; the check follows, in the same order. */
#pragma once

#include "experiment/advise/refinement_series.h"
#include "experiment/statistics/front.h"

enum { LL_TRADEOFF_PROBLEMS_MAX = 3, LL_TRADEOFF_COSTS_MAX = LL_REFINEMENT_COSTS_MAX };

typedef struct ll_tradeoff_problem {
    const char *scenario, *error; /* id in the library; path of a metric */
    const char *title;            /* what the error is */
} ll_tradeoff_problem;

typedef struct ll_tradeoff_cost {
    const char *path;  /* `cpu_s`, a path of a metric, or of the session's cost: `cost.block_bytes` */
    const char *title; /* with its unit */
} ll_tradeoff_cost;

typedef struct ll_tradeoff_family {
    const char *name, *title;
    const char *text;  /* what is compared, in sentences */
    const char *first; /* at most six methods, those most used, by commas */
    ll_tradeoff_problem problems[LL_TRADEOFF_PROBLEMS_MAX]; /* fewer: the next has no scenario */
    ll_tradeoff_cost costs[LL_TRADEOFF_COSTS_MAX];          /* fewer: the next has no path */
} ll_tradeoff_family;

extern const ll_tradeoff_family ll_tradeoff_families[]; /* the last row has no name */

const ll_tradeoff_family *ll_tradeoff_family_find(const char *name); /* NULL: none */

int ll_tradeoff_problem_count(const ll_tradeoff_family *family);
int ll_tradeoff_cost_count(const ll_tradeoff_family *family);

/* A measurement of a setting. */
typedef struct ll_tradeoff_values {
    ll_measured error;
    ll_measured
        costs[LL_TRADEOFF_COSTS_MAX]; /* processor time: minimum, minimum, median; at least 5 % more */
    double cpu_median_s;
    int runs;     /* whose processor time was measured */
    int64_t seed; /* of the first run */
    int seeds;    /* runs with seeds that follow; 1: nothing is random, or nothing is known */
} ll_tradeoff_values;

typedef struct ll_tradeoff_row {
    int problem;              /* index in the family */
    const char *by, *setting; /* paths of method and setting */
    char method[40], value[32];
    char sets[480]; /* `path=value` separated by spaces: makes this setting of the scenario */
    bool random, diverged;
    bool front[LL_TRADEOFF_COSTS_MAX];
    ll_tradeoff_values values, again; /* again: on fresh seeds; of seeds 0 if there was no check */
} ll_tradeoff_row;

typedef struct ll_tradeoff_choice {
    int problem, cost;
    double level;
    int row; /* -1: nothing is within the level */
    bool checked, holds;
    int cheapest_again; /* row; -1: none */
    char why[160];      /* with figures */
    char tied[200];     /* other methods whose cost does not differ certainly from it, separated by `, ` */
} ll_tradeoff_choice;

typedef struct ll_tradeoff {
    const ll_tradeoff_family *family;
    ll_tradeoff_row *rows;
    int count;
    ll_tradeoff_choice *choices; /* by problem, cost, level */
    int choice_count;
} ll_tradeoff;

typedef struct ll_tradeoff_request {
    const char *scenarios; /* folder of the library */
    const char *duration;  /* s; NULL: that of the series or scenario */
    const char *methods;   /* only these, separated by commas; NULL: all */
    int seeds;             /* of levels with randomness */
    int check_seeds;       /* of the check, after those; 0: no check */
    int64_t (*now_ns)(void);
} ll_tradeoff_request;

/* Settings to measure, twice with a check; of integrators, whose settings follow from their errors, at most.
 * 0: the family has none of the methods. */
int64_t ll_tradeoff_steps(const ll_tradeoff_family *family, const ll_tradeoff_request *request);

/* A measurement in progress. */
typedef struct ll_tradeoff_run ll_tradeoff_run;

/* `request` must outlive it. LL_BAD_INPUT: the family has none of the methods. */
ll_status ll_tradeoff_open(const ll_tradeoff_family *family, const ll_tradeoff_request *request,
                           ll_tradeoff_run **run);
/* Measures one more setting. False: there is none, or only in series that other threads are at; or something
 * failed, here or in another thread. Several threads may work at a run; `interrupt`, which may be NULL, is
 * this thread's. */
bool ll_tradeoff_next(ll_tradeoff_run *run, const ll_interrupt *interrupt, ll_status *status);
int64_t ll_tradeoff_done(ll_tradeoff_run *run); /* of ll_tradeoff_steps. Any thread */
/* The rows so far, with fronts and choices, which are checked when all are. The caller frees `tradeoff`,
 * after a failure too. Any thread. */
ll_status ll_tradeoff_so_far(ll_tradeoff_run *run, ll_tradeoff *tradeoff);
void ll_tradeoff_close(ll_tradeoff_run *run); /* NULL: no effect */

/* All of it. The caller frees `tradeoff`, after a failure too. */
ll_status ll_tradeoff_measure(const ll_tradeoff_family *family, const ll_tradeoff_request *request,
                              ll_tradeoff *tradeoff);
void ll_tradeoff_free(ll_tradeoff *tradeoff);

/* `holds`, `does not hold`, `not checked`, or `nothing` where nothing is within the level. */
const char *ll_tradeoff_verdict(const ll_tradeoff_choice *choice);

/* Marks fronts, and fills the choices from the rows. */
ll_status ll_tradeoff_choose(ll_tradeoff *tradeoff);
