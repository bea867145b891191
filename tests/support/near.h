/* Comparisons of real numbers for tests. NaN passes none of them: not as the value, nor as what is wanted,
 * nor as a bound or tolerance. An infinite value passes none, nor a tolerance or bound of infinity that
 * everything would keep. What fails names the test's line and prints the numbers. */
#pragma once

#include <stdbool.h>

/* |got - want| <= tolerance. */
bool is_near(double got, double want, double tolerance);

/* Of two numbers; NaN when either is, so that the worst of many errors is not lost as with fmax and `>`. */
double larger(double a, double b);
double smaller(double a, double b);

#define assert_near(got, want, tolerance)                                                                    \
    assert_near_at(#got, (double)(got), (double)(want), (double)(tolerance), __FILE__, __LINE__)
#define assert_at_most(what, value, most)                                                                    \
    assert_between_at(what, (double)(value), -HUGE_VAL, (double)(most), __FILE__, __LINE__)
#define assert_at_least(what, value, least)                                                                  \
    assert_between_at(what, (double)(value), (double)(least), HUGE_VAL, __FILE__, __LINE__)
#define assert_between(what, value, least, most)                                                             \
    assert_between_at(what, (double)(value), (double)(least), (double)(most), __FILE__, __LINE__)

void assert_near_at(const char *what, double got, double want, double tolerance, const char *file, int line);
void assert_between_at(const char *what, double value, double least, double most, const char *file, int line);
