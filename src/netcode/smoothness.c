#include "netcode/smoothness.h"

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

void ll_smoothness_add(ll_smoothness *s, double x, double y, double truth_x, double truth_y, double dt)
{
    double step_x = x - s->x, step_y = y - s->y, vx = step_x / dt, vy = step_y / dt;
    double ax = (vx - s->vx) / dt, ay = (vy - s->vy) / dt;
    if (s->samples++ >= 3)
        count(s, step_x, step_y, ax, ay, length(truth_x - s->truth_x, truth_y - s->truth_y), dt);
    s->x = x;
    s->y = y;
    s->truth_x = truth_x;
    s->truth_y = truth_y;
    s->step_x = step_x;
    s->step_y = step_y;
    s->vx = vx;
    s->vy = vy;
    s->ax = ax;
    s->ay = ay;
}
