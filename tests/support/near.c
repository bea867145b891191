#include "support/near.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

bool is_near(double got, double want, double tolerance)
{
    return fabs(got - want) <= tolerance && tolerance < HUGE_VAL;
}

double larger(double a, double b)
{
    return isnan(a) || a > b ? a : b;
}

double smaller(double a, double b)
{
    return isnan(a) || a < b ? a : b;
}

void assert_near_at(const char *what, double got, double want, double tolerance, const char *file, int line)
{
    if (is_near(got, want, tolerance))
        return;
    print_error("%s is %.17g, not %.17g +- %.3g\n", what, got, want, tolerance);
    _fail(file, line);
}

void assert_between_at(const char *what, double value, double least, double most, const char *file, int line)
{
    if (isfinite(value) && value >= least && value <= most && (isfinite(least) || isfinite(most)))
        return;
    print_error("%s is %.17g, not from %.9g to %.9g\n", what, value, least, most);
    _fail(file, line);
}
