/* Roots of polynomials of low degree. */
#pragma once

#define LL_DEGREE_MAX 6

/* Roots in (0, 1] of the polynomial sum c[i] u^i, of degree 1 to LL_DEGREE_MAX, at which its sign changes, in
 * order, to 2^-56; returns their count. Between two extrema, which are the roots of its derivative, there is
 * at most one. */
int ll_sign_changes(const double *c, int degree, double *roots);
