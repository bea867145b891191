/* Smoothness of a drawn entity, by differences of its drawn positions from frame to frame. */
#pragma once

#include <stdint.h>

#include "game/core/game.h"

typedef struct ll_smoothness {
    double x, y, truth_x, truth_y; /* of the last frame, m */
    double step_x, step_y;         /* since the frame before it, m */
    double vx, vy, ax, ay;         /* by differences, m/s and m/s2 */
    int64_t samples;               /* frames seen */
    double acceleration, jerk;     /* sums of squares over `frames` */
    double step_max;               /* m */
    double seconds;                /* duration of `frames` */
    double truth_step_sum;         /* m */
    int64_t frames;                /* from the fourth on: all differences are known */
    int64_t moving,
        frozen; /* frames in which the truth moved; of these, frames in which the drawn entity did not */
    int64_t reversals;       /* steps opposite to the one before */
    double moved_x, moved_y; /* truth when the drawn entity last moved */
    int64_t still;           /* frames since then in which the drawn entity stood while the truth moved */
    int64_t hitches;         /* times that these were more than LL_HITCH_FRAMES in a row */
} ll_smoothness;

#define LL_HITCH_FRAMES 2

/* A frame drew the entity, `dt` seconds after the previous one; the truth is given too, as x and y. Returns
 * the animation error: |the drawn step - the drawn velocity * dt|, m; negative for the first frame. */
double ll_smoothness_add(ll_smoothness *s, const ll_entity *drawn, const double *truth, double dt);
