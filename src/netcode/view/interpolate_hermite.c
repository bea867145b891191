/* Hermite: the cubic with the positions and the velocities of both snapshots (Fiedler, "Snapshot
 * Interpolation"). It is exact for motion under constant acceleration and for any cubic; otherwise the error
 * is at most j' dt^4 / 384 where the fourth derivative is at most j'. Speed is continuous at a snapshot. It
 * depends on the velocities: where one is not that of the path, as across a contact, it overshoots. Cost:
 * about 20 multiplications per coordinate. */
#include "netcode/view/view.h"

/* Position and velocity of one coordinate; `s`: fraction of the way, `t`: its length in seconds. */
static void cubic(double p, double v, double q, double w, double s, double t, double *place, double *speed)
{
    double c2 = 3 * (q - p) - t * (2 * v + w), c3 = t * (v + w) - 2 * (q - p);
    *place = p + s * (t * v + s * (c2 + s * c3));
    *speed = v + s * (2 * c2 + s * 3 * c3) / t;
}

static void between(const ll_entity *a, const ll_entity *b, double alpha, double span_s, ll_entity *out)
{
    cubic(a->x, a->vx, b->x, b->vx, alpha, span_s, &out->x, &out->vx);
    cubic(a->y, a->vy, b->y, b->vy, alpha, span_s, &out->y, &out->vy);
    cubic(a->angle, a->angular_velocity, b->angle, b->angular_velocity, alpha, span_s, &out->angle,
          &out->angular_velocity);
}

static void all(const ll_stretch *stretch)
{
    ll_interpolate_all(stretch, between);
}

const ll_interpolation ll_interpolation_hermite = {
    .name = "hermite",
    .help = "On the cubic through two snapshots that also has their velocities.",
    .between = between,
    .all = all,
};
