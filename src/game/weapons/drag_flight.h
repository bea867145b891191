/* Flights of projectiles with quadratic drag: x'' = -drag |v| v - (0, gravity), which has no closed form.
 *
 * A flight is a chain of cubics between nodes. The nodes follow from its launch alone: steps of Runge and
 * Kutta's method of order 4, each a fixed part of the shortest time scale of the motion, 1 / (drag v +
 * sqrt(gravity drag)), and at most 1/4 s and a 16th of the time flown. So a position does not depend on how
 * the flight is divided, and its error is below 1e-8 / drag: 1e-6 m at 0.01 per metre. The number of steps
 * grows with the logarithm of time while drag brakes the projectile, and with time sqrt(gravity drag) while
 * it falls: a flight to the ground takes at most some thousand. Units as in game/core/arena.h; `drag` of a
 * flight is above 0. */
#pragma once

#include "game/core/arena.h"

ll_point ll_drag_flight_at(const ll_flight *flight, double s);
ll_point ll_drag_flight_velocity(const ll_flight *flight, double s);

/* As ll_arena_flight. */
ll_flight_hit ll_drag_flight_meets(const ll_arena *arena, int shooter, const ll_flight *flight, double s0,
                                   double s1, const ll_point *before, const ll_point *after);

/* First time, up to `limit_s`, at which the flight has covered the horizontal distance `x` > 0; negative:
 * none. */
double ll_drag_flight_covers(const ll_flight *flight, double x, double limit_s);
