/* Contacts of the soft step solver: four per struct, without a common movable body, and the loops over them
 * in three widths. */
#pragma once

#include "rigid/solver/solver.h"

#define LL_LANES 4

/* An anchor r is stored by its lever arms: r x n for the normal, and - r . n for the tangent, which is the
 * normal rotated by -90 degrees. */
typedef struct ll_wide_point {
    double cross_a[LL_LANES], dot_a[LL_LANES];
    double cross_b[LL_LANES], dot_b[LL_LANES];
    double adjust[LL_LANES]; /* separation = n . (relative motion of the anchors) + adjust */
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
    double coupling[LL_LANES]; /* change of one point's normal velocity by an impulse at the other */
    ll_wide_point at[2];       /* an absent point has masses 0 and never touches */
} ll_wide_contact;

typedef struct ll_soft_pass {
    ll_softness soft;
    double inverse_h, contact_push_speed;
    /* The state that immovable bodies are written to, in place of their own, which threads share; LL_NONE:
     * all bodies can move. */
    int32_t sink, pad;
} ll_soft_pass;

typedef void ll_soft_loop(ll_wide_contact *at, int32_t count, ll_solver_body *states,
                          const ll_soft_pass *pass);

typedef struct ll_soft_loops {
    const char *name;
    ll_soft_loop *warm_start; /* needs no more of the pass than the sink */
    ll_soft_loop *solve;      /* normals only, against overlap, as a spring and a damper */
    /* Normals and friction without bias: removes the velocity that the correction added. */
    ll_soft_loop *relax;
} ll_soft_loops;

extern const ll_soft_loops ll_soft_scalar, ll_soft_sse2, ll_soft_avx2;
