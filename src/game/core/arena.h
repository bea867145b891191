/* What shots meet: bodies, cover and the ground. Closed forms; nothing here keeps state.
 *
 * A body is a circle, a cover an upright box. A ray is a shot without time of flight. A flight is a parabola;
 * it is met by bodies that move evenly meanwhile, and when it meets one is a root of a polynomial, so that
 * the answer does not depend on how a flight is cut into stretches. Lengths in m, times in s. */
#pragma once

#include <stdbool.h>

#define LL_BODIES_MAX 48 /* players and targets */
#define LL_COVER_MAX 8
#define LL_WEAPONS 2

typedef enum ll_weapon { LL_RIFLE, LL_CANNON } ll_weapon; /* weapon w is fired by button 1 << w */

typedef struct ll_point {
    double x, y;
} ll_point;

typedef struct ll_box {
    double x_min, x_max, y_min, y_max;
} ll_box;

typedef struct ll_arena {
    int players, bodies; /* entities [0, bodies) can be hit: the players', then targets */
    int teams;           /* player i is of team i % teams; a shot passes through the shooter's own team */
    int covers;
    double player_radius, target_radius;
    double shell_speed, gravity;
    double interval_s[LL_WEAPONS]; /* between two shots of a player; 0: nobody carries the weapon */
    ll_box bounds;                 /* shots end here; the lower edge is the ground; flights may rise above */
    ll_box cover[LL_COVER_MAX];
} ll_arena;

bool ll_arena_enemies(const ll_arena *arena, int shooter, int body);
double ll_arena_radius(const ll_arena *arena, int body);

/* ---- without time of flight ---- */

#define LL_NOBODY (-1)

/* How far along the ray of unit `direction`; negative when it misses, 0 from within. */
double ll_ray_circle(ll_point from, ll_point direction, ll_point centre, double radius);
double ll_ray_box(ll_point from, ll_point direction, const ll_box *box);

/* The first body that a ray meets before any cover, or LL_NOBODY. */
int ll_arena_ray(const ll_arena *arena, int shooter, ll_point from, ll_point direction,
                 const ll_point *bodies);

/* Whether no cover stands between two points. */
bool ll_arena_sees(const ll_arena *arena, ll_point a, ll_point b);

/* ---- with it ---- */

typedef struct ll_flight {
    ll_point from, velocity; /* at its start */
    double gravity;
} ll_flight;

ll_point ll_flight_at(const ll_flight *flight, double s);

/* The straight line through where the flight is at `s0` and `s1`, as a flight that begins at `s0`. In between
 * it is off by gravity (s - s0) (s1 - s) / 2, at most gravity (s1 - s0)^2 / 8. */
ll_flight ll_flight_chord(const ll_flight *flight, double s0, double s1);

typedef enum ll_met { LL_MET_NOTHING, LL_MET_BODY, LL_MET_COVER, LL_MET_BOUNDS } ll_met;

typedef struct ll_meeting {
    double s; /* of the flight */
    ll_met met;
    int body;
} ll_meeting;

/* The first thing that a flight meets from `s0` to `s1`, while the bodies move evenly from `before` to
 * `after`. */
ll_meeting ll_arena_flight(const ll_arena *arena, int shooter, const ll_flight *flight, double s0, double s1,
                           const ll_point *before, const ll_point *after);
