#include "experiment/advise/surrogate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"

/* A kernel, in units of the values' own variance: a part common to all points, a trend along each numeric
 * axis, and a smooth part with correlation `length` on the axis. Points that differ in a choice share the
 * part `kin`. `noise` is that of seeds and of what the kernel cannot model. */
typedef struct kernel {
    double trend, bend, length, kin, noise;
} kernel;

#define SHARED 1.0

/* Combinations of smoothness, similarity of choices and noise. Cost and error each use the one with the
 * highest likelihood. */
static const kernel kernels[] = {
    {.trend = 3, .bend = 0.25, .length = 0.3, .kin = 0.6, .noise = 1e-3},
    {.trend = 1, .bend = 1.5, .length = 0.3, .kin = 0.6, .noise = 1e-3},
    {.trend = 3, .bend = 0.5, .length = 0.3, .kin = 0.15, .noise = 1e-3},
    {.trend = 1, .bend = 1.5, .length = 0.2, .kin = 0.15, .noise = 1e-2},
    {.trend = 3, .bend = 0.25, .length = 0.3, .kin = 0.6, .noise = 0.1},
};

enum { MODELS = sizeof kernels / sizeof kernels[0] };

#define PRIOR 4.0 /* weight of a kernel's own variance, in points */

typedef struct model {
    const kernel *kernel;
    double *factor; /* by point: its covariances with the seen points, solved by the Cholesky factor */
    double *left;   /* by point: the remaining variance */
    double *pivot;  /* by seen point: its diagonal element of the factor */
    double *solved[LL_SURROGATE_OUTPUTS];
    double scale[LL_SURROGATE_OUTPUTS]; /* estimated scale of the kernel's standard deviations */
} model;

struct ll_surrogate {
    const ll_experiment *experiment;
    int points, seen, capacity;
    double *place; /* points x dimensions: numeric ones -1 to 1, choices by index */
    bool *choice;  /* by dimension */
    int *order;    /* seen points, in the order in which they were added */
    int *rank;     /* by point: its index in that order; -1: not seen */
    double *values[LL_SURROGATE_OUTPUTS];
    double middle[LL_SURROGATE_OUTPUTS], spread[LL_SURROGATE_OUTPUTS];
    model models[MODELS];
    const model *likely[LL_SURROGATE_OUTPUTS];
};

/* ---- coordinates of points ---- */

static void find_places(ll_surrogate *s)
{
    const ll_experiment *e = s->experiment;
    int64_t after = 1; /* points per step of the dimension */
    for (int a = e->axis_count - 1; a >= 0; a--) {
        int d = e->dimension[a];
        const ll_axis *axis = &e->axes[a];
        if (a > 0 && e->dimension[a - 1] == d) /* zipped: the first axis represents all */
            continue;
        s->choice[d] = axis->type == LL_CELL_BOOL || axis->type == LL_CELL_TEXT;
        for (int p = 0; p < s->points; p++) {
            double k = (double)(p / after % axis->count);
            s->place[p * e->dimension_count + d] = s->choice[d]      ? k
                                                   : axis->count > 1 ? 2 * k / (double)(axis->count - 1) - 1
                                                                     : 0;
        }
        LL_ASSERT(axis->count > 0);
        after *= axis->count;
    }
}

static double covariance(const ll_surrogate *s, const kernel *k, int p, int q)
{
    int n = s->experiment->dimension_count;
    const double *a = s->place + p * n, *b = s->place + q * n;
    double kin = 1, trend = 0, distance = 0;
    for (int d = 0; d < n; d++) {
        if (s->choice[d]) {
            kin *= a[d] == b[d] ? 1 : k->kin;
        } else {
            trend += a[d] * b[d];
            distance += (a[d] - b[d]) * (a[d] - b[d]);
        }
    }
    return kin * (SHARED + k->trend * trend + k->bend * ll_exp(-distance / (8 * k->length * k->length)));
}

/* ---- creation and destruction ---- */

static bool create_model(ll_surrogate *s, const kernel *k, model *m)
{
    size_t points = (size_t)s->points, capacity = (size_t)s->capacity;
    m->kernel = k;
    m->factor = calloc(points * capacity, sizeof *m->factor);
    m->left = calloc(points, sizeof *m->left);
    m->pivot = calloc(capacity, sizeof *m->pivot);
    bool good = m->factor && m->left && m->pivot;
    for (int o = 0; o < LL_SURROGATE_OUTPUTS; o++) {
        m->solved[o] = calloc(capacity, sizeof *m->solved[o]);
        m->scale[o] = 1;
        good = good && m->solved[o];
    }
    for (int p = 0; good && p < s->points; p++)
        m->left[p] = covariance(s, k, p, p);
    return good;
}

static bool create_places(ll_surrogate *s)
{
    size_t points = (size_t)s->points, dimensions = (size_t)s->experiment->dimension_count + 1;
    s->place = calloc(points * dimensions, sizeof *s->place);
    s->choice = calloc(dimensions, sizeof *s->choice);
    s->order = calloc((size_t)s->capacity, sizeof *s->order);
    s->rank = calloc(points, sizeof *s->rank);
    if (!s->place || !s->choice || !s->order || !s->rank)
        return false;
    find_places(s);
    for (int p = 0; p < s->points; p++)
        s->rank[p] = -1;
    return true;
}

ll_status ll_surrogate_create(const ll_experiment *e, int64_t most_seen, ll_surrogate **surrogate)
{
    ll_surrogate *s = *surrogate = calloc(1, sizeof *s);
    LL_ASSERT(e->points <= LL_SURROGATE_POINTS_MAX && most_seen > 0);
    if (!s)
        return ll_error(LL_NO_MEMORY, "out of memory: surrogate");
    s->experiment = e;
    s->points = (int)e->points;
    s->capacity = s->points < LL_SURROGATE_SEEN_MAX ? s->points : LL_SURROGATE_SEEN_MAX;
    s->capacity = most_seen < s->capacity ? (int)most_seen : s->capacity;
    bool good = create_places(s);
    for (int o = 0; o < LL_SURROGATE_OUTPUTS; o++) {
        s->values[o] = calloc((size_t)s->capacity, sizeof *s->values[o]);
        s->likely[o] = &s->models[0];
        s->spread[o] = 1;
        good = good && s->values[o];
    }
    for (int m = 0; good && m < MODELS; m++)
        good = create_model(s, &kernels[m], &s->models[m]);
    if (good)
        return ll_ok();
    ll_surrogate_free(s);
    *surrogate = NULL;
    return ll_error(LL_NO_MEMORY, "out of memory: surrogate");
}

void ll_surrogate_free(ll_surrogate *s)
{
    if (!s)
        return;
    for (model *m = s->models; m < s->models + MODELS; m++) {
        for (int o = 0; o < LL_SURROGATE_OUTPUTS; o++)
            free(m->solved[o]);
        free(m->factor);
        free(m->left);
        free(m->pivot);
    }
    for (int o = 0; o < LL_SURROGATE_OUTPUTS; o++)
        free(s->values[o]);
    free(s->place);
    free(s->choice);
    free(s->order);
    free(s->rank);
    free(s);
}

/* ---- adding points ---- */

/* Adds a column to the Cholesky factor, and to every point's solved covariances. */
static void extend(ll_surrogate *s, model *m, int point)
{
    int n = s->seen;
    double *own = m->factor + (size_t)point * (size_t)s->capacity;
    double pivot = sqrt(fmax(m->left[point], 0) + m->kernel->noise);
    LL_ASSERT(pivot > 0); /* the covariances with noise are positive definite */
    m->pivot[n] = pivot;
    for (int p = 0; p < s->points; p++) {
        double *row = m->factor + (size_t)p * (size_t)s->capacity;
        if (p == point) /* noise is independent */
            continue;
        double sum = covariance(s, m->kernel, p, point);
        for (int i = 0; i < n; i++)
            sum -= row[i] * own[i];
        row[n] = sum / pivot;
        m->left[p] -= row[n] * row[n];
    }
    own[n] = fmax(m->left[point], 0) / pivot;
    m->left[point] -= own[n] * own[n];
}

ll_status ll_surrogate_see(ll_surrogate *s, int point)
{
    if (s->seen == s->capacity)
        return ll_error(LL_LIMIT, "points: must be at most %d tried ones", s->capacity);
    LL_ASSERT(point >= 0 && point < s->points && s->rank[point] < 0); /* each point once */
    s->order[s->seen] = point;
    s->rank[point] = s->seen;
    for (int m = 0; m < MODELS; m++)
        extend(s, &s->models[m], point);
    s->seen++;
    return ll_ok();
}

void ll_surrogate_tell(ll_surrogate *s, int point, const double values[LL_SURROGATE_OUTPUTS])
{
    LL_ASSERT(s->rank[point] >= 0 && s->rank[point] < s->seen);
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++)
        s->values[k][s->rank[point]] = values[k];
}

/* Solves for the values by the factor: row i is that of the i-th seen point. Returns their log likelihood,
 * without the terms common to all models. */
static double solve(ll_surrogate *s, model *m, int output)
{
    double squares = 0, likelihood = 0;
    for (int i = 0; i < s->seen; i++) {
        const double *row = m->factor + (size_t)s->order[i] * (size_t)s->capacity;
        double value = (s->values[output][i] - s->middle[output]) / s->spread[output];
        for (int j = 0; j < i; j++)
            value -= row[j] * m->solved[output][j];
        m->solved[output][i] = value /= m->pivot[i];
        squares += value * value;
        likelihood -= log(m->pivot[i]);
    }
    m->scale[output] = sqrt((squares + PRIOR) / (s->seen + PRIOR));
    return likelihood - s->seen * log(m->scale[output]) -
           (squares + PRIOR) / (2 * m->scale[output] * m->scale[output]);
}

/* Normalises values by mean and spread. */
void ll_surrogate_fit(ll_surrogate *s)
{
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++) {
        double sum = 0, squares = 0, most = -INFINITY;
        for (int i = 0; i < s->seen; i++)
            sum += s->values[k][i];
        s->middle[k] = s->seen ? sum / s->seen : 0;
        for (int i = 0; i < s->seen; i++)
            squares += (s->values[k][i] - s->middle[k]) * (s->values[k][i] - s->middle[k]);
        s->spread[k] = squares > 0 ? sqrt(squares / s->seen) : 1;
        for (model *m = s->models; m < s->models + MODELS; m++) {
            double likelihood = solve(s, m, k);
            if (likelihood > most) {
                most = likelihood;
                s->likely[k] = m;
            }
        }
    }
}

double ll_surrogate_doubt(const ll_surrogate *s, int point)
{
    return s->models[0].left[point];
}

void ll_surrogate_expect(const ll_surrogate *s, int point, double mean[LL_SURROGATE_OUTPUTS],
                         double deviation[LL_SURROGATE_OUTPUTS])
{
    for (int k = 0; k < LL_SURROGATE_OUTPUTS; k++) {
        const model *m = s->likely[k];
        const double *row = m->factor + (size_t)point * (size_t)s->capacity;
        double sum = 0;
        for (int i = 0; i < s->seen; i++)
            sum += row[i] * m->solved[k][i];
        mean[k] = s->middle[k] + s->spread[k] * sum;
        deviation[k] = s->spread[k] * m->scale[k] * sqrt(fmax(m->left[point], 0) + m->kernel->noise);
    }
}
