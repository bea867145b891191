/* Projectiles: when the flight of a shot begins at the server, and which positions of bodies its past part is
 * tested against. */
#include "game/core/compensate.h"

/* ---- flights among past positions ---- */

ll_flight_hit ll_flight_through(const ll_arena *arena, const ll_history *history, int shooter,
                                const ll_flight *flight, ll_time start, ll_time from, ll_time to)
{
    ll_point bodies[2][LL_BODIES_MAX];
    int side = 0;
    ll_bodies_at(arena, history, from, bodies[0]);
    for (int64_t step = ll_history_find(history, from).before + 1; from < to; step++) {
        ll_time next = ll_history_time(history, step);
        if (next > to)
            next = to;
        ll_bodies_at(arena, history, next, bodies[!side]);
        ll_flight_hit m = ll_arena_flight(arena, shooter, flight, ll_to_s(from - start),
                                          ll_to_s(next - start), bodies[side], bodies[!side]);
        if (m.met != LL_MET_NOTHING)
            return m;
        from = next;
        side = !side;
    }
    return (ll_flight_hit){ll_to_s(to - start), LL_MET_NOTHING, LL_NOBODY};
}

ll_flight ll_traced(const ll_past *past, const ll_flight *flight, double s)
{
    ll_flight traced = *flight;
    if (past && past->rules->projectile_trace == LL_TRACE_STRAIGHT)
        return ll_flight_chord(flight, 0, s);
    if (past && past->rules->projectile_trace == LL_TRACE_DRAG_NEGLECTED)
        traced.drag = 0;
    return traced;
}

const char *const ll_trace_names[] = {"parabola", "straight", "drag_neglected", NULL};

/* none (A): the flight begins when the server processes the shot, among present targets. The shooter's
 * own view is behind by its age. Cost: none beyond the flight.
 *
 * client_authoritative: the same at the server. The client flies its projectile in its own view and reports
 * what it hits. Insecure: a dishonest client hits anything. */
static ll_flight_hit launch_now(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                                ll_time *start)
{
    (void)field, (void)flight;
    *start = shot->now;
    return (ll_flight_hit){0, LL_MET_NOTHING, LL_NOBODY};
}

/* fast_forward (B): the projectile is put where it would be by the shooter's view time, and its way there
 * is tested against the present targets. So the first part of the flight hits targets at positions where they
 * were not yet, and misses those that have moved on: a defect in shipped games (devotion, PR 168). Cost: one
 * part of a flight. */
static ll_flight_hit launch_forwarded(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                                      ll_time *start)
{
    *start = shot->seen;
    double s = ll_to_s(shot->now - shot->seen);
    ll_flight traced = ll_traced(field->past, flight, s);
    return ll_arena_flight(field->arena, shot->shooter, &traced, 0, s, field->present, field->present);
}

/* rewind (C), the paper's method: the flight begins at the shooter's view time. The server rewinds, moves
 * projectile and targets together record by record up to now, and then stays in the present. The hit is that
 * of a server without lag. Cost: one part of a flight per record. */
static ll_flight_hit launch_rewound(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                                    ll_time *start)
{
    *start = shot->seen;
    ll_flight traced = ll_traced(field->past, flight, ll_to_s(shot->now - shot->seen));
    return ll_flight_through(field->arena, field->past->history, shot->shooter, &traced, shot->seen,
                             shot->seen, shot->now);
}

/* partial (D): like fast_forward, but by at most projectile_forward_ms, so that no projectile appears far
 * from its muzzle. An older view is compensated in part. Cost: one part of a flight. */
static ll_flight_hit launch_partly(const ll_field *field, const ll_shot *shot, const ll_flight *flight,
                                   ll_time *start)
{
    ll_time furthest = shot->now - ll_ms(field->past->rules->projectile_forward_ms);
    ll_shot near = *shot;
    near.seen = shot->seen > furthest ? shot->seen : furthest;
    return launch_forwarded(field, &near, flight, start);
}

/* X(name, members): the first is the family without a history. */
#define FAMILIES(X)                                                                                          \
    X(none, .launch = launch_now)                                                                            \
    X(fast_forward, .launch = launch_forwarded, .looks_back = true)                                          \
    X(rewind, .launch = launch_rewound, .looks_back = true, .rewinds = true)                                 \
    X(partial, .launch = launch_partly, .looks_back = true)                                                  \
    X(client_authoritative, .launch = launch_now, .claims = true)

#define ROW(name, ...) {__VA_ARGS__},
#define NAME(name, ...) #name,

const ll_projectile_family ll_projectile_families[] = {FAMILIES(ROW)};
const char *const ll_projectile_names[] = {FAMILIES(NAME) NULL};
