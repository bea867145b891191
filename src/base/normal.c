/* Inverse of the normal distribution function by Wichura's AS 241, algorithm PPND16: a rational function of
 * degree 7 over 7 in the middle and two more for the tails. */
#include "base/detmath.h"
#include "base/rng.h"

typedef struct rational {
    double top[8], bottom[8]; /* ascending powers */
} rational;

/* |p - 1/2| <= 0.425, argument 0.425^2 - (p - 1/2)^2 */
static const rational middle = {
    {3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3, 1.3731693765509461125e4,
     4.5921953931549871457e4, 6.7265770927008700853e4, 3.3430575583588128105e4, 2.5090809287301226727e3},
    {1.0, 4.2313330701600911252e1, 6.8718700749205790830e2, 5.3941960214247511077e3, 2.1213794301586595867e4,
     3.9307895800092710610e4, 2.8729085735721942674e4, 5.2264952788528545610e3}};

/* argument sqrt(-log tail) - 1.6, at most 3.4 */
static const rational tail_near = {
    {1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0, 3.64784832476320460504e0,
     1.27045825245236838258e0, 2.41780725177450611770e-1, 2.27238449892691845833e-2,
     7.74545014278341407640e-4},
    {1.0, 2.05319162663775882187e0, 1.67638483018380384940e0, 6.89767334985100004550e-1,
     1.48103976427480074590e-1, 1.51986665636164571966e-2, 5.47593808499534494600e-4,
     1.05075007164441684324e-9}};

/* argument sqrt(-log tail) - 5 */
static const rational tail_far = {
    {6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0, 2.96560571828504891230e-1,
     2.65321895265761230930e-2, 1.24266094738807843860e-3, 2.71155556874348757815e-5,
     2.01033439929228813265e-7},
    {1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1, 1.48753612908506148525e-2,
     7.86869131145613259100e-4, 1.84631831751005468180e-5, 1.42151175831644588870e-7,
     2.04426310338993978564e-15}};

static double evaluate(const rational *f, double x)
{
    double top = f->top[7], bottom = f->bottom[7];
    for (int i = 6; i >= 0; i--) {
        top = top * x + f->top[i];
        bottom = bottom * x + f->bottom[i];
    }
    return top / bottom;
}

double ll_normal_quantile(double p)
{
    double q = p - 0.5;
    if (q >= -0.425 && q <= 0.425)
        return q * evaluate(&middle, 0.180625 - q * q);
    double r = ll_sqrt(-ll_detmath_log(q < 0 ? p : 1 - p));
    double x = r <= 5 ? evaluate(&tail_near, r - 1.6) : evaluate(&tail_far, r - 5);
    return q < 0 ? -x : x;
}

/* x + x^3/3 + x^5/(3 5) + ..., which times the density is the area from 0 to x. */
static double series(double x)
{
    double term = x, sum = x;
    for (int odd = 3; odd < 61; odd += 2) {
        term *= x * x / odd;
        sum += term;
    }
    return sum;
}

/* 1/(x + 1/(x + 2/(x + 3/(x + ...)))), which times the density is the area from x on (Laplace). */
static double fraction(double x)
{
    double f = x;
    for (int i = 120; i >= 1; i--)
        f = x + i / f;
    return 1 / f;
}

double ll_normal_cdf(double x)
{
    double size = x < 0 ? -x : x;
    double density = ll_exp(-0.5 * x * x) * 0.398942280401432678;
    if (size < 1.9)
        return 0.5 + density * series(x);
    double tail = density * fraction(size);
    return x < 0 ? tail : 1 - tail;
}

/* Centre of one of 2^52 equal cells, so that 0 and 1 are impossible. */
double ll_rng_normal(uint64_t seed, uint64_t stream, uint64_t counter)
{
    return ll_normal_quantile(((double)(ll_rng_u64(seed, stream, counter) >> 12) + 0.5) * 0x1p-52);
}
