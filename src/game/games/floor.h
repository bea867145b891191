/* Discs and boxes that push one another about on a floor between four walls, seen from above.
 *
 * A contact is smooth and inelastic: along its normal, bodies that approach go on together. The floor holds
 * by Coulomb's law: it changes a body's velocity by at most grip a second, towards the one that the body
 * wants, which is 0 for a thing that only lies there; and in the same way its spin. (Sliding and turning are
 * held apart, each by its own limit: a thing that does both is held a little too well.)
 *
 * A step is one of src/rigid's (solver pgs_ngs, speculative contacts, friction joints for the floor) in a
 * world that is made of the bodies for it and then forgotten. So a body is its place and its velocity and
 * nothing else: what a state tells of them is all that there is to know, to the bit, and what is kept of the
 * past is 56 bytes a body and not the 5 kB that it has in a rigid world. The price is that a step knows
 * no impulses of the one before it, as it would for stacks. The world has only those bodies that move and
 * those that these may come to: who slides where nothing is near is moved by the same law alone, and at rest
 * a body costs nothing and stays as it is, to the bit. What the floor
 * holds and is slower than 1 mm/s comes to rest.
 *
 * Cost: bodies that move and those that they may press, times the few around each. No allocation; 1.5 MB of
 * stack. */
#pragma once

#include <stdbool.h>
#include <stdint.h>

#include "game/core/game.h"

typedef struct ll_floor_body {
    double x, y, angle;          /* m, rad */
    double vx, vy, spin;         /* m/s, rad/s */
    double wanted_vx, wanted_vy; /* m/s */
    double grip, grip_spin;      /* m/s2, rad/s2: the most that the floor changes velocity and spin */
    double half;                 /* m: radius of a disc, half the side of a box */
    double inverse_mass, inverse_inertia; /* 1/kg, 1/(kg m2); 0: it stays where it is */
    bool round;
    bool unsettled;      /* set by a step: it overlapped something and was moved; not at rest yet */
    uint32_t pressed_by; /* set by a step: bit i for body i of the first 32 */
} ll_floor_body;

typedef struct ll_floor {
    double width, depth; /* m: the walls are x = 0 and width, y = 0 and depth */
    double top_speed;    /* m/s: nothing goes faster, and no corner turns faster */
    double half_max;     /* m: the largest `half` of a body */
    int substeps;        /* of a step */
} ll_floor;

/* How many substeps of a step of `dt` keep the overlap that a contact leaves small beside a body of
 * `half_min`. */
int ll_floor_substeps(double dt, double top_speed, double half_min);

double ll_floor_bound(const ll_floor_body *body); /* m: radius of the circle around it */

/* m: bodies whose outlines are so near may touch in the step, and are looked at as a pair. */
double ll_floor_margin(const ll_game_env *env, const ll_floor *floor);

/* Advances `count` bodies, at most LL_ENTITIES_MAX, by env->dt. Those that overlap at the start are moved
 * apart. */
void ll_floor_step(const ll_game_env *env, const ll_floor *floor, ll_floor_body *bodies, int count);
