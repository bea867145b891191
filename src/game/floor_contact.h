/* Where two bodies of a floor touch, or will within a step. */
#pragma once

#include "game/floor.h"

#define LL_FLOOR_WALL (-1)

typedef struct ll_floor_frame { /* a body's place with the cosine and sine of its angle */
    double x, y, cos, sin;
} ll_floor_frame;

typedef struct ll_floor_point {
    double x, y;   /* m: where */
    double nx, ny; /* from the first body to the second */
    double gap;    /* m; negative: overlap */
} ll_floor_point;

double ll_floor_bound(const ll_floor_body *body); /* m: radius of the circle around it */

/* Points that are at most `margin` apart; returns how many: at most 2. */
int ll_floor_touch(const ll_floor_body *a, const ll_floor_frame *fa, const ll_floor_body *b,
                   const ll_floor_frame *fb, double margin, ll_floor_point points[2]);

/* The same of a body and the wall with outward normal (nx, ny) at distance `wall` from the origin along it.
 */
int ll_floor_touch_wall(const ll_floor_body *body, const ll_floor_frame *frame, double nx, double ny,
                        double wall, double margin, ll_floor_point points[2]);
