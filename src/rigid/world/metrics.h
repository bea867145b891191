/* What is measured of a world. */
#pragma once

#include "rigid/body/rigid.h"

typedef struct ll_body_reference { /* initial position of a body */
    ll_vec2 position;
    double angle;
} ll_body_reference;

typedef struct ll_rigid_metrics {
    double penetration_max; /* m, of current contacts */
    double penetration_mean;
    double drift_max;                        /* m sideways from the initial position, of dynamic bodies */
    double sag_max;                          /* m below its resting position */
    double tilt_max;                         /* rad */
    double kinetic_energy, potential_energy; /* J */
    ll_vec2 momentum;                        /* kg m/s */
    double spin_momentum;                    /* about the origin */
    double speed_max;                        /* m/s */
    double joint_error;                      /* m or rad: largest error of a joint other than a spring */
    int32_t contacts, points, passed;        /* passed: dynamic bodies beyond the given plane */
    int32_t bodies;
} ll_rigid_metrics;

/* `references` has ll_rigid_body_end elements. `fall`: initial height of bodies above their resting
 * positions, m. */
void ll_rigid_refer(const ll_rigid *world, double fall, ll_body_reference *references, int32_t count);
/* Whether anything may add energy: a kinematic body, a motor, a spring, a mouse joint. */
bool ll_rigid_is_driven(const ll_rigid *world);
/* `tunnel_x`: bodies to the right of it count as passed; INFINITY: none. */
ll_rigid_metrics ll_rigid_measure(const ll_rigid *world, const ll_body_reference *references, int32_t count,
                                  double tunnel_x);
