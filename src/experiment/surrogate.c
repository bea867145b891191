#include "experiment/surrogate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

/* The kernel, in units of the values' own variance: what all points share, a trend along each numeric axis,
 * and a bend that fades over BEND_LENGTH of the axis. Points that differ in a choice have KIN of it in
 * common. */
#define SHARED 1.0
#define TREND 3.0
#define BEND 0.25
#define BEND_LENGTH 0.3
#define KIN 0.6
#define NOISE 1e-3 /* of a seed, and of what the kernel cannot follow */

struct ll_surrogate {
    const ll_experiment *experiment;
    int points, seen, capacity;
    double *place;  /* points x dimensions: along a numeric one -1 to 1, of a choice its index */
    bool *choice;   /* of each dimension */
    int *order;     /* seen points, in the order of their coming */
    int *rank;      /* of each point in it; -1: not seen */
    double *factor; /* of each point: its covariances with the seen, solved by the Cholesky factor */
    double *left;   /* of each point: the variance that is left */
    double *pivot;  /* of each seen point: its diagonal of the factor */
    double *values[LL_SURROGATE_OUTPUTS], *solved[LL_SURROGATE_OUTPUTS];
    double middle[LL_SURROGATE_OUTPUTS], spread[LL_SURROGATE_OUTPUTS];
};

/* ---- places ---- */

static void find_places(ll_surrogate *s)
{
    const ll_experiment *e = s->experiment;
    int64_t after = 1; /* points per step of the dimension */
    for (int a = e->axis_count - 1; a >= 0; a--) {
        int d = e->dimension[a];
        const ll_axis *axis = &e->axes[a];
        if (a > 0 && e->dimension[a - 1] == d) /* zipped: the first stands for all */
            continue;
        s->choice[d] = axis->type == LL_CELL_BOOL || axis->type == LL_CELL_TEXT;
        for (int p = 0; p < s->points; p++) {
            double k = (double)(p / after % axis->count);
            s->place[p * e->dimension_count + d] = s->choice[d]      ? k
                                                   : axis->count > 1 ? 2 * k / (double)(axis->count - 1) - 1
                                                                     : 0;
        }
        after *= axis->count;
    }
}

static double kernel(const ll_surrogate *s, int p, int q)
{
    int n = s->experiment->dimension_count;
    const double *a = s->place + p * n, *b = s->place + q * n;
    double kin = 1, trend = 0, distance = 0;
    for (int d = 0; d < n; d++) {
        if (s->choice[d]) {
            kin *= a[d] == b[d] ? 1 : KIN;
        } else {
            trend += a[d] * b[d];
            distance += (a[d] - b[d]) * (a[d] - b[d]);
        }
    }
    return kin * (SHARED + TREND * trend + BEND * ll_exp(-distance / (8 * BEND_LENGTH * BEND_LENGTH)));
}

/* ---- life ---- */

ll_status ll_surrogate_create(const ll_experiment *e, ll_surrogate **surrogate)
{
    ll_surrogate *s = *surrogate = calloc(1, sizeof *s);
    LL_ASSERT(e->points <= LL_SURROGATE_POINTS_MAX);
    if (!s)
        return ll_error(LL_NO_MEMORY, "no memory for a surrogate");
    size_t points = (size_t)e->points;
    s->experiment = e;
    s->points = (int)e->points;
    s->capacity = s->points < LL_SURROGATE_SEEN_MAX ? s->points : LL_SURROGATE_SEEN_MAX;
    s->place = calloc(points * (size_t)(e->dimension_count + 1), sizeof *s->place);
    s->choice = calloc((size_t)e->dimension_count + 1, sizeof *s->choice);
    s->order = calloc(points, sizeof *s->order);
    s->rank = calloc(points, sizeof *s->rank);
    s->factor = calloc(points * (size_t)s->capacity, sizeof *s->factor);
    s->left = calloc(points, sizeof *s->left);
    s->pivot = calloc(points, sizeof *s->pivot);
    bool good = s->place && s->choice && s->order && s->rank && s->factor && s->left && s->pivot;
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++) {
        s->values[k] = calloc(points, sizeof *s->values[k]);
        s->solved[k] = calloc(points, sizeof *s->solved[k]);
        good = good && s->values[k] && s->solved[k];
    }
    if (!good) {
        ll_surrogate_free(s);
        *surrogate = NULL;
        return ll_error(LL_NO_MEMORY, "no memory for a surrogate");
    }
    find_places(s);
    for (int p = 0; p < s->points; p++) {
        s->rank[p] = -1;
        s->left[p] = kernel(s, p, p);
    }
    return ll_ok();
}

void ll_surrogate_free(ll_surrogate *s)
{
    if (!s)
        return;
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++) {
        free(s->values[k]);
        free(s->solved[k]);
    }
    free(s->place);
    free(s->choice);
    free(s->order);
    free(s->rank);
    free(s->factor);
    free(s->left);
    free(s->pivot);
    free(s);
}

/* ---- seeing ---- */

/* One more column of the Cholesky factor, and with it of every point's solved covariances. */
ll_status ll_surrogate_see(ll_surrogate *s, int point)
{
    int n = s->seen;
    if (n == s->capacity)
        return ll_error(LL_LIMIT, "more than %d points were tried", s->capacity);
    const double *own = s->factor + (size_t)point * (size_t)s->capacity;
    double pivot = sqrt(fmax(s->left[point], 0) + NOISE);
    s->order[n] = point;
    s->rank[point] = n;
    s->pivot[n] = pivot;
    for (int p = 0; p < s->points; p++) {
        double *row = s->factor + (size_t)p * (size_t)s->capacity;
        double sum = kernel(s, p, point);
        for (int i = 0; i < n; i++)
            sum -= row[i] * own[i];
        double value = sum / pivot;
        if (p == point) /* the noise is its own */
            continue;
        row[n] = value;
        s->left[p] -= value * value;
    }
    double *mine = s->factor + (size_t)point * (size_t)s->capacity;
    mine[n] = fmax(s->left[point], 0) / pivot;
    s->left[point] -= mine[n] * mine[n];
    s->seen++;
    return ll_ok();
}

void ll_surrogate_tell(ll_surrogate *s, int point, const double values[LL_SURROGATE_OUTPUTS])
{
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++)
        s->values[k][s->rank[point]] = values[k];
}

/* Values in units of their spread around their middle, solved by the factor: row i of it is that of the i-th
 * point that was seen. */
void ll_surrogate_fit(ll_surrogate *s)
{
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++) {
        double sum = 0, squares = 0;
        for (int i = 0; i < s->seen; i++)
            sum += s->values[k][i];
        s->middle[k] = s->seen ? sum / s->seen : 0;
        for (int i = 0; i < s->seen; i++)
            squares += (s->values[k][i] - s->middle[k]) * (s->values[k][i] - s->middle[k]);
        s->spread[k] = squares > 0 ? sqrt(squares / s->seen) : 1;
        for (int i = 0; i < s->seen; i++) {
            const double *row = s->factor + (size_t)s->order[i] * (size_t)s->capacity;
            double value = (s->values[k][i] - s->middle[k]) / s->spread[k];
            for (int j = 0; j < i; j++)
                value -= row[j] * s->solved[k][j];
            s->solved[k][i] = value / s->pivot[i];
        }
    }
}

double ll_surrogate_doubt(const ll_surrogate *s, int point)
{
    return s->left[point];
}

void ll_surrogate_expect(const ll_surrogate *s, int point, double mean[LL_SURROGATE_OUTPUTS],
                         double deviation[LL_SURROGATE_OUTPUTS])
{
    const double *row = s->factor + (size_t)point * (size_t)s->capacity;
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++) {
        double sum = 0;
        for (int i = 0; i < s->seen; i++)
            sum += row[i] * s->solved[k][i];
        mean[k] = s->middle[k] + s->spread[k] * sum;
        deviation[k] = s->spread[k] * sqrt(fmax(s->left[point], 0) + NOISE);
    }
}
