/* Discs and boxes that push each other on a floor between four walls, seen from above.
 *
 * Contacts are frictionless and inelastic: bodies that approach move on together along the normal. The floor
 * holds by Coulomb friction: it changes a body's velocity by at most `grip` per second towards the wanted
 * velocity, which is 0 for crates, and its angular velocity likewise. (Sliding and rotation are limited
 * separately: a body that does both is held slightly too well.)
 *
 * A step is one of src/rigid (solver pgs_ngs, speculative contacts, friction joints for the floor) in a world
 * that is made from the bodies and then discarded. So position and velocity are the whole state of a body: a
 * snapshot holds it to the bit, and the history takes 56 bytes per body, not the 5 kB of a rigid world. The
 * price is that a step does not know the impulses of the last one, which stacks would need. The world holds
 * only moving bodies and those that they may reach. A body that slides with nothing near is moved by the same
 * law alone. A resting body costs nothing and stays as it is, to the bit. A body that the floor holds and
 * that is slower than 1 mm/s comes to rest.
 *
 * Cost: moving bodies and those that they may press, times their neighbours. No allocation; 1.5 MB of
 * stack. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "game/core/game.h"

typedef struct ll_floor_body {
    double x, y, angle;                   /* m, rad */
    double vx, vy, angular_velocity;      /* m/s, rad/s */
    double wanted_vx, wanted_vy;          /* m/s */
    double grip, grip_spin;               /* m/s2, rad/s2: largest change of both velocities by the floor */
    double half;                          /* m: radius of a disc, half the side of a box */
    double inverse_mass, inverse_inertia; /* 1/kg, 1/(kg m2); 0: immovable */
    bool round;
    bool absent;         /* takes no part: its place is not known */
    bool unsettled;      /* set by a step: it overlapped something and was moved; not at rest yet */
    uint32_t pressed_by; /* set by a step: bit i for body i of the first 32 */
} ll_floor_body;

typedef struct ll_floor {
    double width, depth; /* m: the walls are x = 0 and width, y = 0 and depth */
    double top_speed;    /* m/s: limit of all speeds, and of corners by rotation */
    double half_max;     /* m: largest `half` of a body */
    int substeps;        /* per step */
} ll_floor;

/* Number of substeps for a step of `dt` that keeps the overlap of contacts small against a body of
 * `half_min`. */
int ll_floor_substeps(double dt, double top_speed, double half_min);

double ll_floor_bound(const ll_floor_body *body); /* m: radius of its bounding circle */

/* m: bodies with outlines nearer than this may touch in the step and make a pair. */
double ll_floor_margin(const ll_game_env *env, const ll_floor *floor);

/* Advances `count` bodies, at most LL_TOUCHING_MAX, by env->dt. Initial overlaps are corrected. */
void ll_floor_step(const ll_game_env *env, const ll_floor *floor, ll_floor_body *bodies, int count);
