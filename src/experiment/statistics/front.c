#include "experiment/statistics/front.h"

#include <math.h>
#include <stdlib.h>

static int by_cost(const void *a, const void *b)
{
    const ll_front_point *p = *(ll_front_point *const *)a, *q = *(ll_front_point *const *)b;
    if (p->cost != q->cost)
        return (p->cost > q->cost) - (p->cost < q->cost);
    return (p->error > q->error) - (p->error < q->error);
}

/* In order of cost, then error, a point is beaten by those before it, and then by the least error of them. */
ll_status ll_front_mark(ll_front_point *points, int count)
{
    ll_front_point **order = malloc((size_t)count * sizeof(ll_front_point *) + 1), *last = NULL;
    int n = 0;
    if (!order)
        return ll_error(LL_NO_MEMORY, "out of memory: front");
    for (int i = 0; i < count; i++) {
        points[i].front = false;
        if (isfinite(points[i].cost) && isfinite(points[i].error))
            order[n++] = &points[i];
    }
    qsort(order, (size_t)n, sizeof *order, by_cost);
    for (int i = 0; i < n; i++) {
        bool same = last && order[i]->cost == last->cost && order[i]->error == last->error;
        order[i]->front = !last || order[i]->error < last->error || same;
        if (order[i]->front)
            last = order[i];
    }
    free(order);
    return ll_ok();
}

/* Up to two digits; what has two but for rounding stays. */
static double rounded_up(double value)
{
    double power = pow(10, floor(log10(value)) - 1);
    return ceil(value / power * (1 - 1e-12)) * power;
}

int ll_front_levels(const double *bounds, int count, double levels[LL_FRONT_LEVELS])
{
    double least = INFINITY, largest = 0;
    int n = 0;
    for (int i = 0; i < count; i++)
        if (bounds[i] > 0 && isfinite(bounds[i])) {
            least = fmin(least, bounds[i]);
            largest = fmax(largest, bounds[i]);
        }
    for (int k = 1; k <= LL_FRONT_LEVELS && largest > 0; k++) {
        double level = rounded_up(largest * pow(least / largest, (double)k / (LL_FRONT_LEVELS + 1)));
        if (n == 0 || level < levels[n - 1])
            levels[n++] = level;
    }
    return n;
}

int ll_front_cheapest_of(const ll_front_point *points, int count, double level, int method)
{
    int found = -1;
    for (int i = 0; i < count; i++) {
        const ll_front_point *p = &points[i], *best = &points[found < 0 ? i : found];
        if ((method >= 0 && p->method != method) || !isfinite(p->cost) || !(p->error_high <= level))
            continue;
        if (found < 0 || p->cost < best->cost || (p->cost == best->cost && p->error < best->error))
            found = i;
    }
    return found;
}

int ll_front_cheapest(const ll_front_point *points, int count, double level)
{
    return ll_front_cheapest_of(points, count, level, -1);
}

bool ll_front_certainly_cheaper(const ll_front_point *a, const ll_front_point *b)
{
    return a->cost_high < b->cost_low;
}
