/* Linear: the paper's formula ("Interpolation"). Between snapshots dt apart the error is at most a dt^2 / 8
 * where the acceleration is at most a, and speed jumps at every snapshot. Cost: six multiplications per
 * entity. */
#include "base/pair.h"
#include "netcode/view/view.h"

/* The numbers of an entity in pairs: positions, velocities, angles. */
static inline void blend(const ll_entity *a, const ll_entity *b, double alpha, ll_entity *out)
{
    const ll_pair *from = (const ll_pair *)(const void *)a, *to = (const ll_pair *)(const void *)b;
    ll_pair *at = (ll_pair *)(void *)out;
    const ll_pair place = from[0] + alpha * (to[0] - from[0]), speed = from[1] + alpha * (to[1] - from[1]),
                  angle = from[2] + alpha * (to[2] - from[2]);
    at[0] = place;
    at[1] = speed;
    at[2] = angle;
}

static void between(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out)
{
    (void)span_s;
    blend(a, b, alpha, out);
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
