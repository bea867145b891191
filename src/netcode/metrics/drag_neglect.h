/* What a server misses that traces the past part of a projectile's flight as if there were no drag: for each
 * projectile, the distance between the flight without drag and the flight itself, and whether the past part
 * hits something else without drag. Both are computed with any trace of the server. Kept by the observer,
 * behind the other parts of a simulation's block, only where projectiles have drag: no pointers. */
#pragma once

#include "base/histogram.h"
#include "game/core/weapons.h"

#pragma GCC diagnostic push
#pragma GCC diagnostic error "-Wpadded"

typedef struct ll_drag_launch {
    ll_point from, velocity;
    uint32_t number; /* of its owner's projectiles; 0: none */
    uint32_t counts;
} ll_drag_launch;

typedef struct ll_drag_neglect_player {
    ll_histogram past; /* m: distance at the end of the past part */
    ll_histogram end;  /* m: distance at the end of the flight */
    int64_t traced;    /* projectiles with a past part */
    int64_t differing; /* of them, those whose past part hits another body, or one or none, without drag */
    int64_t false_hits, false_misses;        /* of the flight without drag, in the past part */
    ll_drag_launch launches[LL_PROJECTILES]; /* by number modulo the ring */
} ll_drag_neglect_player;

typedef struct ll_drag_neglect {
    ll_time from; /* shots that are judged earlier do not count */
    int64_t players;
    ll_drag_neglect_player player[];
} ll_drag_neglect;

#pragma GCC diagnostic pop

size_t ll_drag_neglect_size(int players); /* a multiple of 8 */
void ll_drag_neglect_init(ll_drag_neglect *neglect, int players, ll_time from);

/* A result of a shot; `field` is what it was judged in, with a history. */
void ll_drag_neglect_judge(ll_drag_neglect *neglect, const ll_field *field, const ll_hit_result *hit_result);
