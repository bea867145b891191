/* Joints as rows of constraints.
 *
 * A joint of any type makes up to six rows. A row has a value C that should be 0 (or at least 0), its
 * dependence on the two bodies' velocities, and a largest impulse. Solvers work on rows and know no joint
 * types. */
#pragma once

#include "rigid/contact/contact.h"

#define LL_ROWS 6

typedef enum ll_constraint_row_kind {
    LL_ROW_NONE,
    LL_ROW_EQUAL, /* C = 0 */
    LL_ROW_LIMIT, /* C >= 0; positive impulses only */
    LL_ROW_MOTOR, /* dC/dt = speed, with a force of at most `most` */
} ll_constraint_row_kind;

/* dC/dt = n . (v_b - v_a) + jb w_b - ja w_a */
typedef struct ll_constraint_row {
    int32_t kind, pad;
    double c;
    ll_vec2 n;
    double ja, jb;
    double speed;          /* of a motor */
    double most;           /* largest force, N or N m */
    double hertz, damping; /* of a spring; 0: the solver's joint stiffness */
} ll_constraint_row;

typedef struct ll_joint_row_type {
    /* Fills the rows for two bodies in these poses; each row keeps its number. With `block`, rows 0 and 1 are
     * solved together. */
    void (*rows)(const ll_joint *joint, ll_pose a, ll_pose b, double angle, ll_constraint_row out[LL_ROWS]);
    bool block;
} ll_joint_row_type;

extern const ll_joint_row_type ll_joint_row_types[LL_JOINT_TYPES];

void ll_unlink_joint(ll_rigid *w, int32_t joint); /* wakes both bodies */
