/* The choice between settings by error and cost: Pareto front, levels of error, the cheapest within a level.
 * Both are better the smaller they are; one that is not finite is unknown. */
#pragma once

#include <stdbool.h>

#include "base/status.h"

enum { LL_FRONT_LEVELS = 3 };

typedef struct ll_front_point {
    double cost, cost_low, cost_high; /* with the bounds of its interval */
    double error, error_high;         /* with the upper bound of its interval; NaN: none */
    int method;                       /* settings of one method have the same number */
    bool front;
} ll_front_point;

/* Marks the points for which no other is as good in both and better in one: equal points are marked
 * together. */
ll_status ll_front_mark(ll_front_point *points, int count);

/* Levels from the upper bounds of errors, of which only those above 0 count: equal steps on a logarithmic
 * scale between the least and the largest of them, without the ends, each rounded up to two digits; the
 * largest first. Returns their number: LL_FRONT_LEVELS, fewer if the bounds are too close, 0 without
 * bounds. */
int ll_front_levels(const double *bounds, int count, double levels[LL_FRONT_LEVELS]);

/* The cheapest point whose upper bound is within the level; of equal costs the one of the smaller error. -1:
 * none. */
int ll_front_cheapest(const ll_front_point *points, int count, double level);

/* Of a method's points within the level the cheapest; -1: none. */
int ll_front_cheapest_of(const ll_front_point *points, int count, double level, int method);

/* Whether `a` costs less than `b` beyond the intervals of both. */
bool ll_front_certainly_cheaper(const ll_front_point *a, const ll_front_point *b);
