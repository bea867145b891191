/* Many oscillators x'' = -k x at once, each with its own start and stiffness: arrays of each quantity, so
 * that the compiler makes vectors of them. Every member takes the bits that a run of it alone would
 * (ode/core/run.h, the method of the same name). */
#pragma once

#include <stdint.h>

typedef struct ll_ensemble {
    int count;
    const double *k; /* 1/s2 */
    double *x, *v;   /* m, m/s */
    double *a;       /* m/s2, at x; kept by velocity Verlet */
} ll_ensemble;

void ll_ensemble_accelerate(
    const ll_ensemble *e); /* Computes a from x, before the first step of velocity Verlet. */
void ll_ensemble_semi_implicit_euler(const ll_ensemble *e, double dt, int64_t steps);
void ll_ensemble_velocity_verlet(const ll_ensemble *e, double dt, int64_t steps);
