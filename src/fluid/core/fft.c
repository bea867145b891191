#include "fluid/core/fft.h"

#include <string.h>

#include "base/assert.h"
#include "base/detmath.h"
#include "fluid/core/rows.h"

#define PI 3.14159265358979323846

/* ---- plans ---- */

static int radix_of(int32_t n)
{
    return n % 4 == 0 ? 4 : n % 2 == 0 ? 2 : n % 3 == 0 ? 3 : n % 5 == 0 ? 5 : 0;
}

bool ll_fft_allowed(int64_t n)
{
    if (n < 1 || n > LL_FFT_MAX)
        return false;
    for (int32_t rest = (int32_t)n; rest > 1; rest /= radix_of(rest))
        if (radix_of(rest) == 0)
            return false;
    return true;
}

size_t ll_fft_size(int32_t n)
{
    return sizeof(ll_fft) + (size_t)(n + n / 2 + 1) * sizeof(ll_complex);
}

/* exp(-2 pi i k / n) from an angle of at most pi / 4, so that symmetric values are equal to the bit. */
static ll_complex root(int64_t k, int64_t n)
{
    int64_t octant = 8 * k / n; /* 0 to 7 */
    bool odd = (octant & 1) != 0;
    int64_t from = (octant + (odd ? 1 : 0)) / 2; /* quarter turns to the nearest axis */
    double angle = 2 * PI * (double)(4 * k - from * n) / (4 * (double)n);
    double c = ll_cos(angle), s = ll_sin(angle);
    static const double turns[4][2] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    const double *turn = turns[from & 3];
    return (ll_complex){c * turn[0] - s * turn[1], -(s * turn[0] + c * turn[1])};
}

static ll_complex *quarters(const ll_fft *plan)
{
    return (ll_complex *)plan->twiddle + plan->n;
}

void ll_fft_init(ll_fft *plan, int32_t n)
{
    LL_ASSERT(ll_fft_allowed(n));
    memset(plan, 0, sizeof *plan);
    plan->n = n;
    for (int32_t rest = n; rest > 1; rest /= plan->radix[plan->stages - 1])
        plan->radix[plan->stages++] = radix_of(rest);
    for (int32_t k = 0; k < n; k++)
        plan->twiddle[k] = root(k, n);
    for (int32_t k = 0; k <= n / 2; k++)
        quarters(plan)[k] = root(k, 4 * (int64_t)n);
}

/* ---- stages ---- One stage of radix r maps sequences of length n = r m at stride `s` to sequences of length
 * m at stride r s. `sign` is +1 forward and -1 backward: it conjugates every factor. */

static ll_complex add(ll_complex a, ll_complex b)
{
    return (ll_complex){a.re + b.re, a.im + b.im};
}

static ll_complex sub(ll_complex a, ll_complex b)
{
    return (ll_complex){a.re - b.re, a.im - b.im};
}

static ll_complex mul(ll_complex a, ll_complex b)
{
    return (ll_complex){a.re * b.re - a.im * b.im, a.re * b.im + a.im * b.re};
}

static ll_complex scaled(double f, ll_complex a)
{
    return (ll_complex){f * a.re, f * a.im};
}

static ll_complex turned(ll_complex a, double sign) /* times -i, or i backward */
{
    return (ll_complex){sign * a.im, -sign * a.re};
}

typedef struct stage {
    const ll_complex *twiddle;
    const ll_complex *x;
    ll_complex *y;
    int64_t m, s;
    int64_t step; /* stride of this stage's factors in the table */
    double sign;
    int64_t begin, end; /* of the s sequences */
    void (*run)(const struct stage *);
} stage;

static ll_complex factor(const stage *g, int64_t k)
{
    ll_complex w = g->twiddle[k * g->step];
    return (ll_complex){w.re, g->sign * w.im};
}

static void radix2(const stage *g)
{
    for (int64_t p = 0; p < g->m; p++) {
        ll_complex w = factor(g, p);
        const ll_complex *x = g->x + g->s * p;
        ll_complex *y = g->y + g->s * 2 * p;
        int64_t s = g->s, far = g->s * g->m;
        for (int64_t q = g->begin; q < g->end; q++) {
            ll_complex a = x[q], b = x[q + far];
            y[q] = add(a, b);
            y[q + s] = mul(w, sub(a, b));
        }
    }
}

static void radix3(const stage *g)
{
    const double sine = g->sign * 0.86602540378443864676;
    for (int64_t p = 0; p < g->m; p++) {
        ll_complex w1 = factor(g, p), w2 = factor(g, 2 * p);
        const ll_complex *x = g->x + g->s * p;
        ll_complex *y = g->y + g->s * 3 * p;
        int64_t s = g->s, far = g->s * g->m;
        for (int64_t q = g->begin; q < g->end; q++) {
            ll_complex a = x[q], sum = add(x[q + far], x[q + 2 * far]);
            ll_complex side = turned(scaled(sine, sub(x[q + far], x[q + 2 * far])), 1);
            ll_complex mid = sub(a, scaled(0.5, sum));
            y[q] = add(a, sum);
            y[q + s] = mul(w1, add(mid, side));
            y[q + 2 * s] = mul(w2, sub(mid, side));
        }
    }
}

static void radix4(const stage *g)
{
    double sign = g->sign;
    for (int64_t p = 0; p < g->m; p++) {
        ll_complex w1 = factor(g, p), w2 = factor(g, 2 * p), w3 = factor(g, 3 * p);
        const ll_complex *x = g->x + g->s * p;
        ll_complex *y = g->y + g->s * 4 * p;
        int64_t s = g->s, far = g->s * g->m;
        for (int64_t q = g->begin; q < g->end; q++) {
            ll_complex a = x[q], b = x[q + far], c = x[q + 2 * far], d = x[q + 3 * far];
            ll_complex even = add(a, c), odd = add(b, d), rest = sub(a, c), side = turned(sub(b, d), sign);
            y[q] = add(even, odd);
            y[q + s] = mul(w1, add(rest, side));
            y[q + 2 * s] = mul(w2, sub(even, odd));
            y[q + 3 * s] = mul(w3, sub(rest, side));
        }
    }
}

static void radix5(const stage *g)
{
    const double c1 = 0.30901699437494742410, c2 = -0.80901699437494742410;
    const double s1 = g->sign * 0.95105651629515357212, s2 = g->sign * 0.58778525229247312917;
    for (int64_t p = 0; p < g->m; p++) {
        ll_complex w[4] = {factor(g, p), factor(g, 2 * p), factor(g, 3 * p), factor(g, 4 * p)};
        const ll_complex *x = g->x + g->s * p;
        ll_complex *y = g->y + g->s * 5 * p;
        int64_t s = g->s, far = g->s * g->m;
        for (int64_t q = g->begin; q < g->end; q++) {
            ll_complex a = x[q], sum1 = add(x[q + far], x[q + 4 * far]);
            ll_complex sum2 = add(x[q + 2 * far], x[q + 3 * far]), gap1 = sub(x[q + far], x[q + 4 * far]);
            ll_complex gap2 = sub(x[q + 2 * far], x[q + 3 * far]);
            ll_complex mid1 = add(a, add(scaled(c1, sum1), scaled(c2, sum2)));
            ll_complex mid2 = add(a, add(scaled(c2, sum1), scaled(c1, sum2)));
            ll_complex side1 = turned(add(scaled(s1, gap1), scaled(s2, gap2)), 1);
            ll_complex side2 = turned(sub(scaled(s2, gap1), scaled(s1, gap2)), 1);
            y[q] = add(a, add(sum1, sum2));
            y[q + s] = mul(w[0], add(mid1, side1));
            y[q + 2 * s] = mul(w[1], add(mid2, side2));
            y[q + 3 * s] = mul(w[2], sub(mid2, side2));
            y[q + 4 * s] = mul(w[3], sub(mid1, side1));
        }
    }
}

static void (*const stages_of[])(const stage *) = {[2] = radix2, [3] = radix3, [4] = radix4, [5] = radix5};

/* ---- complex transforms ---- */

/* What a part has of `count` sequences. */
static void stage_part(void *context, ll_share of, int part)
{
    stage mine = *(const stage *)context;
    (void)part;
    mine.begin = of.begin;
    mine.end = of.end;
    mine.run(&mine);
}

static void run_stages(const ll_fft *plan, ll_complex *data, ll_complex *work, int32_t count,
                       ll_fft_direction direction, ll_team *team)
{
    ll_complex *from = data, *to = work;
    int64_t rest = plan->n, s = count;
    for (int32_t i = 0; i < plan->stages; i++) {
        stage g = {plan->twiddle,     from, to, rest / plan->radix[i],    s, plan->n / rest,
                   (double)direction, 0,    s,  stages_of[plan->radix[i]]};
        if (team == NULL)
            g.run(&g);
        else
            ll_rows_run(team, (int32_t)s, rest, stage_part, &g);
        rest /= plan->radix[i];
        s *= plan->radix[i];
        ll_complex *swap = from;
        from = to;
        to = swap;
    }
    if (from != data)
        memcpy(data, from, (size_t)plan->n * (size_t)count * sizeof *data);
}

void ll_fft_run(const ll_fft *plan, ll_complex *data, ll_complex *work, int32_t count,
                ll_fft_direction direction)
{
    run_stages(plan, data, work, count, direction, NULL);
}

/* Rows, or pairs of them, of a transform in two dimensions. */
typedef struct row_transforms {
    const ll_fft *x;
    void *data, *work; /* each part takes as much of `work` as its rows have */
    ll_fft_direction direction;
} row_transforms;

static void complex_rows(void *context, ll_share rows, int part)
{
    const row_transforms *t = context;
    int64_t n = t->x->n;
    ll_complex *data = t->data, *work = (ll_complex *)t->work + rows.begin * n;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        ll_fft_run(t->x, data + j * n, work, 1, t->direction);
}

void ll_fft_run_2d(const ll_fft *x, const ll_fft *y, ll_complex *data, ll_complex *work,
                   ll_fft_direction direction, ll_team *team)
{
    ll_rows_run(team, y->n, x->n, complex_rows, &(row_transforms){x, data, work, direction});
    run_stages(y, data, work, x->n, direction, team);
}

/* ---- cosine transforms ---- */

/* Splits the transform Z of two real sequences a + i b into their cosine sums, from bins k and n - k. With w
 * = exp(-pi i k / (2 n)): A[k] = Re(w (Z[k] + conj Z[n - k])), A[n - k] is minus its imaginary part; B
 * likewise from -i (Z[k] - conj Z[n - k]). */
static void split(ll_complex *near, ll_complex *far, ll_complex w)
{
    ll_complex z = *near, y = {far->re, -far->im};
    ll_complex a = mul(w, add(z, y)), b = mul(w, turned(sub(z, y), 1));
    *near = (ll_complex){a.re, b.re};
    *far = (ll_complex){-a.im, -b.im};
}

/* Inverse of split. */
static void join(ll_complex *near, ll_complex *far, ll_complex w)
{
    ll_complex back = {w.re, -w.im};
    ll_complex a = mul(back, (ll_complex){near->re, -far->re});
    ll_complex b = mul(back, (ll_complex){near->im, -far->im});
    ll_complex side = turned(b, -1);
    ll_complex y = scaled(0.5, sub(a, side));
    *near = scaled(0.5, add(a, side));
    *far = (ll_complex){y.re, -y.im};
}

/* The cosine transforms of `pairs` pairs of sequences. */
typedef struct cosines {
    const ll_fft *plan;
    const double *from;
    double *to;
    int32_t pairs;
    bool forward;
} cosines;

/* Row k of the bins with row n - k; row 0 and the middle one alone. */
static void split_rows(void *context, ll_share rows, int part)
{
    const cosines *t = context;
    ll_complex *data = (ll_complex *)t->to;
    int32_t n = t->plan->n, pairs = t->pairs;
    double half = 0.70710678118654752440;
    (void)part;
    for (int32_t k = rows.begin; k < rows.end; k++) {
        ll_complex w = quarters(t->plan)[k], *near = data + (int64_t)k * pairs,
                   *far = data + (int64_t)(n - k) * pairs;
        if (k == 0 || 2 * k == n) {
            double scale = (k == 0 ? 1 : half) * (t->forward ? 2 : k == 0 ? 0.5 : 1);
            for (int32_t q = 0; q < pairs; q++)
                near[q] = scaled(scale, near[q]);
            continue;
        }
        for (int32_t q = 0; q < pairs; q++)
            t->forward ? split(near + q, far + q, w) : join(near + q, far + q, w);
    }
}

/* Makhoul's order: even elements ascending, odd ones descending. */
static int64_t shuffled(int64_t j, int64_t n)
{
    return j % 2 == 0 ? j / 2 : n - 1 - j / 2;
}

static void shuffle_rows(void *context, ll_share rows, int part)
{
    const cosines *t = context;
    int64_t n = t->plan->n, row = 2 * (int64_t)t->pairs;
    (void)part;
    for (int64_t j = rows.begin; j < rows.end; j++) {
        const double *from = t->from + (t->forward ? j : shuffled(j, n)) * row;
        double *to = t->to + (t->forward ? shuffled(j, n) : j) * row;
        if (t->forward)
            memcpy(to, from, (size_t)row * sizeof *to);
        else
            for (int64_t q = 0; q < row; q++)
                to[q] = from[q] / (double)n;
    }
}

static void run_cosines(const ll_fft *plan, double *data, double *work, int32_t pairs,
                        ll_fft_direction direction, ll_team *team)
{
    int32_t n = plan->n, bins = n / 2 + 1;
    size_t bytes = 2 * (size_t)pairs * (size_t)n * sizeof *data;
    cosines t = {plan, data, work, pairs, direction == LL_FFT_FORWARD};
    if (t.forward) {
        ll_rows_run(team, n, 2 * (int64_t)pairs, shuffle_rows, &t);
        run_stages(plan, (ll_complex *)work, (ll_complex *)data, pairs, direction, team);
        ll_rows_run(team, bins, 4 * (int64_t)pairs, split_rows, &t);
        memcpy(data, work, bytes);
        return;
    }
    t.to = data;
    ll_rows_run(team, bins, 4 * (int64_t)pairs, split_rows, &t);
    run_stages(plan, (ll_complex *)data, (ll_complex *)work, pairs, direction, team);
    memcpy(work, data, bytes);
    t.from = work;
    ll_rows_run(team, n, 2 * (int64_t)pairs, shuffle_rows, &t);
}

void ll_dct_run(const ll_fft *plan, double *data, double *work, int32_t pairs, ll_fft_direction direction)
{
    run_cosines(plan, data, work, pairs, direction, NULL);
}

/* Two rows, interleaved in `pair`. */
static void rows_of(const ll_fft *x, double *two, double *pair, ll_fft_direction direction)
{
    int32_t n = x->n;
    for (int32_t i = 0; i < n; i++) {
        pair[2 * i] = two[i];
        pair[2 * i + 1] = two[n + i];
    }
    ll_dct_run(x, pair, two, 1, direction);
    for (int32_t i = 0; i < n; i++) {
        two[i] = pair[2 * i];
        two[n + i] = pair[2 * i + 1];
    }
}

static void cosine_rows(void *context, ll_share rows, int part)
{
    const row_transforms *t = context;
    int64_t two = 2 * (int64_t)t->x->n;
    double *data = t->data, *work = (double *)t->work + rows.begin * two;
    (void)part;
    for (int32_t j = rows.begin; j < rows.end; j++)
        rows_of(t->x, data + j * two, work, t->direction);
}

void ll_dct_run_2d(const ll_fft *x, const ll_fft *y, double *data, double *work, ll_fft_direction direction,
                   ll_team *team)
{
    LL_ASSERT(x->n % 2 == 0 && y->n % 2 == 0);
    ll_rows_run(team, y->n / 2, 2 * (int64_t)x->n, cosine_rows, &(row_transforms){x, data, work, direction});
    run_cosines(y, data, work, x->n / 2, direction, team);
}
