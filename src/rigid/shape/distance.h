/* Distance of two shapes by GJK (Gilbert, Johnson, Keerthi 1988), and their time of impact by conservative
 * advancement (Mirtich 1996; along the axis of separation, as Zhang et al. 2006). */
#pragma once

#include "rigid/shape/shape.h"

typedef struct ll_distance_result {
    double distance;          /* 0 when they overlap; radii are subtracted */
    ll_vec2 point_a, point_b; /* nearest, in world coordinates; equal when the hulls without radius overlap */
    ll_vec2 normal;           /* from a to b; zero when the hulls without radius overlap */
    int iterations;
} ll_distance_result;

ll_distance_result ll_distance(const ll_geometry *a, ll_pose pose_a, const ll_geometry *b, ll_pose pose_b);

typedef struct ll_sweep { /* linear motion of a pose: from `start` by `shift` and `turn` */
    ll_pose start;
    ll_vec2 shift;
    double turn;
} ll_sweep;

ll_pose ll_sweep_at(const ll_sweep *sweep, double t); /* t in [0, 1] */

typedef struct ll_toi_result {
    bool hit;
    double t; /* fraction of the step at which the distance has decreased to `target`; 1 without a hit */
    int iterations;
} ll_toi_result;

/* First time at which the shapes are `target` apart. No hit, if they are already nearer at the start. */
ll_toi_result ll_time_of_impact(const ll_geometry *a, const ll_sweep *sweep_a, const ll_geometry *b,
                                const ll_sweep *sweep_b, double target);

/* Whether a cheap bound shows that the shapes stay farther apart than `margin` in all of the motion. Then
 * ll_time_of_impact has no hit for a target of at most margin / 1.05. false: unknown. */
bool ll_sweeps_stay_apart(const ll_geometry *a, const ll_sweep *sweep_a, const ll_geometry *b,
                          const ll_sweep *sweep_b, double margin);
