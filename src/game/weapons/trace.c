/* Past positions of bodies, and projectiles among them. */
#include "game/core/compensate.h"

void ll_bodies_now(const ll_arena *arena, const ll_world *world, ll_point *bodies)
{
    for (int i = 0; i < arena->bodies; i++)
        bodies[i] = (ll_point){world->entity[i].x, world->entity[i].y};
}

void ll_bodies_at(const ll_arena *arena, const ll_history *history, ll_time time, ll_point *bodies)
{
    ll_moment moment = ll_history_find(history, time);
    for (int i = 0; i < arena->bodies; i++)
        ll_history_at(history, moment, i, &bodies[i].x, &bodies[i].y);
}

ll_time ll_view_age(const ll_past *past, int player, uint32_t stated_ns, bool *rejected)
{
    ll_time age = stated_ns, oldest = past->measured[player] + past->buffer;
    *rejected = age > oldest + ll_ms(past->rules->rewind_tolerance_ms);
    return *rejected ? oldest : age;
}

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
