#include "netcode/metrics/smoothness.h"

#include <stdbool.h>

#include "base/detmath.h"
#include "base/pair.h"

/* Two numbers that lie side by side. */
static inline ll_pair pair_at(const double *first)
{
    return *(const ll_pair *)(const void *)first;
}

static inline void put_pair(double *first, ll_pair pair)
{
    *(ll_pair *)(void *)first = pair;
}

static double length(double x, double y)
{
    if (y == 0)
        return x < 0 ? -x : x; /* exactly the root */
    return ll_sqrt(x * x + y * y);
}

static double product(ll_pair a, ll_pair b)
{
    ll_pair c = a * b;
    return c[0] + c[1];
}

static void count(ll_smoothness *s, ll_pair step, ll_pair acceleration, double moved, double dt)
{
    ll_pair jerk = (acceleration - pair_at(&s->ax)) / dt;
    double far = length(step[0], step[1]);
    s->acceleration += product(acceleration, acceleration);
    s->jerk += product(jerk, jerk);
    s->frames++;
    s->seconds += dt;
    s->step_max = far > s->step_max ? far : s->step_max;
    s->truth_step_sum += moved;
    if (moved > 0) {
        s->moving++;
        s->frozen += far == 0;
    }
    s->reversals += product(step, pair_at(&s->step_x)) < 0;
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

/* x and y at once. */
double ll_smoothness_add(ll_smoothness *s, const ll_entity *drawn, double truth_x, double truth_y, double dt)
{
    ll_pair at = pair_at(&drawn->x), step = at - pair_at(&s->x), speed = step / dt;
    ll_pair acceleration = (speed - pair_at(&s->vx)) / dt, off = step - pair_at(&drawn->vx) * dt;
    count_still(s, step[0] == 0 && step[1] == 0, truth_x, truth_y);
    bool first = s->samples == 0;
    if (s->samples++ >= 3)
        count(s, step, acceleration, length(truth_x - s->truth_x, truth_y - s->truth_y), dt);
    put_pair(&s->x, at);
    s->truth_x = truth_x;
    s->truth_y = truth_y;
    put_pair(&s->step_x, step);
    put_pair(&s->vx, speed);
    put_pair(&s->ax, acceleration);
    return first ? -1 : length(off[0], off[1]);
}
