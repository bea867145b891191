#include "game/weapons/drag_flight.h"

#include "base/detmath.h"
#include "game/weapons/roots.h"

#define NEVER 1e300
#define STEPS 128 /* of the integration per time scale of the motion */

typedef struct motion {
    ll_point at, velocity; /* `at` from the muzzle on */
} motion;

/* The flight from one node to the next: for u in [0, 1] its position is the sum of x[i] u^i, and of y. */
typedef struct piece {
    double begin, h; /* s, of flight */
    double x[4], y[4];
} piece;

typedef struct walk {
    const ll_flight *flight;
    motion now; /* at the end of `piece` */
    piece piece;
} walk;

static ll_point acceleration(const ll_flight *f, ll_point v)
{
    double braking = f->drag * ll_sqrt(v.x * v.x + v.y * v.y);
    return (ll_point){-braking * v.x, -braking * v.y - f->gravity};
}

static ll_point plus(ll_point a, double h, ll_point b)
{
    return (ll_point){a.x + h * b.x, a.y + h * b.y};
}

/* The weights 1, 2, 2, 1 of a sixth. */
static ll_point weighted(ll_point a, ll_point b, ll_point c, ll_point d)
{
    return (ll_point){(a.x + 2 * b.x + 2 * c.x + d.x) / 6, (a.y + 2 * b.y + 2 * c.y + d.y) / 6};
}

static motion runge_kutta(const ll_flight *f, const motion *m, double h)
{
    ll_point v1 = m->velocity, a1 = acceleration(f, v1);
    ll_point v2 = plus(v1, h / 2, a1), a2 = acceleration(f, v2);
    ll_point v3 = plus(v1, h / 2, a2), a3 = acceleration(f, v3);
    ll_point v4 = plus(v1, h, a3), a4 = acceleration(f, v4);
    return (motion){plus(m->at, h, weighted(v1, v2, v3, v4)), plus(v1, h, weighted(a1, a2, a3, a4))};
}

/* Hermite's cubic: positions and velocities of both ends. */
static void cubic(double *c, double x0, double v0, double x1, double v1)
{
    c[0] = x0;
    c[1] = v0;
    c[2] = 3 * (x1 - x0) - 2 * v0 - v1;
    c[3] = 2 * (x0 - x1) + v0 + v1;
}

static void next(walk *w)
{
    const ll_flight *f = w->flight;
    const motion m = w->now;
    double speed = ll_sqrt(m.velocity.x * m.velocity.x + m.velocity.y * m.velocity.y);
    double rate = f->drag * speed + ll_sqrt(f->drag * ll_abs(f->gravity));
    piece *p = &w->piece;
    double most = 0.25 + (p->begin + p->h) / 16, h = STEPS * rate * most > 1 ? 1 / (STEPS * rate) : most;
    w->now = runge_kutta(f, &m, h);
    p->begin += p->h;
    p->h = h;
    cubic(p->x, f->from.x + m.at.x, h * m.velocity.x, f->from.x + w->now.at.x, h * w->now.velocity.x);
    cubic(p->y, f->from.y + m.at.y, h * m.velocity.y, f->from.y + w->now.at.y, h * w->now.velocity.y);
}

/* The piece that contains `s`, or the first. */
static walk walk_to(const ll_flight *flight, double s)
{
    walk w = {.flight = flight, .now.velocity = flight->velocity};
    do
        next(&w);
    while (w.piece.begin + w.piece.h < s);
    return w;
}

static double value(const double *c, double u)
{
    return c[0] + u * (c[1] + u * (c[2] + u * c[3]));
}

static double slope(const double *c, double u)
{
    return c[1] + u * (2 * c[2] + u * 3 * c[3]);
}

ll_point ll_drag_flight_at(const ll_flight *flight, double s)
{
    const walk w = walk_to(flight, s);
    double u = (s - w.piece.begin) / w.piece.h;
    return (ll_point){value(w.piece.x, u), value(w.piece.y, u)};
}

ll_point ll_drag_flight_velocity(const ll_flight *flight, double s)
{
    const walk w = walk_to(flight, s);
    const piece *p = &w.piece;
    double u = (s - p->begin) / p->h;
    return (ll_point){slope(p->x, u) / p->h, slope(p->y, u) / p->h};
}

double ll_drag_flight_covers(const ll_flight *flight, double x, double limit_s)
{
    walk w = {.flight = flight, .now.velocity = flight->velocity};
    double roots[LL_DEGREE_MAX];
    do {
        next(&w);
        const piece *p = &w.piece;
        const double c[] = {p->x[0] - flight->from.x - x, p->x[1], p->x[2], p->x[3]};
        if (ll_sign_changes(c, 3, roots) > 0)
            return p->begin + p->h * roots[0];
    } while (w.piece.begin + w.piece.h < limit_s);
    return -1;
}

/* ---- hits ---- */

/* The part of a piece between two times, as a piece of its own. */
static piece part_of(const piece *p, double s0, double s1)
{
    double u = (s0 - p->begin) / p->h, w = (s1 - s0) / p->h;
    piece part = {.begin = s0, .h = s1 - s0};
    part.x[0] = value(p->x, u), part.y[0] = value(p->y, u);
    part.x[1] = w * slope(p->x, u), part.y[1] = w * slope(p->y, u);
    part.x[2] = w * w * (p->x[2] + 3 * u * p->x[3]), part.y[2] = w * w * (p->y[2] + 3 * u * p->y[3]);
    part.x[3] = w * w * w * p->x[3], part.y[3] = w * w * w * p->y[3];
    return part;
}

static double reach_of(const double *c)
{
    return ll_abs(c[1]) + ll_abs(c[2]) + ll_abs(c[3]);
}

/* Time at which the projectile comes within `radius` of a body that moves linearly from `a` to `b`. The
 * square of their distance is a polynomial of degree 6. */
static double meets_body(const piece *p, ll_point a, ll_point b, double radius)
{
    const double x[] = {p->x[0] - a.x, p->x[1] - (b.x - a.x), p->x[2], p->x[3]},
                 y[] = {p->y[0] - a.y, p->y[1] - (b.y - a.y), p->y[2], p->y[3]};
    if (ll_abs(x[0]) > radius + reach_of(x) || ll_abs(y[0]) > radius + reach_of(y))
        return NEVER;
    double c[LL_DEGREE_MAX + 1] = {-radius * radius}, roots[LL_DEGREE_MAX];
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            c[i + k] += x[i] * x[k] + y[i] * y[k];
    if (c[0] <= 0)
        return p->begin;
    return ll_sign_changes(c, LL_DEGREE_MAX, roots) > 0 ? p->begin + p->h * roots[0] : NEVER;
}

/* First u in (0, 1] at which `c` is `at` while `other` is from `low` to `high`. */
static double crosses(const double *c, double at, const double *other, double low, double high)
{
    const double off[] = {c[0] - at, c[1], c[2], c[3]};
    double roots[LL_DEGREE_MAX];
    int n = ll_sign_changes(off, 3, roots);
    for (int i = 0; i < n; i++) {
        double y = value(other, roots[i]);
        if (y >= low && y <= high)
            return roots[i];
    }
    return NEVER;
}

static double least(double a, double b)
{
    return a < b ? a : b;
}

static double meets_box(const piece *p, const ll_box *box)
{
    double x = p->x[0], y = p->y[0], rx = reach_of(p->x), ry = reach_of(p->y);
    if (x + rx < box->x_min || x - rx > box->x_max || y + ry < box->y_min || y - ry > box->y_max)
        return NEVER;
    if (x >= box->x_min && x <= box->x_max && y >= box->y_min && y <= box->y_max)
        return p->begin;
    double sides = least(crosses(p->x, box->x_min, p->y, box->y_min, box->y_max),
                         crosses(p->x, box->x_max, p->y, box->y_min, box->y_max));
    double levels = least(crosses(p->y, box->y_min, p->x, box->x_min, box->x_max),
                          crosses(p->y, box->y_max, p->x, box->x_min, box->x_max));
    double u = least(sides, levels);
    return u < NEVER ? p->begin + p->h * u : NEVER;
}

/* Time at which it leaves through a side or the ground, through which it does not come back. */
static double leaves(const piece *p, const ll_box *bounds)
{
    double x = value(p->x, 1), y = value(p->y, 1);
    if (x >= bounds->x_min && x <= bounds->x_max && y >= bounds->y_min)
        return NEVER;
    double sides = least(crosses(p->x, bounds->x_min, p->y, -NEVER, NEVER),
                         crosses(p->x, bounds->x_max, p->y, -NEVER, NEVER));
    double u = least(sides, crosses(p->y, bounds->y_min, p->x, -NEVER, NEVER));
    return u < NEVER ? p->begin + p->h * u : p->begin; /* it was outside before */
}

/* Bodies during the whole of a flight's part. */
typedef struct moving {
    const ll_point *before, *after;
    double s0, s1;
} moving;

static ll_point body_at(const moving *m, int i, double s)
{
    double u = m->s1 > m->s0 ? (s - m->s0) / (m->s1 - m->s0) : 0;
    ll_point a = m->before[i], b = m->after[i];
    return (ll_point){a.x + u * (b.x - a.x), a.y + u * (b.y - a.y)};
}

static ll_flight_hit meets(const ll_arena *arena, int shooter, const piece *p, const moving *bodies)
{
    ll_flight_hit first = {NEVER, LL_MET_NOTHING, LL_NOBODY};
    for (int i = 0; i < arena->bodies; i++) {
        if (!ll_arena_enemies(arena, shooter, i))
            continue;
        double s = meets_body(p, body_at(bodies, i, p->begin), body_at(bodies, i, p->begin + p->h),
                              ll_arena_radius(arena, i));
        if (s < first.s)
            first = (ll_flight_hit){s, LL_MET_BODY, i};
    }
    for (int i = 0; i < arena->covers; i++) {
        double s = meets_box(p, &arena->cover[i]);
        if (s < first.s)
            first = (ll_flight_hit){s, LL_MET_COVER, LL_NOBODY};
    }
    double s = leaves(p, &arena->bounds);
    if (s < first.s)
        first = (ll_flight_hit){s, LL_MET_BOUNDS, LL_NOBODY};
    return first;
}

ll_flight_hit ll_drag_flight_meets(const ll_arena *arena, int shooter, const ll_flight *flight, double s0,
                                   double s1, const ll_point *before, const ll_point *after)
{
    const moving bodies = {before, after, s0, s1};
    for (walk w = walk_to(flight, s0);; next(&w)) {
        double end = w.piece.begin + w.piece.h, from = w.piece.begin > s0 ? w.piece.begin : s0;
        const piece part = part_of(&w.piece, from, least(end, s1));
        const ll_flight_hit hit = meets(arena, shooter, &part, &bodies);
        if (hit.met != LL_MET_NOTHING || end >= s1)
            return hit;
    }
}
