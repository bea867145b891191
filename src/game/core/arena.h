/* What shots hit: bodies, cover and the ground. Closed forms; nothing here keeps state.
 *
 * A body is a circle, a cover an axis-aligned box. A ray is a hitscan shot. A flight is a parabola, or, with
 * quadratic drag, a chain of cubics (game/weapons/drag_flight.h). Bodies move linearly during it, and the
 * time of a hit is a root of a polynomial, so that it does not depend on how a flight is divided. Lengths in
 * m, times in s. */
#pragma once

#include <stdbool.h>

#define LL_BODIES_MAX 48 /* players and targets */
#define LL_COVER_MAX 7
#define LL_WEAPONS 2

typedef enum ll_weapon { LL_HITSCAN, LL_PROJECTILE } ll_weapon; /* weapon w is fired by button 1 << w */

typedef struct ll_point {
    double x, y;
} ll_point;

typedef struct ll_box {
    double x_min, x_max, y_min, y_max;
} ll_box;

typedef struct ll_arena {
    int players, bodies; /* entities [0, bodies) can be hit: players, then targets */
    int teams;           /* player i is in team i % teams; shots pass through the shooter's team */
    int covers;
    double player_radius, target_radius;
    double projectile_speed, gravity;
    double interval_s[LL_WEAPONS]; /* between two shots of a player; 0: the weapon does not exist */
    ll_box bounds;                 /* shots end here; the lower edge is the ground; flights may rise above */
    ll_box cover[LL_COVER_MAX];
    double projectile_drag; /* 1/m, see ll_flight */
    double reserved[3];
} ll_arena;

static inline bool ll_arena_enemies(const ll_arena *arena, int shooter, int body)
{
    if (body < 0 || body >= arena->bodies)
        return false;
    return body >= arena->players || (body - shooter) % arena->teams != 0;
}

static inline double ll_arena_radius(const ll_arena *arena, int body)
{
    return body < arena->players ? arena->player_radius : arena->target_radius;
}

/* ---- hitscan ---- */

#define LL_NOBODY (-1)

/* Distance along the ray of unit `direction`; negative: no hit, 0: from inside. */
double ll_ray_circle(ll_point from, ll_point direction, ll_point centre, double radius);
double ll_ray_box(ll_point from, ll_point direction, const ll_box *box);

/* First body that a ray hits before any cover, or LL_NOBODY. */
int ll_arena_ray(const ll_arena *arena, int shooter, ll_point from, ll_point direction,
                 const ll_point *bodies);

/* Whether no cover is between two points. */
bool ll_arena_sees(const ll_arena *arena, ll_point a, ll_point b);

/* ---- projectiles ---- */

typedef struct ll_flight {
    ll_point from, velocity; /* at launch */
    double gravity;
    double drag; /* 1/m: slows down by drag v^2, against its velocity v; 0: a parabola */
} ll_flight;

ll_point ll_flight_at(const ll_flight *flight, double s);
ll_point ll_flight_velocity(const ll_flight *flight, double s);

/* The straight line between the flight's positions at `s0` and `s1`, as a flight that begins at `s0`. Its
 * error, without drag, is gravity (s - s0) (s1 - s) / 2, at most gravity (s1 - s0)^2 / 8. */
ll_flight ll_flight_chord(const ll_flight *flight, double s0, double s1);

typedef enum ll_met { LL_MET_NOTHING, LL_MET_BODY, LL_MET_COVER, LL_MET_BOUNDS } ll_met;

typedef struct ll_flight_hit {
    double s; /* of the flight */
    ll_met met;
    int body;
} ll_flight_hit;

/* First hit of a flight from `s0` to `s1`, while the bodies move linearly from `before` to `after`. */
ll_flight_hit ll_arena_flight(const ll_arena *arena, int shooter, const ll_flight *flight, double s0,
                              double s1, const ll_point *before, const ll_point *after);
