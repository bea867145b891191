/* Dense linear systems of the few unknowns of an implicit step, and their Jacobian. Matrices are n x n, by
 * rows; a factorisation replaces its matrix. */
#pragma once

#include <stdbool.h>

#include "ode/core/ode.h"
#include "ode/core/run.h"

/* LU with row exchanges. false: the matrix is singular or not finite. */
bool ll_lu_factorise(int n, double *a, int32_t *pivot);
/* Whether the determinant of the factorised matrix is positive. */
bool ll_lu_positive(int n, const double *a, const int32_t *pivot);
void ll_lu_solve(int n, const double *a, const int32_t *pivot, double *b);

/* The same for complex matrices; real and imaginary parts are separate. */
bool ll_lu_factorise_complex(int n, double *re, double *im, int32_t *pivot);
void ll_lu_solve_complex(int n, const double *re, const double *im, const int32_t *pivot, double *b_re,
                         double *b_im);

/* Jacobian of the system at (t, y), where f is `f`; by forward differences if the system gives none.
 * `scratch` has two vectors. Counted in the run. */
void ll_ode_jacobian_at(ll_ode_run *run, const ll_ode *ode, double t, const double *y, const double *f,
                        double *jacobian, double *scratch);
