/* Linear: the paper's formula ("Interpolation"). Between snapshots dt apart the error is at most a dt^2 / 8
 * where the acceleration is at most a, and speed jumps at every snapshot. Cost: six multiplications per
 * entity. */
#include "netcode/view/view.h"

static void between(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out)
{
    (void)span_s;
    out->x = a->x + alpha * (b->x - a->x);
    out->y = a->y + alpha * (b->y - a->y);
    out->vx = a->vx + alpha * (b->vx - a->vx);
    out->vy = a->vy + alpha * (b->vy - a->vy);
    out->angle = a->angle + alpha * (b->angle - a->angle);
    out->angular_velocity = a->angular_velocity + alpha * (b->angular_velocity - a->angular_velocity);
}

static void all(const ll_stretch *stretch)
{
    ll_interpolate_all(stretch, between);
}

const ll_interpolation ll_interpolation_linear = {
    .name = "linear",
    .help = "On the straight line between two snapshots.",
    .settles = true,
    .between = between,
    .all = all,
};
