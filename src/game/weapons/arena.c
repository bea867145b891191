#include "game/core/arena.h"

#include "base/detmath.h"
#include "game/weapons/drag_flight.h"
#include "game/weapons/roots.h"

/* ---- hitscan ---- */

double ll_ray_circle(ll_point from, ll_point direction, ll_point centre, double radius)
{
    double mx = from.x - centre.x, my = from.y - centre.y;
    double along = mx * direction.x + my * direction.y, outside = mx * mx + my * my - radius * radius;
    if (outside <= 0)
        return 0;
    double within = along * along - outside;
    return along > 0 || within < 0 ? -1 : -along - ll_sqrt(within);
}

/* Narrows [near, far] to where x + t v is between `low` and `high`. */
static bool slab(double x, double v, double low, double high, double *near, double *far)
{
    if (v == 0)
        return x >= low && x <= high;
    double a = (low - x) / v, b = (high - x) / v;
    double first = a < b ? a : b, last = a < b ? b : a;
    *near = first > *near ? first : *near;
    *far = last < *far ? last : *far;
    return *near <= *far;
}

/* In units of the direction's length. */
static double ray_box(ll_point from, ll_point direction, const ll_box *box, double far)
{
    double near = 0;
    bool meets = slab(from.x, direction.x, box->x_min, box->x_max, &near, &far) &&
                 slab(from.y, direction.y, box->y_min, box->y_max, &near, &far);
    return meets ? near : -1;
}

double ll_ray_box(ll_point from, ll_point direction, const ll_box *box)
{
    return ray_box(from, direction, box, 1e9);
}

int ll_arena_ray(const ll_arena *arena, int shooter, ll_point from, ll_point direction,
                 const ll_point *bodies)
{
    int met = LL_NOBODY;
    double nearest = 0;
    for (int i = 0; i < arena->bodies; i++) {
        if (!ll_arena_enemies(arena, shooter, i))
            continue;
        double at = ll_ray_circle(from, direction, bodies[i], ll_arena_radius(arena, i));
        if (at >= 0 && (met == LL_NOBODY || at < nearest)) {
            met = i;
            nearest = at;
        }
    }
    for (int i = 0; met != LL_NOBODY && i < arena->covers; i++)
        if (ray_box(from, direction, &arena->cover[i], nearest) >= 0)
            met = LL_NOBODY;
    return met;
}

static bool beside(double a, double b, double low, double high)
{
    return (a < low && b < low) || (a > high && b > high);
}

bool ll_arena_sees(const ll_arena *arena, ll_point a, ll_point b)
{
    for (int i = 0; i < arena->covers; i++) {
        const ll_box *box = &arena->cover[i];
        if (beside(a.x, b.x, box->x_min, box->x_max) || beside(a.y, b.y, box->y_min, box->y_max))
            continue;
        if (ray_box(a, (ll_point){b.x - a.x, b.y - a.y}, box, 1) >= 0)
            return false;
    }
    return true;
}

/* ---- flights ---- */

ll_point ll_flight_at(const ll_flight *f, double s)
{
    if (f->drag != 0)
        return ll_drag_flight_at(f, s);
    return (ll_point){f->from.x + f->velocity.x * s, f->from.y + (f->velocity.y - f->gravity / 2 * s) * s};
}

ll_point ll_flight_velocity(const ll_flight *f, double s)
{
    if (f->drag != 0)
        return ll_drag_flight_velocity(f, s);
    return (ll_point){f->velocity.x, f->velocity.y - f->gravity * s};
}

ll_flight ll_flight_chord(const ll_flight *f, double s0, double s1)
{
    ll_point a = ll_flight_at(f, s0), b = ll_flight_at(f, s1);
    double s = s1 - s0;
    if (s == 0)
        return (ll_flight){.from = a};
    return (ll_flight){.from = a, .velocity = {(b.x - a.x) / s, (b.y - a.y) / s}};
}

/* ---- hits ---- */

#define NEVER 1e300

static double square(double x)
{
    return x * x;
}

/* A flight from s0 on for h seconds: for u in [0, 1] its position is from + way u - (0, fall) u^2. */
typedef struct stretch {
    ll_point from, way;
    double fall, s0, h;
} stretch;

static stretch stretch_of(const ll_flight *f, double s0, double s1)
{
    double h = s1 - s0, vy = f->velocity.y - f->gravity * s0;
    return (stretch){ll_flight_at(f, s0), {f->velocity.x * h, vy * h}, f->gravity / 2 * h * h, s0, h};
}

/* Time at which it comes within `radius` of a body that moves linearly from `a` to `b`. Their distance is |r0
 * + r1 u + r2 u^2|, so its square minus that of the radius is a polynomial of degree 4. */
static double meets_body(const stretch *t, ll_point a, ll_point b, double radius)
{
    double x0 = t->from.x - a.x, y0 = t->from.y - a.y, x1 = t->way.x - (b.x - a.x),
           y1 = t->way.y - (b.y - a.y);
    double reach = radius + ll_abs(x1) + ll_abs(y1) + t->fall; /* bound of their approach */
    if (ll_abs(x0) > reach || ll_abs(y0) > reach)
        return NEVER;
    double y2 = -t->fall, roots[4];
    const double c[] = {x0 * x0 + y0 * y0 - square(radius), 2 * (x0 * x1 + y0 * y1),
                        x1 * x1 + y1 * y1 + 2 * y0 * y2, 2 * y1 * y2, y2 * y2};
    if (c[0] <= 0)
        return t->s0;
    return ll_sign_changes(c, 4, roots) > 0 ? t->s0 + t->h * roots[0] : NEVER;
}

/* Appends the times at which the flight is at height `y`, and counts them. */
static int at_height(const ll_flight *f, double y, double *times)
{
    double a = f->gravity / 2, b = -f->velocity.y, c = y - f->from.y;
    if (a == 0) {
        times[0] = b != 0 ? -c / b : NEVER;
        return b != 0;
    }
    double within = b * b - 4 * a * c;
    if (within < 0)
        return 0;
    double q = -(b + (b < 0 ? -ll_sqrt(within) : ll_sqrt(within))) / 2; /* the sum without cancellation */
    times[0] = q / a;
    times[1] = q != 0 ? c / q : 0;
    return 2;
}

static int at_width(const ll_flight *f, double x, double *times)
{
    times[0] = f->velocity.x != 0 ? (x - f->from.x) / f->velocity.x : NEVER;
    return f->velocity.x != 0;
}

static bool inside(const ll_box *box, ll_point p)
{
    return p.x >= box->x_min && p.x <= box->x_max && p.y >= box->y_min && p.y <= box->y_max;
}

/* Two edges of a box. */
typedef struct edges {
    bool in_y; /* of y; false: of x */
    double low, high;
} edges;

/* First of `times` from s0 to s1 at which the flight is between the edges. */
static double first_between(const ll_flight *f, const double *times, int count, double s0, double s1,
                            edges between)
{
    double first = NEVER;
    for (int i = 0; i < count; i++) {
        if (!(times[i] >= s0 && times[i] <= s1 && times[i] < first))
            continue;
        ll_point p = ll_flight_at(f, times[i]);
        double other = between.in_y ? p.y : p.x;
        if (other >= between.low && other <= between.high)
            first = times[i];
    }
    return first;
}

static double meets_box(const ll_flight *f, double s0, double s1, const ll_box *box)
{
    ll_point a = ll_flight_at(f, s0), b = ll_flight_at(f, s1);
    double rise = f->gravity * square(s1 - s0) / 8; /* largest height above the chord */
    if (beside(a.x, b.x, box->x_min, box->x_max) || beside(a.y, b.y, box->y_min - rise, box->y_max))
        return NEVER;
    if (inside(box, a))
        return s0;
    double sides[2], levels[4];
    int n = at_width(f, box->x_min, sides);
    n += at_width(f, box->x_max, sides + n);
    int m = at_height(f, box->y_min, levels);
    m += at_height(f, box->y_max, levels + m);
    double by_side = first_between(f, sides, n, s0, s1, (edges){true, box->y_min, box->y_max});
    double by_level = first_between(f, levels, m, s0, s1, (edges){false, box->x_min, box->x_max});
    return by_side < by_level ? by_side : by_level;
}

/* Time at which the flight leaves through a side or the ground. */
static double leaves(const ll_flight *f, double s0, double s1, const ll_box *bounds)
{
    ll_point p = ll_flight_at(f, s1);
    if (p.x >= bounds->x_min && p.x <= bounds->x_max && p.y >= bounds->y_min)
        return NEVER; /* below the ground it does not come back */
    double sides[2], ground[2], first = s1;
    int n = at_width(f, bounds->x_min, sides);
    n += at_width(f, bounds->x_max, sides + n);
    for (int i = 0; i < n; i++)
        if (sides[i] >= s0 && sides[i] < first)
            first = sides[i];
    n = at_height(f, bounds->y_min, ground);
    double falls = n == 0 ? NEVER : n == 1 || ground[0] > ground[1] ? ground[0] : ground[1];
    return falls >= s0 && falls < first ? falls : first;
}

ll_flight_hit ll_arena_flight(const ll_arena *arena, int shooter, const ll_flight *flight, double s0,
                              double s1, const ll_point *before, const ll_point *after)
{
    if (flight->drag != 0)
        return ll_drag_flight_meets(arena, shooter, flight, s0, s1, before, after);
    ll_flight_hit first = {NEVER, LL_MET_NOTHING, LL_NOBODY};
    stretch t = stretch_of(flight, s0, s1);
    for (int i = 0; i < arena->bodies; i++) {
        double s = meets_body(&t, before[i], after[i], ll_arena_radius(arena, i));
        if (s < first.s && ll_arena_enemies(arena, shooter, i))
            first = (ll_flight_hit){s, LL_MET_BODY, i};
    }
    for (int i = 0; i < arena->covers; i++) {
        double s = meets_box(flight, s0, s1, &arena->cover[i]);
        if (s < first.s)
            first = (ll_flight_hit){s, LL_MET_COVER, LL_NOBODY};
    }
    double s = leaves(flight, s0, s1, &arena->bounds);
    if (s < first.s)
        first = (ll_flight_hit){s, LL_MET_BOUNDS, LL_NOBODY};
    return first;
}
