/* What is measured of a world. */
#pragma once

#include "rigid/body/rigid.h"

typedef struct ll_body_reference { /* where a body was at first */
    ll_vec2 position;
    double angle;
} ll_body_reference;

typedef struct ll_rigid_metrics {
    double penetration_max; /* m, of contacts now */
    double penetration_mean;
    double drift_max;                        /* m sideways from the first place, of dynamic bodies */
    double sag_max;                          /* m down from where it would lie */
    double tilt_max;                         /* rad */
    double kinetic_energy, potential_energy; /* J */
    ll_vec2 momentum;                        /* kg m/s */
    double spin_momentum;                    /* about the origin */
    double speed_max;                        /* m/s */
    double joint_error;                      /* m or rad: the largest error of a joint that is not a spring */
    int32_t contacts, points, passed;        /* passed: dynamic bodies beyond the plane that was asked for */
    int32_t bodies;
} ll_rigid_metrics;

/* `references` has ll_rigid_body_end places. `fall`: how far above their places bodies are at first, m. */
void ll_rigid_refer(const ll_rigid *world, double fall, ll_body_reference *references, int32_t count);
/* Whether something in it may give energy to bodies: one that is moved, a motor, a spring, a person's hand.
 */
bool ll_rigid_is_driven(const ll_rigid *world);
/* `beyond_x`: bodies to the right of it count as passed (INFINITY: none does). */
ll_rigid_metrics ll_rigid_measure(const ll_rigid *world, const ll_body_reference *references, int32_t count,
                                  double beyond_x);
