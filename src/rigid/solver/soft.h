/* The soft step solver's contacts: four side by side, without a common movable body, and the loops over them
 * in three widths. */
#pragma once

#include "rigid/solver/solver.h"

#define LL_LANES 4

/* All that is needed of an arm r is how it lies to the normal: r x n is the normal's lever and - r . n that
 * of the tangent, the normal turned by -90 degrees. */
typedef struct ll_wide_point {
    double cross_a[LL_LANES], dot_a[LL_LANES];
    double cross_b[LL_LANES], dot_b[LL_LANES];
    double adjust[LL_LANES]; /* separation = n . (what the anchors moved to each other) + adjust */
    double normal_mass[LL_LANES], tangent_mass[LL_LANES];
    double normal_impulse[LL_LANES], tangent_impulse[LL_LANES];
} ll_wide_point;

typedef struct ll_wide_contact {
    int32_t a[LL_LANES], b[LL_LANES];
    int32_t contact[LL_LANES]; /* LL_NONE: an empty lane */
    int32_t points[LL_LANES];
    double ma[LL_LANES], ia[LL_LANES], mb[LL_LANES], ib[LL_LANES]; /* inverse masses and moments */
    double nx[LL_LANES], ny[LL_LANES];
    double friction[LL_LANES];
    ll_wide_point at[2]; /* one that is not there has masses 0 and never touches */
} ll_wide_contact;

typedef struct ll_soft_pass {
    ll_softness soft;
    double inverse_h, push_speed;
} ll_soft_pass;

typedef struct ll_soft_loops {
    const char *name;
    void (*warm_start)(ll_wide_contact *at, int32_t count, ll_motion *motions);
    /* Normals only, against overlap: a spring and damper. */
    void (*solve)(ll_wide_contact *at, int32_t count, ll_motion *motions, const ll_soft_pass *pass);
    /* Normals and friction, without correction: takes out the speed that the correction put in. */
    void (*relax)(ll_wide_contact *at, int32_t count, ll_motion *motions, const ll_soft_pass *pass);
} ll_soft_loops;

extern const ll_soft_loops ll_soft_scalar, ll_soft_sse2, ll_soft_avx2;
