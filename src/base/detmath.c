/* Elementary functions from + - * / and sqrt alone. Each reduces its argument to a small interval, in which a
 * Taylor series of few terms is accurate to less than half an ulp; the rest is the rounding of the last
 * operations. */
#include "base/detmath.h"

#include <float.h>
#include <stdint.h>
#include <string.h>

#include "base/pair.h"

static const double ln2_high = 0x1.62e42feep-1,
                    ln2_low = 0x1.a39ef35793c76p-33; /* the high part has 21 trailing zero bits */
static const double infinity = (double)__builtin_inff();

/* pi / 2 in three parts of at most 33 bits, so that k times the first two is exact for |k| < 2^20, and a
 * fourth for the remainder. */
static const double pio2_1 = 0x1.921fb544p+0, pio2_2 = 0x1.0b4611a6p-34, pio2_3 = 0x1.3198a2ep-69,
                    pio2_4 = 0x1.b839a252049c1p-104;

static double from_bits(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

static uint64_t to_bits(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

/* Nearest integer, for |x| < 2^51. */
static double nearest(double x)
{
    const double shift = 0x1.8p52;
    return (x + shift) - shift;
}

static double power_of_two(int n) /* -1022 <= n <= 1023 */
{
    return from_bits((uint64_t)(n + 1023) << 52);
}

double ll_exp(double x)
{
    if (x != x)
        return x;
    if (x > 709.79)
        return infinity;
    if (x < -745.2)
        return 0;
    double k = nearest(x * (1 / 0.6931471805599453));
    double r = (x - k * ln2_high) - k * ln2_low; /* |r| <= 0.347 */
    double sum = 1.0 / 87178291200.0;            /* 1/14!, down to 1/2! */
    static const double inverse[] = {1.0 / 6227020800.0, 1.0 / 479001600.0, 1.0 / 39916800.0, 1.0 / 3628800.0,
                                     1.0 / 362880.0,     1.0 / 40320.0,     1.0 / 5040.0,     1.0 / 720.0,
                                     1.0 / 120.0,        1.0 / 24.0,        1.0 / 6.0,        0.5};
    for (int i = 0; i < 12; i++)
        sum = sum * r + inverse[i];
    double e = 1 + (r + r * r * sum);
    int n = (int)k;
    if (n < -1021) /* the result may be subnormal: scale in two steps */
        return e * power_of_two(n + 60) * 0x1p-60;
    if (n > 1022)
        return e * power_of_two(n - 1) * 2;
    return e * power_of_two(n);
}

double ll_detmath_log(double x)
{
    if (x != x || x < 0)
        return from_bits(0x7ff8000000000000u);
    if (x == 0)
        return -infinity;
    if (x > DBL_MAX)
        return x;
    int n = 0;
    if (x < DBL_MIN) {
        x *= 0x1p54;
        n = -54;
    }
    /* x = 2^n m with m in [sqrt(1/2), sqrt(2)) */
    uint64_t bits = to_bits(x) + (0x3ff0000000000000u - 0x3fe6a09e667f3bcdu);
    n += (int)(bits >> 52) - 1023;
    double m = from_bits((bits & 0xfffffffffffffu) + 0x3fe6a09e667f3bcdu);
    /* ln m = 2 atanh(s), s = f / (2 + f), f = m - 1 (exact); f^2/2 is split off so that f itself keeps its
     * bits */
    double f = m - 1, s = f / (2 + f), z = s * s, sum = 0; /* z <= 0.0295 */
    for (int i = 23; i >= 3; i -= 2)
        sum = z * (2.0 / i + sum);
    double half = 0.5 * f * f;
    double tail = s * (half + sum) + n * ln2_low;
    return n * ln2_high + (f - (half - tail));
}

/* ---- sine and cosine ---- */

static const double sine_terms[] = {
    1.0 / 355687428096000.0, -1.0 / 1307674368000.0, 1.0 / 6227020800.0, -1.0 / 39916800.0,
    1.0 / 362880.0,          -1.0 / 5040.0,          1.0 / 120.0,        -1.0 / 6.0};
static const double cosine_terms[] = {
    -1.0 / 6402373705728000.0, 1.0 / 20922789888000.0, -1.0 / 87178291200.0, 1.0 / 479001600.0,
    -1.0 / 3628800.0,          1.0 / 40320.0,          -1.0 / 720.0,         1.0 / 24.0};

/* For one number and for two at once, from the same text: `real` is double or ll_pair.
 *
 * reduce: x - k pi/2 as high + low, for |x| <= 1e6; beyond, the error grows with x. The products with the
 * first two parts of pi/2 are exact, and so is the first difference; `error` and `lost` are rounding errors.
 * Returns a number whose last two bits are those of k. sine, cosine: of x + low, on |x| <= pi/4. */
#define LL_TRIGONOMETRY(real, of)                                                                            \
    LL_INLINE real reduce##of(real x, real *high, real *low)                                                 \
    {                                                                                                        \
        const double shift = 0x1.8p52;                                                                       \
        real shifted = x * 0.6366197723675814 + shift, k = shifted - shift;                                  \
        real second = x - k * pio2_1, a = second - k * pio2_2, error = (second - a) - k * pio2_2;            \
        real b = k * pio2_3, r = a - b, lost = (a - r) - b;                                                  \
        real rest = error + lost - k * pio2_4;                                                               \
        *high = r + rest;                                                                                    \
        *low = (r - *high) + rest;                                                                           \
        return shifted;                                                                                      \
    }                                                                                                        \
    LL_INLINE real sine##of(real x, real low)                                                                \
    {                                                                                                        \
        real z = x * x, sum = z * (-1.0 / 121645100408832000.0) + sine_terms[0]; /* 1/19! */                 \
        for (int i = 1; i < 8; i++)                                                                          \
            sum = sum * z + sine_terms[i];                                                                   \
        return x + (x * z * sum + low * (1 - 0.5 * z));                                                      \
    }                                                                                                        \
    LL_INLINE real cosine##of(real x, real low)                                                              \
    {                                                                                                        \
        real z = x * x, sum = z * (1.0 / 2432902008176640000.0) + cosine_terms[0]; /* 1/20! */               \
        for (int i = 1; i < 8; i++)                                                                          \
            sum = sum * z + cosine_terms[i];                                                                 \
        real half = 0.5 * z, w = 1 - half;                                                                   \
        return w + (((1 - w) - half) + (z * z * sum - x * low));                                             \
    }

LL_TRIGONOMETRY(double, )
LL_TRIGONOMETRY(ll_pair, _pair)

/* Sine at `turns` quarter turns beyond r + low. */
static inline double turned(uint64_t turns, double r, double low)
{
    switch (turns & 3) {
    case 0:
        return sine(r, low);
    case 1:
        return cosine(r, low);
    case 2:
        return -sine(r, low);
    default:
        return -cosine(r, low);
    }
}

double ll_sin(double x)
{
    double r, low, turns = reduce(x, &r, &low);
    return turned(to_bits(turns), r, low);
}

double ll_cos(double x)
{
    double r, low, turns = reduce(x, &r, &low);
    return turned(to_bits(turns) + 1, r, low);
}

void ll_sincos(double x, double *sin, double *cos)
{
    double r, low, turns = reduce(x, &r, &low);
    *sin = turned(to_bits(turns), r, low);
    *cos = turned(to_bits(turns) + 1, r, low);
}

/* Branch-free version: the case of each lane is unpredictable. */
typedef uint64_t lanes __attribute__((vector_size(16)));

static inline ll_pair turned_pair(lanes turns, ll_pair sine, ll_pair cosine)
{
    lanes odd = -(turns & 1), sign = (turns & 2) << 62;
    return (ll_pair)((((lanes)cosine & odd) | ((lanes)sine & ~odd)) ^ sign);
}

void ll_pair_sincos(ll_pair x, ll_pair *sin, ll_pair *cos)
{
    ll_pair r, low, turns = reduce_pair(x, &r, &low), s = sine_pair(r, low), c = cosine_pair(r, low);
    *sin = turned_pair((lanes)turns, s, c);
    *cos = turned_pair((lanes)turns + 1, s, c);
}

ll_pair ll_pair_sin(ll_pair x)
{
    ll_pair sin, cos;
    ll_pair_sincos(x, &sin, &cos);
    return sin;
}

ll_pair ll_pair_cos(ll_pair x)
{
    ll_pair sin, cos;
    ll_pair_sincos(x, &sin, &cos);
    return cos;
}

/* For t in [0, 1]: relative to the nearest of three angles, whose tangents are 0, sqrt(2) - 1 and 1. */
static double arctan(double t)
{
    const double middle = 0x1.a827999fcef32p-2;
    double high = 0, low = 0, r = t; /* |r| <= tan(pi / 16) = 0.199 */
    if (t > 0.6681786379192989) {
        high = 0x1.921fb54442d18p-1, low = 0x1.1a62633145c07p-55;
        r = (t - 1) / (1 + t);
    } else if (t > 0.198912367379658) {
        high = 0x1.921fb54442d18p-2, low = 0x1.c398861b78b55p-59;
        r = (t - middle) / (1 + t * middle);
    }
    double z = r * r, sum = 0;
    for (int i = 25; i >= 3; i -= 2)
        sum = z * (1.0 / i - sum);
    return high + (r - (r * sum - low));
}

double ll_atan2(double y, double x)
{
    const double pi_high = 0x1.921fb54442d18p+1, pi_low = 0x1.1a62633145c07p-53;
    double ax = x < 0 ? -x : x, ay = y < 0 ? -y : y;
    if (ax == 0 && ay == 0)
        return 0;
    double a = ay > ax ? pi_high / 2 - (arctan(ax / ay) - pi_low / 2) : arctan(ay / ax);
    if (x < 0)
        a = pi_high - (a - pi_low);
    return y < 0 ? -a : a;
}
