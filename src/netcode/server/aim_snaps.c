#include "netcode/server/aim_snaps.h"

void ll_aim_watch_init(ll_aim_watch *w)
{
    *w = (ll_aim_watch){.alarms.first = LL_NEVER, .body = LL_NOBODY};
}

bool ll_aim_try(ll_aim_watch *w, bool snap)
{
    w->shots++;
    w->snaps += snap;
    w->sum += snap ? LL_AIM_SNAP : LL_AIM_TURN;
    bool alarm = w->sum >= LL_SPRT_ALARM, clear = w->sum <= LL_SPRT_CLEAR;
    w->cleared += clear;
    if (alarm || clear)
        w->sum = 0;
    return alarm;
}

/* How far the line of an aim passes the middle of a body, in its radii; beyond all measure if the body is
 * behind. */
static double beside(ll_point from, ll_point direction, ll_point body, double radius)
{
    double x = body.x - from.x, y = body.y - from.y;
    if (x * direction.x + y * direction.y <= 0)
        return 1e3;
    double across = x * direction.y - y * direction.x;
    return (across < 0 ? -across : across) / radius;
}

/* The aim is on another body than before, or on none. */
static void come_onto(ll_aim_watch *w, const ll_arena *arena, int body, const ll_point *bodies, ll_point from,
                      ll_time now)
{
    w->body = body;
    w->onto = now;
    w->open = 0;
    if (body == LL_NOBODY || w->at == 0 || now - w->at > LL_AIM_INPUTS)
        return;
    double off = beside(from, w->direction, bodies[body], ll_arena_radius(arena, body)) - 1;
    w->open = off > 0;
    w->rate = off / ll_to_s(now - w->at);
}

double ll_aim_see(ll_aim_watch *w, const ll_arena *arena, int player, const ll_point *bodies,
                  const ll_aim *aim, bool shoots, ll_time now)
{
    int body = ll_arena_ray(arena, player, aim->from, aim->direction, bodies);
    if (body != w->body)
        come_onto(w, arena, body, bodies, aim->from, now);
    w->direction = aim->direction;
    w->at = now;
    if (!shoots || !w->open || now - w->onto > LL_AIM_WITHIN)
        return -1;
    w->open = 0;
    return w->rate;
}
