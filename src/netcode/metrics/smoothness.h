/* M8: how smoothly an entity is drawn, by differences of its drawn places from frame to frame. */
#pragma once

#include <stdint.h>

#include "game/core/game.h"

typedef struct ll_smoothness {
    double x, y, truth_x, truth_y;   /* of the last frame, m */
    double step_x, step_y;           /* since the one before it, m */
    double vx, vy, ax, ay;           /* by differences, m/s and m/s2 */
    int64_t samples;                 /* frames seen */
    double acceleration, jerk;       /* sums of squares over `frames` */
    double step_max, truth_step_sum; /* m */
    double seconds;                  /* that `frames` took */
    int64_t frames;                  /* from the fourth on: all differences are known */
    int64_t moving, frozen;          /* the truth moved; of these, what is drawn did not */
    int64_t reversals;               /* steps back: against the one before */
    double moved_x, moved_y;         /* the truth when what is drawn moved last */
    int64_t still;                   /* frames since, that stood while the truth went on */
    int64_t hitches;                 /* times that these were more than LL_HITCH_FRAMES in a row */
} ll_smoothness;

#define LL_HITCH_FRAMES 2

/* A frame drew the entity, `dt` seconds after the one before; the truth was elsewhere. Returns the animation
 * error: |the drawn step - the drawn velocity * dt|, m; negative for the first frame. */
double ll_smoothness_add(ll_smoothness *s, const ll_entity *drawn, double truth_x, double truth_y, double dt);
