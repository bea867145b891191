/* Arc tangent by two halvings of the angle and its series; elliptic functions by the arithmetic-geometric
 * mean (Abramowitz and Stegun 16.4, 17.6). */
#include "ode/problems/special.h"

#include "base/detmath.h"

static const double half_pi = 1.57079632679489661923;

static double halved(double x) /* tan(a / 2) from tan(a) */
{
    return x / (1 + ll_sqrt(1 + x * x));
}

double ll_ode_atan(double x)
{
    if (x < 0)
        return -ll_ode_atan(-x);
    if (x > 1)
        return half_pi - ll_ode_atan(1 / x);
    double y = halved(halved(x)), z = y * y, sum = 0; /* y <= 0.199 */
    for (int n = 23; n >= 1; n -= 2)
        sum = 1.0 / n - z * sum;
    return 4 * y * sum;
}

double ll_ode_asin(double x)
{
    double rest = (1 - x) * (1 + x);
    if (rest <= 0)
        return x < 0 ? -half_pi : half_pi;
    return ll_ode_atan(x / ll_sqrt(rest));
}

double ll_ode_tanh(double x)
{
    if (x < 0)
        return -ll_ode_tanh(-x);
    if (x < 0.1) { /* the quotient below loses digits */
        double z = x * x;
        return x / (1 + z / (3 + z / (5 + z / (7 + z / (9 + z / 11)))));
    }
    double e = ll_exp(-2 * x);
    return (1 - e) / (1 + e);
}

double ll_ode_atanh(double x)
{
    return ll_detmath_log((1 + x) / (1 - x)) / 2;
}

double ll_ode_log_cosh(double x)
{
    double z = x < 0 ? -x : x;
    if (z < 0.5) { /* log(1 + 2 sinh^2(x / 2)) by its series in t = tanh^2(x / 2): log((1 + t) / (1 - t)) */
        double h = ll_ode_tanh(z / 2), t = h * h, sum = 0;
        for (int n = 15; n >= 1; n -= 2)
            sum = 1.0 / n + t * t * sum;
        return 2 * t * sum;
    }
    return z + ll_detmath_log((1 + ll_exp(-2 * z)) / 2);
}

enum { LEVELS = 8 };

/* The descending sequence; returns its length. */
static int agm(double k, double a[LEVELS + 1], double c[LEVELS + 1])
{
    double b = ll_sqrt((1 - k) * (1 + k));
    int n = 0;
    a[0] = 1;
    c[0] = k;
    while (n < LEVELS && c[n] > 1e-17) {
        double mean = (a[n] + b) / 2;
        c[n + 1] = (a[n] - b) / 2;
        b = ll_sqrt(a[n] * b);
        a[++n] = mean;
    }
    return n;
}

ll_ode_elliptic ll_ode_jacobi(double u, double k)
{
    double a[LEVELS + 1], c[LEVELS + 1];
    int n = agm(k, a, c);
    double period = 4 * half_pi / a[n];
    u -= period * (double)(long long)(u / period);
    double phi = a[n] * u * (double)(1 << n);
    for (int i = n; i > 0; i--)
        phi = (phi + ll_ode_asin(c[i] / a[i] * ll_sin(phi))) / 2;
    double sn = ll_sin(phi), cn = ll_cos(phi), dn = ll_sqrt((1 - k * sn) * (1 + k * sn));
    return (ll_ode_elliptic){sn, cn, dn};
}
