#include "netcode/metrics/smoothness.h"

#include <stdbool.h>

#include "base/detmath.h"

static double length(double x, double y)
{
    return ll_sqrt(x * x + y * y);
}

static void count(ll_smoothness *s, double step_x, double step_y, double ax, double ay, double moved,
                  double dt)
{
    double step = length(step_x, step_y), jx = (ax - s->ax) / dt, jy = (ay - s->ay) / dt;
    s->acceleration += ax * ax + ay * ay;
    s->jerk += jx * jx + jy * jy;
    s->frames++;
    s->seconds += dt;
    s->step_max = step > s->step_max ? step : s->step_max;
    s->truth_step_sum += moved;
    s->moving += moved > 0;
    s->frozen += moved > 0 && step == 0;
    s->reversals += step_x * s->step_x + step_y * s->step_y < 0;
}

/* A hitch is counted once, at its first frame above the limit. */
static void count_still(ll_smoothness *s, bool stood, double truth_x, double truth_y)
{
    if (!stood || s->samples == 0) {
        s->moved_x = truth_x;
        s->moved_y = truth_y;
        s->still = 0;
        return;
    }
    s->still += truth_x != s->moved_x || truth_y != s->moved_y;
    s->hitches += s->still == LL_HITCH_FRAMES + 1;
    if (s->still > LL_HITCH_FRAMES)
        s->still = LL_HITCH_FRAMES + 2;
}

double ll_smoothness_add(ll_smoothness *s, const ll_entity *drawn, double truth_x, double truth_y, double dt)
{
    double step_x = drawn->x - s->x, step_y = drawn->y - s->y, vx = step_x / dt, vy = step_y / dt;
    double ax = (vx - s->vx) / dt, ay = (vy - s->vy) / dt;
    double off_x = step_x - drawn->vx * dt, off_y = step_y - drawn->vy * dt;
    double off = off_y == 0 ? (off_x < 0 ? -off_x : off_x) : length(off_x, off_y);
    count_still(s, step_x == 0 && step_y == 0, truth_x, truth_y);
    bool first = s->samples == 0;
    if (s->samples++ >= 3)
        count(s, step_x, step_y, ax, ay, length(truth_x - s->truth_x, truth_y - s->truth_y), dt);
    s->x = drawn->x;
    s->y = drawn->y;
    s->truth_x = truth_x;
    s->truth_y = truth_y;
    s->step_x = step_x;
    s->step_y = step_y;
    s->vx = vx;
    s->vy = vy;
    s->ax = ax;
    s->ay = ay;
    return first ? -1 : off;
}
