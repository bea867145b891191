#include "game/weapons/roots.h"

#include <stdbool.h>

static double value_of(const double *c, int degree, double u)
{
    double sum = c[degree];
    for (int i = degree - 1; i >= 0; i--)
        sum = sum * u + c[i];
    return sum;
}

/* The single root between `a` and `b`, to 2^-56 of their distance. */
static double bisect(const double *c, int degree, double a, double b)
{
    bool above = value_of(c, degree, a) > 0;
    for (int i = 0; i < 56; i++) {
        double u = a + (b - a) / 2;
        if ((value_of(c, degree, u) > 0) == above)
            a = u;
        else
            b = u;
    }
    return b;
}

int ll_sign_changes(const double *c, int degree, double *roots)
{
    if (degree == 1) {
        roots[0] = c[1] != 0 ? -c[0] / c[1] : -1;
        return roots[0] > 0 && roots[0] <= 1;
    }
    double slope[LL_DEGREE_MAX], turns[LL_DEGREE_MAX];
    for (int i = 0; i < degree; i++)
        slope[i] = (i + 1) * c[i + 1];
    int count = ll_sign_changes(slope, degree - 1, turns), found = 0;
    double a = 0;
    for (int i = 0; i <= count; i++) {
        double b = i < count ? turns[i] : 1;
        if ((value_of(c, degree, a) > 0) != (value_of(c, degree, b) > 0))
            roots[found++] = bisect(c, degree, a, b);
        a = b;
    }
    return found;
}
